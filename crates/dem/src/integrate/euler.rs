//! The two Euler schemes, both of first order, for teaching.
//!
//! * Explicit: x(t+dt) = x(t) + dt v(t), v(t+dt) = v(t) + dt a(t), with v and a on the right at time t. After a time T
//!   of free fall the position is g T dt/2 too high. The scheme multiplies the energy of every spring by
//!   1 + (w0 dt)^2 per step, so it is unstable for contacts at any step. It only serves as the control of the free-fall
//!   test.
//! * Symplectic: v(t+dt) = v(t) + dt a(t), then x(t+dt) = x(t) + dt v(t+dt), with a at time t. After a time T of free
//!   fall the position is g T dt/2 too low. For forces that depend on positions alone the scheme is symplectic: its
//!   energy has an error but no drift. It is stable for w0 dt < 2. Its positions equal those of velocity Verlet with
//!   velocities read half a step late.

use bevy_app::App;
use bevy_ecs::prelude::*;

use crate::space::Space;
use crate::step::{Clock, ClockAdvanced, Drifted, Part, Phase, Step};
use crate::store::{LongestMove, MirrorSet, ParticleStore};

fn euler_step<V: Space, const SYMPLECTIC: bool>(clock: Res<Clock>, mut store: ResMut<ParticleStore<V>>) {
    let dt = clock.dt;
    let mut longest = LongestMove::default();
    for i in store.integrated_rows() {
        let body = store.body[i];
        let force = store.loads.force.of(i);
        let velocity = body.velocity + force * (dt * body.inverse_mass);
        store.body[i].velocity = velocity;
        store.put(i, body.position + (if SYMPLECTIC { velocity } else { body.velocity }) * dt, &mut longest);
    }
    store.travel += longest.length();
    store.stale.add(MirrorSet::POSITION.or(MirrorSet::VELOCITY).and(MirrorSet::FREE));
}

pub(super) fn add_explicit<V: Space>(app: &mut App) {
    let step = euler_step::<V, false>.in_set(Part::Engine(Phase::Drift));
    app.add_systems(Step, step.in_set(Drifted).after(ClockAdvanced));
}

pub(super) fn add_symplectic<V: Space>(app: &mut App) {
    let step = euler_step::<V, true>.in_set(Part::Engine(Phase::Drift));
    app.add_systems(Step, step.in_set(Drifted).after(ClockAdvanced));
}
