//! Velocity Verlet with centred contacts: of second order in damped and frictional contacts too.
//!
//! The motion is that of `verlet`, and the forces are those of [`crate::contact::centred`], which need to know
//! how fast everything was accelerated a step ago: a(t) dt/2, what the first half kick has just added.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::columns::{Columns, DENSE, Gain, Gathered, LookedAhead, MANY, Slot, SpinGain};
use crate::particle::{Fixed, Force, Mass};
use crate::space::Space;
use crate::spin::{Inertia, Torque};
use crate::step::{Clock, Phase, Step};

fn look_ahead<V: Space>(
    clock: Res<Clock>,
    mut columns: ResMut<Columns<V>>,
    grains: Query<(&Slot, &Force<V>, &Mass), Without<Fixed>>,
) {
    let columns = &mut *columns;
    columns.lookahead = 0.5 * clock.dt;
    let fastest = columns.body.iter().map(|body| body.velocity.length_squared()).fold(0.0, f64::max);
    // A hair more than any pair can close, so that only the pair's own speed decides.
    columns.margin = clock.dt * fastest.sqrt() * (1.0 + 1e-12);
    // What is fixed gains nothing.
    columns.gain.clear();
    columns.gain.resize(columns.body.len(), Gain::default());
    columns.contacts.resize(columns.body.len(), MANY);
    for (slots, forces, masses) in grains.contiguous_iter().expect(DENSE) {
        for (slot, (force, mass)) in slots.iter().zip(forces.iter().zip(masses.iter())) {
            if let Some(gain) = columns.gain.get_mut(slot.index()) {
                let lone = if columns.contacts[slot.index()] <= 1 { 1.0 } else { 0.0 };
                *gain = Gain { velocity: force.0 * (0.5 * clock.dt / mass.0), lone };
            }
        }
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

/// What centred contacts need besides the integrator.
pub struct LookAheadPlugin<V: Space> {
    /// Whether grains spin.
    pub spins: bool,
    /// The space.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for LookAheadPlugin<V> {
    fn build(&self, app: &mut App) {
        app.add_systems(Step, look_ahead::<V>.in_set(Phase::Neighbours).in_set(LookedAhead).after(Gathered));
        if self.spins {
            let spins = look_ahead_of_spins::<V>.in_set(Phase::Neighbours).in_set(LookedAhead);
            app.add_systems(Step, spins.after(Gathered).after(look_ahead::<V>));
        }
    }
}
