//! Where two runs part: the first step after which the state of one differs from that of the other by a bit.
//!
//! Two simulations are stepped together. After every step all quantities of all particles, or the states of all sites of a lattice
//! gas, are compared bit by bit, so that the report names the step, the grain and the quantity; two unequal hashes name none of them.
//!
//! Of the quantities that differ after that step, the report names the one that a step computes first, because those after it follow from
//! it: whether the grain is there, its radius and mass, then position, force, torque, velocity and spin. Of the grains in which this
//! quantity differs, it names the one with the smallest id.
//!
//! ```
//! # use std::num::NonZeroUsize;
//! # use std::path::Path;
//! # use siloflow::divergence::Pair;
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
//! # Ok::<(), siloflow::fault::Fault>(())
//! ```
//!
//! A test that holds runs to be the same compares their hashes, and has [`where_they_part`] in the message of its assertion.
//!
//! Limits: the memories of contacts and the plans of spawner and door are not compared; a difference in them shows in the step in which it
//! first moves a grain. Forces on wall grains are not compared either, for nothing follows from them. A quantity that only one of
//! the runs has (spin and torque, without friction in the other) is left out.

mod report;
mod state;

use bevy_ecs::prelude::*;

pub use crate::divergence::report::{Difference, Divergence, Quantity, Value};
use crate::fault::Fault;
use crate::lattice::gas::Gas;
use crate::lattice::sites::Sites;
use crate::outcome::Outcome;
use crate::simulation::Simulation;
use crate::space::Dimension;
use crate::step::Clock;

/// Two runs that are stepped together.
pub struct Pair([Simulation; 2]);

impl Pair {
    /// Two runs whose states can be compared.
    ///
    /// # Errors
    /// If they are of different methods or spaces, if their steps differ, or if the sites of their lattices do.
    pub fn new(first: Simulation, second: Simulation) -> Result<Self, Fault> {
        comparable(first.world(), second.world())?;
        Ok(Self([first, second]))
    }

    /// The two, the first one first.
    #[must_use]
    pub fn runs(&self) -> &[Simulation; 2] {
        &self.0
    }

    /// The first difference from the state as it is to that of step `steps`, or to the end of both runs. `each` is shown the world of the
    /// first run after every step.
    pub fn first_divergence(&mut self, steps: u64, mut each: impl FnMut(&World)) -> Option<Divergence> {
        loop {
            if let Some(divergence) = self.divergence() {
                return Some(divergence);
            }
            let world = self.0[0].world();
            let clock = world.resource::<Clock>();
            // The other run has ended too, or the two would differ.
            if world.resource::<Outcome>().end().is_some() || !clock.is_step_zero() && clock.steps >= steps {
                return None;
            }
            for run in &mut self.0 {
                run.step();
            }
            each(self.0[0].world());
        }
    }

    /// The difference of the two states as they are.
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

/// Where two runs part, up to step `steps`, in words: for the message of a test that expects them to be the same.
#[must_use]
pub fn where_they_part(first: Simulation, second: Simulation, steps: u64) -> String {
    match Pair::new(first, second).map(|mut pair| pair.first_divergence(steps, |_| {})) {
        Ok(Some(divergence)) => format!("they part at {divergence}"),
        Ok(None) => "no quantity of a grain differs".to_owned(),
        Err(fault) => fault.to_string(),
    }
}

/// Refuses two worlds whose states have nothing in common that could be compared.
fn comparable(first: &World, second: &World) -> Result<(), Fault> {
    if is_gas(first) != is_gas(second) {
        return Err(Fault::new("divergence::method", "one is a scene of grains, the other of the lattice gas")
            .help("`siloflow compare` holds the flow patterns of different models against each other"));
    }
    if Dimension::of_world(first) != Dimension::of_world(second) {
        return Err(Fault::new("divergence::space", "one scene is in the plane, the other in solid space")
            .help("give two scenes with the same `space`"));
    }
    let [a, b] = [first, second].map(|world| world.resource::<Clock>());
    if a.dt.to_bits() != b.dt.to_bits() {
        let message = format!("one scene has a time step of {:?} s, the other of {:?} s", a.dt, b.dt);
        return Err(Fault::new("divergence::step", message).help(
            "states are compared at equal steps: give both scenes the same `step`; `siloflow accuracy SCENE` tells the error \
             that a step makes",
        ));
    }
    if (a.steps, a.is_step_zero()) != (b.steps, b.is_step_zero()) {
        let message = format!("one run has done {} steps, the other {}", a.steps, b.steps);
        return Err(Fault::new("divergence::clock", message).help("bring both to the same step first"));
    }
    if !state::have_same_sites([first, second]) {
        return Err(Fault::new("divergence::sites", "the silos have different sites")
            .help("give two scenes with the same `outline`, `inserts`, `door` and `spacing`"));
    }
    Ok(())
}
