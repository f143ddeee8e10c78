//! The components of particles: particles are entities, and their properties are components.
//!
//! A *grain* moves. A *wall grain* is a disc or sphere that is part of the silo's wall or door and carries [`Fixed`].
//! Both have the components of [`Particle`]; a grain also has those of [`GrainBundle`]. The ECS keeps each component as
//! one dense column, so a pass that needs positions reads nothing else.
//!
//! | component | unit | on |
//! |---|---|---|
//! | [`GrainId`] | | all particles |
//! | [`Position`] | m | all particles |
//! | [`Velocity`] | m/s | all particles (zero for a wall at rest) |
//! | [`Force`] | N | all particles where a system uses it: contacts, weight and added forces; on wall grains, the forces of the grains |
//! | [`Radius`] | m | all particles |
//! | [`Mass`] | kg | grains |
//! | [`Species`] | | all particles |
//! | [`Grain`] | marker | grains |
//! | [`Fixed`] | marker | particles that no force moves |
//! | [`Door`] | number | wall grains and wall surfaces that form a door |
//!
//! Vectors have the dimension of the scene's space: `Position` means `Position<Plane>`, and a solid scene has
//! `Position<Solid>`. Other components come only with the plugin that needs them, and so only in scenes that use it.
//! Spin, torque and moment of inertia come with a tangential force ([`crate::spin`]).
//!
//! Forces and torques are numbers of the store. Particles get [`Force`] and [`Torque`](crate::spin::Torque) as components before the first
//! system that uses them runs, and before a caller gets the world between two steps.
//! A run of the program without such a system has neither.

use std::fmt;

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::space::{Plane, Space};

/// Why contiguous iteration cannot fail: all particle components are stored in tables.
pub(crate) const DENSE: &str = "table components are contiguous";

/// The id of a particle for its whole life; never reused.
///
/// Grains count from 0 or carry the ids of their file. Ids of wall grains and door grains are larger than the ids of
/// all grains.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize, Serialize)]
#[component(immutable)]
#[require(Slot)]
pub struct GrainId(u32);

impl GrainId {
    /// The smallest id of wall and door grains.
    const FIRST_WALL: u32 = 1 << 31;
    /// The largest id that a grain can have.
    pub const MAX_GRAIN: u32 = Self::FIRST_WALL - 1;

    /// Returns the id of grain `number`; `None` if the number exceeds [`GrainId::MAX_GRAIN`].
    #[must_use]
    pub fn grain(number: u32) -> Option<Self> {
        (number <= Self::MAX_GRAIN).then_some(Self(number))
    }

    /// Returns the id of fixed disc `number`. Fixed discs are counted from 1 in the order of the silo file (wall, then
    /// door), then of the scene's discs.
    ///
    /// # Panics
    /// If there are 2^31 fixed discs.
    #[must_use]
    pub fn wall(number: usize) -> Self {
        let number = u32::try_from(number).ok().and_then(|n| n.checked_add(Self::FIRST_WALL));
        Self(number.expect("fewer than 2^31 wall grains"))
    }

    /// Like [`GrainId::wall`], `None` if there cannot be so many.
    #[must_use]
    pub(crate) fn numbered_wall(number: u32) -> Option<Self> {
        number.checked_add(Self::FIRST_WALL).map(Self)
    }

    /// The id as a number. The order is the same.
    #[inline]
    pub(crate) fn bits(self) -> u64 {
        self.0.into()
    }

    /// The id of the number that [`Self::bits`] gives.
    #[inline]
    #[expect(clippy::cast_possible_truncation, reason = "the number of an id")]
    pub(crate) fn of_bits(bits: u64) -> Self {
        Self(bits as u32)
    }

    /// The number among particles of this kind: grains as in their file, wall grains from 1.
    #[must_use]
    pub fn number(self) -> u32 {
        self.0 & Self::MAX_GRAIN
    }

    /// Whether this is the id of a wall or door grain.
    #[must_use]
    pub fn is_wall(self) -> bool {
        self.0 >= Self::FIRST_WALL
    }
}

impl fmt::Display for GrainId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = if self.is_wall() { "wall grain" } else { "grain" };
        write!(f, "{kind} {}", self.number())
    }
}

/// Index of a particle in the particle store ([`ParticleStore`](crate::store::ParticleStore)).
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
pub struct Slot(u32);

impl Default for Slot {
    /// The slot of a particle without a row.
    fn default() -> Self {
        Self(u32::MAX)
    }
}

impl Slot {
    pub(crate) fn new(index: u32) -> Self {
        Self(index)
    }

    /// The slot of row `i`. There are fewer than 2^32 rows.
    pub(crate) fn of(i: usize) -> Self {
        u32::try_from(i).map_or_else(|_| Self::default(), Self)
    }

    /// The row; out of range while the particle has none.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Centre, m.
#[derive(Component, Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[component(summary_tick)]
#[serde(bound = "")]
pub struct Position<V: Space = Plane>(pub V);

/// Velocity of the centre, m/s. Between [`Phase::Drift`](crate::step::Phase::Drift) and
/// [`Phase::Kick`](crate::step::Phase::Kick) it is v(t+dt/2), elsewhere v(t).
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[component(summary_tick)]
#[serde(bound = "")]
pub struct Velocity<V: Space = Plane>(pub V);

/// Sum of the forces, N, at the last evaluation. The acceleration is this force divided by [`Mass`]. A grain that enters without
/// this component starts with its weight.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[component(summary_tick)]
#[serde(bound = "")]
pub struct Force<V: Space = Plane>(pub V);

/// Radius, m.
#[derive(Component, Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[component(immutable)]
pub struct Radius(pub f64);

/// Mass, kg.
#[derive(Component, Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[component(immutable)]
pub struct Mass(pub f64);

/// Kind of a grain or wall: 0 for the first size of a mixture, 1 for the second. It selects colours in pictures, groups
/// in averages, and the material in scenes with several materials.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[component(immutable)]
pub struct Species(pub u8);

/// Marks a particle that can move and that the ledger counts.
#[derive(Component, Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub struct Grain;

/// Marks a particle that no force moves: a wall grain, or a grain that a behaviour holds. A system that moves it sets
/// both its [`Position`] and its [`Velocity`]. This is a table component, so that passes over grains run over
/// contiguous columns.
#[derive(Component, Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub struct Fixed;

/// Marks a part of a door, a wall grain or a wall surface, with the number of the door: 0 for the scene key `door`, from 1 for
/// the entries of `doors`.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[component(storage = "SparseSet")]
pub struct Door(pub u16);

/// The components of every particle.
#[derive(Bundle, Clone, Copy, Debug)]
pub struct Particle<V: Space = Plane> {
    /// Id.
    pub id: GrainId,
    /// Centre, m.
    pub position: Position<V>,
    /// Velocity, m/s.
    pub velocity: Velocity<V>,
    /// Radius, m.
    pub radius: Radius,
}

/// The components of every grain.
#[derive(Bundle, Clone, Copy, Debug)]
pub struct GrainBundle<V: Space = Plane> {
    /// The components of every particle.
    pub particle: Particle<V>,
    /// Mass, kg.
    pub mass: Mass,
    /// Species.
    pub species: Species,
    /// The marker of grains.
    pub grain: Grain,
}

/// Returns one disc or sphere of a wall. [`crate::walls::conveyor`] maintains a `velocity` other than zero.
#[must_use]
pub fn wall_grain<V: Space>(id: GrainId, centre: V, radius: f64, velocity: V, species: Species) -> impl Bundle {
    let particle = Particle { id, position: Position(centre), velocity: Velocity(velocity), radius: Radius(radius) };
    (particle, species, Fixed)
}
