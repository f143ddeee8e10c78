//! The effect of half of the step: two runs at the softest stiffness that counts, compared with the others of that stiffness.
//!
//! The standard error of the difference takes the scatter of single runs from the fit. A difference beyond Student's limit at a significance of 1 % refuses
//! the estimate.

use siloflow_figures::statistics::extrapolation::Group;
use siloflow_figures::statistics::quantile::student;
use siloflow_text::fault::Fault;

use super::answer::Answer;
use super::estimator::{Sampler, take};
use super::goal::Goal;
use super::rung::Rung;

/// Runs with half of the step.
const RUNS_OF_HALF_STEP: usize = 2;

/// The effect of half of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepCheck {
    /// Change of the mean.
    pub change: f64,
    /// Its standard error.
    pub error: f64,
    /// Whether it is more than chance, at a significance of 1 %.
    pub is_significant: bool,
}

/// Compares the softest rung that counts with runs of half of its step. `None` if there is nothing to compare.
///
/// # Errors
/// If a run cannot be made.
pub fn check_step(
    answer: &mut Answer,
    goal: &Goal,
    sampler: &mut impl Sampler,
    half_step: usize,
) -> Result<Option<StepCheck>, Fault> {
    let Some(fit) = answer.fit else { return Ok(None) };
    let Some(own) = Group::of(&answer.rungs[answer.softest].values) else { return Ok(None) };
    let mut half = Rung::default();
    let made = take(goal, sampler, &[half_step; RUNS_OF_HALF_STEP], &mut answer.spent)?;
    for sample in made {
        half.add(sample);
    }
    let Some(halved) = Group::of(&half.values) else { return Ok(None) };
    let change = halved.mean - own.mean;
    let error = fit.deviation * (1.0 / halved.count + 1.0 / own.count).sqrt();
    let limit = student(0.99, fit.freedom);
    Ok(Some(StepCheck { change, error, is_significant: change.abs() > limit * error }))
}
