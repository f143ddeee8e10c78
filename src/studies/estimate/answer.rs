//! The answer of an estimate: the runs of each rung, and the fit to them.

use siloflow_figures::statistics::extrapolation::{Fit, Group, Ladder, Powers};
use siloflow_figures::statistics::quantile::binomial;

use super::design::Design;
use super::goal::{Goal, Refusal};
use super::rung::Rung;

/// The answer.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The fit; `None` without enough runs.
    pub fit: Option<Fit>,
    /// Whether the seed has no effect.
    pub is_certain: bool,
    /// The softest rung that counts.
    pub softest: usize,
    /// The runs of each rung.
    pub rungs: Vec<Rung>,
    /// Why it is not as good as asked for.
    pub refused: Option<Refusal>,
    /// Cost of all runs over the number of cores, s.
    pub spent: f64,
}

impl Answer {
    /// Number of runs.
    #[must_use]
    pub fn runs(&self) -> usize {
        self.rungs.iter().map(Rung::runs).sum()
    }

    /// Number of runs without the figure.
    #[must_use]
    pub fn missing(&self) -> usize {
        self.rungs.iter().map(|rung| rung.missing).sum()
    }

    /// Fits the runs of all rungs up to one.
    pub(super) fn fit_up_to(&self, softest: usize, ladder: &Ladder, goal: &Goal) -> Option<Fit> {
        let group = |(number, rung): (usize, &Rung)| Group::of(&rung.values).filter(|_| number <= softest);
        let groups: Vec<_> = self.rungs.iter().enumerate().map(group).collect();
        if goal.is_probability {
            return probability(&groups[0]?, goal.confidence);
        }
        ladder.fit(&groups, goal.confidence)
    }

    /// The rung whose runs are compared with those of a changed scene: the softest that counts, or the scene's own if the seed has no effect.
    #[must_use]
    pub fn compared(&self) -> usize {
        if self.is_certain { 0 } else { self.softest }
    }

    /// The stiffest rung with the figure.
    #[must_use]
    pub fn stiffest(&self) -> usize {
        self.rungs.iter().position(|rung| !rung.values.is_empty()).unwrap_or(self.softest)
    }

    /// Time of all runs on their cores, s.
    #[must_use]
    pub fn cost(&self) -> f64 {
        self.rungs.iter().map(|rung| rung.cost).sum()
    }

    /// The design of the runs so far; `None` without a fit.
    #[must_use]
    pub fn design<'a>(&self, ladder: &'a Ladder, confidence: f64) -> Option<Design<'a>> {
        Some(Design::new(ladder, confidence, self.fit.as_ref()?, &self.rungs, self.softest))
    }
}

/// Returns the estimate of a probability from zeros and ones. The runs are all at softness 1.
fn probability(group: &Group, confidence: f64) -> Option<Fit> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "counts of runs")]
    let [hits, trials] = [group.mean * group.count, group.count].map(|count| count.round() as usize);
    let interval = binomial(confidence, hits, trials);
    let powers = Powers { low: 1.0, usual: 1.0, high: 1.0 };
    let deviation = (group.mean * (1.0 - group.mean)).sqrt();
    (trials > 1).then_some(Fit {
        value: group.mean,
        interval,
        chance: interval.half(),
        powers,
        slope: 0.0,
        deviation,
        freedom: trials - 1,
        lack_of_fit: 1.0,
    })
}
