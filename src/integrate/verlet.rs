//! Velocity Verlet, as the assignment writes it:
//!
//! 1. x(t+dt) = x(t) + dt v(t) + dt^2/2 a(t)
//! 2. v(t+dt/2) = v(t) + dt/2 a(t)
//! 3. F from x(t+dt) and v(t+dt/2)
//! 4. a(t+dt) = F/m
//! 5. v(t+dt) = v(t+dt/2) + dt/2 a(t+dt)
//!
//! Steps 1 and 2 are [`Phase::Drift`], where 1 is written as x + dt v(t+dt/2), the same number; 4 and 5 are
//! [`Phase::Kick`], unless they are put off until the next drift (`columns/settle.rs`). Second order, symplectic and time-reversible while forces depend on positions alone. Drag is
//! evaluated with a velocity half a step old, which makes damped contacts first order; one such contact is stable
//! for dt < 2/w0 (sqrt(1 + zeta^2) - zeta).

use std::ops::Add;

use bevy_app::App;
use bevy_ecs::prelude::*;

use crate::columns::{
    BOOKED, Columns, DENSE, GatheredVelocities, Kicked, Longest, SecondKick, WHOLE, Walkers, add_second_kick, kick_term,
};
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

/// The same in the columns, where they lead; if the second kick of the step before is owed, with that, and with its sum.
fn drift_columns<V: Space>(
    (clock, walkers): (Res<Clock>, Walkers),
    second: Option<Res<SecondKick>>,
    mut columns: ResMut<Columns<V>>,
) {
    let is_owed = second.is_some_and(|kick| kick.is_owed);
    match (columns.has_books, is_owed) {
        (true, true) => drift_by::<V, BOOKED, true>(clock.dt, &walkers, &mut columns),
        (true, false) => drift_by::<V, BOOKED, false>(clock.dt, &walkers, &mut columns),
        (false, true) => drift_by::<V, WHOLE, true>(clock.dt, &walkers, &mut columns),
        (false, false) => drift_by::<V, WHOLE, false>(clock.dt, &walkers, &mut columns),
    }
}

/// By forces of which so many numbers are kept.
fn drift_by<V: Space, const EACH: usize, const OWED: bool>(dt: f64, walkers: &Walkers, columns: &mut Columns<V>) {
    // An open scene pays nothing for sides.
    match columns.periodic.filter(|_| !columns.sets_back_later) {
        None => drift_along::<V, EACH, OWED>(dt, walkers, columns, |_| {}),
        Some(periodic) => drift_along::<V, EACH, OWED>(dt, walkers, columns, |x| periodic.wrap(x)),
    }
}

fn drift_along<V: Space, const EACH: usize, const OWED: bool>(
    dt: f64,
    walkers: &Walkers,
    columns: &mut Columns<V>,
    set_back: impl Fn(&mut V) + Sync,
) {
    let Columns { body, loads, movable_end: end, .. } = columns;
    let strides = walkers.along(
        &loads.force.entries::<EACH>()[..*end],
        &mut body[..*end],
        #[inline(always)]
        |force, body, (longest, sum): &mut (Longest, V)| {
            let gained = half_kick(force[0], dt, body.inverse_mass);
            let mut velocity = body.velocity + gained;
            if OWED {
                *sum += kick_term(force, velocity);
                velocity += gained;
            }
            let mut position = body.position + velocity * dt;
            // Before it is set back.
            longest.raise(position - body.position);
            set_back(&mut position);
            (body.position, body.velocity) = (position, velocity);
        },
    );
    let both = |(longest, sum): (Longest, V), (way, term)| (longest.or(way), sum + term);
    let (longest, sum) = strides.into_iter().fold((Longest::default(), V::ZERO), both);
    columns.travel += longest.length();
    if OWED {
        columns.kick_sum = Some(sum);
    }
}

fn kick<V: Space>(clock: Res<Clock>, mut grains: Query<(&mut Velocity<V>, &Force<V>, &Mass), Movable>) {
    let dt = clock.dt;
    for (mut v, force, mass) in grains.contiguous_iter_mut().expect(DENSE) {
        for (v, (force, mass)) in v.bypass_change_detection().iter_mut().zip(force.iter().zip(mass.iter())) {
            v.0 += half_kick(force.0, dt, 1.0 / mass.0);
        }
    }
}

/// The same in the columns, where they lead; with a sum, which saves a pass ([`Columns::kick_sum`]).
fn kick_columns<V: Space>((clock, walkers): (Res<Clock>, Walkers), mut columns: ResMut<Columns<V>>) {
    let sum = if columns.has_books {
        kick_by::<V, BOOKED>(clock.dt, &walkers, &mut columns)
    } else {
        kick_by::<V, WHOLE>(clock.dt, &walkers, &mut columns)
    };
    columns.kick_sum = Some(sum);
}

fn kick_by<V: Space, const EACH: usize>(dt: f64, walkers: &Walkers, columns: &mut Columns<V>) -> V {
    let Columns { body, loads, movable_end: end, .. } = columns;
    let sums = walkers.along(
        &loads.force.entries::<EACH>()[..*end],
        &mut body[..*end],
        #[inline(always)]
        |force, body, sum: &mut V| {
            let velocity = body.velocity + half_kick(force[0], dt, body.inverse_mass);
            *sum += kick_term(force, velocity);
            body.velocity = velocity;
        },
    );
    sums.into_iter().fold(V::ZERO, Add::add)
}

pub(super) fn add<V: Space>(app: &mut App, columns_lead: bool) {
    let (drifts, kicks) = if columns_lead {
        (drift_columns::<V>.into_configs(), kick_columns::<V>.into_configs())
    } else {
        (drift::<V>.into_configs(), kick::<V>.into_configs())
    };
    app.add_systems(Step, drifts.in_set(Phase::Drift).in_set(Drifted).after(ClockAdvanced));
    add_second_kick(app, kicks.in_set(Kicked).before(GatheredVelocities));
}
