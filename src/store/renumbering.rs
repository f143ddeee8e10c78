//! When slots are dealt out anew, and what goes with it.

use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::ScheduleLabel;

use crate::particle::Slot;
use crate::space::Space;
use crate::step::{Clock, Part, Phase, Step, serial};
use crate::store::ParticleStore;
use crate::store::population::Population;
use crate::store::reorder::EntityRow;

impl<V: Space> ParticleStore<V> {
    /// The slot that the particle of row `i` had before, if it was what it is now.
    pub(crate) fn same_before(&self, i: usize) -> Slot {
        let is_altered = self.altered.binary_search(&Slot::of(i)).is_ok();
        if is_altered { Slot::default() } else { self.former[i] }
    }

    /// Whether more than a tenth of the grains come after one whose place is later.
    fn is_unsorted(&self) -> bool {
        let places = self.body[..self.movable_end].iter().map(|body| self.order.place(body.position));
        10 * places.clone().zip(places.skip(1)).filter(|(one, next)| next < one).count() > self.movable_end
    }
}

/// How often the order of slots is looked over, in steps.
pub const SORT_CHECK_INTERVAL: u64 = 1000;

/// The number of contacts of a grain of which it is not known: a grain that has just entered counts as touched by many.
pub(crate) const UNKNOWN_CONTACTS: u32 = 2;

fn sort_if_needed<V: Space>(store: Res<ParticleStore<V>>, mut population: ResMut<Population>) {
    if store.is_unsorted() {
        population.renumber();
    }
}

/// Run condition: slots have been dealt out in this step.
pub(crate) fn has_renumbered(count: Res<Renumberings>, mut known: Local<u64>) -> bool {
    std::mem::replace(&mut *known, count.0) != count.0
}

/// How often slots have been dealt out.
#[derive(Resource, Default)]
pub(crate) struct Renumberings(u64);

/// Run condition: every [`SORT_CHECK_INTERVAL`] steps.
pub(crate) fn sort_check_is_due(clock: Res<Clock>) -> bool {
    clock.steps.is_multiple_of(SORT_CHECK_INTERVAL) && !clock.is_step_zero()
}

/// Deals out slots.
pub(crate) fn renumber<V: Space>(
    mut store: ResMut<ParticleStore<V>>,
    (mut population, mut count): (ResMut<Population>, ResMut<Renumberings>),
    (particles, mut slots): (Query<EntityRow<V>>, Query<&mut Slot>),
) {
    store.reorder(population.take(), &particles, &mut slots);
    count.0 += 1;
}

/// The schedule that deals out slots: systems that need the old state, in [`BeforeRenumbering`]; then [`Renumbering`].
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Renumber;

/// Before slots are dealt out anew, velocities are those of the step's end after this set.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct KicksApplied;

/// Systems of [`Renumber`] that need the store as it was.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct BeforeRenumbering;

/// Slots are dealt out, and what goes by slots follows.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Renumbering;

/// Deals out slots if the population has changed.
fn renumber_if_due(world: &mut World) {
    if world.resource::<Population>().is_due() {
        world.run_schedule(Renumber);
    }
}

/// The same for particles that entered or were altered between two steps, before systems of [`Phase::Spawn`] look at the store.
fn renumber_first(world: &mut World) {
    if world.resource::<Population>().has_touched() {
        world.run_schedule(Renumber);
    }
}

/// Particles that entered between two steps have slots after this set of [`Phase::Spawn`].
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct FirstRenumbering;

/// Deals out slots where they are due.
pub(super) fn add<V: Space>(app: &mut App) {
    app.init_resource::<Renumberings>().add_schedule(serial(Renumber));
    app.edit_schedule(Renumber, |schedule| {
        schedule.configure_sets((KicksApplied, BeforeRenumbering, Renumbering).chain());
    });
    app.add_systems(Renumber, renumber::<V>.in_set(Renumbering));
    app.add_systems(
        Step,
        (
            (sort_if_needed::<V>.run_if(sort_check_is_due), renumber_first.in_set(FirstRenumbering))
                .chain()
                .in_set(Part::Engine(Phase::Spawn)),
            renumber_if_due.in_set(Part::Renumber),
        ),
    );
}
