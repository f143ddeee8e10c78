//! Rotation of bodies of several spheres.
//!
//! The angular momentum L of a body is kicked by its torque like a velocity, L(t+dt/2) = L(t) + dt/2 T(t). With it the body turns freely for dt
//! ([`Rotor::freely_turned`]), and a second half kick ends the step. Without torques L is constant to the last bit. The scheme is of second
//! order, symplectic and time-reversible, as velocity Verlet is for the centres.
//!
//! The spheres then follow their bodies (`store/body_motion.rs`). Their velocities at the end of a step are set only if the kick is not deferred, that
//! is, if a system reads velocities.

use std::sync::Arc;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::bodies::RigidShape;
use crate::integrate::rotation::{first_kick, second_kick};
use crate::space::{Linear, Rotor, Space};
use crate::step::{Clock, Part, Phase, Step};
use crate::store::{
    Kicked, MirrorSet, ParticleStore, PendingKick, SpinsDrifted, TOTAL, TOTAL_AND_DISSIPATIVE, add_second_kick,
    kick_term,
};

/// Makes the first kick of all bodies and turns them, after the pending second kick of the previous step if `SECOND`.
fn turn_all<V: Space, const NUMBERS: usize, const SECOND: bool>(dt: f64, store: &mut ParticleStore<V>) {
    let predicts = store.predicts();
    let share = store.prediction.spin_share;
    let mut sum = store.spin_kick_sum.unwrap_or(V::Spin::ZERO);
    for b in 0..store.bodies.free {
        let torque = store.loads.torque.entries::<NUMBERS>()[b];
        let gain = torque[0] * (0.5 * dt);
        let inverse_inertia = store.bodies.inverse_inertia[b];
        let rotor = store.bodies.rotor[b];
        let mut momentum = store.bodies.momentum[b];
        if SECOND {
            momentum += gain;
            sum += kick_term(&torque, rotor.spin(momentum, inverse_inertia));
        }
        momentum += gain;
        let turned = rotor.freely_turned(momentum, inverse_inertia, dt);
        let before = rotor.spin(momentum, inverse_inertia);
        let middle = (before + turned.spin(momentum, inverse_inertia)) * 0.5;
        if predicts {
            store.prediction.middle_spin[b] = middle;
            store.rotation[b].spin = turned.spin(momentum + gain * share, inverse_inertia);
        } else {
            store.rotation[b].spin = middle;
        }
        store.bodies.momentum[b] = momentum;
        store.bodies.rotor[b] = turned;
    }
    if SECOND {
        store.spin_kick_sum = Some(sum);
    }
}

/// Makes the second kick of all bodies.
fn kick_all<V: Space, const NUMBERS: usize>(dt: f64, store: &mut ParticleStore<V>) {
    let mut sum = store.spin_kick_sum.unwrap_or(V::Spin::ZERO);
    for b in 0..store.bodies.free {
        let torque = store.loads.torque.entries::<NUMBERS>()[b];
        let momentum = store.bodies.momentum[b] + torque[0] * (0.5 * dt);
        let spin = store.bodies.rotor[b].spin(momentum, store.bodies.inverse_inertia[b]);
        sum += kick_term(&torque, spin);
        store.bodies.momentum[b] = momentum;
        store.rotation[b].spin = spin;
    }
    store.spin_kick_sum = Some(sum);
}

fn turn_bodies<V: Space>(clock: Res<Clock>, second: Res<PendingKick>, mut store: ResMut<ParticleStore<V>>) {
    if store.bodies.free == 0 {
        return;
    }
    store.stale.add(MirrorSet::SPIN.or(MirrorSet::ORIENTATION).and(MirrorSet::FREE));
    let dt = clock.dt;
    match (store.tracks_energy, second.is_pending) {
        (true, true) => turn_all::<V, TOTAL_AND_DISSIPATIVE, true>(dt, &mut store),
        (true, false) => turn_all::<V, TOTAL_AND_DISSIPATIVE, false>(dt, &mut store),
        (false, true) => turn_all::<V, TOTAL, true>(dt, &mut store),
        (false, false) => turn_all::<V, TOTAL, false>(dt, &mut store),
    }
    store.scatter_bodies(dt);
}

fn kick_bodies<V: Space>(clock: Res<Clock>, mut store: ResMut<ParticleStore<V>>) {
    if store.bodies.free == 0 {
        return;
    }
    if store.tracks_energy {
        kick_all::<V, TOTAL_AND_DISSIPATIVE>(clock.dt, &mut store);
    } else {
        kick_all::<V, TOTAL>(clock.dt, &mut store);
    }
    store.scatter_velocities();
    store.stale.add(MirrorSet::SPIN.and(MirrorSet::FREE));
}

/// Shapes of grains. It needs the [rotation of grains](crate::integrate::rotation::SpinPlugin).
pub struct BodiesPlugin<V: Space> {
    /// The shapes, by number.
    pub shapes: Arc<[RigidShape<V>]>,
}

impl<V: Space> Plugin for BodiesPlugin<V> {
    fn build(&self, app: &mut App) {
        app.world_mut().resource_mut::<ParticleStore<V>>().bodies.shapes = self.shapes.clone();
        let turn = turn_bodies::<V>.in_set(Part::Engine(Phase::Drift)).in_set(SpinsDrifted);
        app.add_systems(Step, turn.after(first_kick::<V>));
        add_second_kick(app, kick_bodies::<V>.after(Kicked).after(second_kick::<V>));
    }
}
