//! The scene: one RON file that says what is in the silo. [`Scene`] is one of grains.
//!
//! Every section's keys are documented where its behaviour lives; this file only lists the sections. All numbers
//! are SI; a range that a number must keep is part of its type ([`values`](crate::values)), rules across keys are in [`rules`],
//! and the byte range of each key, for messages and for `--set`, comes from [`source`](crate::source).

pub mod check;
pub mod load;
pub mod outputs;
pub mod rules;

use std::collections::BTreeMap;

use ron::value::RawValue;
use serde::{Deserialize, Serialize};

use crate::contact::Contact;
use crate::contact::config::PairOfSpecies;
use crate::contact::hertz::Material;
use crate::door::DoorControl;
use crate::grains::file::GrainFile;
use crate::grains::fill::Fill;
use crate::grains::mass::MassLaw;
use crate::grains::spawner::Spawner;
use crate::integrate::Integrator;
pub use crate::lattice::scene::Method;
use crate::ledger::{Cull, OnLoss};
use crate::measure::bed::Bed;
use crate::measure::flow::Flow;
use crate::measure::profile::Profile;
use crate::neighbours::Neighbours;
use crate::periodic::PeriodicSides;
use crate::rest::Rest;
use crate::scene::outputs::{Pictures, Series};
use crate::space::Dimension;
use crate::spin::InertiaLaw;
use crate::values::{FiniteVector, ImpactError, Positive};
use crate::walls::config::Wall;
use crate::walls::silo_file::Silo;
use crate::watchdog::Watchdog;

/// A scene as its file says it.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Shown in pictures.
    #[serde(default)]
    pub title: String,
    /// Seed of all random numbers.
    #[serde(default)]
    pub seed: u64,
    /// Grains; a scene with another method has other keys.
    #[serde(default)]
    pub method: Method,
    /// The plane, or solid space.
    #[serde(default)]
    pub space: Dimension,
    /// Acceleration of gravity (x, y), in solid space (x, y, z), m/s^2.
    pub gravity: FiniteVector,
    /// Sides through which the scene repeats itself.
    #[serde(default)]
    pub periodic: PeriodicSides,
    /// Contact law.
    pub contact: Contact,
    /// Other numbers of that law for pairs of species.
    #[serde(default)]
    pub pairs: Vec<PairOfSpecies>,
    /// Elastic materials by species, for Hertz's law.
    #[serde(default)]
    pub materials: Vec<Material>,
    /// Moment of inertia, where grains spin. Default: of spheres in solid space, of discs in the plane.
    pub inertia: Option<InertiaLaw>,
    /// How mass follows from radius, for grains that the spawner makes.
    pub mass: Option<MassLaw>,
    /// Integration scheme.
    #[serde(default)]
    pub integrator: Integrator,
    /// Time step.
    pub step: TimeStep,
    /// Neighbour search. Default: a Verlet list with a skin of the smallest radius, in solid space a fifth of it.
    pub neighbours: Option<Neighbours>,
    /// A silo file: wall grains and door grains.
    pub silo: Option<Silo>,
    /// Discs and flat walls besides.
    #[serde(default)]
    pub walls: Vec<Wall>,
    /// A file with the grains of the start.
    pub grains: Option<GrainFile>,
    /// Grains of the start on lattices.
    #[serde(default)]
    pub fill: Vec<Fill>,
    /// Releases grains one by one.
    pub spawner: Option<Spawner>,
    /// Detects rest.
    pub rest: Option<Rest>,
    /// Opens the door.
    pub door: Option<DoorControl>,
    /// Removes grains that have fallen far enough.
    pub cull: Option<Cull>,
    /// What a lost grain does to the run.
    #[serde(default)]
    pub on_loss: OnLoss,
    /// What stops a run that has gone wrong; `None` for nothing but numbers that are not finite.
    #[serde(default = "default_watchdog")]
    pub watchdog: Option<Watchdog>,
    /// Whether the energy balance is kept, which takes time: [`crate::energy`].
    #[serde(default = "default_books", alias = "energy_books")]
    pub energy_balance: bool,
    /// When the run ends at the latest, s of simulated time.
    pub until: Positive,
    /// Measures fill height and packing fraction at rest.
    pub bed: Option<Bed>,
    /// Averages over bins along an axis.
    #[serde(default)]
    pub profiles: Vec<Profile>,
    /// A field of mean velocity.
    pub flow: Option<Flow>,
    /// The rows of `series.csv`.
    #[serde(default)]
    pub series: Series,
    /// The snapshots; `None` for none.
    #[serde(default = "default_pictures")]
    pub pictures: Option<Pictures>,
    /// Behaviours that a program registered, each with its own keys.
    #[serde(default)]
    pub behaviours: BTreeMap<String, Box<RawValue>>,
}

/// The scene's `step`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum TimeStep {
    /// This time step, s.
    Fixed(Positive),
    /// One that keeps impacts within an error: [`crate::scene::check::step`].
    Auto {
        /// rms error of the velocities after an impact, in units of its speed.
        error: ImpactError,
    },
}

#[expect(clippy::unnecessary_wraps, reason = "the default of a field of this type")]
fn default_pictures() -> Option<Pictures> {
    Some(Pictures::default())
}

fn default_books() -> bool {
    true
}

#[expect(clippy::unnecessary_wraps, reason = "the default of a field of this type")]
fn default_watchdog() -> Option<Watchdog> {
    Some(Watchdog::default())
}
