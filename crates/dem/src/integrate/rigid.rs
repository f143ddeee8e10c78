//! Rotation of bodies of several spheres.
//!
//! The angular momentum L of a body is kicked by its torque like a velocity, L(t+dt/2) = L(t) + dt/2 T(t). With it the body turns freely for dt
//! ([`Rotor::freely_turned`]), and a second half kick ends the step. Without torques L is constant to the last bit. The scheme is of second
//! order, symplectic and time-reversible, as velocity Verlet is for the centres.
//!
//! The spheres then follow their bodies (`integrate/scatter.rs`). Their velocities at the end of a step are set only if the kick is not deferred, that
//! is, if a system reads velocities.

use std::sync::Arc;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::bodies::RigidShape;
use crate::integrate::rotation::{first_kick, second_kick};
use crate::integrate::scatter::scatter;
use crate::integrate::turning::{Turn, TurningBodies, TurningLanes};
use crate::space::{Linear, Rotor, Space};
use crate::step::{Clock, Part, Phase, Step};
use crate::store::{
    BodyColumns, ChunkedPass, Kicked, MirrorSet, ParticleStore, PendingKick, SpinsDrifted, TOTAL,
    TOTAL_AND_DISSIPATIVE, add_second_kick, kick_term,
};

/// Makes the first kick of all bodies and turns them, after the pending second kick of the previous step if `SECOND`.
fn turn_all<V: Space, const NUMBERS: usize, const SECOND: bool>(
    dt: f64,
    chunked: &ChunkedPass,
    store: &mut ParticleStore<V>,
) {
    let predicts = store.predicts();
    let turn = Turn { dt, prediction: predicts.then_some(store.prediction.spin_share) };
    // Without prediction nobody reads it.
    let mut middle_spin = std::mem::take(&mut store.prediction.middle_spin);
    middle_spin.resize(store.rotation.len(), V::Spin::ZERO);
    let free = store.bodies.free;
    let ParticleStore { bodies: BodyColumns { momentum, rotor, inverse_inertia, .. }, loads, rotation, .. } = store;
    let turning = (&mut momentum[..free], (&mut rotor[..free], &inverse_inertia[..free]));
    let spins = (&mut rotation[..free], &mut middle_spin[..free]);
    let instructions = chunked.instructions();
    let sums = chunked.by_chunks(
        &loads.torque.entries::<NUMBERS>()[..free],
        (turning, spins),
        |torque, ((momentum, (rotor, inverse_inertia)), (rotation, middle_spin))| {
            let mut bodies = TurningBodies { torque, inverse_inertia, momentum, rotor, rotation, middle_spin };
            let mut lanes = TurningLanes::default();
            instructions.run(
                #[inline(always)]
                || lanes.turn_all::<SECOND>(turn, &mut bodies),
            )
        },
    );
    if SECOND {
        add_to_kick_sum(sums, store);
    }
    store.prediction.middle_spin = middle_spin;
}

/// Adds the sums of chunks to [`ParticleStore::spin_kick_sum`].
fn add_to_kick_sum<V: Space>(sums: Vec<V::Spin>, store: &mut ParticleStore<V>) {
    let before = store.spin_kick_sum.unwrap_or(V::Spin::ZERO);
    store.spin_kick_sum = Some(sums.into_iter().fold(before, |sum, one| sum + one));
}

/// Makes the second kick of all bodies.
fn kick_all<V: Space, const NUMBERS: usize>(dt: f64, chunked: &ChunkedPass, store: &mut ParticleStore<V>) {
    let free = store.bodies.free;
    let ParticleStore { bodies: BodyColumns { momentum, rotor, inverse_inertia, .. }, loads, rotation, .. } = store;
    let sums = chunked.in_chunks(
        &loads.torque.entries::<NUMBERS>()[..free],
        ((&mut momentum[..free], &rotor[..free]), (&inverse_inertia[..free], &mut rotation[..free])),
        #[inline(always)]
        move |torque, ((momentum, rotor), (inverse_inertia, rotation)), sum: &mut V::Spin| {
            *momentum += torque[0] * (0.5 * dt);
            rotation.spin = rotor.spin(*momentum, *inverse_inertia);
            *sum += kick_term(torque, rotation.spin);
        },
    );
    add_to_kick_sum(sums, store);
}

fn turn_bodies<V: Space>(
    clock: Res<Clock>,
    chunked: ChunkedPass,
    second: Res<PendingKick>,
    mut store: ResMut<ParticleStore<V>>,
) {
    if store.bodies.free == 0 {
        return;
    }
    store.stale.add(MirrorSet::SPIN.or(MirrorSet::ORIENTATION).and(MirrorSet::FREE));
    let dt = clock.dt;
    match (store.tracks_energy, second.is_pending) {
        (true, true) => turn_all::<V, TOTAL_AND_DISSIPATIVE, true>(dt, &chunked, &mut store),
        (true, false) => turn_all::<V, TOTAL_AND_DISSIPATIVE, false>(dt, &chunked, &mut store),
        (false, true) => turn_all::<V, TOTAL, true>(dt, &chunked, &mut store),
        (false, false) => turn_all::<V, TOTAL, false>(dt, &chunked, &mut store),
    }
    scatter(dt, &chunked, &mut store);
}

fn kick_bodies<V: Space>(clock: Res<Clock>, chunked: ChunkedPass, mut store: ResMut<ParticleStore<V>>) {
    if store.bodies.free == 0 {
        return;
    }
    if store.tracks_energy {
        kick_all::<V, TOTAL_AND_DISSIPATIVE>(clock.dt, &chunked, &mut store);
    } else {
        kick_all::<V, TOTAL>(clock.dt, &chunked, &mut store);
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
