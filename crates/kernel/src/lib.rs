//! The numerical core of siloflow: particle store, neighbour searches, contacts, walls and integration schemes, and the modules that
//! these import. The crate `siloflow` exports all modules that users need.
//!
//! The core is a separate crate, because it takes a third of the compiler's time: an edit of `siloflow` does not compile the core again.

pub mod budget;
pub mod contact;
pub mod displacement_trigger;
pub mod engine;
pub mod fault;
pub mod gravity;
pub mod instructions;
pub mod integrate;
pub mod messages;
pub mod neighbours;
pub mod outcome;
pub mod particle;
pub mod particles;
pub mod periodic;
pub mod persist;
pub mod space;
pub mod spin;
pub mod step;
pub mod store;
pub mod survey;
pub mod table_sort;
pub mod text;
pub mod threads;
pub mod values;
pub mod walls;
