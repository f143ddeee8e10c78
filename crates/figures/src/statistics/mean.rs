//! Means: the arithmetic one with its standard error, the geometric one, and the median.
//!
//! The standard error of the mean of n values is s/sqrt(n), where s is the standard deviation of the sample, with n - 1. It holds
//! for independent values.

/// A mean with its standard error, 0 for a single value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean {
    /// The mean.
    pub value: f64,
    /// The standard error of the mean.
    pub error: f64,
}

impl Mean {
    /// Computes the mean of some values; `None` if there are no values.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "a few values")]
    pub fn of(values: &[f64]) -> Option<Self> {
        let n = values.len() as f64;
        let value = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|x| (x - value).powi(2)).sum();
        let error = if values.len() > 1 { (squares / (n - 1.0) / n).sqrt() } else { 0.0 };
        (!values.is_empty()).then_some(Self { value, error })
    }
}

/// Returns the mean of some values with its standard error; `None` without values.
#[must_use]
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<Mean> {
    Mean::of(&values.into_iter().collect::<Vec<_>>())
}

/// Returns the median (the upper one of an even count); `None` if `values` is empty.
#[must_use]
pub fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Returns the geometric mean; `None` if `values` is empty.
#[must_use]
pub fn geometric_mean(values: &[f64]) -> Option<f64> {
    #[expect(clippy::cast_precision_loss, reason = "a few values")]
    let count = values.len() as f64;
    (!values.is_empty()).then(|| (values.iter().map(|value| value.ln()).sum::<f64>() / count).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_the_standard_error_of_the_mean() {
        // The variance of 1, 2, 3, 4 with n - 1 is 5/3, the variance of their mean 5/12.
        let mean = Mean::of(&[1.0, 2.0, 3.0, 4.0]).unwrap();
        assert!((mean.value - 2.5).abs() < 1e-15 && (mean.error - (5.0f64 / 12.0).sqrt()).abs() < 1e-15);
        assert_eq!(Mean::of(&[7.0]), Some(Mean { value: 7.0, error: 0.0 }));
        assert_eq!(Mean::of(&[]), None);
    }

    #[test]
    fn the_geometric_mean_of_1_and_4_is_2() {
        assert!((geometric_mean(&[1.0, 4.0]).unwrap() - 2.0).abs() < 1e-15);
        assert_eq!((geometric_mean(&[]), median(&mut [])), (None, None));
        assert_eq!(median(&mut [3.0, 1.0, 2.0, 9.0]), Some(3.0));
    }
}
