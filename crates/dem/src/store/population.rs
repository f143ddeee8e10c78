//! The population: entities that entered, left, or changed a permanent property since the last renumbering.
//!
//! Component hooks record each change at once, whether a command, an observer or a system with the world makes it.
//! `GrainId` marks a particle. `Radius`, `Mass`, `Species`, `Inertia` and `Fixed` change by insertion only. Their hooks
//! request a renumbering, which reads only the entities recorded here.
//!
//! When a particle leaves, its row loses its entity at once, and the row remains until the renumbering
//! ([`ParticleStore::is_present`]). A mirrored component that is inserted on a particle of the store is written to the
//! store at once.

use bevy_ecs::component::Mutable;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;

use crate::bodies::Orientation;
use crate::particle::{Fixed, Force, GrainId, Mass, Position, Radius, Slot, Species, Velocity};
use crate::space::{Linear, Space};
use crate::spin::{Inertia, Spin, Torque};
use crate::store::ParticleStore;
use crate::store::longest_move::LongestMove;
use crate::store::mirror_set::MirrorSet;
use crate::store::pending_kick::PendingKick;

/// Changes since the last renumbering.
#[derive(Resource, Default)]
pub struct Population {
    /// Entities that entered, were fixed or freed, or got another radius, mass, species or moment of inertia.
    pub(super) touched: Vec<Entity>,
    /// Whether the order of slots is out of date, or a particle has left.
    pub(super) is_out_of_date: bool,
}

impl Population {
    /// Requests a renumbering.
    pub fn renumber(&mut self) {
        self.is_out_of_date = true;
    }

    /// Whether a renumbering is due.
    pub(crate) fn is_due(&self) -> bool {
        self.is_out_of_date || !self.touched.is_empty()
    }

    /// Whether particles entered or were altered.
    pub(super) fn has_touched(&self) -> bool {
        !self.touched.is_empty()
    }

    /// Returns the entities to read again, without duplicates, and clears the record.
    pub(super) fn take(&mut self) -> Vec<Entity> {
        self.is_out_of_date = false;
        let mut touched = std::mem::take(&mut self.touched);
        touched.sort_unstable();
        touched.dedup();
        touched
    }

    fn touch(world: &mut DeferredWorld, entity: Entity) {
        if let Some(mut population) = world.get_resource_mut::<Self>() {
            population.touched.push(entity);
        }
    }
}

/// The row of an entity, or `None` if the store has no row for it.
fn row_of<V: Space>(world: &DeferredWorld, entity: Entity) -> Option<usize> {
    world.get_resource::<ParticleStore<V>>()?.row_of(entity, *world.get::<Slot>(entity)?)
}

fn on_enter(mut world: DeferredWorld, context: HookContext) {
    Population::touch(&mut world, context.entity);
}

/// Removes the entity of a leaving particle from its row, and requests a renumbering.
fn on_leave<V: Space>(mut world: DeferredWorld, context: HookContext) {
    if let Some(row) = row_of::<V>(&world, context.entity) {
        world.resource_mut::<ParticleStore<V>>().vacate(row);
        if let Some(mut population) = world.get_resource_mut::<Population>() {
            population.renumber();
        }
    }
}

/// Records an entity with a permanent property inserted or removed. An entering particle has no slot and is skipped,
/// because all its components are read anyway.
fn on_alter(mut world: DeferredWorld, context: HookContext) {
    if world.get::<Slot>(context.entity).is_some_and(|slot| *slot != Slot::default()) {
        Population::touch(&mut world, context.entity);
    }
}

/// Marks all components of a particle stale after it was fixed or freed. Staleness is kept separately for free and
/// fixed particles, so all components become stale.
fn on_fix_or_free<V: Space>(mut world: DeferredWorld, context: HookContext) {
    if let Some(mut store) = world.get_resource_mut::<ParticleStore<V>>() {
        store.stale = MirrorSet::ALL;
    }
    on_alter(world, context);
}

/// Writes an inserted component to the store, if the particle has a row.
fn on_mirror_insert<V: Space, T: Component<Mutability = Mutable> + Copy>(
    mut world: DeferredWorld,
    context: HookContext,
    write: fn(&mut ParticleStore<V>, usize, T, KickPending),
) {
    if let Some(row) = row_of::<V>(&world, context.entity)
        && let Some(value) = world.get::<T>(context.entity).copied()
    {
        let is_pending = world.get_resource::<PendingKick>().is_some_and(|kick| kick.is_pending);
        write(&mut world.resource_mut::<ParticleStore<V>>(), row, value, KickPending(is_pending));
    }
}

/// Whether a second kick is pending. If it is, the store holds velocities and spins from before this kick.
#[derive(Clone, Copy)]
struct KickPending(bool);

impl<V: Space> ParticleStore<V> {
    /// The row of `entity`, which has this slot; `None` if it has no row.
    #[inline]
    pub(super) fn row_of(&self, entity: Entity, slot: Slot) -> Option<usize> {
        (self.entity.get(slot.index()) == Some(&entity)).then_some(slot.index())
    }

    /// Removes the entity from a row, and from the rows of its spheres.
    fn vacate(&mut self, row: usize) {
        let spheres = self.body_of_row(row).map_or(&[][..], |body| self.bodies.rows_of(body));
        for row in spheres.iter().map(|&sphere| sphere as usize).chain([row]) {
            self.entity[row] = Entity::PLACEHOLDER;
            self.vacated.push(row);
        }
    }

    /// Whether the particle of row `i` still exists. A particle that left keeps its row until the next renumbering.
    #[must_use]
    #[inline]
    pub fn is_present(&self, i: usize) -> bool {
        self.vacated.is_empty() || self.entity[i] != Entity::PLACEHOLDER
    }

    /// The rows of particles that left since the last renumbering, in the order in which they left.
    #[must_use]
    pub fn vacated(&self) -> &[usize] {
        &self.vacated
    }

    fn write_position(&mut self, row: usize, Position(x): Position<V>, _: KickPending) {
        let mut longest = LongestMove::default();
        self.put(row, x, &mut longest);
        self.travel += longest.length();
    }

    /// The velocity change by the pending kick, m/s.
    fn pending_kick_gain(&self, row: usize, force: V, KickPending(is_pending): KickPending) -> V {
        let time = if is_pending { self.half_step } else { 0.0 };
        force * (time * self.body[row].inverse_mass)
    }

    /// The spin change by the pending kick, rad/s.
    fn pending_spin_gain(&self, row: usize, torque: V::Spin, KickPending(is_pending): KickPending) -> V::Spin {
        let time = if is_pending { self.half_step } else { 0.0 };
        self.spin_gain(row, torque * time)
    }

    fn write_velocity(&mut self, row: usize, Velocity(v): Velocity<V>, pending: KickPending) {
        let before_kick = v - self.pending_kick_gain(row, self.loads.force.of(row), pending);
        self.set_velocity(row, before_kick, pending.0);
        self.is_suspect |= !v.is_finite();
    }

    fn write_orientation(&mut self, row: usize, Orientation(rotor): Orientation<V>, _: KickPending) {
        let mut longest = LongestMove::default();
        self.set_orientation(row, rotor, &mut longest);
        self.travel += longest.length();
    }

    fn write_force(&mut self, row: usize, Force(force): Force<V>, pending: KickPending) {
        // A copy of the store's own number changes nothing, not even the sign of a zero.
        if self.loads.force.of(row) == force {
            return;
        }
        let change = self.loads.force.of(row) - force;
        let correction = self.pending_kick_gain(row, change, pending);
        self.set_velocity(row, self.body[row].velocity + correction, false);
        if let Some(added) = self.added.get_mut(row) {
            *added -= change;
        }
        self.loads.force.set(row, force);
        self.is_suspect |= !force.is_finite();
    }

    fn write_spin(&mut self, row: usize, Spin(spin): Spin<V::Spin>, pending: KickPending) {
        if row < self.rotation.len() {
            let before_kick = spin - self.pending_spin_gain(row, self.loads.torque.of(row), pending);
            self.set_spin(row, before_kick, pending.0);
            self.is_suspect |= !spin.is_finite();
        }
    }

    fn write_torque(&mut self, row: usize, Torque(torque): Torque<V::Spin>, pending: KickPending) {
        if row < self.rotation.len() && self.loads.torque.of(row) != torque {
            let correction = self.pending_spin_gain(row, self.loads.torque.of(row) - torque, pending);
            self.set_spin(row, self.rotation[row].spin + correction, false);
            self.loads.torque.set(row, torque);
            self.is_suspect |= !torque.is_finite();
        }
    }
}

/// Registers the hooks. This must happen before the first particle is spawned.
pub(super) fn add<V: Space>(world: &mut World) {
    world.init_resource::<Population>();
    world.register_component_hooks::<GrainId>().on_insert(on_enter).on_remove(on_leave::<V>);
    world.register_component_hooks::<Radius>().on_insert(on_alter);
    world.register_component_hooks::<Mass>().on_insert(on_alter).on_remove(on_alter);
    world.register_component_hooks::<Species>().on_insert(on_alter).on_remove(on_alter);
    world.register_component_hooks::<Inertia>().on_insert(on_alter);
    world
        .register_component_hooks::<Orientation<V>>()
        .on_insert(|world, context| on_mirror_insert::<V, _>(world, context, ParticleStore::write_orientation));
    world.register_component_hooks::<Fixed>().on_insert(on_fix_or_free::<V>).on_remove(on_fix_or_free::<V>);
    world
        .register_component_hooks::<Position<V>>()
        .on_insert(|world, context| on_mirror_insert::<V, _>(world, context, ParticleStore::write_position));
    world
        .register_component_hooks::<Velocity<V>>()
        .on_insert(|world, context| on_mirror_insert::<V, _>(world, context, ParticleStore::write_velocity));
    world
        .register_component_hooks::<Force<V>>()
        .on_insert(|world, context| on_mirror_insert::<V, _>(world, context, ParticleStore::write_force));
    world
        .register_component_hooks::<Spin<V::Spin>>()
        .on_insert(|world, context| on_mirror_insert::<V, _>(world, context, ParticleStore::write_spin));
    world
        .register_component_hooks::<Torque<V::Spin>>()
        .on_insert(|world, context| on_mirror_insert::<V, _>(world, context, ParticleStore::write_torque));
}
