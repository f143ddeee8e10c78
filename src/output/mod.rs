//! Output of a run in its run directory: CSV rows, pictures, the final state and the summary.

pub mod checkpoint;
pub mod cost;
pub mod fields;
pub mod flow;
pub mod frame_recording;
pub mod free_walls;
pub mod losses;
pub mod outflow;
pub mod parent;
pub mod pictures;
pub mod profiles;
pub mod series;
pub mod slopes;
pub mod state_hash;
pub mod summary;
pub mod verification;
pub mod wall_bands;
pub mod walls;
