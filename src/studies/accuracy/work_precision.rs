//! Orders of convergence, the cost of a target error, and Pareto fronts, computed from errors at several costs.
//!
//! Between two neighbouring points of a ladder the error is assumed to be a power of the cost, error = A n^-p.

use std::fmt;

use serde::Serialize;

/// Errors below this are round-off and have no order. They stem from thousands of steps, each of which rounds a
/// position tens of metres from the origin.
pub const ROUND_OFF: f64 = 1e-10;

/// Returns the order p between two points (cost n, error); `None` if an error is round-off or not finite.
#[must_use]
pub fn order(coarse: (f64, f64), fine: (f64, f64)) -> Option<f64> {
    let counts = |error: f64| error.is_finite() && error > ROUND_OFF;
    (counts(coarse.1) && counts(fine.1)).then(|| (coarse.1 / fine.1).ln() / (fine.0 / coarse.0).ln())
}

/// Returns the order of a ladder: minus the least-squares slope of ln(error) against ln(n) over n > 20, where the
/// leading error term dominates.
#[must_use]
pub fn order_of_all(points: &[(f64, f64)]) -> Option<f64> {
    let counts = |&&(n, error): &&(f64, f64)| n > 20.0 && error.is_finite() && error > ROUND_OFF;
    let logs: Vec<_> = points.iter().filter(counts).map(|(n, error)| (n.ln(), error.ln())).collect();
    if logs.len() < 2 {
        return None;
    }
    #[expect(clippy::cast_precision_loss, reason = "a small number")]
    let count = logs.len() as f64;
    let mean = logs.iter().fold((0.0, 0.0), |sum, log| (sum.0 + log.0 / count, sum.1 + log.1 / count));
    let mut above = 0.0;
    let mut below = 0.0;
    for (x, y) in logs {
        above += (x - mean.0) * (y - mean.1);
        below += (x - mean.0).powi(2);
    }
    Some(-above / below)
}

/// The cost of a target error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Needed {
    /// Steps per contact, interpolated.
    Steps(f64),
    /// All steps of the ladder are good enough; the number is t_c/dt of the coarsest.
    AtMost(f64),
    /// The finest step of the ladder is not good enough.
    NotReached,
}

impl Needed {
    /// Returns the number of steps per contact; `None` if the error is not reached.
    #[must_use]
    pub fn steps(self) -> Option<f64> {
        match self {
            Self::Steps(n) | Self::AtMost(n) => Some(n),
            Self::NotReached => None,
        }
    }
}

impl fmt::Display for Needed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Steps(n) => write!(f, "{n:.0}"),
            Self::AtMost(n) => write!(f, "<{n:.0}"),
            Self::NotReached => f.write_str("-"),
        }
    }
}

/// Returns the lowest cost above which the error stays at or below `target`; `points` are (cost, error) with ascending
/// cost.
#[must_use]
pub fn needed(points: &[(f64, f64)], target: f64) -> Needed {
    let Some(last) = points.iter().rposition(|&(_, error)| error.is_nan() || error > target) else {
        return points.first().map_or(Needed::NotReached, |first| Needed::AtMost(first.0));
    };
    let Some(&(n1, e1)) = points.get(last + 1) else { return Needed::NotReached };
    let (n0, e0) = points[last];
    // There is no power law through a zero or an infinite error.
    let share = if e0.is_finite() && e1 > 0.0 { (e0 / target).ln() / (e0 / e1).ln() } else { 1.0 };
    Needed::Steps(n0 * (n1 / n0).powf(share))
}

/// Returns for each (cost, error) whether it is Pareto-optimal.
///
/// A point is Pareto-optimal if its error is finite and no other point is at least as good in both and better in one.
#[must_use]
pub fn pareto(points: &[(f64, f64)]) -> Vec<bool> {
    let beats = |a: (f64, f64), b: (f64, f64)| a.0 <= b.0 && a.1 <= b.1 && (a.0 < b.0 || a.1 < b.1);
    points.iter().map(|&point| point.1.is_finite() && !points.iter().any(|&other| beats(other, point))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns points with error = 3 n^-2.
    fn second_order() -> Vec<(f64, f64)> {
        [10.0, 20.0, 50.0, 100.0, 200.0].map(|n: f64| (n, 3.0 / (n * n))).to_vec()
    }

    #[test]
    fn order_and_cost_of_a_power_law_are_exact() {
        // The tolerance is the round-off of sums of a few logarithms.
        assert!((order_of_all(&second_order()).unwrap() - 2.0).abs() < 1e-12);
        assert!((order(second_order()[0], second_order()[1]).unwrap() - 2.0).abs() < 1e-12);
        let Needed::Steps(n) = needed(&second_order(), 1e-3) else { panic!("not reached") };
        assert!((n - 3000.0f64.sqrt()).abs() < 1e-10, "{n}");
        assert_eq!(needed(&second_order(), 1e-5), Needed::NotReached);
        assert_eq!(needed(&second_order(), 0.5), Needed::AtMost(10.0));
    }

    #[test]
    fn needed_cost_lies_above_every_failed_step() {
        let odd = [(10.0, 1e-4), (20.0, f64::INFINITY), (50.0, 1e-5)];
        assert_eq!(needed(&odd, 1e-3), Needed::Steps(50.0));
        assert_eq!(needed(&[], 1e-3), Needed::NotReached);
        assert_eq!(order(odd[1], odd[2]), None);
    }

    #[test]
    fn pareto_front_has_exactly_the_undominated_points() {
        let points = [(1.0, 0.5), (2.0, 0.1), (2.0, 0.2), (3.0, 0.1), (4.0, f64::INFINITY), (5.0, 0.01)];
        assert_eq!(pareto(&points), [true, true, false, false, false, true]);
    }
}
