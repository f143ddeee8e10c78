//! Velocity Verlet, as the assignment writes it:
//!
//! 1. x(t+dt) = x(t) + dt v(t) + dt^2/2 a(t)
//! 2. v(t+dt/2) = v(t) + dt/2 a(t)
//! 3. F from x(t+dt) and v(t+dt/2)
//! 4. a(t+dt) = F/m
//! 5. v(t+dt) = v(t+dt/2) + dt/2 a(t+dt)
//!
//! Steps 1 and 2 are [`Phase::Drift`], where 1 is written as x + dt v(t+dt/2), the same number; 4 and 5 are
//! [`Phase::Kick`], unless they are put off until the next drift (`columns/deferred_kick.rs`). Second order, symplectic and time-reversible while forces depend on positions alone. Drag is
//! evaluated with a velocity half a step old, which makes damped contacts first order; one such contact is stable
//! for dt < 2/w0 (sqrt(1 + zeta^2) - zeta).

use std::ops::Add;

use bevy_app::App;
use bevy_ecs::prelude::*;

use crate::columns::{
    BOOKED, Columns, Kicked, Longest, Mirrors, SecondKick, WHOLE, Walkers, add_second_kick, kick_term,
};
use crate::space::Space;
use crate::step::{Clock, ClockAdvanced, Drifted, Part, Phase, Step};

/// What a force (N) adds to the velocity in half a step of `dt` (s), m/s.
#[inline]
fn half_kick<V: Space>(force: V, dt: f64, inverse_mass: f64) -> V {
    force * (0.5 * dt * inverse_mass)
}

/// If the second kick of the step before is owed, with that, and with its sum.
fn drift<V: Space>((clock, walkers): (Res<Clock>, Walkers), second: Res<SecondKick>, mut columns: ResMut<Columns<V>>) {
    columns.half_step = 0.5 * clock.dt;
    columns.stale.add(Mirrors::POSITION.or(Mirrors::VELOCITY).and(Mirrors::FREE));
    match (columns.has_books, second.is_owed) {
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

/// With a sum, which saves a pass ([`Columns::kick_sum`]).
fn kick<V: Space>((clock, walkers): (Res<Clock>, Walkers), mut columns: ResMut<Columns<V>>) {
    let sum = if columns.has_books {
        kick_by::<V, BOOKED>(clock.dt, &walkers, &mut columns)
    } else {
        kick_by::<V, WHOLE>(clock.dt, &walkers, &mut columns)
    };
    columns.kick_sum = Some(sum);
    columns.stale.add(Mirrors::VELOCITY.and(Mirrors::FREE));
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

pub(super) fn add<V: Space>(app: &mut App) {
    app.add_systems(Step, drift::<V>.in_set(Part::Engine(Phase::Drift)).in_set(Drifted).after(ClockAdvanced));
    add_second_kick(app, kick::<V>.in_set(Kicked));
}
