//! The files of siloflow: names, lock and record of a run directory, tables, frames of data, and how they are read and written.
//! It imports `siloflow-text` and no other crate of siloflow: no entity-component-system, no physics.
//!
//! Begin with [`run_directory`] for what a run leaves, [`frames`] for `frames.bin`, [`disk`] for what survives a crash.

pub mod binary;
pub mod columns;
pub mod disk;
pub mod flow_means;
pub mod fnv;
pub mod frames;
pub mod growing;
pub mod hashes;
pub mod marked;
pub mod own_files;
pub mod run_directory;
pub mod run_files;
pub mod table;
pub mod whole_file;
