//! How grains get into a scene: from a file, or released one by one.

pub(crate) mod census;
pub mod file;
pub mod fill;
pub mod mass;
pub mod spawner;
