//! Means of observables over the seeds, with their standard errors.

use std::collections::BTreeSet;

use crate::lattice_silo::observables::Quantity;
use crate::studies::study::plan::Variant;
use crate::studies::study::replica::Replica;

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
    #[expect(clippy::cast_precision_loss, reason = "a few seeds")]
    pub fn of(values: &[f64]) -> Option<Self> {
        let n = values.len() as f64;
        let value = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|x| (x - value).powi(2)).sum();
        let error = if values.len() > 1 { (squares / (n - 1.0) / n).sqrt() } else { 0.0 };
        (!values.is_empty()).then_some(Self { value, error })
    }
}

/// All replicas of a study.
#[derive(Debug)]
pub struct Results(pub Vec<Replica>);

impl Results {
    /// Returns the values of a quantity in the replicas of a variant, leaving out replicas in which it is undefined.
    #[must_use]
    pub fn values(&self, silo: &str, variant: &Variant, quantity: &Quantity) -> Vec<f64> {
        let replicas = self.0.iter().filter(|one| one.case.silo == silo && one.case.variant == *variant);
        replicas.filter_map(|one| (quantity.value)(&one.observables)).collect()
    }

    /// Returns the value of a quantity in one replica; `None` if there is no such replica or the quantity is undefined.
    #[must_use]
    pub fn value(&self, silo: &str, variant: &Variant, seed: u64, quantity: &Quantity) -> Option<f64> {
        let case = |one: &&Replica| one.case.silo == silo && one.case.variant == *variant && one.case.seed == seed;
        self.0.iter().find(case).and_then(|one| (quantity.value)(&one.observables))
    }

    /// Returns the seeds of all replicas, in ascending order.
    #[must_use]
    pub fn seeds(&self) -> BTreeSet<u64> {
        self.0.iter().map(|one| one.case.seed).collect()
    }

    /// Returns the mean of [`Results::values`]; `None` if there are no values.
    #[must_use]
    pub fn mean(&self, silo: &str, variant: &Variant, quantity: &Quantity) -> Option<Mean> {
        Mean::of(&self.values(silo, variant, quantity))
    }
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
}
