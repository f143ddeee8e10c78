//! Slots: which entry of the columns belongs to whom, and when they are dealt out anew.

use bevy_app::App;
use bevy_ecs::change_detection::ContiguousRef;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_ecs::world::DeferredWorld;

use crate::columns::order::Order;
use crate::columns::{Body, Columns, DENSE, Load};
use crate::particle::{Fixed, GrainId, Mass, Position, Radius, Species, Velocity};
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
    pub(super) fn at(index: u32) -> Self {
        Self(index)
    }

    /// The index, out of range as long as the particle has no place.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// What the columns hold of a particle.
#[derive(QueryData)]
pub(crate) struct Particle<V: Space> {
    entity: Entity,
    id: &'static GrainId,
    position: &'static Position<V>,
    velocity: &'static Velocity<V>,
    radius: &'static Radius,
    mass: Option<&'static Mass>,
    species: Option<&'static Species>,
    is_fixed: Has<Fixed>,
    slot: &'static Slot,
}

impl<V: Space> ParticleItem<'_, '_, V> {
    /// As contacts see it, 1/kg.
    fn inverse_mass(&self) -> f64 {
        self.mass.map_or(0.0, |mass| if self.is_fixed { 0.0 } else { 1.0 / mass.0 })
    }
}

impl<V: Space> Columns<V> {
    fn refill<'w, 's>(&mut self, particles: impl Iterator<Item = ParticleItem<'w, 's, V>>) {
        let mut rows: Vec<_> = particles.collect();
        let movable = || rows.iter().filter(|row| !row.is_fixed);
        let largest = movable().map(|row| row.radius.0).fold(0.0, f64::max);
        self.order = Order::of(movable().map(|row| row.position.0), 2.0 * largest);
        rows.sort_by_cached_key(|row| (row.inverse_mass() == 0.0, self.order.place(row.position.0), *row.id));
        if !self.contacts.is_empty() {
            let contacts = |row: &ParticleItem<V>| self.contacts.get(row.slot.index()).copied().unwrap_or(MANY);
            self.contacts = rows.iter().map(contacts).collect();
        }
        self.id = rows.iter().map(|row| *row.id).collect();
        self.entity = rows.iter().map(|row| row.entity).collect();
        let body = |row: &ParticleItem<V>| Body {
            position: row.position.0,
            velocity: row.velocity.0,
            radius: row.radius.0,
            inverse_mass: row.inverse_mass(),
        };
        self.body = rows.iter().map(body).collect();
        self.mass = rows.iter().map(|row| row.mass.map_or(0.0, |mass| mass.0)).collect();
        self.species = rows.iter().map(|row| row.species.copied().unwrap_or_default()).collect();
        self.load = vec![Load::default(); rows.len()];
        self.movable_end = self.body.partition_point(|body| body.inverse_mass != 0.0);
        self.generation += 1;
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
    mut particles: ParamSet<(Query<Particle<V>>, Query<&mut Slot>)>,
) {
    columns.refill(particles.p0().iter());
    let mut slots = particles.p1();
    for (slot, &entity) in (0..).zip(&columns.entity) {
        if let Ok(mut place) = slots.get_mut(entity) {
            place.0 = slot;
        }
    }
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
