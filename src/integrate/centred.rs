//! Velocity Verlet with centred contacts: of second order in damped and frictional contacts too.
//!
//! The motion is that of `verlet`, and the forces are those of [`crate::contact::centred`], which need to know
//! how fast everything was accelerated a step ago: a(t) dt/2, what the first half kick has just added.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::columns::{Columns, DENSE, Gain, Gathered, Lead, LookedAhead, MANY, Slot, SpinGain};
use crate::particle::{Fixed, Force, Mass};
use crate::space::Space;
use crate::spin::{Inertia, Torque};
use crate::step::{Clock, Phase, Step};

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

fn look_ahead<V: Space>(
    clock: Res<Clock>,
    mut columns: ResMut<Columns<V>>,
    grains: Query<(&Slot, &Force<V>), (With<Mass>, Without<Fixed>)>,
) {
    columns.prepare(clock.dt);
    for (slots, forces) in grains.contiguous_iter().expect(DENSE) {
        for (slot, force) in slots.iter().zip(forces.iter()) {
            if slot.index() < columns.len() {
                columns.gain[slot.index()] = columns.gain_by(slot.index(), force.0);
            }
        }
    }
}

/// The same where columns lead: they still hold the forces of the step's beginning.
fn look_ahead_in_columns<V: Space>(clock: Res<Clock>, mut columns: ResMut<Columns<V>>) {
    columns.prepare(clock.dt);
    for i in 0..columns.movable_end {
        columns.gain[i] = columns.gain_by(i, columns.loads.force.of(i));
    }
}

fn look_ahead_of_spins<V: Space>(
    clock: Res<Clock>,
    mut columns: ResMut<Columns<V>>,
    grains: Query<(&Slot, &Torque<V::Spin>, &Inertia), Without<Fixed>>,
) {
    let spins = columns.rotation.len();
    columns.spin_gain.clear();
    columns.spin_gain.resize(spins, SpinGain::default());
    for (slots, torques, inertias) in grains.contiguous_iter().expect(DENSE) {
        for (slot, (torque, inertia)) in slots.iter().zip(torques.iter().zip(inertias.iter())) {
            if let Some(gain) = columns.spin_gain.get_mut(slot.index()) {
                let inverse_inertia = 1.0 / inertia.0;
                *gain = SpinGain { spin: torque.0 * (0.5 * clock.dt * inverse_inertia), inverse_inertia };
            }
        }
    }
}

/// The same where columns lead.
fn look_ahead_of_spins_in_columns<V: Space>(mut columns: ResMut<Columns<V>>) {
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
        let (looks, spins) = if app.world().contains_resource::<Lead>() {
            (look_ahead_in_columns::<V>.into_configs(), look_ahead_of_spins_in_columns::<V>.into_configs())
        } else {
            (look_ahead::<V>.into_configs(), look_ahead_of_spins::<V>.into_configs())
        };
        let all = if self.spins { (looks, spins).chain() } else { looks };
        app.add_systems(Step, all.in_set(Phase::Neighbours).in_set(LookedAhead).after(Gathered));
    }
}
