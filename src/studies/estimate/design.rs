//! Which runs to do next: those that narrow the expected interval most for their cost.
//!
//! The expected half width of a plan is that of a fit to means that lie on the present curve, with the present scatter, and with the numbers of runs of
//! the plan ([`Ladder::fit`]). So it knows both reasons for a wide interval: chance, which runs at the outer rungs reduce, and the unknown power, which
//! a stiffer rung reduces. With a known power the best plan for one point outside has the runs at two rungs, in proportion to their weight over the
//! root of their cost (Elfving 1952, Hoel and Levine 1964: optimal designs for extrapolation); the search finds it by itself.
//!
//! Each step of the search compares 1, 2, 4, ... further runs at every rung by the logarithm of the width that they save, over their cost. Several runs at
//! once are needed to see the use of a rung without any. Once the interval is as narrow as asked for, the cheapest runs that keep it so are best.

use super::rung::Rung;
use siloflow_figures::statistics::extrapolation::{Fit, Group, Ladder};

/// Most further runs that are compared at once.
const MOST_AT_ONCE: u8 = 16;

/// Most steps of the search of [`Design::cost_of`].
const MOST_STEPS: usize = 400;

/// The present curve, and the numbers and costs of runs by rung.
#[derive(Clone, Debug)]
pub struct Design<'a> {
    ladder: &'a Ladder,
    confidence: f64,
    /// Means that the curve expects.
    means: Vec<f64>,
    /// Numbers of runs with the figure.
    counts: Vec<f64>,
    /// Costs of a run, s.
    costs: Vec<f64>,
    /// The softest rung that counts.
    softest: usize,
    variance: f64,
}

impl<'a> Design<'a> {
    /// Makes the design of the present runs.
    #[must_use]
    pub fn new(ladder: &'a Ladder, confidence: f64, fit: &Fit, rungs: &[Rung], softest: usize) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "counts of runs")]
        let count = |(rung, it): (usize, &Rung)| if rung > softest { 0.0 } else { it.values.len() as f64 };
        Self {
            ladder,
            confidence,
            means: ladder.softness().iter().map(|&s| fit.at(s)).collect(),
            counts: rungs.iter().enumerate().map(count).collect(),
            costs: costs(ladder, rungs),
            softest,
            variance: fit.deviation.powi(2),
        }
    }

    /// Returns the expected half width with these numbers of runs.
    fn width(&self, counts: &[f64]) -> f64 {
        let used = counts.iter().filter(|count| **count > 0.0).count();
        let samples: f64 = counts.iter().sum();
        #[expect(clippy::cast_precision_loss, reason = "a few rungs")]
        let freedom = samples - used.min(3) as f64;
        // The scatter of all samples together is that of the degrees of freedom.
        let share = (self.variance * freedom / samples).max(0.0);
        let group = |(count, mean): (&f64, &f64)| {
            (*count > 0.0).then_some(Group { count: *count, mean: *mean, squares: share * count })
        };
        let groups: Vec<_> = counts.iter().zip(&self.means).map(group).collect();
        self.ladder.fit(&groups, self.confidence).map_or(f64::INFINITY, |fit| fit.interval.half())
    }

    /// Returns the rung at which further runs serve most, and their number. `target` is the half width to keep.
    #[must_use]
    pub fn best(&self, target: Option<f64>) -> Addition {
        let now = self.width(&self.counts);
        let stiffest = self.counts.iter().position(|count| *count > 0.0).unwrap_or(self.softest);
        let mut best = Addition { rung: self.softest, runs: 1.0 };
        let mut most = f64::NEG_INFINITY;
        let mut least = f64::INFINITY;
        // The rungs in use, the next stiffer one, and the scene's own stiffness.
        let rungs = (stiffest.saturating_sub(1)..=self.softest).chain((stiffest > 1).then_some(0));
        for rung in rungs {
            let mut more = 1;
            while more <= MOST_AT_ONCE {
                let mut counts = self.counts.clone();
                counts[rung] += f64::from(more);
                let cost = f64::from(more) * self.costs[rung];
                let width = self.width(&counts);
                let addition = Addition { rung, runs: f64::from(more) };
                if target.is_some_and(|target| width <= target) {
                    if cost < least {
                        (least, best) = (cost, addition);
                    }
                    break;
                }
                let saved = (now / width).ln() / cost;
                if least.is_infinite() && saved > most {
                    (most, best) = (saved, addition);
                }
                more *= 2;
            }
        }
        best
    }

    /// Adds a run to the plan, and returns its rung.
    pub fn add_best(&mut self, target: Option<f64>) -> usize {
        let best = self.best(target).rung;
        self.counts[best] += 1.0;
        best
    }

    /// Returns the cost of a run of a rung, s.
    #[must_use]
    pub fn cost(&self, rung: usize) -> f64 {
        self.costs[rung]
    }

    /// Returns the further cost, s, after which the expected half width is at most `half`; `None` if the search does not find a plan.
    #[must_use]
    pub fn cost_of(mut self, half: f64) -> Option<f64> {
        let mut cost = 0.0;
        for _ in 0..MOST_STEPS {
            if self.width(&self.counts) <= half {
                return Some(cost);
            }
            let best = self.best(None);
            self.counts[best.rung] += best.runs;
            cost += best.runs * self.costs[best.rung];
        }
        None
    }
}

/// Runs that are added to a plan.
#[derive(Clone, Copy, Debug)]
pub struct Addition {
    /// Their rung.
    pub rung: usize,
    /// Their number.
    pub runs: f64,
}

/// Returns the cost of a run of each rung, s: its own mean, or that of the nearest rung with runs, times the ratio of the steps.
fn costs(ladder: &Ladder, rungs: &[Rung]) -> Vec<f64> {
    let softness = ladder.softness();
    let known = |&rung: &usize| rungs[rung].runs() > 0;
    let cost = |rung: usize| {
        let nearest = (0..softness.len()).filter(known).min_by_key(|other| other.abs_diff(rung));
        nearest.map_or(1.0, |other| rungs[other].cost_of_a_run() * (softness[other] / softness[rung]).sqrt())
    };
    (0..softness.len()).map(cost).collect()
}
