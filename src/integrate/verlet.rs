//! Velocity Verlet, as the assignment writes it:
//!
//! 1. x(t+dt) = x(t) + dt v(t) + dt^2/2 a(t)
//! 2. v(t+dt/2) = v(t) + dt/2 a(t)
//! 3. F from x(t+dt) and v(t+dt/2)
//! 4. a(t+dt) = F/m
//! 5. v(t+dt) = v(t+dt/2) + dt/2 a(t+dt)
//!
//! Steps 1 and 2 are [`Phase::Drift`], where 1 is written as x + dt v(t+dt/2), the same number; 4 and 5 are
//! [`Phase::Kick`], unless they are put off until the next drift (`store/deferred_kick.rs`). Second order, symplectic
//! and time-reversible while forces depend on positions alone. Drag is evaluated with a velocity half a step old, which
//! makes damped contacts first order; one such contact is stable for dt < 2/w0 (sqrt(1 + zeta^2) - zeta).

use std::ops::Add;

use bevy_app::App;
use bevy_ecs::prelude::*;

use crate::space::Space;
use crate::step::{Clock, ClockAdvanced, Drifted, Part, Phase, Step};
use crate::store::{
    ChunkedPass, Kicked, LongestMove, MirrorSet, ParticleStore, PendingKick, TOTAL, TOTAL_AND_DISSIPATIVE,
    add_second_kick, kick_term,
};

/// What a force (N) adds to the velocity in half a step of `dt` (s), m/s.
#[inline]
fn half_kick<V: Space>(force: V, dt: f64, inverse_mass: f64) -> V {
    force * (0.5 * dt * inverse_mass)
}

/// If the second kick of the step before is owed, with that, and with its sum.
fn drift<V: Space>(
    (clock, chunked): (Res<Clock>, ChunkedPass),
    second: Res<PendingKick>,
    mut store: ResMut<ParticleStore<V>>,
) {
    store.half_step = 0.5 * clock.dt;
    store.stale.add(MirrorSet::POSITION.or(MirrorSet::VELOCITY).and(MirrorSet::FREE));
    match (store.tracks_energy, second.is_pending) {
        (true, true) => drift_by::<V, TOTAL_AND_DISSIPATIVE, true>(clock.dt, &chunked, &mut store),
        (true, false) => drift_by::<V, TOTAL_AND_DISSIPATIVE, false>(clock.dt, &chunked, &mut store),
        (false, true) => drift_by::<V, TOTAL, true>(clock.dt, &chunked, &mut store),
        (false, false) => drift_by::<V, TOTAL, false>(clock.dt, &chunked, &mut store),
    }
}

/// By forces of which so many numbers are kept.
fn drift_by<V: Space, const NUMBERS: usize, const OWED: bool>(
    dt: f64,
    chunked: &ChunkedPass,
    store: &mut ParticleStore<V>,
) {
    // An open scene pays nothing for sides.
    match store.periodic.filter(|_| !store.sets_back_later) {
        None => drift_along::<V, NUMBERS, OWED>(dt, chunked, store, |_| {}),
        Some(periodic) => drift_along::<V, NUMBERS, OWED>(dt, chunked, store, |x| periodic.wrap(x)),
    }
}

fn drift_along<V: Space, const NUMBERS: usize, const OWED: bool>(
    dt: f64,
    chunked: &ChunkedPass,
    store: &mut ParticleStore<V>,
    set_back: impl Fn(&mut V) + Sync,
) {
    let ParticleStore { body, loads, movable_end: end, .. } = store;
    let chunks = chunked.in_chunks(
        &loads.force.entries::<NUMBERS>()[..*end],
        &mut body[..*end],
        #[inline(always)]
        |force, body, (longest, sum): &mut (LongestMove, V)| {
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
    let both = |(longest, sum): (LongestMove, V), (way, term)| (longest.or(way), sum + term);
    let (longest, sum) = chunks.into_iter().fold((LongestMove::default(), V::ZERO), both);
    store.travel += longest.length();
    if OWED {
        store.kick_sum = Some(sum);
    }
}

/// With a sum, which saves a pass ([`ParticleStore::kick_sum`]).
fn kick<V: Space>((clock, chunked): (Res<Clock>, ChunkedPass), mut store: ResMut<ParticleStore<V>>) {
    let sum = if store.tracks_energy {
        kick_by::<V, TOTAL_AND_DISSIPATIVE>(clock.dt, &chunked, &mut store)
    } else {
        kick_by::<V, TOTAL>(clock.dt, &chunked, &mut store)
    };
    store.kick_sum = Some(sum);
    store.stale.add(MirrorSet::VELOCITY.and(MirrorSet::FREE));
}

fn kick_by<V: Space, const NUMBERS: usize>(dt: f64, chunked: &ChunkedPass, store: &mut ParticleStore<V>) -> V {
    let ParticleStore { body, loads, movable_end: end, .. } = store;
    let sums = chunked.in_chunks(
        &loads.force.entries::<NUMBERS>()[..*end],
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
