//! Figures of runs: the numbers for which a sweep or an estimate runs a scene.

mod excerpt;
pub mod figure;
mod rows;
pub mod summary;
pub mod words;
