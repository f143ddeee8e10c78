//! Cost of a step: nanoseconds per particle-step of each scheme, measured in the bed.
//!
//! The bed of 400 discs is representative of a scene; with two grains, the overhead of the app would dominate. The
//! schemes run in turn, so that a machine that slows down slows all of them, and the result is the median over rounds.
//! The numbers hold for one thread and for the machine at the time of the measurement. They belong in a report, not in
//! a test.

use std::num::NonZeroUsize;
use std::time::Instant;

use super::cases::bed;
use super::{SCHEMES, trial};
use crate::behaviour::Registry;
use crate::simulation::Simulation;
use siloflow_figures::statistics::mean::median;

/// t_c/dt of the timed runs.
const STEPS_PER_CONTACT: f64 = 20.4;
/// Timed steps per round.
const STEPS: u64 = 1500;

/// Returns nanoseconds per particle-step of each of [`SCHEMES`]; `None` if the scene of the bed refuses the scheme.
#[must_use]
pub fn measure(rounds: usize) -> Vec<Option<f64>> {
    let case = bed();
    let dt = case.contact_duration / STEPS_PER_CONTACT;
    let system = &case.systems[0];
    let answer = super::case::Answer { system: system.clone(), began: 0.0, start: system.start(), end: system.start() };
    let mut times = vec![Vec::new(); SCHEMES.len()];
    for _ in 0..rounds {
        for (scheme, times) in SCHEMES.iter().zip(&mut times) {
            let loaded = trial::scene(case.name, std::slice::from_ref(&answer), scheme, dt, 1e3);
            let simulation =
                loaded.and_then(|loaded| Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN));
            if let Ok(mut simulation) = simulation {
                times.push(
                    nanoseconds_per_step(&mut simulation)
                        / f64::from(u32::try_from(system.discs.len()).unwrap_or(u32::MAX)),
                );
            }
        }
    }
    times.iter_mut().map(|times| median(times)).collect()
}

/// Times one round and returns nanoseconds per step.
#[expect(clippy::cast_precision_loss, reason = "small numbers")]
fn nanoseconds_per_step(simulation: &mut Simulation) -> f64 {
    simulation.run_steps(10);
    let before = simulation.world().resource::<siloflow_dem::step::Clock>().steps;
    let start = Instant::now();
    simulation.run_steps(before + STEPS);
    let seconds = start.elapsed().as_secs_f64();
    let steps = simulation.world().resource::<siloflow_dem::step::Clock>().steps - before;
    1e9 * seconds / steps.max(1) as f64
}
