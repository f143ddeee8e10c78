//! Finite-value check: an infinite or undefined number stops the run. The error names the quantity, the grain and the
//! step.
//!
//! The check needs no pass of its own. If a velocity or spin is not finite, neither is the sum that the kick forms: of
//! all velocities or spins, or in a step that sums dissipation, the power of the drag forces ([`crate::energy`]). If a
//! position is not finite, neither is the distance moved ([`ParticleStore::travel`]). A force that is not finite shows
//! in the velocity of the same step. Values written by systems are checked at write-back. Only after one of these signs, and in step zero, the
//! check searches for the grain among all particles.
//!
//! If the second kick of a step is deferred to the next drift (`store/deferred_kick.rs`), velocities show the fault
//! only then, and the error names the previous step.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use crate::energy::{EnergyBalanced, EnergyFlows};
use siloflow_dem::contact::{AnyLaw, Bounce};
use siloflow_dem::outcome::{Failure, Outcome};
use siloflow_dem::space::{Linear, Space};
use siloflow_dem::step::{Clock, Step};
use siloflow_dem::store::{AfterDeferredKick, DeferredKick, EngineChecks, ParticleStore, SecondKicks};

/// Returns whether the sums of all velocities and of all spins are finite.
fn sums_are_finite<V: Space>(store: &ParticleStore<V>) -> bool {
    let of_velocities = || store.body.iter().map(|body| body.velocity).sum();
    let of_spins = || store.rotation.iter().map(|rotation| rotation.spin).sum();
    let (velocities, spins): (V, V::Spin) =
        (store.kick_sum.unwrap_or_else(of_velocities), store.spin_kick_sum.unwrap_or_else(of_spins));
    velocities.is_finite() && spins.is_finite()
}

/// System parameters of the check.
#[derive(SystemParam)]
struct FiniteCheck<'w, V: Space> {
    clock: Res<'w, Clock>,
    store: Res<'w, ParticleStore<V>>,
    law: Option<Res<'w, AnyLaw<V>>>,
    flows: Option<Res<'w, EnergyFlows>>,
    outcome: ResMut<'w, Outcome>,
}

impl<V: Space> FiniteCheck<'_, V> {
    /// Returns whether all velocities and spins are finite.
    fn motion_is_finite(&self) -> bool {
        sums_are_finite(&self.store) && self.flows.as_ref().is_none_or(|flows| flows.dissipated.is_finite())
    }

    /// Fails the run with the first grain that has a value that is not finite. Positions are tested only if they belong
    /// to `step`.
    fn report_first(&mut self, step: u64, test_positions: bool) {
        for i in 0..self.store.len() {
            let body = &self.store.body[i];
            let quantity = if test_positions && !body.position.is_finite() {
                "position"
            } else if !body.velocity.is_finite() {
                "velocity"
            } else if !self.store.spin(i).is_finite() {
                "spin"
            } else {
                continue;
            };
            let grain = self.store.id[i];
            let cause = self.cause(i);
            self.outcome.fail(Failure::NotFinite { step, grain, quantity, cause });
            return;
        }
    }

    /// Returns the probable cause for the particle in slot `i`.
    fn cause(&self, i: usize) -> String {
        let Self { clock, store, law, .. } = self;
        if store.added.get(i).is_some_and(|added| !added.is_finite()) {
            "a behaviour has added a force that is not finite".to_owned()
        } else if !store.loads.force.of(i).is_finite() {
            let mass = 1.0 / store.body[i].inverse_mass;
            let radius = store.body[i].radius;
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

/// Checks the present step.
fn check<V: Space>(mut parameters: FiniteCheck<V>) {
    let store = &parameters.store;
    let has_sign = store.is_suspect || !store.travel.is_finite();
    if has_sign || parameters.clock.is_step_zero() || !parameters.motion_is_finite() {
        let step = parameters.clock.steps;
        parameters.report_first(step, true);
    }
}

/// Checks the previous step, with its second kick made in this drift. Positions are not tested, because they already
/// belong to this step.
fn check_late<V: Space>(mut parameters: FiniteCheck<V>) {
    if !parameters.motion_is_finite() {
        let step = parameters.clock.steps - 1;
        parameters.report_first(step, false);
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
