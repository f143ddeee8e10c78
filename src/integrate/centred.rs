//! Velocity Verlet with centred contacts: of second order in damped and frictional contacts too.
//!
//! The motion is that of `verlet`, and the forces are those of [`crate::contact::centred`], which need to know
//! how fast everything was accelerated a step ago: a(t) dt/2, what the first half kick has just added.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::columns::{Columns, Gain, LookedAhead, MANY, SpinGain};
use crate::space::Space;
use crate::step::{Clock, Part, Phase, Step};

impl<V: Space> Columns<V> {
    /// Makes ready for steps of `dt`, s.
    fn prepare(&mut self, dt: f64) {
        self.lookahead = 0.5 * dt;
        let fastest = self.body.iter().map(|body| body.velocity.length_squared()).fold(0.0, f64::max);
        // A hair more than any pair can close, so that only the pair's own speed decides.
        self.margin = dt * fastest.sqrt() * (1.0 + 1e-12);
        // What is fixed gains nothing.
        self.gain.clear();
        self.gain.resize(self.body.len(), Gain::default());
        self.loads.contacts.resize(self.body.len(), MANY);
    }

    /// What grain `i` gains by a force, N.
    fn gain_by(&self, i: usize, force: V) -> Gain<V> {
        let lone = if self.loads.contacts[i] <= 1 { 1.0 } else { 0.0 };
        Gain { velocity: force * (self.lookahead / self.mass[i]), lone }
    }
}

/// The store still holds the forces of the step's beginning.
fn look_ahead<V: Space>(clock: Res<Clock>, mut columns: ResMut<Columns<V>>) {
    columns.prepare(clock.dt);
    for i in 0..columns.movable_end {
        columns.gain[i] = columns.gain_by(i, columns.loads.force.of(i));
    }
}

fn look_ahead_of_spins<V: Space>(mut columns: ResMut<Columns<V>>) {
    let Columns { rotation, loads, spin_gain, lookahead, movable_end: end, .. } = &mut *columns;
    spin_gain.clear();
    spin_gain.extend(rotation[..*end].iter().enumerate().map(|(i, rotation)| {
        let inverse_inertia = rotation.inverse_inertia;
        SpinGain { spin: loads.torque.of(i) * (*lookahead * inverse_inertia), inverse_inertia }
    }));
    spin_gain.resize(rotation.len(), SpinGain::default());
}

/// What centred contacts need besides the integrator.
pub struct LookAheadPlugin<V: Space> {
    /// Whether grains spin.
    pub spins: bool,
    /// The space.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for LookAheadPlugin<V> {
    fn build(&self, app: &mut App) {
        let looks = look_ahead::<V>.into_configs();
        let all = if self.spins { (looks, look_ahead_of_spins::<V>).chain() } else { looks };
        app.add_systems(Step, all.in_set(Part::Engine(Phase::Neighbours)).in_set(LookedAhead));
    }
}
