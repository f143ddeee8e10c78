//! Velocity Verlet, as the assignment writes it:
//!
//! 1. x(t+dt) = x(t) + dt v(t) + dt^2/2 a(t)
//! 2. v(t+dt/2) = v(t) + dt/2 a(t)
//! 3. F from x(t+dt) and v(t+dt/2)
//! 4. a(t+dt) = F/m
//! 5. v(t+dt) = v(t+dt/2) + dt/2 a(t+dt)
//!
//! Steps 1 and 2 are [`Phase::Drift`]. Step 1 is written as x + dt v(t+dt/2), which is the same number. Steps 4 and 5
//! are [`Phase::Kick`], unless the kick is deferred to the next drift (`store/deferred_kick.rs`).
//!
//! The scheme is second order, symplectic and time-reversible for forces that depend on positions alone. Drag is
//! evaluated with a velocity half a step old, so damped contacts are first order. One such contact is stable for
//! dt < 2/w0 (sqrt(1 + zeta^2) - zeta).

use std::ops::Add;

use bevy_app::App;
use bevy_ecs::prelude::*;

use crate::integrate::recorded_velocity::{InTheMiddle, Predicted, RecordedVelocity, Swept};
use crate::space::Space;
use crate::step::{Clock, ClockAdvanced, Drifted, Part, Phase, Step};
use crate::store::{
    Body, ChunkedPass, Kicked, LongestMove, MirrorSet, ParticleStore, PendingKick, TOTAL, TOTAL_AND_DISSIPATIVE,
    add_second_kick, kick_term,
};

/// Returns the gain of velocity (m/s) by a force (N) in half a step; `dt` is the step, s.
#[inline]
fn half_kick<V: Space>(force: V, dt: f64, inverse_mass: f64) -> V {
    force * (0.5 * dt * inverse_mass)
}

/// Makes the first kick and the drift. A pending second kick of the previous step, with its sum, comes first.
fn drift<V: Space>(
    clock: Res<Clock>,
    chunked: ChunkedPass,
    second: Res<PendingKick>,
    mut store: ResMut<ParticleStore<V>>,
) {
    store.half_step = 0.5 * clock.dt;
    store.stale.add(MirrorSet::POSITION.or(MirrorSet::VELOCITY).and(MirrorSet::FREE));
    let dt = clock.dt;
    let is_pending = second.is_pending;
    // Values without size: such vectors allocate nothing.
    let count = store.body.len();
    let unit = |count| vec![(); count];
    if store.predicts() {
        let recorded = Predicted { share: store.prediction.share };
        let mut apart = std::mem::take(&mut store.prediction.middle);
        apart.resize(count, V::MiddleBesideBody::default());
        let longest = if store.prediction.sweeps {
            let mut swept = std::mem::take(&mut store.prediction.swept);
            swept.resize(count, 0.0);
            let kept = Kept { apart: &mut apart, swept: &mut swept };
            let longest = drift_all(recorded, kept, dt, is_pending, &chunked, &mut store);
            store.prediction.swept = swept;
            longest
        } else {
            let kept = Kept { apart: &mut apart, swept: &mut unit(count) };
            drift_all(recorded, kept, dt, is_pending, &chunked, &mut store)
        };
        store.prediction.middle = apart;
        store.prediction.is_ahead = true;
        // The spheres of bodies follow them later, with margins of their own.
        let first = store.free_end;
        store.set_margins(first, longest, dt);
    } else {
        let kept = Kept { apart: &mut unit(count), swept: &mut unit(count) };
        drift_all(InTheMiddle, kept, dt, is_pending, &chunked, &mut store);
    }
}

/// The numbers of particles that the drift writes beside the bodies.
struct Kept<'a, V: Space, H: RecordedVelocity<Body<V>, V>, W> {
    /// Velocities that the scheme keeps apart from the bodies.
    apart: &'a mut [H::Apart],
    /// Swept radii.
    swept: &'a mut [W],
}

/// Drifts, and makes the pending second kick first. Returns the longest move, m.
fn drift_all<V: Space, H: RecordedVelocity<Body<V>, V>, W: Swept>(
    recorded: H,
    kept: Kept<'_, V, H, W>,
    dt: f64,
    is_pending: bool,
    chunked: &ChunkedPass,
    store: &mut ParticleStore<V>,
) -> f64 {
    let longest = match (store.tracks_energy, is_pending) {
        (true, true) => drift_by::<V, H, W, TOTAL_AND_DISSIPATIVE, true>(recorded, kept, dt, chunked, store),
        (true, false) => drift_by::<V, H, W, TOTAL_AND_DISSIPATIVE, false>(recorded, kept, dt, chunked, store),
        (false, true) => drift_by::<V, H, W, TOTAL, true>(recorded, kept, dt, chunked, store),
        (false, false) => drift_by::<V, H, W, TOTAL, false>(recorded, kept, dt, chunked, store),
    };
    store.travel += longest;
    store.bodies.drifted = longest;
    longest
}

/// Drifts under forces with `NUMBERS` accumulators per particle.
fn drift_by<V: Space, H: RecordedVelocity<Body<V>, V>, W: Swept, const NUMBERS: usize, const PENDING: bool>(
    recorded: H,
    kept: Kept<'_, V, H, W>,
    dt: f64,
    chunked: &ChunkedPass,
    store: &mut ParticleStore<V>,
) -> f64 {
    // The pass is compiled without wrapping too, so that open scenes do not pay for it.
    match store.periodic.filter(|_| !store.wraps_after_drift) {
        None => drift_with::<V, H, W, NUMBERS, PENDING>(recorded, kept, dt, chunked, store, |_| {}),
        Some(periodic) => {
            drift_with::<V, H, W, NUMBERS, PENDING>(recorded, kept, dt, chunked, store, |x| periodic.wrap(x))
        }
    }
}

/// Drifts, and applies `wrap` to each new position.
fn drift_with<V: Space, H: RecordedVelocity<Body<V>, V>, W: Swept, const NUMBERS: usize, const PENDING: bool>(
    recorded: H,
    kept: Kept<'_, V, H, W>,
    dt: f64,
    chunked: &ChunkedPass,
    store: &mut ParticleStore<V>,
    wrap: impl Fn(&mut V) + Copy + Sync,
) -> f64 {
    let range = store.prediction.range;
    let end = store.integrated_rows().end;
    let ParticleStore { body, loads, .. } = store;
    let Kept { apart, swept } = kept;
    let chunks = chunked.in_chunks(
        &loads.force.entries::<NUMBERS>()[..end],
        ((&mut body[..end], &mut apart[..end]), &mut swept[..end]),
        #[inline(always)]
        move |force, ((body, apart), swept), (longest, sum): &mut (LongestMove, V)| {
            let gain = half_kick(force[0], dt, body.inverse_mass);
            let mut velocity = if PENDING { recorded.middle(body, apart) } else { body.velocity } + gain;
            if PENDING {
                *sum += kick_term(force, velocity);
                velocity += gain;
            }
            let mut position = body.position + velocity * dt;
            // The move is measured before the position is wrapped.
            *swept = W::of(body.radius, longest.raise(position - body.position), range);
            wrap(&mut position);
            body.position = position;
            recorded.store(velocity, gain, body, apart);
        },
    );
    let both = |(longest, sum): (LongestMove, V), (other, term)| (longest.or(other), sum + term);
    let (longest, sum) = chunks.into_iter().fold((LongestMove::default(), V::ZERO), both);
    if PENDING {
        store.kick_sum = Some(sum);
    }
    longest.length()
}

/// Makes the second kick. It also sums [`ParticleStore::kick_sum`], which saves a pass.
fn kick<V: Space>(clock: Res<Clock>, chunked: ChunkedPass, mut store: ResMut<ParticleStore<V>>) {
    let sum = if std::mem::take(&mut store.prediction.is_ahead) {
        let recorded = Predicted { share: store.prediction.share };
        let mut apart = std::mem::take(&mut store.prediction.middle);
        let sum = kick_all(recorded, &mut apart, clock.dt, &chunked, &mut store);
        store.prediction.middle = apart;
        sum
    } else {
        let mut apart = vec![(); store.body.len()];
        kick_all(InTheMiddle, &mut apart, clock.dt, &chunked, &mut store)
    };
    store.kick_sum = Some(sum);
    store.stale.add(MirrorSet::VELOCITY.and(MirrorSet::FREE));
}

fn kick_all<V: Space, H: RecordedVelocity<Body<V>, V>>(
    recorded: H,
    apart: &mut [H::Apart],
    dt: f64,
    chunked: &ChunkedPass,
    store: &mut ParticleStore<V>,
) -> V {
    if store.tracks_energy {
        kick_by::<V, H, TOTAL_AND_DISSIPATIVE>(recorded, apart, dt, chunked, store)
    } else {
        kick_by::<V, H, TOTAL>(recorded, apart, dt, chunked, store)
    }
}

fn kick_by<V: Space, H: RecordedVelocity<Body<V>, V>, const NUMBERS: usize>(
    recorded: H,
    apart: &mut [H::Apart],
    dt: f64,
    chunked: &ChunkedPass,
    store: &mut ParticleStore<V>,
) -> V {
    let end = store.integrated_rows().end;
    let ParticleStore { body, loads, .. } = store;
    let sums = chunked.in_chunks(
        &loads.force.entries::<NUMBERS>()[..end],
        (&mut body[..end], &mut apart[..end]),
        #[inline(always)]
        move |force, (body, apart), sum: &mut V| {
            let velocity = recorded.middle(body, apart) + half_kick(force[0], dt, body.inverse_mass);
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
