//! Flat walls: half-planes, segments and panels, under the same contact law as contacts between grains.
//!
//! The wall has no curvature and infinite mass. The overlap is delta = R - d, with d the distance from the centre of
//! the grain to the wall. The normal points from the wall to the centre. The reduced mass is the mass of the grain.
//!
//! A half-plane (in solid space: a half-space) is solid behind its surface at any depth, and may move along itself like
//! a belt. A segment and a panel, its rectangle in solid space, are thin and act on both sides. A grain above the seam
//! of two panels in one plane touches both, so a floor should be one panel. The force pass sums contacts with walls
//! ([`crate::contact`]).

use std::marker::PhantomData;
use std::ops::AddAssign;

use bevy_app::{App, Plugin};
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use serde::{Deserialize, Serialize};

use crate::particle::Species;
use crate::space::{COINCIDENT, PARTED, Plane, Space};
use crate::step::{Part, Phase, Step};
use crate::store::AfterDeferredKick;

/// A flat surface.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(bound = "")]
pub enum Surface<V: Space = Plane> {
    /// Solid behind the surface.
    HalfPlane {
        /// A point of the surface, m.
        point: V,
        /// Unit normal into the free half.
        normal: V,
    },
    /// Thin line between two points.
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

/// Load of the grains on a wall in the present step.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub struct WallLoad<V> {
    /// Force on the wall, N.
    pub force: V,
    /// Dissipative part of the force, from normal and tangential dashpots, N.
    pub drag: V,
}

impl<V: Space> AddAssign for WallLoad<V> {
    fn add_assign(&mut self, more: Self) {
        self.force += more.force;
        self.drag += more.drag;
    }
}

/// A flat wall of the scene.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(bound = "")]
pub struct FlatWall<V: Space = Plane> {
    /// Geometry.
    pub surface: Surface<V>,
    /// Velocity along the wall, m/s.
    pub velocity: V,
    /// Material.
    pub species: Species,
    /// Whether the wall is the door.
    pub is_door: bool,
    /// Whether the wall is present; a door that has opened is not.
    pub is_present: bool,
    /// Load of the grains on the wall.
    pub load: WallLoad<V>,
}

/// Position of a surface relative to a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Nearest<V> {
    /// Vector from the nearest point of a thin surface to the centre, m. It is never zero: for a centre on the surface
    /// it is a very short vector to one side.
    Point(V),
    /// Normal and distance of a half-space.
    Half {
        /// Unit normal into the free half.
        normal: V,
        /// Distance from the surface, m; negative inside.
        distance: f64,
    },
}

/// Returns the point of an edge nearest to a centre, as a share of the edge (0 to 1).
#[inline]
fn foot_share<V: Space>(from_corner: V, edge: V) -> f64 {
    (from_corner.dot(edge) / edge.length_squared()).clamp(0.0, 1.0)
}

impl<V: Space> Surface<V> {
    /// Returns the position of the surface relative to `x` (m).
    #[inline(always)]
    #[must_use]
    pub fn nearest(&self, x: V) -> Nearest<V> {
        let away = match *self {
            Self::HalfPlane { point, normal } => return Nearest::Half { normal, distance: (x - point).dot(normal) },
            Self::Segment { from, to } => x - (from + (to - from) * foot_share(x - from, to - from)),
            Self::Panel { corner, along, across } => {
                x - (corner + along * foot_share(x - corner, along) + across * foot_share(x - corner, across))
            }
        };
        Nearest::Point(if away.length_squared() < COINCIDENT { self.side() * PARTED } else { away })
    }

    /// Returns the unit vector along which a thin surface pushes a centre that lies exactly on it.
    #[cold]
    fn side(&self) -> V {
        let across = match *self {
            Self::HalfPlane { normal, .. } => normal,
            Self::Segment { from, to } => (to - from).any_perpendicular(),
            Self::Panel { along, across, .. } => V::narrow(along.spread().cross(across.spread())),
        };
        across.unit_or_zero()
    }

    /// Returns the distance of a point from the wall, m; negative inside a half-plane.
    #[inline]
    #[must_use]
    pub fn distance(&self, x: V) -> f64 {
        match self.nearest(x) {
            Nearest::Point(away) => away.length(),
            Nearest::Half { distance, .. } => distance,
        }
    }
}

/// Flat walls, in the order of the scene.
#[derive(Resource, Clone, Debug, Deserialize, Serialize)]
#[serde(bound = "")]
pub struct Surfaces<V: Space = Plane>(pub Vec<FlatWall<V>>);

/// Marks the entity of a flat wall by its index in [`Surfaces`]. After the entity is despawned, the wall is absent from
/// the next step on.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[component(immutable, on_remove = record_leaving_wall)]
pub struct WallIndex(pub usize);

/// Walls whose entities have been despawned since the last step.
#[derive(Resource, Clone, Debug, Default, Deserialize, Serialize)]
pub(crate) struct LeavingWalls(pub(crate) Vec<usize>);

/// Records a wall whose entity is despawned.
fn record_leaving_wall(mut world: DeferredWorld, context: HookContext) {
    let Some(&WallIndex(wall)) = world.get(context.entity) else { return };
    if let Some(mut leaving) = world.get_resource_mut::<LeavingWalls>() {
        leaving.0.push(wall);
    }
}

/// Run condition: the entity of a wall has been despawned.
pub(crate) fn walls_leave(leaving: Res<LeavingWalls>) -> bool {
    !leaving.0.is_empty()
}

/// Removes walls whose entities were despawned. This happens one step later, so that the energy balance accounts for
/// the elastic energy of their contacts first.
fn remove_walls<V: Space>(mut leaving: ResMut<LeavingWalls>, mut walls: ResMut<Surfaces<V>>) {
    for wall in leaving.0.drain(..) {
        walls.0[wall].is_present = false;
    }
}

/// Removes walls whose entities are despawned.
pub struct LeavingWallsPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for LeavingWallsPlugin<V> {
    fn build(&self, app: &mut App) {
        let remove = remove_walls::<V>.in_set(Part::Engine(Phase::Drift)).after(AfterDeferredKick).run_if(walls_leave);
        app.add_systems(Step, remove);
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
        assert_eq!(wall.nearest(Vector::new(1.0, -0.5)), Nearest::Point(Vector::new(0.0, -0.5)));
        assert_eq!(wall.nearest(Vector::new(5.0, 4.0)), Nearest::Point(Vector::new(3.0, 4.0)));
        assert_eq!(wall.distance(Vector::new(5.0, 4.0)), 5.0);
        assert_eq!(wall.nearest(Vector::new(1.0, 0.0)), Nearest::Point(Vector::Y * PARTED));
    }

    #[test]
    fn a_half_plane_measures_depth() {
        let wall = Surface::HalfPlane { point: Vector::new(0.0, 1.0), normal: Vector::Y };
        let nearest = Nearest::Half { normal: Vector::Y, distance: -0.75 };
        assert_eq!(wall.nearest(Vector::new(7.0, 0.25)), nearest);
    }

    #[test]
    fn a_panel_has_a_face_edges_and_corners() {
        let wall =
            Surface::Panel { corner: Solid::ZERO, along: Solid::new(2.0, 0.0, 0.0), across: Solid::new(0.0, 1.0, 0.0) };
        assert_eq!(wall.nearest(Solid::new(1.0, 0.5, 0.3)), Nearest::Point(Solid::Z * 0.3));
        assert_eq!(wall.nearest(Solid::new(1.0, 0.5, -0.3)), Nearest::Point(Solid::Z * -0.3));
        assert_eq!(wall.nearest(Solid::new(1.0, 4.0, 4.0)), Nearest::Point(Solid::new(0.0, 3.0, 4.0)));
        assert_eq!(wall.distance(Solid::new(-2.0, -1.0, 2.0)), 3.0);
        assert_eq!(wall.nearest(Solid::new(1.0, 0.5, 0.0)), Nearest::Point(Solid::Z * PARTED));
    }
}
