//! Writers for files of any content: CSV rows that survive a crash of the run, SVG and PNG drawings, plots, and a
//! thread that writes pictures during a run. This module contains no physics.

pub mod colour;
pub mod fnv;
pub mod frame_writer;
pub mod marked;
pub mod memory;
pub mod movie;
pub mod plot;
pub mod png;
pub mod provenance;
pub mod rows;
pub mod svg;
pub mod volume;
pub mod whole_file;

/// Version of the format of `summary.json`.
pub const SUMMARY_FORMAT: u32 = 1;
