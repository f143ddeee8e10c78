//! The discrete element method of siloflow: particle store, neighbour searches, contacts, walls and integration schemes,
//! as plugins of an app of an entity-component-system. It imports `siloflow-text` and no other crate of siloflow: it knows neither scenes as a whole
//! nor files of results.
//!
//! Begin with [`step`] for the phases of a step, [`store`] for the numbers, [`contact`] for a law, [`walls`] for a shape.

// Numbers of a run have the same bits on every machine: see the module `math` of the kernel.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod added_loads;
pub mod bodies;
pub mod budget;
pub mod contact;
pub mod displacement_trigger;
pub mod engine;
pub mod gravity;
pub mod instruction_set;
pub mod integrate;
pub(crate) mod lanes;
pub mod math;
pub mod messages;
mod nearly_sorted;
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
pub mod threads;
pub mod values;
pub mod walls;
