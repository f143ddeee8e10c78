//! Means of observables over the seeds, with their standard errors.

use std::collections::BTreeSet;

use crate::lattice_silo::observables::Quantity;
use crate::studies::study::plan::Variant;
use crate::studies::study::replica::Replica;
use siloflow_figures::statistics::mean::Mean;

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
