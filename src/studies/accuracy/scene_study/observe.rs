//! One run of a scene and its observables.

use std::num::NonZeroUsize;
use std::time::Instant;

use bevy_ecs::prelude::*;

use crate::behaviour::Registry;
use crate::ledger::Ledger;
use crate::output::summary::grains::free_grains;
use crate::output::summary::{Cost, Summary};
use crate::scene::loaded::Loaded;
use crate::simulation::Simulation;
use siloflow_dem::gravity::Gravity;
use siloflow_dem::space::{Dimension, Plane, Solid, Space};
use siloflow_dem::store::ParticleStore;
use siloflow_text::fault::Fault;

/// Way in which an observable is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// By its relative difference from the value at the finest step.
    Value,
    /// As an error by itself, with the exact value 0.
    Error,
}

/// All observables: name with unit, and kind.
pub const OBSERVABLES: [(&str, Kind); 10] = [
    ("rest_time_s", Kind::Value),
    ("empty_time_s", Kind::Value),
    ("discharge_rate_per_s", Kind::Value),
    ("packing_fraction", Kind::Value),
    ("fill_height_m", Kind::Value),
    ("mean_height_m", Kind::Value),
    ("largest_overlap_ratio", Kind::Value),
    ("dissipated_j", Kind::Value),
    ("kinetic_j", Kind::Value),
    ("energy_balance_error", Kind::Error),
];

/// Result of a run.
#[derive(Clone, Debug)]
pub struct Observed {
    /// Values in the order of [`OBSERVABLES`]; `None` if the scene does not have the observable or its event did not
    /// happen.
    pub values: [Option<f64>; OBSERVABLES.len()],
    /// Reason of a failure.
    pub failure: Option<String>,
    /// Hash of the final state.
    pub state_hash: String,
    /// Wall-clock time of the steps, s.
    pub wall_s: f64,
    /// Computing time per particle-step, ns.
    pub ns_per_particle_step: f64,
}

/// One step of the ladder.
pub struct Rung {
    /// Step in units of the scene's own step.
    pub factor: f64,
    /// Step, s.
    pub step: f64,
    /// Result of each seed.
    pub runs: Vec<Observed>,
    /// Reason why the step was not run: the error or the warning of the scene check.
    pub refusal: Option<String>,
}

/// Runs a scene to its end on one thread, without writing files.
///
/// # Errors
/// If a check of the scene refuses it.
pub fn run(loaded: &Loaded, registry: &Registry) -> Result<Observed, Fault> {
    let mut simulation = Simulation::new(loaded, registry, NonZeroUsize::MIN)?;
    let mut cost = Cost::default();
    let start = Instant::now();
    let end = simulation.advance_to_end(|world| cost.updates += free_grains(world) as u64);
    cost.wall_s = start.elapsed().as_secs_f64();
    // The mean height is meaningful only if no grain has left, because grains outside fall without a limit.
    let no_grain_is_out = simulation.world().resource::<Ledger>().out() == 0;
    let height = mean_height(simulation.world()).filter(|_| no_grain_is_out);
    let summary = Summary::of_grains(simulation.world_mut(), loaded, &end, cost, None);
    let results = &summary.results;
    let energy = &results.energy;
    let dissipated = energy.flows.map(|flows| flows.dissipated);
    // The error of the energy balance is relative to the dissipated or the present energy, whichever is larger.
    let turnover = dissipated.unwrap_or(0.0).max(energy.kinetic + energy.rotational + energy.elastic);
    // The kinetic energy at the end; left out if it is no more than the residual motion of a bed at rest.
    let kinetic = energy.kinetic + energy.rotational;
    let kinetic = dissipated.filter(|dissipated| no_grain_is_out && kinetic > 1e-3 * dissipated).map(|_| kinetic);
    let failure = if summary.is_done() {
        None
    } else {
        Some(summary.head.failure.clone().unwrap_or_else(|| format!("{} grains were lost", results.grains.lost)))
    };
    Ok(Observed {
        values: [
            results.rest_time_s,
            results.empty_time_s,
            results.discharge.map(|flow| flow.rate_per_s),
            // An empty window has no packing fraction.
            results.bed.map(|bed| bed.packing_fraction).filter(|&fraction| fraction > 0.0),
            results.bed.map(|bed| bed.fill_height_m),
            height,
            Some(results.max_overlap_ratio).filter(|&ratio| ratio > 0.0),
            dissipated.filter(|&dissipated| dissipated > 0.0),
            kinetic.filter(|&kinetic| kinetic > 0.0),
            energy.balance_error.map(|error| error.abs() / turnover).filter(|error| error.is_finite()),
        ],
        failure,
        state_hash: results.state_hash.clone(),
        wall_s: cost.wall_s,
        ns_per_particle_step: 1e9 / results.performance.particle_steps_per_s,
    })
}

/// Returns the mean height of the grains above the lowest grain, measured against gravity, m.
fn mean_height(world: &World) -> Option<f64> {
    match Dimension::of_world(world) {
        Dimension::Plane => mean_height_in::<Plane>(world),
        Dimension::Solid => mean_height_in::<Solid>(world),
    }
}

fn mean_height_in<V: Space>(world: &World) -> Option<f64> {
    let store = world.resource::<ParticleStore<V>>();
    let gravity = world.resource::<Gravity<V>>().0;
    let up = gravity * (-1.0 / gravity.length_squared().sqrt());
    let grains = store.integrated_rows();
    let heights: Vec<f64> = grains.map(|i| store.body[i].position.dot(up)).collect();
    let lowest = heights.iter().copied().reduce(f64::min)?;
    #[expect(clippy::cast_precision_loss, reason = "fewer than 2^32 grains")]
    let mean = heights.iter().sum::<f64>() / heights.len() as f64;
    Some(mean - lowest).filter(|height| height.is_finite() && *height > 0.0)
}
