//! The results of a run of the lattice gas in [`summary.json`](crate::output::summary), its state hash and `state.csv`.
//!
//! A value is `null` if its event did not happen.

use std::io::{self, Write};

use bevy_ecs::prelude::*;
use serde::Serialize;

use crate::ending::regular::EmptyTime;
use crate::lattice_silo::door::DoorState;
use crate::lattice_silo::loaded::LoadedLattice;
use crate::lattice_silo::rest::RestDetector;
use crate::measure::outputs::{self, Values};
use crate::output::summary::{Cost, Results, Summary};
use crate::writers::memory::peak_memory;
use crate::writers::provenance::Provenance;
use siloflow_dem::outcome::End;
use siloflow_dem::persist::CheckpointFigures;
use siloflow_dem::space::Vector;
use siloflow_dem::step::Clock;
use siloflow_dem::threads::Threads;
use siloflow_files::columns::Cell::{Decimal, Whole};
use siloflow_files::columns::{Column, Columns};
use siloflow_files::fnv::Fnv;
use siloflow_lattice::gas::Gas;
use siloflow_lattice::rules::Rules;
use siloflow_lattice::sites::Sites;

/// The results of a run of the lattice gas.
#[derive(Debug, Serialize)]
pub struct LatticeResults {
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

impl Results for LatticeResults {
    const METHOD: Option<&'static str> = Some("LatticeGas");

    fn lost(&self) -> u32 {
        0
    }
}

impl Summary<LatticeResults> {
    /// Returns the summary of a run that ended with `end` after `wall_s` seconds of wall-clock time.
    #[must_use]
    pub fn of_lattice(
        world: &mut World,
        loaded: &LoadedLattice,
        end: &End,
        wall_s: f64,
        provenance: Option<Provenance>,
    ) -> Self {
        let results = LatticeResults::of(world, loaded, wall_s, provenance);
        Self::new(world, &loaded.source, &loaded.scene.parameters, end, results)
    }
}

/// Returns the number of site updates of a run so far.
#[must_use]
pub fn site_updates(world: &World) -> u64 {
    world.resource::<Clock>().steps * world.resource::<Sites>().fluid_count() as u64
}

impl LatticeResults {
    /// Returns the results of a run that took `wall_s` seconds of wall-clock time.
    fn of(world: &mut World, loaded: &LoadedLattice, wall_s: f64, provenance: Option<Provenance>) -> Self {
        let behaviours = outputs::summary_values(world);
        let sites = world.resource::<Sites>();
        let gas = world.resource::<Gas>();
        let cost = Cost { wall_s, updates: site_updates(world) };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of steps")]
        let empty_step = world.resource::<EmptyTime>().0.map(|time| time as u64);
        Self {
            sites: sites.fluid_count(),
            particles: Particles { entered: gas.entered(), inside: gas.inside(), out: gas.out() },
            rest_step: world.get_resource::<RestDetector>().and_then(|rest| rest.rest_step),
            door_open_step: world.get_resource::<DoorState>().and_then(|door| door.open_step),
            empty_step,
            behaviours,
            performance: Performance {
                wall_s,
                site_updates: cost.updates,
                site_updates_per_s: cost.updates_per_s(),
                peak_memory_bytes: peak_memory(),
                threads: world.resource::<Threads>().count(),
                rules: loaded.rules,
            },
            provenance,
            checkpoints: world.get_resource().copied(),
            state_hash: format!("{:016x}", state_hash(sites, gas)),
        }
    }
}
