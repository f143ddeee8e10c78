//! Slots: which entry of the columns belongs to whom, and when they are dealt out anew.

use bevy_app::App;
use bevy_ecs::change_detection::ContiguousRef;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_ecs::world::DeferredWorld;

use crate::columns::order::Order;
use crate::columns::{Body, Columns, DENSE};
use crate::particle::{Fixed, Force, GrainId, Mass, Position, Radius, Species, Velocity};
use crate::space::Space;
use crate::step::{Clock, Phase, Step};

/// Index of a particle in the [`Columns`].
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot(u32);

impl Default for Slot {
    /// No place yet.
    fn default() -> Self {
        Self(u32::MAX)
    }
}

impl Slot {
    #[cfg(test)]
    pub(crate) fn at(index: u32) -> Self {
        Self(index)
    }

    /// The index, out of range as long as the particle has no place.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// What the columns hold of a particle, and its slot.
#[derive(QueryData)]
#[query_data(mutable)]
pub(crate) struct Particle<V: Space> {
    entity: Entity,
    id: &'static GrainId,
    position: &'static Position<V>,
    velocity: &'static Velocity<V>,
    force: &'static Force<V>,
    radius: &'static Radius,
    mass: Option<&'static Mass>,
    species: Option<&'static Species>,
    is_fixed: Has<Fixed>,
    slot: &'static mut Slot,
}

/// 1/m as contacts see it, 1/kg.
fn inverse_mass(mass: Option<&Mass>, is_fixed: bool) -> f64 {
    mass.map_or(0.0, |mass| if is_fixed { 0.0 } else { 1.0 / mass.0 })
}

impl<V: Space> Columns<V> {
    /// Deals out slots to all particles, and fills the columns.
    fn refill(&mut self, particles: &mut Query<Particle<V>>) {
        let grains = || particles.iter().filter(|row| !row.is_fixed);
        let largest = grains().map(|row| row.radius.0).fold(0.0, f64::max);
        self.order = Order::of(grains().map(|row| row.position.0), 2.0 * largest);
        let keys = (0u32..).zip(particles.iter()).map(|(row, particle)| {
            let is_fixed = inverse_mass(particle.mass, particle.is_fixed) == 0.0;
            let slot = *particle.slot;
            let is_known = self.is_still(slot.index(), particle.entity, particle.radius.0, is_fixed);
            let former = if is_known { slot } else { Slot::default() };
            ((is_fixed, self.order.place(particle.position.0), *particle.id), row, former)
        });
        // Tables are walked twice: that takes less room than to keep who was met.
        let mut keys: Vec<_> = keys.collect();
        keys.sort_unstable_by_key(|&(key, ..)| key);
        self.movable_end = keys.partition_point(|&((is_fixed, ..), ..)| !is_fixed);
        self.id.clear();
        self.id.extend(keys.iter().map(|&((.., id), ..)| id));
        self.former.clear();
        self.former.extend(keys.iter().map(|&(.., former)| former));
        let mut slots = vec![0; keys.len()];
        for (slot, (_, row, _)) in (0u32..).zip(keys) {
            slots[row as usize] = slot;
        }
        self.fill(particles, &slots);
        self.generation += 1;
    }

    /// Whether entry `i` is of this entity, with this radius (m), and fixed or not.
    fn is_still(&self, i: usize, entity: Entity, radius: f64, is_fixed: bool) -> bool {
        self.entity.get(i) == Some(&entity)
            && self.body[i].radius.total_cmp(&radius).is_eq()
            && self.is_fixed(i) == is_fixed
    }

    /// Fills the columns but the names with particles as they come, who have these slots.
    fn fill(&mut self, particles: &mut Query<Particle<V>>, slots: &[u32]) {
        let size = slots.len();
        let contacts = std::mem::take(&mut self.loads.contacts);
        if !contacts.is_empty() {
            self.loads.contacts.resize(size, MANY);
        }
        self.entity.resize(size, Entity::PLACEHOLDER);
        self.body.resize(size, Body { position: V::ZERO, velocity: V::ZERO, radius: 0.0, inverse_mass: 0.0 });
        self.mass.resize(size, 0.0);
        self.species.resize(size, Species::default());
        self.loads.force.reset(size, self.has_books);
        for (mut particle, &slot) in particles.iter_mut().zip(slots) {
            let i = slot as usize;
            if let (Some(entry), Some(&count)) = (self.loads.contacts.get_mut(i), contacts.get(particle.slot.index())) {
                *entry = count;
            }
            self.entity[i] = particle.entity;
            self.body[i] = Body {
                position: particle.position.0,
                velocity: particle.velocity.0,
                radius: particle.radius.0,
                inverse_mass: inverse_mass(particle.mass, particle.is_fixed),
            };
            self.loads.force.set(i, particle.force.0);
            self.mass[i] = particle.mass.map_or(0.0, |mass| mass.0);
            self.species[i] = particle.species.copied().unwrap_or_default();
            particle.slot.0 = slot;
        }
        let radii = || self.body.iter().map(|body| body.radius);
        let (smallest, largest) = (radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max));
        self.smallest_share = smallest / (smallest + largest);
    }

    /// Whether more than a tenth of the grains come after one whose place is later.
    fn is_untidy(&self) -> bool {
        let places = self.body[..self.movable_end].iter().map(|body| self.order.place(body.position));
        10 * places.clone().zip(places.skip(1)).filter(|(one, next)| next < one).count() > self.movable_end
    }
}

/// Whether particles were added, removed, fixed or freed since slots were dealt out.
#[derive(Resource, Default)]
pub struct PopulationChanged(bool);

/// Component hook: the population changed.
pub(crate) fn population_changed(mut world: DeferredWorld, _: HookContext) {
    if let Some(mut changed) = world.get_resource_mut::<PopulationChanged>() {
        changed.0 = true;
    }
}

/// Run condition: slots will be dealt out anew in this step.
#[must_use]
pub fn renumbering_due(
    changed: Res<PopulationChanged>,
    (radii, changed_radii): (Query<Ref<Radius>>, Query<(), Changed<Radius>>),
    (masses, changed_masses): (Query<Ref<Mass>>, Query<(), Changed<Mass>>),
) -> bool {
    // A table's summary is looked at first, for it is one for all rows; it also counts rows that have only moved.
    changed.0
        || (is_any_touched(&radii) && !changed_radii.is_empty())
        || (is_any_touched(&masses) && !changed_masses.is_empty())
}

/// Whether the summary of any table says that its column has changed.
fn is_any_touched<T: Component>(column: &Query<Ref<T>>) -> bool {
    let mut tables = column.contiguous_iter().expect(DENSE);
    tables.any(|rows| ContiguousRef::split(rows).1.summary_tick_is_changed() != Some(false))
}

/// How often the order of slots is looked over, in steps.
pub const TIDY_EVERY: u64 = 1000;

/// What stands for the number of contacts where it is not known: a grain that has just entered counts as touched by many.
pub(crate) const MANY: u32 = 2;

fn tidy_up<V: Space>(columns: Res<Columns<V>>, mut changed: ResMut<PopulationChanged>) {
    changed.0 |= columns.is_untidy();
}

/// Run condition: slots have been dealt out in this step.
pub(crate) fn has_renumbered(count: Res<Renumberings>, mut known: Local<u64>) -> bool {
    std::mem::replace(&mut *known, count.0) != count.0
}

/// How often slots have been dealt out.
#[derive(Resource, Default)]
pub(crate) struct Renumberings(u64);

/// Run condition: every [`TIDY_EVERY`] steps.
pub(crate) fn is_time_to_tidy(clock: Res<Clock>) -> bool {
    clock.steps.is_multiple_of(TIDY_EVERY) && !clock.is_step_zero()
}

pub(crate) fn renumber<V: Space>(
    mut columns: ResMut<Columns<V>>,
    (mut changed, mut count): (ResMut<PopulationChanged>, ResMut<Renumberings>),
    mut particles: Query<Particle<V>>,
) {
    columns.refill(&mut particles);
    changed.0 = false;
    count.0 += 1;
}

/// What has to be booked before slots are dealt out anew (the columns still hold the old state) belongs here.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct BeforeRenumbering;

/// The system that deals out slots; spawners run before it.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Renumbering;

/// Deals out slots where they are due.
pub(super) fn add<V: Space>(app: &mut App) {
    app.insert_resource(PopulationChanged(true)).init_resource::<Renumberings>();
    app.edit_schedule(Step, |schedule| {
        schedule.configure_sets((BeforeRenumbering, Renumbering).chain().run_if(renumbering_due).in_set(Phase::Spawn));
    });
    app.add_systems(
        Step,
        (
            tidy_up::<V>.in_set(Phase::Spawn).before(BeforeRenumbering).run_if(is_time_to_tidy),
            renumber::<V>.in_set(Renumbering),
        ),
    );
}
