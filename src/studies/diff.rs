//! Divergence of two runs: the first step after which their states differ by a bit.
//!
//! Two simulations advance together. After every step all quantities of all particles, or the states of all sites of a
//! lattice gas, are compared bit by bit. The report names the step, the grain and the quantity, which a comparison of
//! hashes cannot do.
//!
//! If several quantities differ after that step, the report names the quantity that a step computes first, because the
//! others follow from it. The order is: presence of the grain, radius, mass, position, force, torque, velocity, spin.
//! If this quantity differs in several grains, the report names the grain with the smallest id.
//!
//! ```
//! # use std::num::NonZeroUsize;
//! # use std::path::Path;
//! # use siloflow::studies::diff::Pair;
//! # use siloflow::prelude::*;
//! # let run = |height: f64| {
//! #     let scene = format!("(gravity: (0.0, -9.81), contact: Linear(k: 1.0e5, damping: B(0.0)), mass: ArealSquare(100.0), \
//! #         step: Fixed(1.0e-4), spawner: (point: (0.0, {height:?}), velocity: (0.0, 0.0), interval: 1.0, count: 1, \
//! #         radius: Fixed(0.04)), until: 0.1)");
//! #     let loaded = load::from_text("fall.ron", "fall", Path::new(""), scene, &[])?;
//! #     Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN)
//! # };
//! let mut pair = Pair::new(run(1.0)?, run(1.5)?)?;
//! let divergence = pair.first_divergence(u64::MAX, |_| {}).unwrap();
//! assert_eq!(divergence.step, 0);
//! assert!(divergence.to_string().starts_with("step 0, t = 0 s: the position of grain 1 (m)"));
//! # Ok::<(), siloflow::text::fault::Fault>(())
//! ```
//!
//! A test that requires equal runs compares their hashes and calls [`where_they_part`] in the message of its assertion.
//!
//! Limits: the contact history and the states of spawner and door are not compared. A difference in them is found at
//! the step in which it first moves a grain. Forces on wall grains are not compared, because they have no effect. A
//! quantity that only one of the runs has is ignored (for example spin and torque, if the other run has no friction).

mod report;
mod state;

use bevy_ecs::prelude::*;

use crate::simulation::Simulation;
pub use crate::studies::diff::report::{Difference, Divergence, Quantity, Value};
use siloflow_dem::outcome::Outcome;
use siloflow_dem::space::Dimension;
use siloflow_dem::step::Clock;
use siloflow_lattice::gas::Gas;
use siloflow_lattice::sites::Sites;
use siloflow_text::fault::Fault;

/// Two runs that advance together.
pub struct Pair([Simulation; 2]);

impl Pair {
    /// Pairs two runs.
    ///
    /// # Errors
    /// If the runs have different methods, spaces, time steps, step counts or lattice sites.
    pub fn new(first: Simulation, second: Simulation) -> Result<Self, Fault> {
        check_comparable(first.world(), second.world())?;
        Ok(Self([first, second]))
    }

    /// Returns the two runs in the order of [`Pair::new`].
    #[must_use]
    pub fn runs(&self) -> &[Simulation; 2] {
        &self.0
    }

    /// Steps both runs and returns their first difference; `None` if there is none.
    ///
    /// The comparison covers the present state and the states up to step `steps` or the end of both runs. `each` is
    /// called with the world of the first run after every step.
    pub fn first_divergence(&mut self, steps: u64, mut each: impl FnMut(&World)) -> Option<Divergence> {
        loop {
            if let Some(divergence) = self.divergence() {
                return Some(divergence);
            }
            let world = self.0[0].world();
            let clock = world.resource::<Clock>();
            // The other run has ended too: otherwise `divergence` would have reported different ends.
            if world.resource::<Outcome>().end().is_some() || !clock.is_step_zero() && clock.steps >= steps {
                return None;
            }
            for run in &mut self.0 {
                run.step();
            }
            each(self.0[0].world());
        }
    }

    /// Returns the difference of the present states.
    #[must_use]
    pub fn divergence(&self) -> Option<Divergence> {
        let worlds = self.0.each_ref().map(Simulation::world);
        let difference = if is_gas(worlds[0]) { state::of_gas(worlds) } else { state::of_grains(worlds) };
        let clock = worlds[0].resource::<Clock>();
        let difference = difference.or_else(|| {
            let ends = worlds.map(|world| world.resource::<Outcome>().end().cloned());
            (ends[0] != ends[1]).then_some(Difference::End { ends })
        })?;
        Some(Divergence { step: clock.steps, time_s: clock.time(), difference })
    }
}

fn is_gas(world: &World) -> bool {
    world.contains_resource::<Gas>() && world.contains_resource::<Sites>()
}

/// Describes the first difference of two runs up to step `steps`, for the message of a test that expects equal runs.
#[must_use]
pub fn where_they_part(first: Simulation, second: Simulation, steps: u64) -> String {
    match Pair::new(first, second).map(|mut pair| pair.first_divergence(steps, |_| {})) {
        Ok(Some(divergence)) => format!("they part at {divergence}"),
        Ok(None) => "no quantity of a grain differs".to_owned(),
        Err(fault) => fault.to_string(),
    }
}

/// Returns an error if the states of two worlds cannot be compared.
fn check_comparable(first: &World, second: &World) -> Result<(), Fault> {
    if is_gas(first) != is_gas(second) {
        return Err(Fault::new("divergence::method", "one is a scene of grains, the other of the lattice gas")
            .help("`siloflow compare` compares the flow patterns of different models"));
    }
    if Dimension::of_world(first) != Dimension::of_world(second) {
        return Err(Fault::new("divergence::space", "one scene is in the plane, the other in solid space")
            .help("give two scenes with the same `space`"));
    }
    let [a, b] = [first, second].map(|world| world.resource::<Clock>());
    if a.dt.to_bits() != b.dt.to_bits() {
        let message = format!("one scene has a time step of {:?} s, the other of {:?} s", a.dt, b.dt);
        return Err(Fault::new("divergence::step", message).help(
            "states are compared at equal steps: give both scenes the same `step`; `siloflow accuracy SCENE` measures \
             the error of a step",
        ));
    }
    if (a.steps, a.is_step_zero()) != (b.steps, b.is_step_zero()) {
        let message = format!("one run has done {} steps, the other {}", a.steps, b.steps);
        return Err(Fault::new("divergence::clock", message).help("advance both runs to the same step first"));
    }
    if !state::have_same_sites([first, second]) {
        return Err(Fault::new("divergence::sites", "the silos have different sites")
            .help("give two scenes with the same `outline`, `inserts`, `door` and `spacing`"));
    }
    Ok(())
}
