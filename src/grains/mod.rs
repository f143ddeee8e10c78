//! Sources of grains: files, fills, feeds and the spawner; and grain snapshots.

pub mod feed;
pub mod file;
pub mod fill;
pub mod free_id;
pub(crate) mod grain_snapshot;
pub mod mass;
pub mod occupied;
pub mod pending;
pub mod region;
pub mod shaped;
pub mod sizes;
pub mod spawner;

/// Most grains at the start of a scene, from its file and all its fills: more exceed the memory of most machines, or are a typing
/// error.
pub const MOST_GRAINS: u32 = 10_000_000;
