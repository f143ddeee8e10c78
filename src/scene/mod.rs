//! The scene: one RON file that describes the silo. [`Scene`] is a scene of grains.
//!
//! This file lists the sections. The keys of a section are documented in the module of its behaviour. All numbers are in
//! SI units. The type of a number enforces its range ([`values`](siloflow_dem::values)). Rules between keys are in [`rules`]. The
//! byte range of each key, for messages and for `--set`, comes from [`source`](siloflow_text::source).

pub mod check;
pub mod expected;
pub mod extent;
pub mod facts;
pub mod load;
pub mod loaded;
pub mod outputs;
pub mod rules;
pub mod shipped;
pub mod view;

use std::collections::BTreeMap;
use std::num::NonZeroU32;

use ron::value::RawValue;
use serde::{Deserialize, Serialize};

use crate::door::{DoorControl, DoorOpens, NamedDoor};
use crate::ending::stop::conditions::StopCondition;
use crate::ending::stop::kick::Kick;
use crate::ending::watchdog::Watchdog;
use crate::grains::feed::Feed;
use crate::grains::file::GrainFile;
use crate::grains::fill::Fill;
use crate::grains::mass::MassLaw;
use crate::grains::spawner::Spawner;
pub use crate::lattice_silo::scene::Method;
use crate::ledger::{Cull, OnLoss};
use crate::measure::bed::Bed;
use crate::measure::fields::Field;
use crate::measure::flow::Flow;
use crate::measure::outflow::Outflow;
use crate::measure::profile::Profile;
use crate::measure::slope::Slope;
use crate::measure::wall_bands::WallBands;
use crate::rest::Rest;
use crate::scene::outputs::{DataFrames, Pictures, Series};
use siloflow_dem::bodies::config::ShapeConfig;
use siloflow_dem::contact::Contact;
use siloflow_dem::contact::config::PairOfSpecies;
use siloflow_dem::contact::hertz::Material;
use siloflow_dem::integrate::Integrator;
use siloflow_dem::neighbours::Neighbours;
use siloflow_dem::periodic::PeriodicSides;
use siloflow_dem::persist::{CheckpointConfig, default_checkpoint};
use siloflow_dem::space::Dimension;
use siloflow_dem::spin::InertiaLaw;
use siloflow_dem::values::{FiniteVector, ImpactError, Positive, Share};
use siloflow_dem::walls::config::Wall;
use siloflow_dem::walls::free::FreeWall;
use siloflow_dem::walls::motion::Motion;
use siloflow_dem::walls::silo_file::Silo;

/// The page of reference of the keys, for the help of errors.
pub(crate) const KEYS: &str = include_str!("../../docs/reference/scene-file.md");

/// A scene of grains.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Title shown in pictures.
    #[serde(default)]
    pub title: String,
    /// Seed of all random numbers.
    #[serde(default)]
    pub seed: u64,
    /// Named values for [expressions](siloflow_text::source::parameters), of any unit.
    #[serde(default)]
    pub parameters: BTreeMap<String, f64>,
    /// The method: `Grains` for a scene with the keys here. Scenes of another method have other keys.
    #[serde(default)]
    pub method: Method,
    /// The plane, or solid space. Heights are along its last axis whatever `gravity` is; `check` warns where they differ.
    #[serde(default)]
    pub space: Dimension,
    /// Acceleration of gravity (x, y), in solid space (x, y, z), m/s^2.
    pub gravity: FiniteVector,
    /// Sides beyond which the box repeats itself. Default: none.
    #[serde(default)]
    pub periodic: PeriodicSides,
    /// The law of contacts between grains, and between grains and walls.
    pub contact: Contact,
    /// Parameters of that law for pairs of species, with the same kind of law.
    #[serde(default)]
    pub pairs: Vec<PairOfSpecies>,
    /// Elastic materials for Hertz's law: one for all species, or one for each.
    #[serde(default)]
    pub materials: Vec<Material>,
    /// Moment of inertia, where grains spin; refused with `shapes`, from which it follows. Default: of spheres in solid space, of discs in the plane.
    pub inertia: Option<InertiaLaw>,
    /// Law for the masses of grains from their radii; needed by `spawner`, `feed` and `fill`.
    pub mass: Option<MassLaw>,
    /// Share by which grains of `fill`, `spawner` and `feed` are larger than these say, at the same masses, to make up for the overlaps of soft contacts.
    /// Default: 0.
    pub growth: Option<Share>,
    /// Integration scheme. Default `Centred`, with `step: Auto` the cheaper of `Centred` and `Verlet`.
    #[serde(default)]
    pub integrator: Integrator,
    /// Time step.
    pub step: TimeStep,
    /// Neighbour search. Default: a Verlet list with a skin of the smallest radius, in solid space a fifth of it.
    pub neighbours: Option<Neighbours>,
    /// A silo file: wall grains and door grains, in the plane.
    pub silo: Option<Silo>,
    /// Shapes of grains by name; without, grains are spheres (discs).
    #[serde(default)]
    pub shapes: BTreeMap<String, ShapeConfig>,
    /// Walls: surfaces, and discs or spheres that are fixed grains.
    #[serde(default)]
    pub walls: Vec<Wall>,
    /// A file with the grains at the start.
    pub grains: Option<GrainFile>,
    /// Grains at the start, on lattices or at random places.
    #[serde(default)]
    pub fill: Vec<Fill>,
    /// Releases grains one by one.
    pub spawner: Option<Spawner>,
    /// Releases grains at a rate in a region; not beside `spawner`.
    #[serde(default)]
    pub feed: Vec<Feed>,
    /// Detects rest.
    pub rest: Option<Rest>,
    /// Opens the door of door grains, or of walls with `door: true`.
    pub door: Option<DoorControl>,
    /// Opens doors whose walls have names.
    #[serde(default)]
    pub doors: Vec<NamedDoor>,
    /// Moves walls that have names.
    #[serde(default)]
    pub motions: Vec<Motion>,
    /// Lets forces move walls that have names.
    #[serde(default)]
    pub free_walls: Vec<FreeWall>,
    /// Removes grains that have fallen far enough.
    pub cull: Option<Cull>,
    /// Effect of a lost grain on the run.
    #[serde(default)]
    pub on_loss: OnLoss,
    /// Limits that stop a faulty run; with `None` only non-finite numbers stop it.
    #[serde(default = "default_watchdog")]
    pub watchdog: Option<Watchdog>,
    /// Whether the [energy balance](crate::energy) is computed, which takes time. Without it there are no energy flows in `summary.json` and
    /// `series.csv`, and the watchdog checks overlaps alone; the motion is the same to the last bit. Default `true`.
    #[serde(default = "default_energy_balance", alias = "energy_books")]
    pub energy_balance: bool,
    /// At least one of so many steps [sums](crate::energy::sampling) the dissipation of the energy balance; with 1 every step does. Default: one in
    /// 4 with 1000 grains or more, one in 8 with 10,000 or more, else every step; more on demand.
    pub energy_balance_every: Option<NonZeroU32>,
    /// Latest end of the run in simulated time, s.
    pub until: Positive,
    /// Conditions that end the run before `until`.
    #[serde(default)]
    pub stop: Vec<StopCondition>,
    /// Restarts the flow when the outlet is clogged.
    pub kick: Option<Kick>,
    /// Measures fill height and packing fraction at rest, in the plane.
    pub bed: Option<Bed>,
    /// Averages over bins along an axis, written to `profiles.csv`.
    #[serde(default)]
    pub profiles: Vec<Profile>,
    /// Averages on grids: densities, velocity, temperature, stress and shares of species, written to `fields.csv`.
    #[serde(default)]
    pub fields: Vec<Field>,
    /// Pressure and friction on walls by height, written to `wall_bands.csv`.
    #[serde(default)]
    pub wall_bands: Vec<WallBands>,
    /// Angles of the free surface, written to `slopes.csv` and `summary.json`.
    #[serde(default)]
    pub slopes: Vec<Slope>,
    /// A field of mean velocity while grains flow out, in the plane, written to `flow.csv`.
    pub flow: Option<Flow>,
    /// Figures of the discharge over a window of time: rates with confidence intervals, residence time and segregation, in `summary.json`.
    pub outflow: Option<Outflow>,
    /// The rows of `series.csv` and of other files. Default: interval 0.05.
    #[serde(default)]
    pub series: Series,
    /// Checkpoints; `None` for none.
    #[serde(default = "default_checkpoint")]
    pub checkpoint: Option<CheckpointConfig>,
    /// The snapshots; `None` for none.
    #[serde(default = "default_pictures")]
    pub pictures: Option<Pictures>,
    /// The frames of data; `None` for none.
    #[serde(default = "default_data_frames")]
    pub data_frames: Option<DataFrames>,
    /// Behaviours that the program registered, each with keys of its own.
    #[serde(default)]
    pub behaviours: BTreeMap<String, Box<RawValue>>,
}

impl Scene {
    /// The doors: their numbers, the keys that control them, and how.
    #[must_use]
    pub fn door_controls(&self) -> Vec<(u16, String, DoorControl)> {
        let own = self.door.iter().map(|control| (0, "door".to_owned(), control.clone()));
        let named = (1u16..).zip(&self.doors).map(|(number, door)| {
            let control = DoorControl { opens: door.opens.clone(), how: door.how };
            (number, format!("doors[{}]", number - 1), control)
        });
        own.chain(named).collect()
    }

    /// Whether any door ever opens.
    #[must_use]
    pub fn opens_a_door(&self) -> bool {
        self.door_controls().iter().any(|(_, _, control)| control.opens != DoorOpens::Never)
    }

    /// The number of the door that a wall belongs to.
    #[must_use]
    pub fn door_of(&self, wall: &Wall) -> Option<u16> {
        let named = (1u16..).zip(&self.doors).find(|(_, door)| wall.name() == Some(&door.walls));
        named.map(|(number, _)| number).or_else(|| wall.door.then_some(0))
    }

    /// The conditions that end the run early: `stop`, and rest if `rest.stop` asks for it.
    #[must_use]
    pub fn stop_conditions(&self) -> Vec<StopCondition> {
        let at_rest = self.rest.is_some_and(|rest| rest.stop) && !self.stop.contains(&StopCondition::AtRest);
        self.stop.iter().copied().chain(at_rest.then_some(StopCondition::AtRest)).collect()
    }
}

/// The scene's `step`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum TimeStep {
    /// A fixed time step, s.
    Fixed(Positive),
    /// The largest step that keeps the [rms error of impacts](crate::scene::check::automatic) within a bound. An impact at the worst phase of a step
    /// may have up to 2.5 times this error.
    Auto {
        /// Root-mean-square error of the velocities after an impact, over the impact speed.
        error: ImpactError,
    },
}

#[expect(clippy::unnecessary_wraps, reason = "the default of a field of this type")]
fn default_pictures() -> Option<Pictures> {
    Some(Pictures::default())
}

#[expect(clippy::unnecessary_wraps, reason = "the default of a field of this type")]
fn default_data_frames() -> Option<DataFrames> {
    Some(DataFrames::default())
}

fn default_energy_balance() -> bool {
    true
}

#[expect(clippy::unnecessary_wraps, reason = "the default of a field of this type")]
fn default_watchdog() -> Option<Watchdog> {
    Some(Watchdog::default())
}
