//! Contacts between grains, and between grains and walls: contact laws, contact history, and the pass that sums
//! contact forces.
//!
//! Particles i and j touch when |x_ij| < R_i + R_j, with x_ij = x_i - x_j. Their overlap is delta = R_i + R_j - |x_ij|.
//! Their normal is n = x_ij/|x_ij|, from j to i.
//!
//! A contact law is a [`PairLaw`]. [`composite`] builds laws from terms: a normal force ([`linear`], [`hertz`], with
//! [`adhesion`], and [`jkr`]), friction ([`tangential`]) and rolling resistance ([`rolling`], with [`twisting`]). [`assignment`] is a law
//! without terms. [`table`] holds the parameters for each species pair. [`centred`] averages a law over a step, for the integration scheme
//! of second order. [`memory`] describes the numbers that a law remembers of a contact.
//!
//! [`force_pass`] iterates over the candidate pairs in the same way for every law and every neighbour search. [`history`]
//! keeps the memories of contacts between steps. [`crate::survey`] shows contacts to other systems. Contacts with walls
//! obey the same law, with a partner of infinite mass ([`crate::walls::surfaces`]).

pub mod adhesion;
pub mod assignment;
pub(crate) mod batch;
pub(crate) mod batch_law;
pub mod centred;
pub mod composite;
pub mod config;
pub mod damping;
mod facets;
pub(crate) mod force_accumulation;
pub mod force_pass;
pub mod geometry;
mod held_forces;
pub mod hertz;
pub mod history;
pub(crate) mod inverse_root;
pub mod jkr;
pub(crate) mod law;
pub mod linear;
pub mod memory;
mod needs;
pub(crate) mod pair;
pub(crate) mod pair_force;
pub(crate) mod plugin;
pub mod rolling;
pub mod selection;
pub mod spring;
pub mod spring_memory;
pub mod table;
pub mod tangential;
pub mod twisting;

pub use self::batch_law::{AnyLaw, BatchLaw};
pub use self::config::Contact;
pub use self::law::{Bounce, LawComputation, LawRequirements, PairLaw};
pub use self::memory::Memory;
pub use self::pair::{Gathered, MemoryTimes, Pair, VelocityPrediction};
pub use self::pair_force::{PairForce, Resistance};
pub use self::plugin::{ContactForces, ContactPlugin, ContactsAtStart, LargestOverlap};
