//! The lattice gas: silo flow by cellular automaton.
//!
//! Particles sit on a triangular lattice, at most thirteen at a site: one at rest and one on its way in each of twelve
//! directions ([`velocities`]). In a step they enter ([`enter`]), collide (`stop`, `scatter`, `collide`), rub at walls
//! (`friction`), trickle down (`trickle`) and move on (`propagate`). Six probabilities rule them ([`rules`]). After J.
//! Kozicki and J. Tejchman, Simulations of flow patterns in silos with a cellular automaton, part 2, TASK Quarterly 9(1),
//! 2005; where the paper leaves something open, the module that decides says so.
//!
//! Lengths are in m by the scene's `spacing`. Times are in steps: a step is no time of nature, and only shares of a
//! discharge compare with it.
//!
//! Limits. Energy is not conserved, only number and, without p, q, k, g, h and b, momentum. The densest state is 12 movers and
//! one at rest; one downward kick a site and step against at most twelve movers makes the upper layer of a bed about 12/g
//! sites thick: all gas at g = 0.05, a sharp surface at g = 0.95. With h = 0, and nearly so with p = 0.8, single particles
//! stay at rest above the bed.
//!
//! The lattice is one resource and not an entity a particle: [`Gas`](gas::Gas) and [`Sites`](sites::Sites) are what a
//! behaviour works on, in the phases of every [`Step`](crate::step::Step).

pub mod check;
pub mod collisions;
pub mod door;
pub mod draws;
pub mod enter;
pub(crate) mod flow;
pub mod gas;
pub mod load;
pub mod observables;
pub mod outline;
pub mod pictures;
pub(crate) mod plugins;
pub mod reflection;
pub mod rest;
pub mod rules;
pub mod scene;
pub mod series;
pub mod sites;
pub mod summary;
pub mod velocities;

mod bands;
mod collide;
mod ending;
mod friction;
mod propagate;
mod scatter;
mod stop;
mod trickle;
mod validity;
