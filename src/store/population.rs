//! The population: which entities entered, left, or changed what the store keeps of them for good, since slots were dealt out.
//!
//! Component hooks note it at once, whoever acts: commands, systems with the world, observers. `GrainId` marks a particle;
//! `Radius`, `Mass`, `Species`, `Inertia` and `Fixed` change by insertion only. Their hooks ask for a renumbering, which reads
//! the entities noted here and no others. A particle that leaves is struck out of the store at once: its row stays, without
//! an entity, until the renumbering ([`ParticleStore::is_present`]). A mirrored component that is inserted on a particle of the store
//! is written through.

use bevy_ecs::component::Mutable;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;

use crate::particle::{Fixed, Force, GrainId, Mass, Position, Radius, Slot, Species, Velocity};
use crate::space::Space;
use crate::spin::{Inertia, Spin, Torque};
use crate::store::deferred_kick::PendingKick;
use crate::store::mirror::MirrorSet;
use crate::store::{LongestMove, ParticleStore};

/// What has changed since slots were dealt out.
#[derive(Resource, Default)]
pub(crate) struct Population {
    /// Entities that entered, or have another radius, mass, species or moment of inertia, or were fixed or freed.
    touched: Vec<Entity>,
    /// Whether the order of slots is out of date, or a particle has left.
    is_out_of_date: bool,
}

impl Population {
    /// Asks for a renumbering.
    pub(crate) fn renumber(&mut self) {
        self.is_out_of_date = true;
    }

    /// Whether slots have to be dealt out anew.
    pub(crate) fn is_due(&self) -> bool {
        self.is_out_of_date || !self.touched.is_empty()
    }

    /// Whether particles entered or were altered.
    pub(super) fn has_touched(&self) -> bool {
        !self.touched.is_empty()
    }

    /// The entities to be read anew, each once; and a new start.
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

/// The row of an entity, if the store has one.
fn row_of<V: Space>(world: &DeferredWorld, entity: Entity) -> Option<usize> {
    world.get_resource::<ParticleStore<V>>()?.row_of(entity, *world.get::<Slot>(entity)?)
}

fn entered(mut world: DeferredWorld, context: HookContext) {
    Population::touch(&mut world, context.entity);
}

/// A particle leaves: its row belongs to no entity any more.
fn left<V: Space>(mut world: DeferredWorld, context: HookContext) {
    if let Some(row) = row_of::<V>(&world, context.entity) {
        world.resource_mut::<ParticleStore<V>>().vacate(row);
        if let Some(mut population) = world.get_resource_mut::<Population>() {
            population.renumber();
        }
    }
}

/// What the store keeps for good of a particle was inserted or removed. Of one that enters all is read anyway.
fn altered(mut world: DeferredWorld, context: HookContext) {
    if world.get::<Slot>(context.entity).is_some_and(|slot| *slot != Slot::default()) {
        Population::touch(&mut world, context.entity);
    }
}

/// A particle was fixed or freed: what is stale is counted apart for both.
fn fixed_or_freed<V: Space>(mut world: DeferredWorld, context: HookContext) {
    if let Some(mut store) = world.get_resource_mut::<ParticleStore<V>>() {
        store.stale = MirrorSet::ALL;
    }
    altered(world, context);
}

/// Writes an inserted component through to the store, if the particle is there.
fn inserted<V: Space, T: Component<Mutability = Mutable> + Copy>(
    mut world: DeferredWorld,
    context: HookContext,
    write: fn(&mut ParticleStore<V>, usize, T, Owed),
) {
    if let Some(row) = row_of::<V>(&world, context.entity)
        && let Some(value) = world.get::<T>(context.entity).copied()
    {
        let is_pending = world.get_resource::<PendingKick>().is_some_and(|kick| kick.is_pending);
        write(&mut world.resource_mut::<ParticleStore<V>>(), row, value, Owed(is_pending));
    }
}

/// Whether a second kick is owed: then the store holds velocities and spins from before it.
#[derive(Clone, Copy)]
struct Owed(bool);

impl<V: Space> ParticleStore<V> {
    /// The row of `entity`, which has this slot, if it has a row.
    #[inline]
    pub(super) fn row_of(&self, entity: Entity, slot: Slot) -> Option<usize> {
        (self.entity.get(slot.index()) == Some(&entity)).then_some(slot.index())
    }

    /// Strikes out the particle of a row.
    fn vacate(&mut self, row: usize) {
        self.entity[row] = Entity::PLACEHOLDER;
        self.vacated.push(row);
    }

    /// Whether the particle of row `i` is still there: one that left keeps its row until slots are dealt out anew.
    #[must_use]
    #[inline]
    pub fn is_present(&self, i: usize) -> bool {
        self.vacated.is_empty() || self.entity[i] != Entity::PLACEHOLDER
    }

    /// The rows of particles that left since slots were dealt out, in the order of their leaving.
    #[must_use]
    pub fn vacated(&self) -> &[usize] {
        &self.vacated
    }

    fn write_position(&mut self, row: usize, Position(x): Position<V>, _: Owed) {
        let mut longest = LongestMove::default();
        self.put(row, x, &mut longest);
        self.travel += longest.length();
    }

    /// What the owed kick will add to the velocity of a row, m/s.
    fn owed_kick(&self, row: usize, force: V, Owed(is_pending): Owed) -> V {
        let time = if is_pending { self.half_step } else { 0.0 };
        force * (time * self.body[row].inverse_mass)
    }

    /// What it will add to the spin, rad/s.
    fn owed_spin(&self, row: usize, torque: V::Spin, Owed(is_pending): Owed) -> V::Spin {
        let time = if is_pending { self.half_step } else { 0.0 };
        torque * (time * self.rotation[row].inverse_inertia)
    }

    fn write_velocity(&mut self, row: usize, Velocity(v): Velocity<V>, owed: Owed) {
        self.body[row].velocity = v - self.owed_kick(row, self.loads.force.of(row), owed);
        self.is_suspect |= !v.is_finite();
    }

    fn write_force(&mut self, row: usize, Force(force): Force<V>, owed: Owed) {
        let change = self.loads.force.of(row) - force;
        let kept = self.owed_kick(row, change, owed);
        self.body[row].velocity += kept;
        self.loads.force.set(row, force);
        self.is_suspect |= !force.is_finite();
    }

    fn write_spin(&mut self, row: usize, Spin(spin): Spin<V::Spin>, owed: Owed) {
        if row < self.rotation.len() {
            self.rotation[row].spin = spin - self.owed_spin(row, self.loads.torque.of(row), owed);
        }
    }

    fn write_torque(&mut self, row: usize, Torque(torque): Torque<V::Spin>, owed: Owed) {
        if row < self.rotation.len() {
            let kept = self.owed_spin(row, self.loads.torque.of(row) - torque, owed);
            self.rotation[row].spin += kept;
            self.loads.torque.set(row, torque);
        }
    }
}

/// Registers the hooks, before the first particle is spawned.
pub(super) fn add<V: Space>(world: &mut World) {
    world.init_resource::<Population>();
    world.register_component_hooks::<GrainId>().on_insert(entered).on_remove(left::<V>);
    world.register_component_hooks::<Radius>().on_insert(altered);
    world.register_component_hooks::<Mass>().on_insert(altered).on_remove(altered);
    world.register_component_hooks::<Species>().on_insert(altered).on_remove(altered);
    world.register_component_hooks::<Inertia>().on_insert(altered);
    world.register_component_hooks::<Fixed>().on_insert(fixed_or_freed::<V>).on_remove(fixed_or_freed::<V>);
    world
        .register_component_hooks::<Position<V>>()
        .on_insert(|world, context| inserted::<V, _>(world, context, ParticleStore::write_position));
    world
        .register_component_hooks::<Velocity<V>>()
        .on_insert(|world, context| inserted::<V, _>(world, context, ParticleStore::write_velocity));
    world
        .register_component_hooks::<Force<V>>()
        .on_insert(|world, context| inserted::<V, _>(world, context, ParticleStore::write_force));
    world
        .register_component_hooks::<Spin<V::Spin>>()
        .on_insert(|world, context| inserted::<V, _>(world, context, ParticleStore::write_spin));
    world
        .register_component_hooks::<Torque<V::Spin>>()
        .on_insert(|world, context| inserted::<V, _>(world, context, ParticleStore::write_torque));
}
