//! Flat walls: half-planes, segments and panels, under the same contact law as between grains.
//!
//! The partner has no curvature and infinite mass: overlap delta = R - d with d the distance from the centre to the
//! wall, normal from the wall to the centre, reduced mass that of the grain. A half-plane (in solid space: a half-space)
//! is solid behind its normal however deep a grain is in it, and may move along itself like a belt; a segment and a
//! panel, its rectangle in solid space, are thin and act on both sides. A grain above the seam of two panels in one plane
//! touches both: build floors of one piece. Forces: [`crate::walls::forces`].

use std::ops::AddAssign;

use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;

use crate::columns::Columns;
use crate::contact::{Ahead, Pair};
use crate::particle::Species;
use crate::space::{Linear, Plane, Space};

/// A flat surface.
#[derive(Clone, Copy, Debug)]
pub enum Surface<V: Space = Plane> {
    /// Solid behind `normal`, a unit vector.
    HalfPlane {
        /// A point of the surface, m.
        point: V,
        /// Unit normal into the free half.
        normal: V,
    },
    /// Thin, between two points, m.
    Segment {
        /// One end, m.
        from: V,
        /// The other end, m.
        to: V,
    },
    /// A thin rectangle.
    Panel {
        /// One corner, m.
        corner: V,
        /// One edge, m.
        along: V,
        /// The other edge, m.
        across: V,
    },
}

/// What the grains do to a wall in the present step.
#[derive(Clone, Copy, Debug, Default)]
pub struct WallLoad<V> {
    /// Force on the wall, N.
    pub force: V,
    /// The part of it that dashpots make, along the normal and across, N.
    pub drag: V,
}

impl<V: Space> AddAssign for WallLoad<V> {
    fn add_assign(&mut self, more: Self) {
        self.force += more.force;
        self.drag += more.drag;
    }
}

/// A flat wall of the scene.
#[derive(Clone, Copy, Debug)]
pub struct FlatWall<V: Space = Plane> {
    /// Where it is.
    pub surface: Surface<V>,
    /// Its velocity along itself, m/s.
    pub velocity: V,
    /// Its material.
    pub species: Species,
    /// Whether it is the door.
    pub is_door: bool,
    /// Whether it is there: a door that has opened is not.
    pub is_present: bool,
    /// What the grains do to it.
    pub load: WallLoad<V>,
}

/// Where along an edge (0 to 1) the foot of a point is.
#[inline]
fn share<V: Space>(from_corner: V, edge: V) -> f64 {
    (from_corner.dot(edge) / edge.length_squared()).clamp(0.0, 1.0)
}

impl<V: Space> Surface<V> {
    /// Distance of a point from the wall, m (negative inside a half-plane), and the unit vector towards the point.
    #[inline]
    #[must_use]
    pub fn distance(&self, x: V) -> (f64, V) {
        let (foot, edge) = match *self {
            Self::HalfPlane { point, normal } => return ((x - point).dot(normal), normal),
            Self::Segment { from, to } => (from + (to - from) * share(x - from, to - from), to - from),
            Self::Panel { corner, along, across } => {
                (corner + along * share(x - corner, along) + across * share(x - corner, across), along)
            }
        };
        let away = x - foot;
        let distance = away.length();
        // A centre exactly on the wall is pushed to one side of it, always the same.
        let normal = if distance > 0.0 {
            away / distance
        } else if let Self::Panel { along, across, .. } = *self {
            V::narrow(along.spread().cross(across.spread())).unit_or_zero()
        } else {
            edge.any_perpendicular().unit_or_zero()
        };
        (distance, normal)
    }
}

/// The flat walls of the scene, in its order.
#[derive(Resource, Clone, Debug)]
pub struct Surfaces<V: Space = Plane>(pub Vec<FlatWall<V>>);

/// The entity of a flat wall, by its index in [`Surfaces`]. A wall whose entity is despawned is not there any more from the next step on.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[component(immutable, on_remove = leave)]
pub struct WallIndex(pub usize);

/// Walls whose entities have gone since the last step.
#[derive(Resource, Clone, Debug, Default)]
pub(crate) struct LeavingWalls(pub(crate) Vec<usize>);

fn leave(mut world: DeferredWorld, context: HookContext) {
    let Some(&WallIndex(wall)) = world.get(context.entity) else { return };
    if let Some(mut leaving) = world.get_resource_mut::<LeavingWalls>() {
        leaving.0.push(wall);
    }
}

/// Run condition: a wall's entity has gone.
pub(crate) fn walls_leave(leaving: Res<LeavingWalls>) -> bool {
    !leaving.0.is_empty()
}

/// The contact of movable entry `i` with a wall, if they touch (`AHEAD`: within half a step).
#[inline]
#[must_use]
pub fn touching<const AHEAD: bool, V: Space>(
    columns: &Columns<V>,
    i: usize,
    wall: &FlatWall<V>,
    dt: f64,
) -> Option<Pair<V>> {
    let body = &columns.body[i];
    let (distance, normal) = wall.surface.distance(body.position);
    let window = if AHEAD { 0.5 * dt * (body.velocity - wall.velocity).dot(normal).abs() } else { 0.0 };
    if !(distance < body.radius + window && wall.is_present) {
        return None;
    }
    let mut pair = pair(columns, i, wall, distance, normal, dt);
    if AHEAD {
        let (gain, spin) = (&columns.gain[i], columns.spin_gain.get(i).copied().unwrap_or_default());
        pair.ahead = Ahead {
            velocity: gain.velocity,
            spins: [spin.spin, V::Spin::ZERO],
            inverse_masses: [body.inverse_mass, 0.0],
            inverse_inertias: [spin.inverse_inertia, 0.0],
            lone: [gain.lone, 0.0],
        };
    }
    Some(pair)
}

/// The geometry of entry `i` and a wall at this distance (m).
#[inline]
pub(super) fn pair<V: Space>(
    columns: &Columns<V>,
    i: usize,
    wall: &FlatWall<V>,
    distance: f64,
    normal: V,
    dt: f64,
) -> Pair<V> {
    let body = &columns.body[i];
    let reduced_mass = 1.0 / body.inverse_mass;
    Pair {
        normal,
        overlap: body.radius - distance,
        relative_velocity: body.velocity - wall.velocity,
        reduced_mass,
        root: reduced_mass.sqrt(),
        radii: [body.radius, f64::INFINITY],
        inverse_reach: 0.0,
        spins: [columns.spin(i), V::Spin::ZERO],
        species: [columns.species[i], wall.species],
        dt,
        ahead: Ahead::default(),
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use super::*;
    use crate::space::{Solid, Vector};

    #[test]
    fn a_segment_is_round_at_its_ends_and_two_sided() {
        let wall = Surface::Segment { from: Vector::ZERO, to: Vector::new(2.0, 0.0) };
        assert_eq!(wall.distance(Vector::new(1.0, -0.5)), (0.5, Vector::NEG_Y));
        assert_eq!(wall.distance(Vector::new(5.0, 4.0)), (5.0, Vector::new(0.6, 0.8)));
        assert_eq!(wall.distance(Vector::new(1.0, 0.0)), (0.0, Vector::Y));
    }

    #[test]
    fn a_half_plane_measures_depth() {
        let wall = Surface::HalfPlane { point: Vector::new(0.0, 1.0), normal: Vector::Y };
        assert_eq!(wall.distance(Vector::new(7.0, 0.25)), (-0.75, Vector::Y));
    }

    #[test]
    fn a_panel_has_a_face_edges_and_corners() {
        let wall =
            Surface::Panel { corner: Solid::ZERO, along: Solid::new(2.0, 0.0, 0.0), across: Solid::new(0.0, 1.0, 0.0) };
        assert_eq!(wall.distance(Solid::new(1.0, 0.5, 0.3)), (0.3, Solid::Z));
        assert_eq!(wall.distance(Solid::new(1.0, 0.5, -0.3)), (0.3, Solid::NEG_Z));
        assert_eq!(wall.distance(Solid::new(1.0, 4.0, 4.0)), (5.0, Solid::new(0.0, 0.6, 0.8)));
        assert_eq!(wall.distance(Solid::new(-2.0, -1.0, 2.0)).0, 3.0);
        assert_eq!(wall.distance(Solid::new(1.0, 0.5, 0.0)), (0.0, Solid::Z));
    }
}
