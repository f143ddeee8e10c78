//! Sources of grains: files, lattice fills and the spawner; and grain snapshots.

pub mod file;
pub mod fill;
pub(crate) mod grain_snapshot;
pub mod mass;
pub mod spawner;
