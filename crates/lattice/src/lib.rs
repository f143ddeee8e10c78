//! The lattice gas, a cellular automaton: sites, states, and the rules of a step. `siloflow` adds scenes, doors and output.
//! It imports `siloflow-dem` for vectors, numbers with a range, and threads.
//!
//! Begin with [`sites`] and [`gas`], then [`rules`].

// Numbers of a run have the same bits on every machine: see the module `math` of the kernel.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod bands;
pub mod collide;
pub mod collisions;
pub mod draws;
pub mod friction;
pub mod gas;
pub mod outline;
pub mod propagate;
pub mod reflection;
pub mod rules;
pub mod scatter;
pub mod sites;
pub mod stop;
pub mod trickle;
pub mod velocities;
