//! Mirrored components: copies a component from the store (refresh), and a value that a system wrote to the store
//! (write-back).
//!
//! [`Position`], [`Velocity`], [`Force`], [`Spin`], [`Torque`] and [`Orientation`] of a particle are copies of numbers in the store. A
//! copy is *stale* if the store has changed since ([`ParticleStore::stale`]). [`Force`] and [`Torque`] exist only from the first use on
//! (`store/load_components.rs`).

use bevy_ecs::change_detection::{ContiguousRef, Tick};
use bevy_ecs::component::Mutable;
use bevy_ecs::prelude::*;
use bevy_ecs::query::ArchetypeFilter;
use bevy_ecs::system::SystemParam;

use crate::bodies::Orientation;
use crate::particle::{DENSE, Fixed, Force, Position, Slot, Velocity};
use crate::space::{Linear, Space};
use crate::spin::{Spin, Torque};
use crate::store::ParticleStore;
use crate::store::longest_move::LongestMove;
use crate::store::mirror_set::MirrorSet;

/// A component that mirrors numbers of the store.
pub(super) trait Mirror<V: Space>: Component<Mutability = Mutable> + Copy {
    const KIND: MirrorSet;

    /// Returns the value of row `i`, or `None` if the scene has no such numbers.
    fn from_store(store: &ParticleStore<V>, i: usize) -> Option<Self>;

    /// Writes the value to row `i`.
    fn write_to(self, store: &mut ParticleStore<V>, i: usize, longest: &mut LongestMove);
}

impl<V: Space> Mirror<V> for Position<V> {
    const KIND: MirrorSet = MirrorSet::POSITION;

    fn from_store(store: &ParticleStore<V>, i: usize) -> Option<Self> {
        store.body.get(i).map(|body| Self(body.position))
    }

    fn write_to(self, store: &mut ParticleStore<V>, i: usize, longest: &mut LongestMove) {
        store.put(i, self.0, longest);
    }
}

impl<V: Space> Mirror<V> for Velocity<V> {
    const KIND: MirrorSet = MirrorSet::VELOCITY;

    fn from_store(store: &ParticleStore<V>, i: usize) -> Option<Self> {
        store.body.get(i).map(|body| Self(body.velocity))
    }

    fn write_to(self, store: &mut ParticleStore<V>, i: usize, _: &mut LongestMove) {
        store.set_velocity(i, self.0, false);
        store.is_suspect |= !self.0.is_finite();
    }
}

impl<V: Space> Mirror<V> for Force<V> {
    const KIND: MirrorSet = MirrorSet::FORCE;

    fn from_store(store: &ParticleStore<V>, i: usize) -> Option<Self> {
        store.loads.force.get(i).map(Self)
    }

    fn write_to(self, store: &mut ParticleStore<V>, i: usize, _: &mut LongestMove) {
        if let Some(added) = store.added.get_mut(i) {
            *added += self.0 - store.loads.force.of(i);
        }
        store.loads.force.set(i, self.0);
        store.is_suspect |= !self.0.is_finite();
    }
}

impl<V: Space> Mirror<V> for Spin<V::Spin> {
    const KIND: MirrorSet = MirrorSet::SPIN;

    fn from_store(store: &ParticleStore<V>, i: usize) -> Option<Self> {
        store.rotation.get(i).map(|rotation| Self(rotation.spin))
    }

    fn write_to(self, store: &mut ParticleStore<V>, i: usize, _: &mut LongestMove) {
        if i < store.rotation.len() {
            store.set_spin(i, self.0, false);
            store.is_suspect |= !self.0.is_finite();
        }
    }
}

impl<V: Space> Mirror<V> for Torque<V::Spin> {
    const KIND: MirrorSet = MirrorSet::TORQUE;

    fn from_store(store: &ParticleStore<V>, i: usize) -> Option<Self> {
        store.loads.torque.get(i).map(Self)
    }

    fn write_to(self, store: &mut ParticleStore<V>, i: usize, _: &mut LongestMove) {
        store.loads.torque.set(i, self.0);
        store.is_suspect |= !self.0.is_finite();
    }
}

impl<V: Space> Mirror<V> for Orientation<V> {
    const KIND: MirrorSet = MirrorSet::ORIENTATION;

    fn from_store(store: &ParticleStore<V>, i: usize) -> Option<Self> {
        let body = store.body_of_row(i).filter(|_| i < store.len())?;
        Some(Self(store.bodies.rotor[body.index()]))
    }

    fn write_to(self, store: &mut ParticleStore<V>, i: usize, longest: &mut LongestMove) {
        store.set_orientation(i, self.0, longest);
    }
}

/// A mirrored component of free and of fixed particles.
#[derive(SystemParam)]
struct RefreshQueries<'w, 's, C: Component<Mutability = Mutable>> {
    free: Query<'w, 's, (&'static Slot, &'static mut C), Without<Fixed>>,
    fixed: Query<'w, 's, (&'static Slot, &'static mut C), With<Fixed>>,
}

/// System parameter for the refresh: the store and all mirrored components.
#[derive(SystemParam)]
pub(super) struct Refresh<'w, 's, V: Space> {
    store: ResMut<'w, ParticleStore<V>>,
    positions: RefreshQueries<'w, 's, Position<V>>,
    velocities: RefreshQueries<'w, 's, Velocity<V>>,
    forces: RefreshQueries<'w, 's, Force<V>>,
    spins: RefreshQueries<'w, 's, Spin<<V as Space>::Spin>>,
    torques: RefreshQueries<'w, 's, Torque<<V as Space>::Spin>>,
    orientations: RefreshQueries<'w, 's, Orientation<V>>,
}

impl<V: Space> Refresh<'_, '_, V> {
    /// Refreshes the stale components among `wanted`.
    pub(super) fn refresh(mut self, wanted: MirrorSet) {
        let due = wanted.and(self.store.stale);
        let stale = self.store.stale.without(due);
        let store = self.store.bypass_change_detection();
        store.stale = stale;
        refresh_component(store, due, &mut self.positions);
        refresh_component(store, due, &mut self.velocities);
        refresh_component(store, due, &mut self.forces);
        refresh_component(store, due, &mut self.spins);
        refresh_component(store, due, &mut self.torques);
        refresh_component(store, due, &mut self.orientations);
    }
}

fn refresh_component<V: Space, C: Mirror<V>>(
    store: &ParticleStore<V>,
    due: MirrorSet,
    rows: &mut RefreshQueries<'_, '_, C>,
) {
    let due = due.and(C::KIND);
    if due.meets(MirrorSet::FREE) {
        refresh_rows(store, &mut rows.free);
    }
    if due.meets(MirrorSet::FIXED) {
        refresh_rows(store, &mut rows.fixed);
    }
}

/// Copies the store to the components without setting change ticks, so that `Changed` shows only writes of systems.
fn refresh_rows<V: Space, C: Mirror<V>, F: ArchetypeFilter>(
    store: &ParticleStore<V>,
    rows: &mut Query<(&Slot, &mut C), F>,
) {
    for (slots, mut values) in rows.contiguous_iter_mut().expect(DENSE) {
        for (slot, value) in slots.iter().zip(values.bypass_change_detection()) {
            if let Some(now) = C::from_store(store, slot.index()) {
                *value = now;
            }
        }
    }
}

type WrittenQuery<'w, 's, C> = Query<'w, 's, (&'static Slot, Ref<'static, C>)>;

/// System parameter for the write-back: the store and all mirrored components.
#[derive(SystemParam)]
pub(super) struct WriteBack<'w, 's, V: Space> {
    store: ResMut<'w, ParticleStore<V>>,
    positions: WrittenQuery<'w, 's, Position<V>>,
    velocities: WrittenQuery<'w, 's, Velocity<V>>,
    forces: WrittenQuery<'w, 's, Force<V>>,
    spins: WrittenQuery<'w, 's, Spin<<V as Space>::Spin>>,
    torques: WrittenQuery<'w, 's, Torque<<V as Space>::Spin>>,
    orientations: WrittenQuery<'w, 's, Orientation<V>>,
}

impl<V: Space> WriteBack<'_, '_, V> {
    /// Writes back the components in `written` that systems wrote after the tick `since`.
    pub(super) fn write_back(mut self, written: MirrorSet, since: Tick) {
        let mut longest = LongestMove::default();
        let store = &mut *self.store;
        write_back_component(store, written, since, &self.positions, &mut longest);
        write_back_component(store, written, since, &self.velocities, &mut longest);
        write_back_component(store, written, since, &self.forces, &mut longest);
        write_back_component(store, written, since, &self.spins, &mut longest);
        write_back_component(store, written, since, &self.torques, &mut longest);
        write_back_component(store, written, since, &self.orientations, &mut longest);
        store.travel += longest.length();
        // A write that bypassed change detection was not written back, so the component may differ from the store.
        store.stale.add(written);
    }
}

/// Writes back free and fixed particles alike: a system may fix a particle in the phase in which it writes to it.
fn write_back_component<V: Space, C: Mirror<V>>(
    store: &mut ParticleStore<V>,
    written: MirrorSet,
    since: Tick,
    rows: &WrittenQuery<C>,
    longest: &mut LongestMove,
) {
    if !written.meets(C::KIND) {
        return;
    }
    for (slots, values) in rows.contiguous_iter().expect(DENSE) {
        let (values, ticks) = ContiguousRef::split(values);
        if ticks.summary_tick_is_changed() == Some(false) {
            continue;
        }
        let now = ticks.this_run();
        for (slot, (value, changed)) in slots.iter().zip(values.iter().zip(ticks.changed())) {
            // A particle without a slot is read when it gets one.
            if changed.is_newer_than(since, now) && slot.index() < store.len() {
                value.write_to(store, slot.index(), longest);
            }
        }
    }
}
