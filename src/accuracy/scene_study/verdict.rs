//! Means over seeds, and whether one can be told from another.
//!
//! With n seeds a mean has the standard error se = s/sqrt(n), s the sample's standard deviation. Two means differ
//! beyond the noise where |a - b| > t sqrt(se_a^2 + se_b^2), with t of Student's distribution for 2 (n - 1) degrees of
//! freedom such that one comparison in a hundred of equals is marked by chance. Seeds of different steps count as
//! independent: after the first few collisions they are.

use serde::Serialize;

/// A mean over seeds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Mean {
    /// The mean.
    pub mean: f64,
    /// Its standard error; `null` of one run.
    pub standard_error: Option<f64>,
    /// Of how many.
    pub runs: usize,
}

impl Mean {
    /// Of these; `None` of nothing.
    #[must_use]
    pub fn of(values: &[f64]) -> Option<Self> {
        if values.is_empty() {
            return None;
        }
        #[expect(clippy::cast_precision_loss, reason = "a small number")]
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
        let standard_error = (values.len() > 1).then(|| (squares / (n - 1.0) / n).sqrt());
        Some(Self { mean, standard_error, runs: values.len() })
    }

    /// By how much this must differ from `other` to be told from it.
    #[must_use]
    pub fn noise(&self, other: &Self) -> f64 {
        self.standard_error_of_difference(other) * student(self.runs + other.runs - 2)
    }

    fn standard_error_of_difference(&self, other: &Self) -> f64 {
        self.standard_error.unwrap_or(0.0).hypot(other.standard_error.unwrap_or(0.0))
    }

    /// How many runs each would bring the noise down to a share `error` of `other`.
    #[must_use]
    pub fn runs_for(&self, other: &Self, error: f64) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "a small number")]
        let runs = self.runs as f64;
        // With that many, t is that of the normal distribution.
        runs * (2.58 * self.standard_error_of_difference(other) / (error * other.mean.abs())).powi(2)
    }
}

/// How one mean stands to that of the finest step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// It is the finest.
    Finest,
    /// Difference and noise together are within the wanted error.
    Within,
    /// It cannot be told from the finest, but the noise is larger than the wanted error.
    NotToldApart,
    /// It differs by more than the noise, though by less than the wanted error.
    DiffersWithin,
    /// It differs by more than noise and wanted error.
    Differs,
}

impl Standing {
    /// Of `mean` against `finest`, for a relative error.
    #[must_use]
    pub fn of(mean: &Mean, finest: &Mean, error: f64) -> Self {
        let (difference, noise) = ((mean.mean - finest.mean).abs(), mean.noise(finest));
        let allowed = error * finest.mean.abs();
        // Without seeds that matter there is no noise, and a difference is one, down to the last bit.
        match (difference <= noise, difference <= allowed) {
            (true, _) if difference + noise <= allowed => Self::Within,
            (true, _) => Self::NotToldApart,
            (false, true) => Self::DiffersWithin,
            (false, false) => Self::Differs,
        }
    }

    /// Whether the step shows in it.
    #[must_use]
    pub fn is_told_apart(self) -> bool {
        matches!(self, Self::DiffersWithin | Self::Differs)
    }
}

/// Student's t that one in a hundred exceeds on either side together, for these degrees of freedom.
fn student(freedom: usize) -> f64 {
    const TABLE: [f64; 14] = [63.66, 9.92, 5.84, 4.60, 4.03, 3.71, 3.50, 3.36, 3.25, 3.17, 3.11, 3.05, 3.01, 2.98];
    match freedom {
        0 => 0.0,
        1..=14 => TABLE[freedom - 1],
        // Below 2.98 and above the normal distribution's 2.58: on the safe side.
        15..=30 => 2.95,
        _ => 2.75,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_has_its_standard_error() {
        let mean = Mean::of(&[1.0, 2.0, 3.0, 4.0]).unwrap();
        // Variance 5/3 of the sample, over 4.
        assert!((mean.mean - 2.5).abs() < 1e-15);
        assert!((mean.standard_error.unwrap() - (5.0f64 / 12.0).sqrt()).abs() < 1e-15);
        assert_eq!(Mean::of(&[7.0]), Some(Mean { mean: 7.0, standard_error: None, runs: 1 }));
        assert_eq!(Mean::of(&[]), None);
    }

    #[test]
    fn what_noise_hides_is_not_told_apart() {
        let mean = |values: &[f64]| Mean::of(values).unwrap();
        let finest = mean(&[9.9, 10.0, 10.0, 10.1]);
        assert_eq!(Standing::of(&mean(&[10.0, 10.1, 10.1, 10.2]), &finest, 1e-3), Standing::NotToldApart);
        assert_eq!(Standing::of(&mean(&[10.0, 10.1, 10.1, 10.2]), &finest, 0.1), Standing::Within);
        assert_eq!(Standing::of(&mean(&[11.0, 11.0, 11.0, 11.1]), &finest, 1e-2), Standing::Differs);
        assert_eq!(Standing::of(&mean(&[11.0, 11.0, 11.0, 11.1]), &finest, 0.2), Standing::DiffersWithin);
        // One run each, nothing random: no noise.
        assert_eq!(Standing::of(&mean(&[10.05]), &mean(&[10.0]), 1e-2), Standing::DiffersWithin);
    }
}
