//! Writers for files of any content: CSV rows that survive a crash of the run, SVG and PNG drawings, plots, a
//! thread that writes pictures during a run, and the record of what a run has written. This module contains no physics.

pub mod colour;
pub mod disk;
pub mod fnv;
pub mod growing;
pub mod hashes;
pub mod marked;
pub mod memory;
pub mod movie;
pub mod picture_writer;
pub mod plot;
pub mod png;
pub mod provenance;
pub mod rows;
pub mod run_files;
pub mod svg;
pub mod volume;
pub mod whole_file;

/// Version of the format of `summary.json`.
pub const SUMMARY_FORMAT: u32 = 1;
