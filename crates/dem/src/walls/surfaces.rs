//! Wall surfaces: walls other than fixed grains, under the same contact law as contacts between grains.
//!
//! The wall has infinite mass. The overlap is delta = R - d, with d the distance from the centre of the grain to the
//! wall. The normal points from the nearest point of the wall to the centre. The reduced mass is the mass of the grain.
//!
//! Walls may turn about their axis, and half-planes may move along themselves like a belt. Both keep the shape in its
//! place. Other motions of walls are in [`moving`](crate::walls::moving). The force pass sums contacts with walls ([`crate::contact`]). Where walls meet, a grain touches each of them
//! only at a point that is nearest on both ([`seams`](crate::walls::seams)).

use std::marker::PhantomData;
use std::ops::AddAssign;

use bevy_app::{App, Plugin};
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;
use serde::{Deserialize, Serialize};

use crate::particle::Species;
use crate::persist::Problem;
use crate::space::{Linear, Plane, Space};
use crate::step::{Part, Phase, Step};
use crate::store::AfterDeferredKick;
use crate::walls::moving::{LeafState, Mover, WallsPlaced};
use crate::walls::pose::Pose;
use crate::walls::shapes::ball::Ball;
use crate::walls::shapes::half_plane::HalfPlane;
use crate::walls::shapes::panel::Panel;
use crate::walls::shapes::revolved::Revolved;
use crate::walls::shapes::segment::Segment;
use crate::walls::shapes::spherical_zone::SphericalZone;
use crate::walls::shapes::triangle::Triangle;
use crate::walls::shapes::trimmed::Trimmed;
use crate::walls::shapes::{Nearest, Shape, box_around};
use crate::walls::surface_index::{Candidates, SurfaceIndex};
use crate::walls::twins::Twins;

/// The shape of a wall.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(bound = "")]
pub enum Surface<V: Space = Plane> {
    /// Solid behind the surface.
    HalfPlane(HalfPlane<V>),
    /// Thin line between two points.
    Segment(Segment<V>),
    /// A thin rectangle of solid space.
    Panel(Panel<V>),
    /// A thin triangle of solid space.
    Triangle(Triangle<V>),
    /// A thin cylinder, cone, frustum or ring of solid space.
    Revolved(Revolved<V>),
    /// A thin part of a sphere, in solid space.
    SphericalZone(SphericalZone<V>),
    /// A disc of the plane or a sphere of solid space, solid inside.
    Ball(Ball<V>),
    /// A panel, cylinder, cone or ring with a hole, or the part of it that fills a hole. Boxed, because it is twice as large as the others.
    Trimmed(Box<Trimmed<V>>),
}

impl<V: Space> Surface<V> {
    /// Returns a point of the surface, or of its axis, m.
    #[must_use]
    pub fn reference(&self) -> V {
        match self {
            Self::HalfPlane(shape) => shape.point,
            Self::Segment(shape) => shape.from,
            Self::Panel(shape) => shape.corner,
            Self::Triangle(shape) => shape.0[0],
            Self::Revolved(shape) => shape.base,
            Self::SphericalZone(shape) => shape.centre,
            Self::Ball(shape) => shape.centre,
            Self::Trimmed(shape) => shape.whole.reference(),
        }
    }

    fn shape(&self) -> &dyn Shape<V> {
        match self {
            Self::HalfPlane(shape) => shape,
            Self::Segment(shape) => shape,
            Self::Panel(shape) => shape,
            Self::Triangle(shape) => shape,
            Self::Revolved(shape) => shape,
            Self::SphericalZone(shape) => shape,
            Self::Ball(shape) => shape,
            Self::Trimmed(shape) => &**shape,
        }
    }

    /// Returns the distance of a point from the wall, m; negative inside a solid.
    #[inline]
    #[must_use]
    pub fn distance(&self, x: V) -> f64 {
        self.nearest(x).distance()
    }

    /// Returns the point of the surface that is nearest to `x`, m.
    #[must_use]
    pub fn nearest_point(&self, x: V) -> V {
        x - self.nearest(x).away()
    }
}

impl<V: Space> Shape<V> for Surface<V> {
    #[inline(always)]
    fn nearest(&self, x: V) -> Nearest<V> {
        match self {
            Self::HalfPlane(shape) => shape.nearest(x),
            Self::Segment(shape) => shape.nearest(x),
            Self::Panel(shape) => shape.nearest(x),
            Self::Triangle(shape) => shape.nearest(x),
            // Inlined, the rarer shapes would make loops over the others longer and slower.
            Self::Revolved(_) | Self::SphericalZone(_) | Self::Ball(_) | Self::Trimmed(_) => self.shape().nearest(x),
        }
    }

    fn bounds(&self) -> Option<[V; 2]> {
        self.shape().bounds()
    }

    #[inline]
    fn crossing(&self, from: V, to: V) -> Option<f64> {
        match self {
            Self::HalfPlane(shape) => shape.crossing(from, to),
            _ => self.shape().crossing(from, to),
        }
    }

    fn placed(&self, pose: &Pose<V>) -> Self {
        match self {
            Self::HalfPlane(shape) => Self::HalfPlane(shape.placed(pose)),
            Self::Segment(shape) => Self::Segment(shape.placed(pose)),
            Self::Panel(shape) => Self::Panel(shape.placed(pose)),
            Self::Triangle(shape) => Self::Triangle(shape.placed(pose)),
            Self::Revolved(shape) => Self::Revolved(shape.placed(pose)),
            Self::SphericalZone(shape) => Self::SphericalZone(shape.placed(pose)),
            Self::Ball(shape) => Self::Ball(shape.placed(pose)),
            Self::Trimmed(shape) => Self::Trimmed(Box::new(shape.placed(pose))),
        }
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
    /// Torque of the force about [`SurfaceWall::reference`], N m.
    pub torque: V::Spin,
    /// Torque of the dissipative part, N m.
    pub drag_torque: V::Spin,
}

impl<V: Space> WallLoad<V> {
    /// Returns the load of a force and its dissipative part, N, at the point `arm` (m) from the reference point.
    #[inline]
    pub(crate) fn of(force: V, drag: V, arm: V) -> Self {
        Self { force, drag, torque: arm.cross(force), drag_torque: arm.cross(drag) }
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

/// A wall surface: a wall of the scene, or a triangle of one.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(bound = "")]
pub struct SurfaceWall<V: Space = Plane> {
    /// Geometry.
    pub surface: Surface<V>,
    /// Number of the wall in the scene, from 0, without discs. The triangles of a polygon have one number.
    pub number: usize,
    /// Number of the surface within its wall, from 0. Images of a surface beyond periodic sides have its numbers.
    pub piece: u32,
    /// The point of the wall about which torques on it are measured, m; it moves with the wall. If the wall turns about its
    /// axis, the point is on the axis.
    pub reference: V,
    /// Velocity of the wall at the reference point, m/s; of a belt, along the wall.
    pub velocity: V,
    /// Angular velocity, rad/s.
    pub spin: V::Spin,
    /// Material.
    pub species: Species,
    /// Number of the door that the wall belongs to: [`Door`](crate::particle::Door).
    pub door: Option<u16>,
    /// Whether the wall is present; a door that has opened is not.
    pub is_present: bool,
}

impl<V: Space> SurfaceWall<V> {
    /// Returns a wall at rest that is no door.
    #[must_use]
    pub fn still(surface: Surface<V>, species: Species) -> Self {
        Self {
            number: 0,
            piece: 0,
            reference: surface.reference(),
            surface,
            velocity: V::ZERO,
            spin: V::Spin::ZERO,
            species,
            door: None,
            is_present: true,
        }
    }

    /// Returns the image of the wall that is shifted by whole lengths of a periodic box, m.
    #[must_use]
    pub fn image(&self, shift: V) -> Self {
        let surface = self.surface.placed(&Pose::shifted(shift));
        Self { surface, reference: self.reference + shift, ..self.clone() }
    }

    /// Returns the velocity of the wall at one of its points, m/s.
    #[inline(always)]
    pub(crate) fn velocity_at(&self, point: impl FnOnce() -> V) -> V {
        if self.spin == V::Spin::ZERO {
            self.velocity
        } else {
            self.velocity + (point() - self.reference).turned_by(self.spin)
        }
    }
}

/// Wall surfaces, in the order of the scene.
#[derive(Resource, Clone, Debug)]
pub struct Surfaces<V: Space = Plane> {
    /// The surfaces.
    pub all: Vec<SurfaceWall<V>>,
    /// Moving walls, each group with its motion.
    pub(super) movers: Vec<Mover<V>>,
    /// Radius of the largest grain, m.
    pub(super) largest: f64,
    /// The end of the last step for which the walls were placed, s.
    pub(super) placed_at: f64,
    /// Sum over the steps of the longest way of any point of a wall in a step, m.
    pub(super) travel: f64,
    /// The part of `travel` since the index was made, m.
    pub(super) drift: f64,
    pub(super) index: SurfaceIndex,
    /// The images of each surface that has some.
    twins: Twins,
    /// For each wall of the scene, its first surface.
    first: Vec<usize>,
    /// For each wall of the scene, the load of the grains on it in the last step.
    pub loads: Vec<WallLoad<V>>,
}

/// Returns the box around `x` with this half-width, m.
fn around<V: Space>(x: V, reach: f64) -> [V; 2] {
    let reach = V::from_components(|_| reach);
    [x - reach, x + reach]
}

/// The part of the walls that changes in a run.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(bound = "")]
pub struct SavedWalls<V: Space> {
    are_present: Vec<bool>,
    loads: Vec<WallLoad<V>>,
    leaves: Vec<Option<LeafState>>,
    placed_at: f64,
    travel: f64,
}

impl<V: Space> Surfaces<V> {
    /// Takes the surfaces of a scene whose largest grain has the radius `largest`, m.
    #[must_use]
    pub fn new(all: Vec<SurfaceWall<V>>, largest: f64) -> Self {
        let first: Vec<_> = (0..all.len()).filter(|&at| at == 0 || all[at].number != all[at - 1].number).collect();
        let loads = vec![WallLoad::default(); first.len()];
        Self {
            index: SurfaceIndex::new(&all, largest),
            twins: Twins::of(&all),
            movers: Vec::new(),
            largest,
            placed_at: 0.0,
            travel: 0.0,
            drift: 0.0,
            all,
            first,
            loads,
        }
    }

    /// The images of surfaces beyond periodic sides.
    #[must_use]
    pub fn twins(&self) -> &Twins {
        &self.twins
    }

    /// Whether a wall has ends.
    pub(crate) fn have_ends(&self) -> bool {
        self.all.iter().any(|wall| !matches!(wall.surface, Surface::HalfPlane(_)))
    }

    /// Returns the first surface of the wall of the scene with this number, from 0.
    #[must_use]
    pub fn first_surface(&self, number: usize) -> &SurfaceWall<V> {
        &self.all[self.first[number]]
    }

    /// Returns each wall of the scene, by its first surface, with its load.
    pub fn with_loads(&self) -> impl Iterator<Item = (&SurfaceWall<V>, &WallLoad<V>)> {
        self.first.iter().map(|&at| &self.all[at]).zip(&self.loads)
    }

    /// Sets the loads to the sums of these loads of surfaces, given by their indices.
    pub(crate) fn set_loads<'a>(&mut self, of_contacts: impl Iterator<Item = &'a (usize, WallLoad<V>)>) {
        self.loads.fill(WallLoad::default());
        for (surface, load) in of_contacts {
            self.loads[self.all[*surface].number] += *load;
        }
    }

    /// Whether there are so many surfaces that they are searched by place.
    pub(crate) fn are_many(&self) -> bool {
        self.index.has_grid()
    }

    /// Returns the surfaces that may be near any place, ascending: all if they are few.
    pub(crate) fn everywhere(&self) -> Vec<u32> {
        self.index.everywhere().to_vec()
    }

    /// Sets `found` to the surfaces that may be nearer to `x` than `reach` (m), ascending.
    pub(crate) fn find_near(&self, x: V, reach: f64, found: &mut Vec<u32>) {
        self.index.find(around(x, reach + self.drift), found);
    }

    /// Returns the surfaces that may be nearer to `x` than `reach` (m), ascending.
    pub fn near(&self, x: V, reach: f64) -> Candidates {
        self.index.candidates(around(x, reach + self.drift), self.all.len())
    }

    /// Returns the surfaces that a straight path may cross, ascending.
    pub(crate) fn on_path(&self, from: V, to: V) -> Candidates {
        if !self.are_many() {
            return Candidates::all(self.all.len());
        }
        let bounds = box_around(&[from, to]).unwrap_or([from, to]);
        self.index.candidates(bounds, self.all.len())
    }

    /// Returns the part that changes in a run.
    pub fn saved(&self) -> SavedWalls<V> {
        SavedWalls {
            are_present: self.all.iter().map(|wall| wall.is_present).collect(),
            loads: self.loads.clone(),
            leaves: self.movers.iter().map(Mover::leaf).collect(),
            placed_at: self.placed_at,
            travel: self.travel,
        }
    }

    /// Takes over what [`Self::saved`] returned.
    ///
    /// # Errors
    /// If it has another number of surfaces.
    pub fn restore(&mut self, saved: SavedWalls<V>) -> Result<(), &'static str> {
        let sizes = (saved.are_present.len(), saved.loads.len(), saved.leaves.len());
        let have_leaves =
            saved.leaves.iter().zip(&self.movers).all(|(leaf, mover)| leaf.is_some() == mover.leaf().is_some());
        if sizes != (self.all.len(), self.loads.len(), self.movers.len()) || !have_leaves {
            return Err("the checkpoint has another number of walls");
        }
        self.all.iter_mut().zip(saved.are_present).for_each(|(wall, is_present)| wall.is_present = is_present);
        self.loads = saved.loads;
        self.movers.iter_mut().zip(saved.leaves).for_each(|(mover, leaf)| mover.set_leaf(leaf));
        self.place(saved.placed_at);
        self.list_anew();
        self.travel = saved.travel;
        Ok(())
    }
}

/// Marks the entity of a wall surface by its index in [`Surfaces`]. After the entity is despawned, the wall is absent from
/// the next step on.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[component(immutable, on_remove = record_leaving_wall)]
pub struct WallIndex(pub usize);

/// Walls whose entities have been despawned since the last step.
#[derive(Resource, Clone, Debug, Default, Deserialize, Serialize)]
pub struct LeavingWalls(pub Vec<usize>);

/// Refuses restored indices of walls that the scene does not have.
///
/// # Errors
/// It names the index.
pub fn check_restored<V: Space>(world: &mut World) -> Result<(), Problem> {
    let mut marked = world.query::<&WallIndex>();
    let count = world.get_resource::<Surfaces<V>>().map_or(0, |walls| walls.all.len());
    let leaving = world.get_resource::<LeavingWalls>().into_iter().flat_map(|leaving| &leaving.0).copied();
    let mut indices = marked.iter(world).map(|wall| wall.0).chain(leaving);
    match indices.find(|index| *index >= count) {
        Some(index) => Err(format!("it names wall surface {index}, and the scene has {count}")),
        None => Ok(()),
    }
}

/// Records a wall whose entity is despawned.
fn record_leaving_wall(mut world: DeferredWorld, context: HookContext) {
    let Some(&WallIndex(wall)) = world.get(context.entity) else { return };
    if let Some(mut leaving) = world.get_resource_mut::<LeavingWalls>() {
        leaving.0.push(wall);
    }
}

/// Run condition: the entity of a wall has been despawned.
#[must_use]
pub fn walls_leave(leaving: Res<LeavingWalls>) -> bool {
    !leaving.0.is_empty()
}

/// Removes walls whose entities were despawned. This happens one step later, so that the energy balance accounts for
/// the elastic energy of their contacts first.
fn remove_walls<V: Space>(mut leaving: ResMut<LeavingWalls>, mut walls: ResMut<Surfaces<V>>) {
    for wall in leaving.0.drain(..) {
        walls.all[wall].is_present = false;
    }
}

/// Removes walls whose entities are despawned.
pub struct LeavingWallsPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for LeavingWallsPlugin<V> {
    fn build(&self, app: &mut App) {
        let remove = remove_walls::<V>.in_set(Part::Engine(Phase::Drift)).after(AfterDeferredKick).after(WallsPlaced);
        app.add_systems(Step, remove.run_if(walls_leave));
    }
}
