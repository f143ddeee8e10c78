//! The readers of finished runs: reports, figures of runs, comparisons, pictures from frames, and exports.
//!
//! Nothing here simulates, and nothing knows the types of a scene. Facts of a scene come as plain values ([`scene_facts`]), which the app
//! makes. It imports `siloflow-text`, `siloflow-figures` and `siloflow-files`.
//!
//! Begin with [`run_results::RunResults`], the files of a run.

pub mod compare;
pub mod export;
pub mod pictures;
pub mod plot;
#[cfg(feature = "report")]
pub mod report;
pub mod run_results;
pub mod scene_facts;
