//! `summary.json` of a lattice gas: the results of a run, in a stable format for scripts.
//!
//! `format` increases when a key is removed or changes its meaning. Keys may be added without a new format. A value is
//! `null` if its event did not happen.

use std::collections::BTreeMap;
use std::io::{self, Write};

use bevy_ecs::prelude::*;
use serde::Serialize;

use crate::ending::EmptyTime;
use crate::lattice_silo::door::DoorState;
use crate::lattice_silo::load::LoadedLattice;
use crate::lattice_silo::rest::RestDetector;
use crate::measure::outputs::{self, Values};
use crate::writers::SUMMARY_FORMAT;
use crate::writers::fnv::Fnv;
use crate::writers::hashes::SummaryFiles;
use crate::writers::memory::peak_memory;
use crate::writers::provenance::Provenance;
use crate::writers::run_files::Damage;
use siloflow_dem::outcome::End;
use siloflow_dem::persist::CheckpointFigures;
use siloflow_dem::space::Vector;
use siloflow_dem::step::Clock;
use siloflow_dem::threads::Threads;
use siloflow_files::columns::Cell::{Decimal, Whole};
use siloflow_files::columns::{Column, Columns};
use siloflow_lattice::gas::Gas;
use siloflow_lattice::rules::Rules;
use siloflow_lattice::sites::Sites;

/// The content of `summary.json`.
#[derive(Debug, Serialize)]
pub struct Summary {
    /// Version of the format, [`SUMMARY_FORMAT`].
    pub format: u32,
    /// Name of the scene.
    pub scene: String,
    /// Values of the scene's parameters. The key is absent if the scene has none.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, f64>,
    /// Method of the scene: `LatticeGas`.
    pub method: &'static str,
    /// End of the run: `empty`, `at_rest`, `time_reached` for a regular end, `interrupted` by a signal, `failed` for a
    /// failure.
    pub status: &'static str,
    /// Cause of a failure.
    pub failure: Option<String>,
    /// Number of completed steps.
    pub steps: u64,
    /// Number of fluid sites.
    pub sites: usize,
    /// Numbers of particles.
    pub particles: Particles,
    /// Step at the end of which rest was detected.
    pub rest_step: Option<u64>,
    /// Step at the end of which the door opened.
    pub door_open_step: Option<u64>,
    /// Step at the end of which the silo was empty.
    pub empty_step: Option<u64>,
    /// Values that behaviours register, by behaviour and name. The key is absent without one.
    #[serde(skip_serializing_if = "Values::is_empty")]
    pub behaviours: Values,
    /// Cost of the run.
    pub performance: Performance,
    /// Version, command, date and machine; `null` unless `siloflow run` wrote the summary.
    pub provenance: Option<Provenance>,
    /// Checkpoints during the run; `null` if none was taken.
    pub checkpoints: Option<CheckpointFigures>,
    /// Hash of the final state ([`state_hash`]), as 16 hexadecimal digits.
    pub state_hash: String,
    /// Damaged files without which the run was continued. The key is absent without any.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub damaged: Vec<Damage>,
    /// The files of the run; `null` unless `siloflow run` wrote the summary.
    pub files: Option<SummaryFiles>,
}

/// Numbers of particles: entered = inside + out.
#[derive(Debug, Serialize)]
pub struct Particles {
    /// Particles that entered.
    pub entered: u64,
    /// Particles that are inside at the end.
    pub inside: u64,
    /// Particles that left through the door.
    pub out: u64,
}

/// Cost of a run, and its parameters.
#[derive(Debug, Serialize)]
pub struct Performance {
    /// Wall-clock time of the steps, s.
    pub wall_s: f64,
    /// Number of steps times number of fluid sites.
    pub site_updates: u64,
    /// Site updates per second of wall-clock time, 1/s.
    pub site_updates_per_s: f64,
    /// Largest resident set of the program up to the end of the last step, including set-up, bytes. `null` if the
    /// system does not report it.
    pub peak_memory_bytes: Option<u64>,
    /// Number of threads.
    pub threads: usize,
    /// Parameters of the automaton.
    pub rules: Rules,
}

/// Returns a hash of the states of all fluid sites: FNV-1a, 64 bits, over 2 little-endian bytes per site, in the order
/// of the site index.
#[must_use]
pub fn state_hash(sites: &Sites, gas: &Gas) -> u64 {
    let mut hash = Fnv::default();
    sites.fluid().for_each(|s| hash.update(&gas.states()[s].to_le_bytes()));
    hash.value()
}

/// The columns of `state.csv`: place (m) and state of a site.
pub(crate) const STATE: &[Column<(Vector, u16)>] = &[
    Column::new("x_m", "m", "place of the site; sites without particles have no row", |(x, _)| Decimal(x.x)),
    Column::new("y_m", "m", "place of the site; sites without particles have no row", |(x, _)| Decimal(x.y)),
    Column::new("state", "", "bit *i* is set if a particle has velocity *i*", |&(_, state)| Whole(state.into())),
];

/// Writes `state.csv`, with the columns `STATE`.
///
/// # Errors
/// If the file cannot be written.
pub fn write_state(sites: &Sites, gas: &Gas, file: &mut dyn Write) -> io::Result<()> {
    let columns = Columns::of(false, &[STATE]);
    writeln!(file, "{}", columns.header())?;
    for s in sites.fluid().filter(|&s| gas.states()[s] != 0) {
        writeln!(file, "{}", columns.cells(&(sites.position(s), gas.states()[s])))?;
    }
    Ok(())
}

impl Summary {
    /// Creates the summary of a run that ended with `end` after `wall_s` seconds of wall-clock time.
    #[must_use]
    pub fn of(world: &mut World, loaded: &LoadedLattice, end: &End, wall_s: f64) -> Self {
        let behaviours = outputs::summary_values(world);
        let sites = world.resource::<Sites>();
        let gas = world.resource::<Gas>();
        let clock = world.resource::<Clock>();
        let failure = match end {
            End::Failed(failure) => Some(failure.to_string()),
            _ => None,
        };
        let site_updates = clock.steps * sites.fluid_count() as u64;
        #[expect(clippy::cast_precision_loss, reason = "a speed needs few digits")]
        let speed = site_updates as f64 / wall_s.max(f64::MIN_POSITIVE);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of steps")]
        let empty_step = world.resource::<EmptyTime>().0.map(|time| time as u64);
        Self {
            format: SUMMARY_FORMAT,
            scene: loaded.source.name.clone(),
            parameters: loaded.scene.parameters.clone(),
            method: "LatticeGas",
            status: end.word(),
            failure,
            steps: clock.steps,
            sites: sites.fluid_count(),
            particles: Particles { entered: gas.entered(), inside: gas.inside(), out: gas.out() },
            rest_step: world.get_resource::<RestDetector>().and_then(|rest| rest.rest_step),
            door_open_step: world.get_resource::<DoorState>().and_then(|door| door.open_step),
            empty_step,
            behaviours,
            performance: Performance {
                wall_s,
                site_updates,
                site_updates_per_s: speed,
                peak_memory_bytes: peak_memory(),
                threads: world.resource::<Threads>().count(),
                rules: loaded.rules,
            },
            provenance: None,
            damaged: Vec::new(),
            files: None,
            checkpoints: world.get_resource().copied(),
            state_hash: format!("{:016x}", state_hash(sites, gas)),
        }
    }
}
