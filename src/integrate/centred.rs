//! Velocity Verlet with centred contacts: of second order in damped and frictional contacts too.
//!
//! The motion is that of `verlet`, and the forces are those of [`crate::contact::centred`], which need to know
//! how fast everything was accelerated a step ago: a(t) dt/2, what the first half kick has just added.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::space::Space;
use crate::step::{Clock, Part, Phase, Step};
use crate::store::{ParticleStore, SpinGain, UNKNOWN_CONTACTS, VelocitiesPredicted, VelocityGain};

impl<V: Space> ParticleStore<V> {
    /// Makes ready for steps of `dt`, s.
    fn prepare(&mut self, dt: f64) {
        self.lookahead = 0.5 * dt;
        let fastest = self.body.iter().map(|body| body.velocity.length_squared()).fold(0.0, f64::max);
        // A hair more than any pair can close, so that only the pair's own speed decides.
        self.margin = dt * fastest.sqrt() * (1.0 + 1e-12);
        // What is fixed gains nothing.
        self.gain.clear();
        self.gain.resize(self.body.len(), VelocityGain::default());
        self.loads.contacts.resize(self.body.len(), UNKNOWN_CONTACTS);
    }

    /// What grain `i` gains by a force, N.
    fn gain_by(&self, i: usize, force: V) -> VelocityGain<V> {
        let only_contact = if self.loads.contacts[i] <= 1 { 1.0 } else { 0.0 };
        VelocityGain { velocity: force * (self.lookahead / self.mass[i]), only_contact }
    }
}

/// The store still holds the forces of the step's beginning.
fn predict_velocities<V: Space>(clock: Res<Clock>, mut store: ResMut<ParticleStore<V>>) {
    store.prepare(clock.dt);
    for i in 0..store.movable_end {
        store.gain[i] = store.gain_by(i, store.loads.force.of(i));
    }
}

fn predict_spins<V: Space>(mut store: ResMut<ParticleStore<V>>) {
    let ParticleStore { rotation, loads, spin_gain, lookahead, movable_end: end, .. } = &mut *store;
    spin_gain.clear();
    spin_gain.extend(rotation[..*end].iter().enumerate().map(|(i, rotation)| {
        let inverse_inertia = rotation.inverse_inertia;
        SpinGain { spin: loads.torque.of(i) * (*lookahead * inverse_inertia), inverse_inertia }
    }));
    spin_gain.resize(rotation.len(), SpinGain::default());
}

/// What centred contacts need besides the integrator.
pub struct VelocityPredictionPlugin<V: Space> {
    /// Whether grains spin.
    pub spins: bool,
    /// The space.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for VelocityPredictionPlugin<V> {
    fn build(&self, app: &mut App) {
        let looks = predict_velocities::<V>.into_configs();
        let all = if self.spins { (looks, predict_spins::<V>).chain() } else { looks };
        app.add_systems(Step, all.in_set(Part::Engine(Phase::Neighbours)).in_set(VelocitiesPredicted));
    }
}
