//! The lattice gas, a cellular automaton: sites, states, and the rules of a step. `siloflow` adds scenes, doors and output.

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
