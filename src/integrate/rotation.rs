//! The rotation of grains, in scenes with friction: spins by torques.
//!
//! w follows velocity Verlet as the velocity does: w(t+dt/2) = w(t) + dt/2 T(t)/I, then T from positions and half-step
//! velocities, then w(t+dt) = w(t+dt/2) + dt/2 T(t+dt)/I. Orientations are not followed: a sphere looks the same from
//! all sides.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::particle::{Grain, Mass, Radius};
use crate::space::{Linear, Space};
use crate::spin::{Inertia, InertiaLaw, Spin, Torque};
use crate::step::{Clock, Drifted, Part, Phase, Step};
use crate::store::{
    ChunkedPass, Kicked, MirrorSet, OwnObserver, ParticleStore, PendingKick, SpinsDrifted, TOTAL,
    TOTAL_AND_DISSIPATIVE, add_second_kick, kick_term,
};

/// Every grain that enters gets what it needs to turn, unless it brings all of it.
fn equip<V: Space>(
    added: On<Add<Grain>>,
    store: Res<ParticleStore<V>>,
    grains: Query<(&Mass, &Radius, Has<Spin<V::Spin>>, Has<Torque<V::Spin>>, Has<Inertia>)>,
    mut commands: Commands,
) {
    let Ok((mass, radius, spins, has_torque, has_inertia)) = grains.get(added.entity) else { return };
    if spins && has_torque && has_inertia {
        return;
    }
    let Some(law) = store.inertia else { return };
    let (spin, torque, inertia) = law.turning::<V>(mass.0, radius.0, V::Spin::ZERO);
    let mut grain = commands.entity(added.entity);
    grain.insert((torque, inertia));
    if !spins {
        grain.insert(spin);
    }
}

/// What a torque (N m) adds to the spin in half a step of `dt` (s), rad/s.
#[inline]
fn gained<W: Linear>(torque: W, dt: f64, inverse_inertia: f64) -> W {
    torque * (0.5 * dt * inverse_inertia)
}

/// The second kick of a step, the first of the next, or both in one pass. The second leaves
/// a sum, which saves a pass ([`ParticleStore::spin_kick_sum`]).
fn kick_spins<V: Space, const SECOND: bool, const FIRST: bool>(
    dt: f64,
    chunked: &ChunkedPass,
    store: &mut ParticleStore<V>,
) {
    if store.tracks_energy {
        kick_by::<V, TOTAL_AND_DISSIPATIVE, SECOND, FIRST>(dt, chunked, store);
    } else {
        kick_by::<V, TOTAL, SECOND, FIRST>(dt, chunked, store);
    }
}

/// By torques of which so many numbers are kept.
fn kick_by<V: Space, const NUMBERS: usize, const SECOND: bool, const FIRST: bool>(
    dt: f64,
    chunked: &ChunkedPass,
    store: &mut ParticleStore<V>,
) {
    let ParticleStore { loads, rotation, movable_end: end, .. } = store;
    let sums = chunked.in_chunks(
        &loads.torque.entries::<NUMBERS>()[..*end],
        &mut rotation[..*end],
        #[inline(always)]
        |torque, rotation, sum: &mut V::Spin| {
            let gained = gained(torque[0], dt, rotation.inverse_inertia);
            if SECOND {
                rotation.spin += gained;
                *sum += kick_term(torque, rotation.spin);
            }
            if FIRST {
                rotation.spin += gained;
            }
        },
    );
    if SECOND {
        store.spin_kick_sum = Some(sums.into_iter().fold(V::Spin::ZERO, |sum, one| sum + one));
    }
}

/// Before the drift; with the second kick of the step before, if it is owed.
fn first_kick<V: Space>(
    (clock, chunked): (Res<Clock>, ChunkedPass),
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

/// After the forces.
fn second_kick<V: Space>((clock, chunked): (Res<Clock>, ChunkedPass), mut store: ResMut<ParticleStore<V>>) {
    kick_spins::<V, true, false>(clock.dt, &chunked, &mut store);
    store.stale.add(MirrorSet::SPIN.and(MirrorSet::FREE));
}

/// Rotation of grains.
pub struct SpinPlugin<V: Space> {
    /// What moments of inertia follow from.
    pub inertia: InertiaLaw,
    /// The space.
    pub space: PhantomData<V>,
}

impl<V: Space> Plugin for SpinPlugin<V> {
    fn build(&self, app: &mut App) {
        app.world_mut().resource_mut::<ParticleStore<V>>().inertia = Some(self.inertia);
        app.world_mut().spawn((Observer::new(equip::<V>), OwnObserver));
        app.add_systems(Step, first_kick::<V>.in_set(Part::Engine(Phase::Drift)).in_set(SpinsDrifted).after(Drifted));
        add_second_kick(app, second_kick::<V>.after(Kicked));
    }
}
