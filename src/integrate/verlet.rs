//! Velocity Verlet, as the assignment writes it:
//!
//! 1. x(t+dt) = x(t) + dt v(t) + dt^2/2 a(t)
//! 2. v(t+dt/2) = v(t) + dt/2 a(t)
//! 3. F from x(t+dt) and v(t+dt/2)
//! 4. a(t+dt) = F/m
//! 5. v(t+dt) = v(t+dt/2) + dt/2 a(t+dt)
//!
//! Steps 1 and 2 are [`Phase::Drift`], where 1 is written as x + dt v(t+dt/2), the same number; 4 and 5 are
//! [`Phase::Kick`]. Second order, symplectic and time-reversible while forces depend on positions alone. Drag is
//! evaluated with a velocity half a step old, which makes damped contacts first order; one such contact is stable
//! for dt < 2/w0 (sqrt(1 + zeta^2) - zeta).

use std::ops::Add;

use bevy_app::App;
use bevy_ecs::prelude::*;

use crate::columns::{Columns, DENSE, GatheredVelocities, Kicked, Longest, Passes, Slot, Walkers};
use crate::particle::{Fixed, Force, Mass, Position, Velocity};
use crate::space::Space;
use crate::step::{Clock, ClockAdvanced, Drifted, Phase, Step};

type Movable = Without<Fixed>;

type Drifting<V> = (&'static mut Position<V>, &'static mut Velocity<V>, &'static Force<V>, &'static Mass);

/// What a force (N) adds to the velocity in half a step of `dt` (s), m/s.
#[inline]
fn half_kick<V: Space>(force: V, dt: f64, inverse_mass: f64) -> V {
    force * (0.5 * dt * inverse_mass)
}

fn drift<V: Space>(clock: Res<Clock>, mut grains: Query<Drifting<V>, Movable>) {
    let dt = clock.dt;
    for (mut x, mut v, force, mass) in grains.contiguous_iter_mut().expect(DENSE) {
        let columns = x.bypass_change_detection().iter_mut().zip(v.bypass_change_detection());
        for ((x, v), (force, mass)) in columns.zip(force.iter().zip(mass.iter())) {
            v.0 += half_kick(force.0, dt, 1.0 / mass.0);
            x.0 += v.0 * dt;
        }
    }
}

type Gathering<V> = (&'static Slot, &'static mut Position<V>, &'static mut Velocity<V>, &'static Force<V>);

/// The same, into the columns too, which saves a pass.
fn drift_and_gather<V: Space>(
    (clock, walkers): (Res<Clock>, Walkers),
    mut columns: ResMut<Columns<V>>,
    grains: Query<Gathering<V>, Movable>,
) {
    // An open scene pays nothing for sides.
    match columns.periodic {
        None => drift_along(clock.dt, &walkers, &mut columns, grains, |_| {}),
        Some(periodic) => drift_along(clock.dt, &walkers, &mut columns, grains, |x| periodic.wrap(x)),
    }
}

fn drift_along<V: Space>(
    dt: f64,
    walkers: &Walkers,
    columns: &mut Columns<V>,
    mut grains: Query<Gathering<V>, Movable>,
    set_back: impl Fn(&mut V) + Sync,
) {
    let mut longest = Longest::default();
    for (slots, mut x, mut v, force) in grains.contiguous_iter_mut().expect(DENSE) {
        let rows = ((x.bypass_change_detection(), v.bypass_change_detection()), force);
        let ways = walkers.along_one(
            slots,
            &mut columns.body,
            rows,
            #[inline(always)]
            |body, ((x, v), force), longest: &mut Longest| {
                let velocity = v.0 + half_kick(force.0, dt, body.inverse_mass);
                let mut position = x.0 + velocity * dt;
                // From where the columns had it, before it is set back: whoever has moved it meanwhile.
                longest.raise(position - body.position);
                set_back(&mut position);
                (body.position, body.velocity) = (position, velocity);
                (x.0, v.0) = (position, velocity);
            },
        );
        longest = ways.into_iter().fold(longest, Longest::or);
    }
    columns.travel += longest.length();
}

fn kick<V: Space>(clock: Res<Clock>, mut grains: Query<(&mut Velocity<V>, &Force<V>, &Mass), Movable>) {
    let dt = clock.dt;
    for (mut v, force, mass) in grains.contiguous_iter_mut().expect(DENSE) {
        for (v, (force, mass)) in v.bypass_change_detection().iter_mut().zip(force.iter().zip(mass.iter())) {
            v.0 += half_kick(force.0, dt, 1.0 / mass.0);
        }
    }
}

type Kicking<V> = (&'static Slot, &'static mut Velocity<V>, &'static mut Force<V>);

/// The same, with the forces from the columns and the velocities into them, which saves two passes; and with the power of the
/// drag where rows come in the order of slots, which saves a third.
fn kick_and_write<V: Space>(
    (clock, walkers): (Res<Clock>, Walkers),
    mut columns: ResMut<Columns<V>>,
    mut grains: Query<Kicking<V>, Movable>,
) {
    let dt = clock.dt;
    let columns = &mut *columns;
    columns.drag_power = None;
    for (slots, mut v, mut force) in grains.contiguous_iter_mut().expect(DENSE) {
        let rows = (v.bypass_change_detection(), force.bypass_change_detection());
        let both = (&columns.load[..], &mut columns.body[..]);
        let (powers, run) = walkers.along(
            slots,
            both,
            rows,
            #[inline(always)]
            |load, body, (v, force), power: &mut V| {
                let velocity = v.0 + half_kick(load.force, dt, body.inverse_mass);
                *power += load.drag.times(velocity);
                force.0 = load.force;
                (body.velocity, v.0) = (velocity, velocity);
            },
        );
        if run == Some(0..columns.movable_end) {
            columns.drag_power = Some(powers.into_iter().fold(V::ZERO, Add::add));
        }
    }
}

pub(super) fn add<V: Space>(app: &mut App, passes: Passes) {
    if passes.drift_gathers {
        app.add_systems(Step, drift_and_gather::<V>.in_set(Phase::Drift).in_set(Drifted).after(ClockAdvanced));
    } else {
        app.add_systems(Step, drift::<V>.in_set(Phase::Drift).in_set(Drifted).after(ClockAdvanced));
    }
    if passes.kick_writes {
        app.add_systems(Step, kick_and_write::<V>.in_set(Phase::Kick).in_set(Kicked).before(GatheredVelocities));
    } else {
        app.add_systems(Step, kick::<V>.in_set(Phase::Kick).in_set(Kicked).before(GatheredVelocities));
    }
}
