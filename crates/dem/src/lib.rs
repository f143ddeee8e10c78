//! The discrete element method of siloflow: particle store, neighbour searches, contacts, walls and integration schemes.

pub mod budget;
pub mod contact;
pub mod displacement_trigger;
pub mod engine;
pub mod gravity;
pub mod instruction_set;
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
pub mod threads;
pub mod values;
pub mod walls;
