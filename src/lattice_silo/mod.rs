//! The lattice gas: simulates silo flow with a cellular automaton.
//!
//! Particles occupy the sites of a triangular lattice. A site holds at most thirteen particles: one at rest and one
//! moving in each of twelve directions ([`velocities`](siloflow_lattice::velocities)). In each step particles enter ([`enter`]), collide (`stop`,
//! `scatter`, `collide`), stop at rough walls (`friction`), move down from rest (`trickle`) and propagate to other
//! sites (`propagate`). Six probabilities are the parameters of these rules ([`rules`](siloflow_lattice::rules)).
//!
//! Source: J. Kozicki and J. Tejchman, Simulations of flow patterns in silos with a cellular automaton, part 2, TASK
//! Quarterly 9(1), 2005. Where the paper leaves a rule open, the header of the module with the rule states the choice.
//!
//! Lengths are in m; the scene's `spacing` sets the scale. Times are in steps. A step has no physical duration, so only
//! the progress of a discharge can be compared with other models.
//!
//! Limits. The number of particles is conserved; energy is not. Momentum is conserved only if p, q, k, g, h and b are
//! all 0. The densest state of a site is 12 movers and one particle at rest. A site gets at most one downward kick a
//! step, against at most 12 movers, so the upper layer of a bed is about 12/g sites thick: the bed is all gas at
//! g = 0.05 and has a sharp surface at g = 0.95. With h = 0, and nearly so with p = 0.8, single particles stay at rest
//! above the bed.
//!
//! The lattice is one ECS resource; its particles are not entities. A behaviour works on [`Gas`](siloflow_lattice::gas::Gas) and
//! [`Sites`](siloflow_lattice::sites::Sites), in the stages and phases of each [`step`].

pub mod check;
pub mod door;
pub mod enter;
pub(crate) mod limits;
pub mod load;
pub mod loaded;
pub mod observables;
pub mod pictures;
pub(crate) mod plugins;
pub mod rest;
pub mod scene;
pub mod series;
pub mod step;

mod ending;
mod validity;
