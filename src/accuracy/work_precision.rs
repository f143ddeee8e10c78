//! What can be read off errors at several costs: orders, the cost of a wanted error, who is on the Pareto front.
//!
//! Between two neighbouring points of a ladder an error is taken for a power of the cost, error = A n^-p.

use std::fmt;

use serde::Serialize;

/// Errors below this are rounding, and have no order: thousands of steps, each rounding a place tens of metres from the
/// origin.
pub const ROUND_OFF: f64 = 1e-10;

/// The order p between two costs n with these errors; `None` where an error is round-off or none at all.
#[must_use]
pub fn order(coarse: (f64, f64), fine: (f64, f64)) -> Option<f64> {
    let counts = |error: f64| error.is_finite() && error > ROUND_OFF;
    (counts(coarse.1) && counts(fine.1)).then(|| (coarse.1 / fine.1).ln() / (fine.0 / coarse.0).ln())
}

/// The order of a ladder: the least-squares slope of ln(error) against ln(n) from n = 20 on, where the leading term rules.
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
    let (mut above, mut below) = (0.0, 0.0);
    for (x, y) in logs {
        above += (x - mean.0) * (y - mean.1);
        below += (x - mean.0).powi(2);
    }
    Some(-above / below)
}

/// The cost of a wanted error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Needed {
    /// This many steps a contact.
    Steps(f64),
    /// The coarsest of the ladder is good enough already.
    AtMost(f64),
    /// The finest is not.
    NotReached,
}

impl Needed {
    /// The number of steps, if there is one.
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

/// The cost from which on the error stays at or below `target`; `points` ascend in cost.
#[must_use]
pub fn needed(points: &[(f64, f64)], target: f64) -> Needed {
    let Some(last) = points.iter().rposition(|&(_, error)| error.is_nan() || error > target) else {
        return points.first().map_or(Needed::NotReached, |first| Needed::AtMost(first.0));
    };
    let Some(&(n1, e1)) = points.get(last + 1) else { return Needed::NotReached };
    let (n0, e0) = points[last];
    // An error of nothing at all, or beyond all bounds, has no power law through it.
    let share = if e0.is_finite() && e1 > 0.0 { (e0 / target).ln() / (e0 / e1).ln() } else { 1.0 };
    Needed::Steps(n0 * (n1 / n0).powf(share))
}

/// Which of these (cost, error) are on the Pareto front: nothing else is as cheap or cheaper and better.
#[must_use]
pub fn pareto(points: &[(f64, f64)]) -> Vec<bool> {
    let beats = |a: (f64, f64), b: (f64, f64)| a.0 <= b.0 && a.1 <= b.1 && (a.0 < b.0 || a.1 < b.1);
    points.iter().map(|&point| point.1.is_finite() && !points.iter().any(|&other| beats(other, point))).collect()
}

/// The geometric mean; `None` of nothing.
#[must_use]
pub fn geometric_mean(values: &[f64]) -> Option<f64> {
    #[expect(clippy::cast_precision_loss, reason = "a small number")]
    let count = values.len() as f64;
    (!values.is_empty()).then(|| (values.iter().map(|value| value.ln()).sum::<f64>() / count).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// error = 3 n^-2.
    fn square() -> Vec<(f64, f64)> {
        [10.0, 20.0, 50.0, 100.0, 200.0].map(|n: f64| (n, 3.0 / (n * n))).to_vec()
    }

    #[test]
    fn a_power_law_has_its_order_and_its_cost() {
        // Sums of a few logarithms: round-off.
        assert!((order_of_all(&square()).unwrap() - 2.0).abs() < 1e-12);
        assert!((order(square()[0], square()[1]).unwrap() - 2.0).abs() < 1e-12);
        let Needed::Steps(n) = needed(&square(), 1e-3) else { panic!("not reached") };
        assert!((n - 3000.0f64.sqrt()).abs() < 1e-10, "{n}");
        assert_eq!(needed(&square(), 1e-5), Needed::NotReached);
        assert_eq!(needed(&square(), 0.5), Needed::AtMost(10.0));
    }

    #[test]
    fn what_goes_wrong_at_a_finer_step_counts() {
        let odd = [(10.0, 1e-4), (20.0, f64::INFINITY), (50.0, 1e-5)];
        assert_eq!(needed(&odd, 1e-3), Needed::Steps(50.0));
        assert_eq!(needed(&[], 1e-3), Needed::NotReached);
        assert_eq!(order(odd[1], odd[2]), None);
    }

    #[test]
    fn the_front_has_what_nobody_beats() {
        let points = [(1.0, 0.5), (2.0, 0.1), (2.0, 0.2), (3.0, 0.1), (4.0, f64::INFINITY), (5.0, 0.01)];
        assert_eq!(pareto(&points), [true, true, false, false, false, true]);
        assert!((geometric_mean(&[1.0, 4.0]).unwrap() - 2.0).abs() < 1e-15);
    }
}
