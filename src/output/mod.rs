//! What a run leaves behind: rows, pictures, the final state and the summary, in one run directory.

pub mod flow;
pub mod frames;
pub mod profiles;
pub mod run_directory;
pub mod series;
pub mod state_hash;
pub mod summary;
pub mod walls;
