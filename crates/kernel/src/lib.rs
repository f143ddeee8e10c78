//! What a step of the simulation computes on particles: the particle store, neighbour searches, contacts, walls and integration
//! schemes, and the plain modules below them. Users find these modules in the crate `siloflow`, which exports them.
//!
//! It is a crate of its own, so that its loops are compiled as a whole, and only after an edit of it.

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
