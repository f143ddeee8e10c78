//! How grains get into a scene: from a file, or released one by one.

pub mod file;
pub mod fill;
pub(crate) mod grain_snapshot;
pub mod mass;
pub mod spawner;
