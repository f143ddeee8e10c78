//! The data structure: particles are entities, their properties are components.
//!
//! A *grain* moves; a *wall grain* is a disc that is part of the silo's wall or door and carries [`Fixed`].
//! Both have the columns of [`Particle`]; a grain has also those of [`GrainBundle`]. The ECS keeps each component
//! as one dense column, so a pass that needs positions reads nothing else.
//!
//! | component | unit | who has it |
//! |---|---|---|
//! | [`GrainId`] | | all |
//! | [`Position`] | m | all |
//! | [`Velocity`] | m/s | all (zero for a wall at rest) |
//! | [`Force`] | N | all: contacts, weight and added forces; on wall grains, what the grains do to them |
//! | [`Radius`] | m | all |
//! | [`Mass`] | kg | grains |
//! | [`Species`] | | all |
//! | [`Grain`] | marker | grains |
//! | [`Fixed`] | marker | particles that no force moves |
//! | [`Door`] | marker | wall grains that form the door |
//!
//! Vectors are those of the scene's space: `Position` is `Position<Plane>`, a solid scene has `Position<Solid>`. Other
//! components come only with the plugin that needs them, so only in scenes that ask for it: spin, torque and moment of
//! inertia with a tangential force ([`crate::spin`]).

use std::fmt;

use bevy_ecs::prelude::*;

use crate::space::{Plane, Space};

/// The name of a particle for its whole life; never reused. Forces are summed in ascending order of it.
///
/// Grains count from 0 or carry the ids of their file; wall grains and door grains follow after all grains.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[component(immutable)]
#[require(Slot)]
pub struct GrainId(u32);

impl GrainId {
    /// Ids from here on belong to wall and door grains.
    const FIRST_WALL: u32 = 1 << 31;
    /// The largest id that a grain can have.
    pub const MAX_GRAIN: u32 = Self::FIRST_WALL - 1;

    /// The id of grain `number`, if that is at most [`GrainId::MAX_GRAIN`].
    #[must_use]
    pub fn grain(number: u32) -> Option<Self> {
        (number <= Self::MAX_GRAIN).then_some(Self(number))
    }

    /// The id of fixed disc `number`, counted from 1 in the order of the silo file (wall, then door) and then of
    /// the scene's discs.
    ///
    /// # Panics
    /// If there are 2^31 fixed discs.
    #[must_use]
    pub fn wall(number: usize) -> Self {
        let number = u32::try_from(number).ok().and_then(|n| n.checked_add(Self::FIRST_WALL));
        Self(number.expect("fewer than 2^31 wall grains"))
    }

    /// The number within its kind: grains as in their file, wall grains from 1.
    #[must_use]
    pub fn number(self) -> u32 {
        self.0 & Self::MAX_GRAIN
    }

    /// Whether this names a wall or door grain.
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

/// Index of a particle in the packed store ([`ParticleStore`](crate::store::Columns)).
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Slot(u32);

impl Default for Slot {
    /// No place yet.
    fn default() -> Self {
        Self(u32::MAX)
    }
}

impl Slot {
    pub(crate) fn new(index: u32) -> Self {
        Self(index)
    }

    /// That of row `i`, of which there are fewer than 2^32.
    pub(crate) fn of(i: usize) -> Self {
        u32::try_from(i).map_or_else(|_| Self::default(), Self)
    }

    /// The index, out of range as long as the particle has no place.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Centre, m.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[component(summary_tick)]
pub struct Position<V: Space = Plane>(pub V);

/// Velocity of the centre, m/s. Between [`Phase::Drift`](crate::step::Phase::Drift) and
/// [`Phase::Kick`](crate::step::Phase::Kick) it is v(t+dt/2), elsewhere v(t).
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
#[component(summary_tick)]
pub struct Velocity<V: Space = Plane>(pub V);

/// Sum of the forces, N, as of the last evaluation; the acceleration is this over [`Mass`].
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
#[component(summary_tick)]
pub struct Force<V: Space = Plane>(pub V);

/// Radius, m.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[component(immutable)]
pub struct Radius(pub f64);

/// Mass, kg.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[component(immutable)]
pub struct Mass(pub f64);

/// Which kind of grain or wall: 0 for the first size of a mixture, 1 for the second. Colours pictures and averages, and
/// chooses among the materials of a scene that has several.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
#[component(immutable)]
pub struct Species(pub u8);

/// Marks a particle that can move and that the ledger counts.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Grain;

/// Marks a particle that no force moves: a wall grain, or a grain that a behaviour holds. Who moves it sets its
/// [`Position`] and its [`Velocity`]. A table component, so that passes over grains run over contiguous columns.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Fixed;

/// Marks a part of the door: a wall grain, or a flat wall.
#[derive(Component, Clone, Copy, Debug, Default)]
#[component(storage = "SparseSet")]
pub struct Door;

/// What every particle has.
#[derive(Bundle, Clone, Copy, Debug)]
pub struct Particle<V: Space = Plane> {
    /// Its name.
    pub id: GrainId,
    /// Its centre, m.
    pub position: Position<V>,
    /// Its velocity, m/s.
    pub velocity: Velocity<V>,
    /// The force on it, N.
    pub force: Force<V>,
    /// Its radius, m.
    pub radius: Radius,
}

/// What every grain has.
#[derive(Bundle, Clone, Copy, Debug)]
pub struct GrainBundle<V: Space = Plane> {
    /// What every particle has.
    pub particle: Particle<V>,
    /// Its mass, kg.
    pub mass: Mass,
    /// Its kind.
    pub species: Species,
    /// That it is a grain.
    pub grain: Grain,
}

/// One disc or sphere of a wall; a `velocity` other than zero is kept up by [`crate::walls::conveyor`].
#[must_use]
pub fn wall_grain<V: Space>(id: GrainId, centre: V, radius: f64, velocity: V, species: Species) -> impl Bundle {
    let particle = Particle {
        id,
        position: Position(centre),
        velocity: Velocity(velocity),
        force: Force(V::ZERO),
        radius: Radius(radius),
    };
    (particle, species, Fixed)
}
