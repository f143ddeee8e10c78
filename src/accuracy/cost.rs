//! What a step costs: nanoseconds a particle-step of each scheme, in the bed.
//!
//! A case of two grains would measure the app around them; 400 discs in a bed are what a scene is like. Schemes take turns, so
//! that a machine that slows down slows all of them, and the median of the rounds counts. Figures are of one thread and of
//! this machine now; they belong to a report, never to a test.

use std::num::NonZeroUsize;
use std::time::Instant;

use super::cases::bed;
use super::{SCHEMES, trial};
use crate::behaviour::Registry;
use crate::simulation::Simulation;

/// t_c/dt while it is timed.
const STEPS_A_CONTACT: f64 = 20.4;
/// Steps of a round.
const STEPS: u64 = 1500;

/// Nanoseconds a particle-step of each of [`SCHEMES`]; `None` where the bed refuses it.
#[must_use]
pub fn measure(rounds: usize) -> Vec<Option<f64>> {
    let case = bed();
    let dt = case.contact_duration / STEPS_A_CONTACT;
    let system = &case.systems[0];
    let answer = super::case::Answer { system: system.clone(), start: system.start(), end: system.start() };
    let mut times = vec![Vec::new(); SCHEMES.len()];
    for _ in 0..rounds {
        for (scheme, times) in SCHEMES.iter().zip(&mut times) {
            let loaded = trial::scene(case.name, std::slice::from_ref(&answer), scheme, dt, 1e3);
            let simulation =
                loaded.and_then(|loaded| Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN));
            if let Ok(mut simulation) = simulation {
                times.push(round(&mut simulation) / f64::from(u32::try_from(system.discs.len()).unwrap_or(u32::MAX)));
            }
        }
    }
    times.iter_mut().map(|times| median(times)).collect()
}

/// Nanoseconds a step.
#[expect(clippy::cast_precision_loss, reason = "small numbers")]
fn round(simulation: &mut Simulation) -> f64 {
    simulation.run_steps(10);
    let before = simulation.world().resource::<crate::step::Clock>().steps;
    let start = Instant::now();
    simulation.run_steps(before + STEPS);
    let seconds = start.elapsed().as_secs_f64();
    let steps = simulation.world().resource::<crate::step::Clock>().steps - before;
    1e9 * seconds / steps.max(1) as f64
}

/// The middle one; `None` of nothing.
#[must_use]
pub fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}
