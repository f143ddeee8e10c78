//! Flat walls: half-planes, segments and panels, under the same contact law as between grains.
//!
//! The partner has no curvature and infinite mass: overlap delta = R - d with d the distance from the centre to the
//! wall, normal from the wall to the centre, reduced mass that of the grain. A half-plane (in solid space: a
//! half-space) is solid behind its normal however deep a grain is in it, and may move along itself like a belt; a
//! segment and a panel, its rectangle in solid space, are thin and act on both sides. A grain above the seam of two
//! panels in one plane touches both: build floors of one piece. Contacts with walls are made and summed where all
//! contacts are ([`crate::contact`]).

use std::marker::PhantomData;
use std::ops::AddAssign;

use bevy_app::{App, Plugin};
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;

use crate::particle::Species;
use crate::space::{COINCIDENT, PARTED, Plane, Space};
use crate::step::{Part, Phase, Step};
use crate::store::AfterDeferredKick;

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

/// Where the surface is, as seen from a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Nearest<V> {
    /// From the nearest point of a thin surface to the centre, m. Not zero: on the surface itself it is a length far
    /// below any other, to one side.
    Point(V),
    /// A half-space has its normal everywhere, and a distance (m) that is negative inside.
    Half {
        /// Unit normal into the free half.
        normal: V,
        /// m.
        distance: f64,
    },
}

/// The foot of a point on an edge, from 0 to 1.
#[inline]
fn foot<V: Space>(from_corner: V, edge: V) -> f64 {
    (from_corner.dot(edge) / edge.length_squared()).clamp(0.0, 1.0)
}

impl<V: Space> Surface<V> {
    /// Where the surface is, as seen from `x`.
    #[inline(always)]
    #[must_use]
    pub fn nearest(&self, x: V) -> Nearest<V> {
        let away = match *self {
            Self::HalfPlane { point, normal } => return Nearest::Half { normal, distance: (x - point).dot(normal) },
            Self::Segment { from, to } => x - (from + (to - from) * foot(x - from, to - from)),
            Self::Panel { corner, along, across } => {
                x - (corner + along * foot(x - corner, along) + across * foot(x - corner, across))
            }
        };
        Nearest::Point(if away.length_squared() < COINCIDENT { self.side() * PARTED } else { away })
    }

    /// The side to which a thin surface pushes a centre that lies exactly on it, as a unit vector.
    #[cold]
    fn side(&self) -> V {
        let across = match *self {
            Self::HalfPlane { normal, .. } => normal,
            Self::Segment { from, to } => (to - from).any_perpendicular(),
            Self::Panel { along, across, .. } => V::narrow(along.spread().cross(across.spread())),
        };
        across.unit_or_zero()
    }

    /// Distance of a point from the wall, m; negative inside a half-plane.
    #[inline]
    #[must_use]
    pub fn distance(&self, x: V) -> f64 {
        match self.nearest(x) {
            Nearest::Point(away) => away.length(),
            Nearest::Half { distance, .. } => distance,
        }
    }
}

/// The flat walls of the scene, in its order.
#[derive(Resource, Clone, Debug)]
pub struct Surfaces<V: Space = Plane>(pub Vec<FlatWall<V>>);

/// The entity of a flat wall, by its index in [`Surfaces`]. A wall whose entity is despawned is not there any more from
/// the next step on.
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

/// Walls whose entities have gone are no more there. In the step after that, so that what their contacts held is booked
/// first.
fn remove_walls<V: Space>(mut leaving: ResMut<LeavingWalls>, mut walls: ResMut<Surfaces<V>>) {
    for wall in leaving.0.drain(..) {
        walls.0[wall].is_present = false;
    }
}

/// Walls go with their entities.
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
