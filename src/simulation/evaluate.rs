//! One run as a function call: a scene and settings in, the summary as JSON out. For programs that calibrate.
//!
//! The run is on one thread and writes no files. Outside of Rust, `siloflow -q run SCENE --set KEY=VALUE --json --out DIR` does the same and
//! leaves a run directory.

use std::num::NonZeroUsize;
use std::path::Path;
use std::time::Instant;

use serde_json::Value;

use crate::behaviour::Registry;
use crate::output::summary::grains::free_grains;
use crate::output::summary::{Cost, Summary};
use crate::scene::load;
use crate::scene::loaded::AnyScene;
use crate::simulation::Simulation;
use siloflow_text::fault::Fault;

/// Runs the scene at `path` with settings (key, value as RON) to its end, and returns the content of `summary.json`. A run that fails has
/// a summary too; its status tells.
///
/// ```no_run
/// use std::path::Path;
/// use siloflow::prelude::*;
/// use siloflow::simulation::evaluate::evaluate;
/// use siloflow::studies::figures::summary::figure;
///
/// let settings = [("contact.tangential.friction".to_owned(), "0.3".to_owned())];
/// let summary = evaluate(Path::new("silo.ron"), &settings, &Registry::default())?;
/// let rate: Option<f64> = figure(&summary, "discharge.rate_per_s").and_then(|rate| rate.parse().ok());
/// # Ok::<(), siloflow::text::fault::Fault>(())
/// ```
///
/// # Errors
/// If the scene is refused with these settings.
pub fn evaluate(path: &Path, settings: &[(String, String)], registry: &Registry) -> Result<Value, Fault> {
    let summary = match load::any(path, settings)? {
        AnyScene::Grains(loaded) => {
            let mut simulation = Simulation::new(&loaded, registry, NonZeroUsize::MIN)?;
            let mut cost = Cost::default();
            let start = Instant::now();
            let end = simulation.advance_to_end(|world| cost.updates += free_grains(world) as u64);
            cost.wall_s = start.elapsed().as_secs_f64();
            serde_json::to_value(Summary::of_grains(simulation.world_mut(), &loaded, &end, cost, None))
        }
        AnyScene::Lattice(loaded) => {
            let mut simulation = Simulation::of_lattice(&loaded, registry, NonZeroUsize::MIN)?;
            let start = Instant::now();
            let end = simulation.run();
            let wall_s = start.elapsed().as_secs_f64();
            serde_json::to_value(Summary::of_lattice(simulation.world_mut(), &loaded, &end, wall_s, None))
        }
    };
    summary.map_err(|error| {
        Fault::new("sweep::summary", format!("could not write the summary as JSON: {error}"))
            .help("this is an error of siloflow")
    })
}
