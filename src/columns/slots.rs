//! Slots: which entry of the columns belongs to whom, and when they are dealt out anew.

use bevy_app::App;
use bevy_ecs::lifecycle::HookContext;
use bevy_ecs::prelude::*;
use bevy_ecs::world::DeferredWorld;

use crate::columns::passes::with_changes;
use crate::columns::refill::EntityRow;
use crate::columns::{Columns, DENSE, Entering, Settled, Turnover};
use crate::particle::{Mass, Radius};
use crate::space::Space;
use crate::step::{Clock, Phase, Step};

/// Index of a particle in the [`Columns`].
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Slot(u32);

impl Default for Slot {
    /// No place yet.
    fn default() -> Self {
        Self(u32::MAX)
    }
}

impl Slot {
    pub(crate) fn new(index: u32) -> Self {
        Self(index)
    }

    /// That of entry `i`, of which there are fewer than 2^32.
    pub(super) fn of(i: usize) -> Self {
        u32::try_from(i).map_or_else(|_| Self::default(), Self)
    }

    /// The index, out of range as long as the particle has no place.
    #[must_use]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl<V: Space> Columns<V> {
    /// The slot that who has slot `i` had before, if it was what it is now.
    pub(crate) fn same_before(&self, i: usize) -> Slot {
        let is_altered = self.altered.binary_search(&Slot::of(i)).is_ok();
        if is_altered { Slot::default() } else { self.former[i] }
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

impl PopulationChanged {
    /// It has.
    pub(crate) fn note(&mut self) {
        self.0 = true;
    }
}

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
    tables.any(|rows| with_changes(rows).1)
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
    mut turnover: ResMut<Turnover<V>>,
    mut particles: Query<EntityRow<V>>,
) {
    columns.refill(&std::mem::take(&mut *turnover), &mut particles);
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
    app.insert_resource(PopulationChanged(true)).init_resource::<Renumberings>().init_resource::<Turnover<V>>();
    app.edit_schedule(Step, |schedule| {
        schedule.configure_sets(Entering.in_set(Phase::Spawn).before(Settled));
        let all = (Settled, BeforeRenumbering, Renumbering).chain().run_if(renumbering_due).in_set(Phase::Spawn);
        schedule.configure_sets(all);
    });
    app.add_systems(
        Step,
        (
            tidy_up::<V>.in_set(Phase::Spawn).before(Entering).before(Settled).run_if(is_time_to_tidy),
            renumber::<V>.in_set(Renumbering),
        ),
    );
}
