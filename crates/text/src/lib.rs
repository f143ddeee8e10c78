//! Text that siloflow reads and shows: faults with their place, text made safe for messages and pictures, and scene text with its
//! places, parameters and expressions. The lowest crate: it imports no other of siloflow.
//!
//! Begin with [`fault`], then [`source::Source`].

// Numbers of a run have the same bits on every machine: see the module `math` of the kernel.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod encoding;
pub mod fault;
pub mod file;
pub mod safe;
pub mod source;
pub mod suggestion;
