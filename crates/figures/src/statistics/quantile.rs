//! Quantiles of Student's and Fisher's distribution, and the interval of a probability.
//!
//! The distributions are those of the crate `statrs`.

use statrs::distribution::{Beta, ContinuousCDF as _, FisherSnedecor, StudentsT};

/// An interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// Half of the width.
    #[must_use]
    pub fn half(self) -> f64 {
        0.5 * (self.high - self.low)
    }

    /// Whether a number lies in the interval.
    #[must_use]
    pub fn contains(self, x: f64) -> bool {
        (self.low..=self.high).contains(&x)
    }
}

#[expect(clippy::cast_precision_loss, reason = "counts of runs")]
fn real(count: usize) -> f64 {
    count as f64
}

/// Returns the number that |t| exceeds with probability 1 - `confidence`; infinite without degrees of freedom.
#[must_use]
pub fn student(confidence: f64, freedom: usize) -> f64 {
    let distribution = StudentsT::new(0.0, 1.0, real(freedom));
    distribution.map_or(f64::INFINITY, |it| it.inverse_cdf(0.5 + 0.5 * confidence))
}

/// Returns the probability that Fisher's F exceeds `ratio`; 1 without degrees of freedom.
#[must_use]
pub fn fisher_tail(ratio: f64, above: usize, below: usize) -> f64 {
    FisherSnedecor::new(real(above), real(below)).map_or(1.0, |it| it.sf(ratio.max(0.0)))
}

/// Returns the interval of a probability, if `hits` of `trials` independent trials hit: that of Clopper and Pearson (Biometrika 26, 404, 1934),
/// which contains the probability at least as often as `confidence` says.
#[must_use]
pub fn binomial(confidence: f64, hits: usize, trials: usize) -> Interval {
    let misses = real(trials.saturating_sub(hits));
    let tail = 0.5 * (1.0 - confidence);
    let quantile = |a: f64, b: f64, share: f64| Beta::new(a, b).ok().map(|it| it.inverse_cdf(share));
    Interval {
        low: quantile(real(hits), misses + 1.0, tail).unwrap_or(0.0),
        high: quantile(real(hits) + 1.0, misses, 1.0 - tail).unwrap_or(1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::student::{MOST_95, t_95};

    #[test]
    fn quantiles_are_those_of_the_printed_tables() {
        for freedom in 1..=MOST_95 {
            assert!((student(0.95, freedom) - t_95(freedom)).abs() < 6e-4, "{freedom}");
        }
        assert!(student(0.95, 0).is_infinite());
        // Tables of F: 5 % at 2 and 10 degrees of freedom is 4.103, 1 % at 1 and 5 is 16.26. t^2 is F with 1 above.
        assert!((fisher_tail(4.103, 2, 10) - 0.05).abs() < 1e-4);
        assert!((fisher_tail(16.26, 1, 5) - 0.01).abs() < 1e-4);
        assert!((fisher_tail(t_95(7).powi(2), 1, 7) - 0.05).abs() < 1e-4);
    }

    #[test]
    fn the_interval_of_a_probability_is_that_of_clopper_and_pearson() {
        // Without a hit the upper end is 1 - 0.025^(1/n); the table for 3 of 10 has 0.0667 and 0.6525.
        let none = binomial(0.95, 0, 10);
        assert!(none.low.abs() < 1e-12 && (none.high - (1.0 - 0.025f64.powf(0.1))).abs() < 1e-6, "{none:?}");
        let all = binomial(0.95, 10, 10);
        assert!((all.high - 1.0).abs() < 1e-12 && (all.low - 0.025f64.powf(0.1)).abs() < 1e-6, "{all:?}");
        let some = binomial(0.95, 3, 10);
        assert!((some.low - 0.0667).abs() < 1e-4 && (some.high - 0.6525).abs() < 1e-4, "{some:?}");
    }
}
