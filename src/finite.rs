//! The finite-value check: an infinite or undefined number stops the run and is named, with the grain and the step.
//!
//! It takes no pass of its own: a velocity or spin that is not finite makes the power of the drag forces so ([`crate::energy`]), or,
//! where no books are kept, the sum of all of them; a position that is not finite makes the distance moved so
//! ([`ParticleStore::travel`]); a force that is not finite shows in the velocity of the same step; and what systems write is looked at when
//! it is taken over. Only then, and in step zero, are all particles looked through for the grain. Where the second kick of a step is made
//! with the next drift (`store/deferred_kick.rs`), velocities show it then, and the step before is named.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use crate::contact::{AnyLaw, Bounce};
use crate::energy::{EnergyBalanced, EnergyFlows};
use crate::outcome::{Failure, Outcome};
use crate::space::{Linear, Space};
use crate::step::{Clock, Step};
use crate::store::{AfterDeferredKick, DeferredKick, EngineChecks, ParticleStore, SecondKicks};

/// Whether the sums of all velocities and of all spins are.
fn sums_are_finite<V: Space>(store: &ParticleStore<V>) -> bool {
    let of_velocities = || store.body.iter().map(|body| body.velocity).sum();
    let of_spins = || store.rotation.iter().map(|rotation| rotation.spin).sum();
    let (velocities, spins): (V, V::Spin) =
        (store.kick_sum.unwrap_or_else(of_velocities), store.spin_kick_sum.unwrap_or_else(of_spins));
    velocities.is_finite() && spins.is_finite()
}

/// What tells whether all is finite, and whose fault it is if not.
#[derive(SystemParam)]
struct Evidence<'w, V: Space> {
    clock: Res<'w, Clock>,
    store: Res<'w, ParticleStore<V>>,
    law: Option<Res<'w, AnyLaw<V>>>,
    flows: Option<Res<'w, EnergyFlows>>,
    outcome: ResMut<'w, Outcome>,
}

impl<V: Space> Evidence<'_, V> {
    /// Whether velocities and spins are.
    fn motion_is_finite(&self) -> bool {
        match &self.flows {
            Some(flows) => flows.dissipated.is_finite(),
            None => sums_are_finite(&self.store),
        }
    }

    /// Fails with the first grain of which something is not; positions count if they are of that step.
    fn accuse(&mut self, step: u64, positions_count: bool) {
        for i in 0..self.store.len() {
            let body = &self.store.body[i];
            let quantity = if positions_count && !body.position.is_finite() {
                "position"
            } else if !body.velocity.is_finite() {
                "velocity"
            } else if !self.store.spin(i).is_finite() {
                "spin"
            } else {
                continue;
            };
            let (grain, cause) = (self.store.id[i], self.cause(i));
            self.outcome.fail(Failure::NotFinite { step, grain, quantity, cause });
            return;
        }
    }

    /// Why entry `i` may be as it is.
    fn cause(&self, i: usize) -> String {
        let Self { clock, store, law, .. } = self;
        if store.added.get(i).is_some_and(|added| !added.is_finite()) {
            "a behaviour has added a force that is not finite".to_owned()
        } else if !store.loads.force.of(i).is_finite() {
            let (mass, radius) = (1.0 / store.body[i].inverse_mass, store.body[i].radius);
            let bounce = Bounce { reduced_mass: mass, reduced_radius: radius, speed: 1.0 };
            let step = law.as_ref().map_or(f64::NAN, |law| clock.dt * law.0.frequency(&bounce));
            format!(
                "the force of its contacts is not finite either: the step is probably unstable, w0 dt = {step:.2} for \
                 this grain; lower `step` (`check` prints the limit)"
            )
        } else {
            "its forces are finite, so a behaviour or an input file has set it".to_owned()
        }
    }
}

fn check<V: Space>(mut evidence: Evidence<V>) {
    let store = &evidence.store;
    let is_odd = store.is_suspect || !store.travel.is_finite();
    if is_odd || evidence.clock.is_step_zero() || !evidence.motion_is_finite() {
        let step = evidence.clock.steps;
        evidence.accuse(step, true);
    }
}

/// Of the step before, whose second kick was made with the drift: positions that have followed from it do not count.
fn check_late<V: Space>(mut evidence: Evidence<V>) {
    if !evidence.motion_is_finite() {
        let step = evidence.clock.steps - 1;
        evidence.accuse(step, false);
    }
}

/// The finite-value check of every step.
pub struct FinitePlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for FinitePlugin<V> {
    fn build(&self, app: &mut App) {
        app.add_systems(DeferredKick, check::<V>.after(SecondKicks).after(EnergyBalanced));
        app.add_systems(
            Step,
            (check::<V>.in_set(EngineChecks), check_late::<V>.in_set(AfterDeferredKick).after(EnergyBalanced)),
        );
    }
}
