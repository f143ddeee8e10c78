//! Flat walls: half-planes, segments and panels, under the same contact law as between grains.
//!
//! The partner has no curvature and infinite mass: overlap delta = R - d with d the distance from the centre to the
//! wall, normal from the wall to the centre, reduced mass that of the grain. A half-plane (in solid space: a half-space)
//! is solid behind its normal however deep a grain is in it, and may move along itself like a belt; a segment and a
//! panel, its rectangle in solid space, are thin and act on both sides. Forces are summed in the scene's order, after
//! those of all particles. A grain above the seam of two panels in one plane touches both: build floors of one piece.
//!
//! What the grains do to a wall is summed too ([`WallLoad`]): the force *on the wall*, so a floor under gravity has
//! one that points down.

use std::sync::Arc;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::columns::Columns;
use crate::contact::history::{History, Recall};
use crate::contact::kernel::Ended;
use crate::contact::{Demands, LargestOverlap, Law, Memory, Pair, PairForce, PairLaw, kernel, memory_step};
use crate::messages::DoorOpened;
use crate::particle::Species;
use crate::scene::values::{FiniteVector, Positive};
use crate::space::{Linear, Plane, Space};
use crate::step::{Clock, ForceStage, Phase, Step};

/// One of the scene's `walls`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Wall {
    /// Everything behind a line, in solid space behind a plane, is solid.
    #[serde(alias = "HalfSpace")]
    HalfPlane {
        /// A point of the surface, m.
        point: FiniteVector,
        /// The direction from the solid into the free half, of any length but zero.
        normal: FiniteVector,
        /// Its velocity along itself, m/s: a belt. Default at rest.
        #[serde(default)]
        velocity: Option<FiniteVector>,
        /// Its material. Default 0.
        #[serde(default)]
        species: u8,
    },
    /// A thin wall between two points; in solid space, a thin rod.
    Segment {
        /// One end, m.
        from: FiniteVector,
        /// The other end, m.
        to: FiniteVector,
        /// Its material. Default 0.
        #[serde(default)]
        species: u8,
    },
    /// A thin rectangle of solid space.
    Panel {
        /// One corner, m.
        corner: FiniteVector,
        /// From there along one edge, m.
        along: FiniteVector,
        /// From there along the other edge, m, at right angles to the first.
        across: FiniteVector,
        /// Its material. Default 0.
        #[serde(default)]
        species: u8,
        /// Whether it is the door: gone when the door opens, and grains that pass where it was are out.
        #[serde(default)]
        door: bool,
    },
    /// A fixed disc or sphere: a wall grain like those of a silo file.
    #[serde(alias = "Sphere")]
    Disc {
        /// Centre, m.
        centre: FiniteVector,
        /// Radius, m.
        radius: Positive,
        /// Its material. Default 0.
        #[serde(default)]
        species: u8,
    },
}

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
    /// The part of it that dampers make, N.
    pub drag: V,
    /// The part of it that tangential dashpots make, N.
    pub friction_drag: V,
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

impl Wall {
    /// The flat wall, unless it is a disc.
    #[must_use]
    pub fn flat<V: Space>(&self) -> Option<FlatWall<V>> {
        let (surface, species) = match *self {
            Self::HalfPlane { point, normal, species, .. } => {
                (Surface::HalfPlane { point: point.get(), normal: normal.get::<V>().unit_or_zero() }, species)
            }
            Self::Segment { from, to, species } => (Surface::Segment { from: from.get(), to: to.get() }, species),
            Self::Panel { corner, along, across, species, .. } => {
                (Surface::Panel { corner: corner.get(), along: along.get(), across: across.get() }, species)
            }
            Self::Disc { .. } => return None,
        };
        let velocity = match self {
            Self::HalfPlane { velocity: Some(velocity), .. } => velocity.get(),
            _ => V::ZERO,
        };
        let is_door = matches!(self, Self::Panel { door: true, .. });
        let load = WallLoad::default();
        Some(FlatWall { surface, velocity, species: Species(species), is_door, is_present: true, load })
    }
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

/// The contact of movable entry `i` with a wall, if they touch.
#[inline]
#[must_use]
pub fn touching<V: Space>(columns: &Columns<V>, i: usize, wall: &FlatWall<V>, dt: f64) -> Option<Pair<V>> {
    let body = &columns.body[i];
    let (distance, normal) = wall.surface.distance(body.position);
    (distance < body.radius && wall.is_present).then(|| pair(columns, i, wall, distance, normal, dt))
}

/// The geometry of entry `i` and a wall at this distance (m).
#[inline]
fn pair<V: Space>(columns: &Columns<V>, i: usize, wall: &FlatWall<V>, distance: f64, normal: V, dt: f64) -> Pair<V> {
    let body = &columns.body[i];
    Pair {
        normal,
        overlap: body.radius - distance,
        relative_velocity: body.velocity - wall.velocity,
        reduced_mass: 1.0 / body.inverse_mass,
        radii: [body.radius, f64::INFINITY],
        spins: [columns.spin.get(i).copied().unwrap_or_default(), V::Spin::ZERO],
        species: [columns.species[i], wall.species],
        dt,
    }
}

fn wall_forces<V: Space, L: PairLaw<V> + Demands>(
    law: Res<Law<L>>,
    clock: Res<Clock>,
    mut walls: ResMut<Surfaces<V>>,
    mut columns: ResMut<Columns<V>>,
    mut history: ResMut<History<V>>,
    mut largest: ResMut<LargestOverlap>,
) {
    let dt = memory_step(&clock);
    let (before, pages) = history.walls.turn();
    walls.0.iter_mut().for_each(|wall| wall.load = WallLoad::default());
    for i in 0..columns.movable_end {
        let mut recall = Recall::new(before, i);
        let mut ended = Ended::default();
        for index in 0..if columns.is_fixed(i) { 0 } else { walls.0.len() } {
            let Some(pair) = touching(&columns, i, &walls.0[index], dt) else { continue };
            let number = u32::try_from(index).expect("fewer than 2^32 walls");
            let mut memory = Memory::default();
            if L::MEMORY {
                memory = recall.of::<L>(number, |wall, memory| {
                    if let Some(pair) = parted(&columns, i, &walls.0[wall as usize], dt) {
                        ended.add_pair(&*law.0, &pair, memory);
                    }
                });
            }
            let on_i = law.0.force(&pair, &mut memory);
            add_load::<V, L>(&mut columns, i, &mut walls.0[index].load, &pair, &on_i);
            if L::MEMORY {
                pages.push::<L>(number, &memory);
            }
            largest.0.raise(pair.overlap, pair.radii[0]);
        }
        if L::MEMORY {
            recall.finish::<L>(|wall, memory| {
                if let Some(pair) = parted(&columns, i, &walls.0[wall as usize], dt) {
                    ended.add_pair(&*law.0, &pair, memory);
                }
            });
            pages.end_row();
        }
        // Most grains are far from every wall: their entries are left alone.
        if L::SPIN && ended.is_any() {
            ended.book(&mut columns.turn[i]);
        }
    }
}

/// The geometry of entry `i` and a wall that it has just left; none of a door that has gone, which took all its contacts'
/// energy with it.
fn parted<V: Space>(columns: &Columns<V>, i: usize, wall: &FlatWall<V>, dt: f64) -> Option<Pair<V>> {
    let (distance, normal) = wall.surface.distance(columns.body[i].position);
    wall.is_present.then(|| pair(columns, i, wall, distance, normal, dt))
}

/// Adds what a contact does to grain and wall.
#[inline]
fn add_load<V: Space, L: Demands>(
    columns: &mut Columns<V>,
    i: usize,
    on_wall: &mut WallLoad<V>,
    pair: &Pair<V>,
    on_i: &PairForce<V>,
) {
    let sum = kernel::total::<L, V>(on_i);
    columns.load[i].force += sum;
    columns.load[i].drag += on_i.drag;
    on_wall.force -= sum;
    on_wall.drag -= on_i.drag;
    if L::SPIN {
        kernel::turn::<L, V>(&mut columns.turn[i], pair, on_i, 0);
        kernel::book_losses::<L, V>(&mut columns.turn[i], on_i);
        on_wall.friction_drag -= on_i.turning.friction_drag;
    }
}

/// A door made of panels goes when it opens.
fn open_door<V: Space>(mut opened: MessageReader<DoorOpened>, mut walls: ResMut<Surfaces<V>>) {
    if opened.read().next().is_some() {
        walls.0.iter_mut().filter(|wall| wall.is_door).for_each(|wall| wall.is_present = false);
    }
}

/// Flat walls under the law `law`.
pub struct SurfacesPlugin<V: Space, L>(std::marker::PhantomData<(V, L)>);

impl<V: Space, L: PairLaw<V> + Demands> SurfacesPlugin<V, L> {
    /// Under the law that [`ContactPlugin`](crate::contact::ContactPlugin) has brought.
    #[must_use]
    pub fn new(_: &Arc<L>) -> Self {
        Self(std::marker::PhantomData)
    }
}

impl<V: Space, L: PairLaw<V> + Demands> Plugin for SurfacesPlugin<V, L> {
    fn build(&self, app: &mut App) {
        app.add_systems(Step, wall_forces::<V, L>.in_set(ForceStage::Walls));
        if app.world().resource::<Surfaces<V>>().0.iter().any(|wall| wall.is_door) {
            // In the step after the one that opens the door, so that what it held is booked first.
            app.add_systems(Step, open_door::<V>.in_set(Phase::Drift));
        }
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
