//! A mean rate with its 95 % confidence interval.
//!
//! The mean of the rates of n blocks of time, of standard deviation s, has the interval t s/sqrt(n) on each side, with Student's t
//! for n - 1 degrees of freedom. It is sound if the flows of successive blocks are independent.

use serde::Serialize;

use super::student::t_95;

/// A mean with its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rate {
    /// Mean of the blocks.
    pub mean: f64,
    /// Lower end of the interval; `None` below two blocks.
    pub low: Option<f64>,
    /// Upper end.
    pub high: Option<f64>,
}

impl Rate {
    /// Most blocks of which [`Rate::of`] takes the mean.
    pub const MOST_BLOCKS: usize = 16;

    /// Returns the mean of the rates of at most [`Self::MOST_BLOCKS`] blocks, with its interval.
    ///
    /// # Panics
    /// With more blocks.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "16 blocks")]
    pub fn of(rates: &[f64]) -> Self {
        let n = rates.len() as f64;
        let mean = rates.iter().sum::<f64>() / n;
        let squares: f64 = rates.iter().map(|rate| (rate - mean).powi(2)).sum();
        let half = (rates.len() > 1).then(|| t_95(rates.len() - 1) * (squares / (n - 1.0) / n).sqrt());
        Self { mean, low: half.map(|half| mean - half), high: half.map(|half| mean + half) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_has_the_width_of_student_s_distribution() {
        // 2 and 4: standard deviation sqrt 2, so the interval is 12.706 on each side. Table of Student's t.
        assert_eq!(Rate::of(&[2.0, 4.0]), Rate { mean: 3.0, low: Some(3.0 - 12.706), high: Some(3.0 + 12.706) });
        assert_eq!(Rate::of(&[2.0]), Rate { mean: 2.0, low: None, high: None });
    }
}
