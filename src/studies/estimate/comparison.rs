//! Runs that differ in one thing, compared with the others of their stiffness: half of the step, or a larger silo.
//!
//! Both sides have the softest stiffness that counts. The standard error of the difference takes the scatter of single runs from the fit. A difference is more
//! than chance if it lies beyond Student's limit at a significance of 1 %.
//!
//! Where the seed has no effect, both sides have the stiffness of the scene, and one run tells the difference exactly.

use siloflow_figures::statistics::extrapolation::Group;
use siloflow_figures::statistics::quantile::student;
use siloflow_text::fault::Fault;

use super::answer::Answer;
use super::estimator::{Sampler, take};
use super::goal::Goal;
use super::rung::Rung;

/// The effect of a change of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Change of the mean.
    pub change: f64,
    /// Its standard error.
    pub error: f64,
    /// Whether it is more than chance, at a significance of 1 %.
    pub is_significant: bool,
}

/// Compares the [compared rung](Answer::compared) with some runs of a changed scene. `None` if there is nothing to compare.
///
/// # Errors
/// If a run cannot be made.
pub fn compare(
    answer: &mut Answer,
    goal: &Goal,
    sampler: &mut impl Sampler,
    changed: &[usize],
) -> Result<Option<Comparison>, Fault> {
    let fit = answer.fit.filter(|_| !answer.is_certain);
    let Some(own) = Group::of(&answer.rungs[answer.compared()].values) else { return Ok(None) };
    if fit.is_none() && !answer.is_certain {
        return Ok(None);
    }
    let mut rung = Rung::default();
    for sample in take(goal, sampler, changed, &mut answer.spent)? {
        rung.add(sample);
    }
    let Some(other) = Group::of(&rung.values) else { return Ok(None) };
    let change = other.mean - own.mean;
    let deviation = fit.map_or(0.0, |fit| fit.deviation);
    let error = deviation * (1.0 / other.count + 1.0 / own.count).sqrt();
    let limit = fit.map_or(0.0, |fit| student(0.99, fit.freedom));
    Ok(Some(Comparison { change, error, is_significant: change.abs() > limit * error }))
}
