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

impl Comparison {
    /// Whether the effect of half of the step refuses an interval of this half width: it is more than chance, and too large for the half width that is
    /// wanted. The error of the step itself is taken for twice the effect of its half, as in a scheme of first order.
    #[must_use]
    pub fn matters(self, half: f64, wanted: Option<f64>) -> bool {
        self.is_significant && wanted.is_none_or(|wanted| half + 2.0 * self.change.abs() > wanted)
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_effect_of_the_step_refuses_if_it_is_too_large_for_the_request() {
        let clear = Comparison { change: -0.1, error: 0.01, is_significant: true };
        assert!(clear.matters(0.3, None) && clear.matters(0.3, Some(0.49)));
        assert!(!clear.matters(0.3, Some(0.51)));
        assert!(!Comparison { is_significant: false, ..clear }.matters(0.3, None));
    }
}
