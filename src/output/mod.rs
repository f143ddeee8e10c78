//! What a run leaves behind: rows, pictures, the final state and the summary, in one run directory.

pub mod album;
pub mod colour;
pub mod flow;
pub mod frames;
pub mod peak;
pub mod plot;
pub mod png;
pub mod profiles;
pub mod rows;
pub mod run_directory;
pub mod series;
pub mod state_hash;
pub mod summary;
pub mod svg;
pub mod walls;
