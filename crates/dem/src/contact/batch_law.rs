//! The law of the run as a trait object.
//!
//! The force pass calls the law once for a batch of contacts ([`BatchLaw`]), so that only the loop over the lanes of a batch is compiled for
//! each law. Surveys, estimates and reports call it for single contacts.

use std::sync::Arc;

use bevy_ecs::prelude::*;

use crate::contact::batch::{Batch, Call, Evaluated, EventStep};
use crate::contact::law::{LawComputation, LawRequirements, PairLaw};
use crate::contact::needs::Needs;
use crate::contact::pair::MemoryTimes;
use crate::particle::Species;
use crate::space::{Plane, Space};
use crate::store::{TOTAL, TOTAL_AND_DISSIPATIVE};

/// The contact law of the run.
#[derive(Resource, Clone)]
pub struct AnyLaw<V: Space = Plane>(pub Arc<dyn BatchLaw<V>>);

/// A law as the force pass calls it: once for a batch of contacts.
pub trait BatchLaw<V: Space>: PairLaw<V> {
    /// Returns the requirements of the law.
    fn needs(&self) -> Needs;

    /// Evaluates the law for all contacts of a batch, with the numbers that only the energy balance needs if `tracks_energy`.
    fn evaluate(&self, batch: &mut Batch<V>, call: &Call, tracks_energy: bool) -> Evaluated;

    /// Evaluates the law anew for the contacts near an event, `near` (bits of lanes).
    fn evaluate_events(&self, batch: &mut Batch<V>, times: MemoryTimes, step: &EventStep<V>, near: u64);
}

impl<V: Space, L: PairLaw<V> + LawRequirements> BatchLaw<V> for L {
    fn needs(&self) -> Needs {
        Needs::of::<L, V>(self.depends_on_species())
    }

    fn evaluate(&self, batch: &mut Batch<V>, call: &Call, tracks_energy: bool) -> Evaluated {
        if tracks_energy {
            batch.evaluate::<L, TOTAL_AND_DISSIPATIVE>(self, call)
        } else {
            batch.evaluate::<L, TOTAL>(self, call)
        }
    }

    fn evaluate_events(&self, batch: &mut Batch<V>, times: MemoryTimes, step: &EventStep<V>, near: u64) {
        let events = Events { batch, times, step, near };
        if L::SPECIES && self.depends_on_species() {
            events.run(self);
        } else {
            self.between([Species(0); 2], events);
        }
    }
}

/// Arguments of [`Batch::evaluate_events`].
struct Events<'a, V: Space> {
    batch: &'a mut Batch<V>,
    times: MemoryTimes,
    step: &'a EventStep<'a, V>,
    near: u64,
}

impl<V: Space> LawComputation<V> for Events<'_, V> {
    type Output = ();

    fn run<L: PairLaw<V> + LawRequirements>(self, law: &L) {
        self.batch.evaluate_events(law, self.times, self.step, self.near);
    }
}
