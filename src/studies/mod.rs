//! Programs about simulations: each runs many, or compares some.

pub mod accuracy;
pub mod diff;
pub mod estimate;
pub mod figures;
pub mod study;
pub mod sweep;
pub mod validation;
