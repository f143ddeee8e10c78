//! Rotation of grains: integrates spins from torques, in scenes with friction.
//!
//! The spin w follows velocity Verlet like the velocity: w(t+dt/2) = w(t) + dt/2 T(t)/I, then T from positions and
//! half-step velocities, then w(t+dt) = w(t+dt/2) + dt/2 T(t+dt)/I. Orientations of spheres are not integrated, because a sphere
//! is symmetric; [`rigid`](super::rigid) has those of bodies.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::bodies::Shape;
use crate::integrate::recorded_velocity::{InTheMiddle, Predicted, RecordedVelocity};
use crate::particle::{Grain, Mass, Radius};
use crate::persist::PersistApp as _;
use crate::space::{Linear, Space};
use crate::spin::{Inertia, InertiaLaw, Spin, Torque};
use crate::step::{Clock, Drifted, Part, Phase, Step};
use crate::store::{
    ChunkedPass, Kicked, MirrorSet, OwnObserver, ParticleStore, PendingKick, Rotation, SpinsDrifted, TOTAL,
    TOTAL_AND_DISSIPATIVE, add_second_kick, kick_term,
};

/// Adds the missing components of rotation to each grain that enters.
fn add_rotation_components<V: Space>(
    added: On<Add<Grain>>,
    store: Res<ParticleStore<V>>,
    grains: Query<(&Mass, &Radius, Option<&Shape>, Has<Spin<V::Spin>>, Has<Inertia>)>,
    mut commands: Commands,
) {
    let Ok((mass, radius, shape, spins, has_inertia)) = grains.get(added.entity) else { return };
    if spins && has_inertia {
        return;
    }
    let Some(law) = store.inertia else { return };
    let (spin, mut inertia) = law.turning::<V>(mass.0, radius.0, V::Spin::ZERO);
    if let Some(shape) = shape.and_then(|shape| store.bodies.shapes.get(shape.index())) {
        inertia = Inertia(shape.mean_inertia(mass.0, radius.0));
    }
    let mut grain = commands.entity(added.entity);
    grain.insert(inertia);
    if !spins {
        grain.insert(spin);
    }
}

/// Returns the gain of spin (rad/s) by a torque (N m) in half a step; `dt` is the step, s.
#[inline]
fn half_kick<W: Linear>(torque: W, dt: f64, inverse_inertia: f64) -> W {
    torque * (0.5 * dt * inverse_inertia)
}

/// Makes the second kick of a step, the first kick of the next step, or both in one pass. The second kick also sums
/// [`ParticleStore::spin_kick_sum`], which saves a pass.
fn kick_spins<V: Space, const SECOND: bool, const FIRST: bool>(
    dt: f64,
    chunked: &ChunkedPass,
    store: &mut ParticleStore<V>,
) {
    if store.predicts() {
        let recorded = Predicted { share: store.prediction.spin_share };
        let mut apart = std::mem::take(&mut store.prediction.middle_spin);
        apart.resize(store.rotation.len(), V::Spin::ZERO);
        kick_all::<V, Predicted, SECOND, FIRST>(recorded, &mut apart, dt, chunked, store);
        store.prediction.middle_spin = apart;
    } else {
        // Values without size: the vector allocates nothing.
        let mut apart = vec![(); store.rotation.len()];
        kick_all::<V, InTheMiddle, SECOND, FIRST>(InTheMiddle, &mut apart, dt, chunked, store);
    }
}

fn kick_all<V: Space, H: RecordedVelocity<Rotation<V>, V::Spin>, const SECOND: bool, const FIRST: bool>(
    recorded: H,
    apart: &mut [H::Apart],
    dt: f64,
    chunked: &ChunkedPass,
    store: &mut ParticleStore<V>,
) {
    if store.tracks_energy {
        kick_by::<V, H, TOTAL_AND_DISSIPATIVE, SECOND, FIRST>(recorded, apart, dt, chunked, store);
    } else {
        kick_by::<V, H, TOTAL, SECOND, FIRST>(recorded, apart, dt, chunked, store);
    }
}

/// Kicks spins by torques with `NUMBERS` accumulators per particle.
fn kick_by<
    V: Space,
    H: RecordedVelocity<Rotation<V>, V::Spin>,
    const NUMBERS: usize,
    const SECOND: bool,
    const FIRST: bool,
>(
    recorded: H,
    apart: &mut [H::Apart],
    dt: f64,
    chunked: &ChunkedPass,
    store: &mut ParticleStore<V>,
) {
    // Bodies of several spheres turn about principal axes of their own (`rigid`).
    let rows = store.bodies.free..store.integrated_rows().end;
    let ParticleStore { loads, rotation, .. } = store;
    let sums = chunked.in_chunks(
        &loads.torque.entries::<NUMBERS>()[rows.clone()],
        (&mut rotation[rows.clone()], &mut apart[rows]),
        #[inline(always)]
        move |torque, (rotation, apart), sum: &mut V::Spin| {
            let gain = half_kick(torque[0], dt, rotation.inverse_inertia);
            if SECOND {
                rotation.spin = recorded.middle(rotation, apart) + gain;
                *sum += kick_term(torque, rotation.spin);
            }
            if FIRST {
                recorded.store(rotation.spin + gain, gain, rotation, apart);
            }
        },
    );
    if SECOND {
        store.spin_kick_sum = Some(sums.into_iter().fold(V::Spin::ZERO, |sum, one| sum + one));
    }
}

/// Makes the first kick before the drift, together with the second kick of the previous step if that is pending.
pub(super) fn first_kick<V: Space>(
    clock: Res<Clock>,
    chunked: ChunkedPass,
    second: Res<PendingKick>,
    mut store: ResMut<ParticleStore<V>>,
) {
    store.stale.add(MirrorSet::SPIN.and(MirrorSet::FREE));
    if second.is_pending {
        kick_spins::<V, true, true>(clock.dt, &chunked, &mut store);
    } else {
        kick_spins::<V, false, true>(clock.dt, &chunked, &mut store);
    }
}

/// Makes the second kick, after the forces.
pub(super) fn second_kick<V: Space>(clock: Res<Clock>, chunked: ChunkedPass, mut store: ResMut<ParticleStore<V>>) {
    kick_spins::<V, true, false>(clock.dt, &chunked, &mut store);
    store.stale.add(MirrorSet::SPIN.and(MirrorSet::FREE));
}

/// Adds the rotation of grains.
pub struct SpinPlugin<V: Space> {
    /// Law for the moments of inertia.
    pub inertia: InertiaLaw,
    /// The space.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for SpinPlugin<V> {
    fn build(&self, app: &mut App) {
        app.world_mut().resource_mut::<ParticleStore<V>>().inertia = Some(self.inertia);
        app.persist_sound_component::<Spin<V::Spin>>()
            .persist_sound_component::<Torque<V::Spin>>()
            .persist_sound_component::<Inertia>()
            .derived::<OwnObserver>();
        app.world_mut().spawn((Observer::new(add_rotation_components::<V>), OwnObserver));
        app.add_systems(Step, first_kick::<V>.in_set(Part::Engine(Phase::Drift)).in_set(SpinsDrifted).after(Drifted));
        add_second_kick(app, second_kick::<V>.after(Kicked));
    }
}
