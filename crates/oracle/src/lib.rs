//! A naive simulator of grains, with which the tests compare siloflow: plain loops over all pairs and walls, with vectors and formulas of the
//! contact laws of its own.
//!
//! The crate has no dependencies, so that it shares no code with siloflow. `tests/physics/oracle.rs` describes the comparison.

#![allow(
    clippy::missing_panics_doc,
    clippy::must_use_candidate,
    clippy::return_self_not_must_use,
    clippy::similar_names,
    clippy::unwrap_used,
    missing_docs,
    reason = "only tests use this crate"
)]

pub mod centred;
pub mod clump;
pub mod free_wall;
pub mod law;
pub mod plain;
pub mod simulator;
pub mod vector;
pub mod wall;
