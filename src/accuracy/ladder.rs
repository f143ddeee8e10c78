//! The ladder of steps, and a case run up it by every scheme.

use std::f64::consts::PI;

use super::case::{Answer, Case};
use super::work_precision::{order, order_of_all};
use super::{SCHEMES, Scheme, trial};

/// Whole numbers of the ladder; a rung has pi/8 steps a contact more, so that no rung divides t_c.
pub const WHOLE: [f64; 8] = [5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0];
/// Those of a short one.
pub const SHORT: [f64; 4] = [10.0, 20.0, 50.0, 100.0];

/// The rungs of a case, t_c/dt, ascending.
#[must_use]
pub fn rungs(case: &Case, quick: bool) -> Vec<f64> {
    let whole = if quick { &SHORT[..] } else { &WHOLE[..] };
    whole.iter().filter(|&&n| n <= case.finest).map(|n| n + PI / 8.0).collect()
}

/// What came of one rung.
#[derive(Clone, Debug)]
pub struct Rung {
    /// t_c/dt.
    pub steps: f64,
    /// Rms error; infinite where the run broke down, `None` where the step was refused.
    pub error: Option<f64>,
    /// The order from the rung before.
    pub order: Option<f64>,
    /// Why there is no error.
    pub refusal: Option<String>,
}

/// A case by one scheme.
#[derive(Clone, Debug)]
pub struct Climb {
    /// Name of the case.
    pub case: &'static str,
    /// For people.
    pub title: &'static str,
    /// Number of the scheme in [`SCHEMES`].
    pub scheme: usize,
    /// Its rungs; none where the scheme is not for this case.
    pub rungs: Vec<Rung>,
    /// Why the scheme is not for this case.
    pub refusal: Option<String>,
    /// Order of the whole ladder.
    pub order: Option<f64>,
    /// By how much the reference differs from itself at twice its step.
    pub reference_error: f64,
}

impl Climb {
    /// (t_c/dt, error), ascending.
    #[must_use]
    pub fn points(&self) -> Vec<(f64, f64)> {
        self.rungs.iter().filter_map(|rung| Some((rung.steps, rung.error?))).collect()
    }
}

/// A case with the answers for each of its rungs.
pub struct Prepared {
    /// The case.
    pub case: Case,
    rungs: Vec<f64>,
    answers: Vec<Vec<Answer>>,
    reference_error: f64,
}

/// Finds the answers.
#[must_use]
pub fn prepare(case: Case, quick: bool) -> Prepared {
    let rungs = rungs(&case, quick);
    let steps: Vec<f64> = rungs.iter().map(|n| case.contact_duration / n).collect();
    let (answers, reference_error) = case.answers(&steps);
    Prepared { case, rungs, answers, reference_error }
}

impl Prepared {
    /// Runs the case by one scheme. A scheme whose finest step is refused is not for this case.
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
        // From the finest on, which tells whether to go on at all.
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

/// Root of the mean of squares; infinite if one of them is no number.
#[must_use]
pub fn rms(errors: &[f64]) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "a small number")]
    let mean = errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64;
    if mean.is_nan() { f64::INFINITY } else { mean.sqrt() }
}
