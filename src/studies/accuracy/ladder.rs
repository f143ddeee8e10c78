//! The ladder of time steps, and the errors of a case along it.

use std::f64::consts::PI;

use super::case::{Answer, Case};
use super::work_precision::{order, order_of_all};
use super::{SCHEMES, Scheme, trial};

/// Steps per contact of each rung of the ladder, without pi/8. Each rung adds pi/8, so that no step divides t_c.
pub const WHOLE: [f64; 8] = [5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0];
/// Steps per contact of each rung of the short ladder, without pi/8.
pub const SHORT: [f64; 4] = [10.0, 20.0, 50.0, 100.0];

/// Returns the rungs of a case as t_c/dt, ascending; `quick` selects the short ladder.
#[must_use]
pub fn rungs(case: &Case, quick: bool) -> Vec<f64> {
    let whole = if quick { &SHORT[..] } else { &WHOLE[..] };
    whole.iter().filter(|&&n| n <= case.finest).map(|n| n + PI / 8.0).collect()
}

/// Result of one step of the ladder.
#[derive(Clone, Debug)]
pub struct Rung {
    /// t_c/dt.
    pub steps: f64,
    /// Rms error. It is infinite if the run broke down and `None` if the scene check refused the step.
    pub error: Option<f64>,
    /// Order of convergence between the next coarser rung and this one.
    pub order: Option<f64>,
    /// Reason of the refusal.
    pub refusal: Option<String>,
}

/// Results of one case with one scheme.
#[derive(Clone, Debug)]
pub struct Climb {
    /// Name of the case.
    pub case: &'static str,
    /// Title in tables and figures.
    pub title: &'static str,
    /// Index of the scheme in [`SCHEMES`].
    pub scheme: usize,
    /// Results by step, coarse to fine; empty if the scheme cannot run this case.
    pub rungs: Vec<Rung>,
    /// Reason why the scheme cannot run this case.
    pub refusal: Option<String>,
    /// Order of convergence over the whole ladder.
    pub order: Option<f64>,
    /// Difference between the reference and the reference at twice its step.
    pub reference_error: f64,
}

impl Climb {
    /// Returns (t_c/dt, error), ascending in t_c/dt.
    #[must_use]
    pub fn points(&self) -> Vec<(f64, f64)> {
        self.rungs.iter().filter_map(|rung| Some((rung.steps, rung.error?))).collect()
    }
}

/// A case with the exact solutions for each of its steps.
pub struct Prepared {
    /// The case.
    pub case: Case,
    rungs: Vec<f64>,
    answers: Vec<Vec<Answer>>,
    reference_error: f64,
}

/// Computes the exact solutions of a case for each step of its ladder; `quick` selects the short ladder.
#[must_use]
pub fn prepare(case: Case, quick: bool) -> Prepared {
    let rungs = rungs(&case, quick);
    let steps: Vec<f64> = rungs.iter().map(|n| case.contact_duration / n).collect();
    let (answers, reference_error) = case.answers(&steps);
    Prepared { case, rungs, answers, reference_error }
}

impl Prepared {
    /// Runs the case with the scheme of this index in [`SCHEMES`].
    ///
    /// If the scene check refuses the finest step, the scheme cannot run this case.
    #[must_use]
    pub fn climb(&self, scheme: usize) -> Climb {
        let Case { name, title, .. } = self.case;
        let mut climb = Climb {
            case: name,
            title,
            scheme,
            rungs: Vec::new(),
            refusal: None,
            order: None,
            reference_error: self.reference_error,
        };
        // The finest step runs first: if it is refused, the coarser ones need not run.
        for (&steps, answers) in self.rungs.iter().zip(&self.answers).rev() {
            let (error, refusal) = self.rung(&SCHEMES[scheme], steps, answers);
            if refusal.is_some() && climb.rungs.is_empty() {
                climb.refusal = refusal;
                return climb;
            }
            climb.rungs.push(Rung { steps, error, order: None, refusal });
        }
        climb.rungs.reverse();
        for n in 1..climb.rungs.len() {
            let point = |rung: &Rung| rung.error.map(|error| (rung.steps, error));
            let ends = point(&climb.rungs[n - 1]).zip(point(&climb.rungs[n]));
            climb.rungs[n].order = ends.and_then(|(coarse, fine)| order(coarse, fine));
        }
        climb.order = order_of_all(&climb.points());
        climb
    }

    fn rung(&self, scheme: &Scheme, steps: f64, answers: &[Answer]) -> (Option<f64>, Option<String>) {
        match trial::errors(&self.case, answers, scheme, self.case.contact_duration / steps) {
            Ok(errors) => (Some(rms(&errors)), None),
            Err(fault) => (None, Some(fault.to_string())),
        }
    }
}

/// Returns the root mean square; infinite if an error is NaN.
#[must_use]
pub fn rms(errors: &[f64]) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "a small number")]
    let mean = errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64;
    if mean.is_nan() { f64::INFINITY } else { mean.sqrt() }
}
