//! Velocity Verlet with centred contacts: second order also for damped and frictional contacts.
//!
//! Positions move as in `verlet`. The forces of [`crate::contact::centred`] need a velocity prediction. It uses the
//! acceleration at the start of the step: a(t) dt/2, the gain of the first half kick.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::space::Space;
use crate::step::{Clock, Part, Phase, Step};
use crate::store::{ParticleStore, SpinGain, UNKNOWN_CONTACTS, VelocitiesPredicted, VelocityGain};

impl<V: Space> ParticleStore<V> {
    /// Prepares the velocity prediction of a step of `dt`, s.
    fn prepare_prediction(&mut self, dt: f64) {
        self.lookahead = 0.5 * dt;
        let fastest = self.body.iter().map(|body| body.velocity.length_squared()).fold(0.0, f64::max);
        // Slightly more than any pair can close in a step, so that only the velocities of a pair decide whether it
        // counts.
        self.margin = dt * fastest.sqrt() * (1.0 + 1e-12);
        // Fixed particles gain no velocity.
        self.gain.clear();
        self.gain.resize(self.body.len(), VelocityGain::default());
        self.loads.contacts.resize(self.body.len(), UNKNOWN_CONTACTS);
    }

    /// Returns the velocity gain of grain `i` by `force` (N).
    fn predicted_gain(&self, i: usize, force: V) -> VelocityGain<V> {
        let only_contact = if self.loads.contacts[i] <= 1 { 1.0 } else { 0.0 };
        VelocityGain { velocity: force * (self.lookahead / self.mass[i]), only_contact }
    }
}

/// Predicts velocity gains. At this point the store still holds the forces of the start of the step.
fn predict_velocities<V: Space>(clock: Res<Clock>, mut store: ResMut<ParticleStore<V>>) {
    store.prepare_prediction(clock.dt);
    for i in 0..store.movable_end {
        store.gain[i] = store.predicted_gain(i, store.loads.force.of(i));
    }
}

/// Predicts spin gains from the torques of the start of the step.
fn predict_spins<V: Space>(mut store: ResMut<ParticleStore<V>>) {
    let ParticleStore { rotation, loads, spin_gain, lookahead, movable_end: end, .. } = &mut *store;
    spin_gain.clear();
    spin_gain.extend(rotation[..*end].iter().enumerate().map(|(i, rotation)| {
        let inverse_inertia = rotation.inverse_inertia;
        SpinGain { spin: loads.torque.of(i) * (*lookahead * inverse_inertia), inverse_inertia }
    }));
    spin_gain.resize(rotation.len(), SpinGain::default());
}

/// Velocity prediction for centred contacts, in addition to the integrator.
pub struct VelocityPredictionPlugin<V: Space> {
    /// Whether grains spin.
    pub spins: bool,
    /// The space.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for VelocityPredictionPlugin<V> {
    fn build(&self, app: &mut App) {
        let velocities = predict_velocities::<V>.into_configs();
        let all = if self.spins { (velocities, predict_spins::<V>).chain() } else { velocities };
        app.add_systems(Step, all.in_set(Part::Engine(Phase::Neighbours)).in_set(VelocitiesPredicted));
    }
}
