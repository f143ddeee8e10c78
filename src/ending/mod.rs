//! How a run ends. A system that ends the run records the end in [`Outcome`](siloflow_dem::outcome::Outcome), and the simulation stops
//! after that step. The first regular end is kept, and a failure replaces it.
//!
//! | end | file |
//! |---|---|
//! | the silo is empty, or the time is over | [`regular`] |
//! | the caller asks for the end | `request` |
//! | a condition of the scene holds: the bed is at rest, the flow has ended, the outlet is clogged, enough grains are out | [`stop`] |
//! | a failure: a number is not finite | [`finite`] |
//! | a failure: energy appears without a source, or an overlap is too large | [`watchdog`] |
//!
//! Other failures are recorded where they happen: grains that are lost ([`crate::ledger`]) or find no place
//! ([`crate::grains::spawner`], [`crate::grains::feed`]), and files that cannot be written. The lattice gas has its own regular ends
//! (`lattice_silo/ending.rs`).

pub mod finite;
pub mod regular;
pub(crate) mod request;
pub mod stop;
pub mod watchdog;
