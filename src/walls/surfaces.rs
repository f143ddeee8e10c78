//! Wall surfaces: walls other than fixed grains, under the same contact law as contacts between grains.
//!
//! The wall has infinite mass. The overlap is delta = R - d, with d the distance from the centre of the grain to the
//! wall. The normal points from the nearest point of the wall to the centre. The reduced mass is the mass of the grain.
//!
//! Walls may turn about their axis, and half-planes may move along themselves like a belt. Both keep the shape in its
//! place. The force pass sums contacts with walls ([`crate::contact`]). Where walls meet, a grain touches each of them
//! only at a point that is nearest on both ([`seams`](crate::walls::seams)).

use std::marker::PhantomData;
use std::ops::AddAssign;

use bevy_app::{App, Plugin};
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use serde::{Deserialize, Serialize};

use crate::particle::Species;
use crate::space::{Linear, Plane, Space};
use crate::step::{Part, Phase, Step};
use crate::store::AfterDeferredKick;
use crate::walls::shapes::half_plane::HalfPlane;
use crate::walls::shapes::panel::Panel;
use crate::walls::shapes::revolved::Revolved;
use crate::walls::shapes::segment::Segment;
use crate::walls::shapes::{Nearest, Shape};

/// The shape of a wall.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(bound = "")]
pub enum Surface<V: Space = Plane> {
    /// Solid behind the surface.
    HalfPlane(HalfPlane<V>),
    /// Thin line between two points.
    Segment(Segment<V>),
    /// A thin rectangle of solid space.
    Panel(Panel<V>),
    /// A thin cylinder, cone, frustum or ring of solid space.
    Revolved(Revolved<V>),
}

impl<V: Space> Surface<V> {
    /// Returns the point about which torques on the wall are measured, m.
    #[must_use]
    pub fn reference(&self) -> V {
        match self {
            Self::HalfPlane(shape) => shape.point,
            Self::Segment(shape) => shape.from,
            Self::Panel(shape) => shape.corner,
            Self::Revolved(shape) => shape.base,
        }
    }

    fn shape(&self) -> &dyn Shape<V> {
        match self {
            Self::HalfPlane(shape) => shape,
            Self::Segment(shape) => shape,
            Self::Panel(shape) => shape,
            Self::Revolved(shape) => shape,
        }
    }

    /// Returns the distance of a point from the wall, m; negative inside a half-plane.
    #[inline]
    #[must_use]
    pub fn distance(&self, x: V) -> f64 {
        self.nearest(x).distance()
    }
}

impl<V: Space> Shape<V> for Surface<V> {
    #[inline(always)]
    fn nearest(&self, x: V) -> Nearest<V> {
        match self {
            Self::HalfPlane(shape) => shape.nearest(x),
            Self::Segment(shape) => shape.nearest(x),
            Self::Panel(shape) => shape.nearest(x),
            Self::Revolved(shape) => shape.nearest(x),
        }
    }

    fn bounds(&self) -> Option<[V; 2]> {
        self.shape().bounds()
    }

    fn crossing(&self, from: V, to: V) -> Option<f64> {
        self.shape().crossing(from, to)
    }

    fn lines(&self) -> Vec<[V; 2]> {
        self.shape().lines()
    }
}

/// Load of the grains on a wall in the present step.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
#[serde(bound = "")]
pub struct WallLoad<V: Space> {
    /// Force on the wall, N.
    pub force: V,
    /// Dissipative part of the force, from normal and tangential dashpots, N.
    pub drag: V,
    /// Torque of the force about [`Surface::reference`], N m.
    pub torque: V::Spin,
    /// Torque of the dissipative part, N m.
    pub drag_torque: V::Spin,
}

impl<V: Space> WallLoad<V> {
    /// Adds a force on the wall and its dissipative part, N, at the point `arm` (m) from the reference point.
    #[inline]
    pub(crate) fn add(&mut self, force: V, drag: V, arm: V) {
        *self += Self { force, drag, torque: arm.cross(force), drag_torque: arm.cross(drag) };
    }
}

impl<V: Space> AddAssign for WallLoad<V> {
    fn add_assign(&mut self, more: Self) {
        self.force += more.force;
        self.drag += more.drag;
        self.torque += more.torque;
        self.drag_torque += more.drag_torque;
    }
}

/// A wall surface of the scene.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
#[serde(bound = "")]
pub struct SurfaceWall<V: Space = Plane> {
    /// Geometry.
    pub surface: Surface<V>,
    /// Velocity along the wall, m/s.
    pub velocity: V,
    /// Angular velocity of a surface of revolution about its axis, rad/s.
    pub spin: V::Spin,
    /// Material.
    pub species: Species,
    /// Whether the wall is the door.
    pub is_door: bool,
    /// Whether the wall is present; a door that has opened is not.
    pub is_present: bool,
    /// Load of the grains on the wall.
    pub load: WallLoad<V>,
}

impl<V: Space> SurfaceWall<V> {
    /// Returns a wall at rest that is not the door.
    #[must_use]
    pub fn still(surface: Surface<V>, species: Species) -> Self {
        Self {
            surface,
            velocity: V::ZERO,
            spin: V::Spin::ZERO,
            species,
            is_door: false,
            is_present: true,
            load: WallLoad::default(),
        }
    }

    /// Returns the velocity of the wall at one of its points, m/s.
    #[inline(always)]
    pub(crate) fn velocity_at(&self, point: impl FnOnce() -> V) -> V {
        if self.spin == V::Spin::ZERO {
            self.velocity
        } else {
            self.velocity + (point() - self.surface.reference()).turned_by(self.spin)
        }
    }
}

/// Wall surfaces, in the order of the scene.
#[derive(Resource, Clone, Debug, Deserialize, Serialize)]
#[serde(bound = "")]
pub struct Surfaces<V: Space = Plane>(pub Vec<SurfaceWall<V>>);

/// Marks the entity of a wall surface by its index in [`Surfaces`]. After the entity is despawned, the wall is absent from
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
