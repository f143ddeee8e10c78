//! The study of the lattice gas that its source reports.

pub mod figures;
