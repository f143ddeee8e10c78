//! Files of any content: rows of CSV that survive the death of a run, drawings as SVG and PNG, plots, and a thread that
//! writes pictures while a run goes on. Nothing here knows a grain or a lattice.

pub mod colour;
pub mod fnv;
pub mod frame_writer;
pub mod peak;
pub mod plot;
pub mod png;
pub mod rows;
pub mod svg;

/// The version of the contract that `summary.json` keeps.
pub const SUMMARY_FORMAT: u32 = 1;
