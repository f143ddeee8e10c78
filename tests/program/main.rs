//! Tests of the program as users see it: scenes, searches, threads, files, errors, exit statuses, behaviours.

#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    clippy::float_cmp,
    clippy::missing_panics_doc,
    clippy::must_use_candidate,
    clippy::unwrap_used,
    clippy::similar_names,
    missing_docs,
    reason = "tests count in small numbers and compare exact values"
)]

mod accuracy;
mod architecture;
mod behaviour_outputs;
mod behaviours;
mod callers;
mod checkpoints;
mod checks;
mod command_line;
mod compare;
mod contact_behaviours;
mod diff;
mod digits;
mod divergence;
#[cfg(unix)]
mod docs;
mod doors;
mod energy_samples;
mod estimate;
mod export;
#[cfg(unix)]
mod faults;
mod feeds;
mod fields;
mod fixed_shapes;
mod frame_data;
mod friction_scenes;
mod from_other_walls;
mod from_run;
mod grain_requests;
mod hard;
#[cfg(unix)]
mod hostile;
mod instructions;
mod lammps;
mod lattice;
mod long_runs;
mod meshes;
mod new;
mod outflow;
mod parameters;
#[cfg(unix)]
mod patience;
mod periodic;
mod pins;
mod plots;
mod render;
#[cfg(unix)]
mod report;
#[cfg(unix)]
mod resume;
#[cfg(unix)]
mod run_directory;
#[cfg(unix)]
mod scene_keys;
mod scenes;
mod searches;
mod shaped_results;
mod shapes;
mod silo_file;
mod sliced;
mod slopes;
mod stops;
#[cfg(unix)]
mod strange_runs;
mod sweep;
mod synchronisation;
mod testers;
mod texts;
mod validate;
mod validate_flows;
mod validate_impacts;
mod validate_rates;
#[cfg(unix)]
mod verify;
mod wall_loads;
mod watchdog;
mod without_energy_balance;

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use siloflow::output::state_hash;
use siloflow::prelude::*;

/// Returns the root of the repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Returns a path in `scenes/`.
pub fn scene(name: &str) -> PathBuf {
    root().join("scenes").join(name)
}

/// Loads a scene with settings.
pub fn load(name: &str, settings: &[(&str, &str)]) -> Loaded {
    let settings: Vec<_> = settings.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    load::load(&scene(name), &settings).unwrap_or_else(|fault| panic!("{name}: {fault}"))
}

/// Builds a simulation of a loaded scene.
pub fn simulation(loaded: &Loaded, threads: usize) -> Simulation {
    Simulation::new(loaded, &Registry::default(), NonZeroUsize::new(threads).unwrap()).unwrap()
}

/// Returns the state hash of a simulation.
pub fn hash(simulation: &mut Simulation) -> u64 {
    state_hash::of_world(simulation.world_mut())
}
