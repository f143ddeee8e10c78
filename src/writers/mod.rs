//! Writers of the app: CSV rows that survive a crash of the run, threads that write beside a run, the pictures of a run, the place of
//! the run directory for behaviours, and facts about machine
//! and output. This module contains no physics.

pub(crate) mod background;
pub mod memory;
pub mod picture_writer;
pub mod provenance;
pub mod rows;
pub mod run_path;
pub mod volume;

/// Version of the format of `summary.json`.
pub const SUMMARY_FORMAT: u32 = 2;
