//! Means over seeds, and the statistical test whether two means differ.
//!
//! With n seeds a mean has the standard error se = s/sqrt(n), where s is the standard deviation of the sample. Two
//! means a and b differ by more than the noise if |a - b| > t sqrt(se_a^2 + se_b^2). Here t is from Student's
//! distribution with 2 (n - 1) degrees of freedom, such that equal means appear to differ in one of a hundred
//! comparisons. Runs at different steps count as independent even with the same seed, because they are so after the
//! first few collisions.

use serde::Serialize;

use siloflow_figures::statistics::mean::Mean;
use siloflow_figures::statistics::student::t_99;

/// A mean over seeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeanOfRuns {
    /// The mean.
    pub mean: f64,
    /// Standard error of the mean; `null` for a single run.
    pub standard_error: Option<f64>,
    /// Number of runs.
    pub runs: usize,
}

impl MeanOfRuns {
    /// Returns the mean of `values`; `None` if there are none.
    #[must_use]
    pub fn of(values: &[f64]) -> Option<Self> {
        let Mean { value, error } = Mean::of(values)?;
        Some(Self { mean: value, standard_error: (values.len() > 1).then_some(error), runs: values.len() })
    }

    /// Returns the noise: the smallest significant difference between this mean and `other`.
    #[must_use]
    pub fn noise(&self, other: &Self) -> f64 {
        self.standard_error_of_difference(other) * t_99(self.runs + other.runs - 2)
    }

    fn standard_error_of_difference(&self, other: &Self) -> f64 {
        self.standard_error.unwrap_or(0.0).hypot(other.standard_error.unwrap_or(0.0))
    }

    /// Returns the number of runs for each mean that would reduce the noise to `error` times `other`.
    #[must_use]
    pub fn runs_for(&self, other: &Self, error: f64) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "a small number")]
        let runs = self.runs as f64;
        // For many runs, t approaches the value 2.58 of the normal distribution.
        runs * (2.58 * self.standard_error_of_difference(other) / (error * other.mean.abs())).powi(2)
    }
}

/// Result of comparing a mean with the mean at the finest step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// The mean is itself at the finest step.
    Finest,
    /// The sum of difference and noise is within the target error.
    Within,
    /// The difference is within the noise, but difference plus noise exceed the target error.
    NotToldApart,
    /// The difference exceeds the noise but not the target error.
    DiffersWithin,
    /// The difference exceeds both the noise and the target error.
    Differs,
}

impl Standing {
    /// Compares `mean` with `finest` for the relative target error `error`.
    #[must_use]
    pub fn of(mean: &MeanOfRuns, finest: &MeanOfRuns, error: f64) -> Self {
        let difference = (mean.mean - finest.mean).abs();
        let noise = mean.noise(finest);
        let allowed = error * finest.mean.abs();
        // If the seed has no effect the noise is 0, and a difference in the last bit is significant.
        match (difference <= noise, difference <= allowed) {
            (true, _) if difference + noise <= allowed => Self::Within,
            (true, _) => Self::NotToldApart,
            (false, true) => Self::DiffersWithin,
            (false, false) => Self::Differs,
        }
    }

    /// Returns whether the difference exceeds the noise.
    #[must_use]
    pub fn is_told_apart(self) -> bool {
        matches!(self, Self::DiffersWithin | Self::Differs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_standard_error_are_exact() {
        let mean = MeanOfRuns::of(&[1.0, 2.0, 3.0, 4.0]).unwrap();
        // The variance of the sample is 5/3; it is divided by 4 runs.
        assert!((mean.mean - 2.5).abs() < 1e-15);
        assert!((mean.standard_error.unwrap() - (5.0f64 / 12.0).sqrt()).abs() < 1e-15);
        assert_eq!(MeanOfRuns::of(&[7.0]), Some(MeanOfRuns { mean: 7.0, standard_error: None, runs: 1 }));
        assert_eq!(MeanOfRuns::of(&[]), None);
    }

    #[test]
    fn differences_below_the_noise_are_not_significant() {
        let mean = |values: &[f64]| MeanOfRuns::of(values).unwrap();
        let finest = mean(&[9.9, 10.0, 10.0, 10.1]);
        assert_eq!(Standing::of(&mean(&[10.0, 10.1, 10.1, 10.2]), &finest, 1e-3), Standing::NotToldApart);
        assert_eq!(Standing::of(&mean(&[10.0, 10.1, 10.1, 10.2]), &finest, 0.1), Standing::Within);
        assert_eq!(Standing::of(&mean(&[11.0, 11.0, 11.0, 11.1]), &finest, 1e-2), Standing::Differs);
        assert_eq!(Standing::of(&mean(&[11.0, 11.0, 11.0, 11.1]), &finest, 0.2), Standing::DiffersWithin);
        // With one run each there is no noise.
        assert_eq!(Standing::of(&mean(&[10.05]), &mean(&[10.0]), 1e-2), Standing::DiffersWithin);
    }
}
