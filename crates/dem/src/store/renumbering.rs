//! Renumbering: decides when slots are assigned anew, and orders the systems that depend on it.

use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::ScheduleLabel;
use serde::{Deserialize, Serialize};

use crate::gravity::Gravity;
use crate::particle::Slot;
use crate::persist::PersistApp as _;
use crate::space::Space;
use crate::step::{Clock, Part, Phase, Step, serial};
use crate::store::ParticleStore;
use crate::store::population::Population;
use crate::store::reorder::EntityRow;
use crate::store::sets::KicksApplied;

impl<V: Space> ParticleStore<V> {
    /// The previous slot of the particle in row `i`; the default slot if the particle had none or was altered.
    pub(crate) fn same_before(&self, i: usize) -> Slot {
        let is_altered = self.altered.binary_search(&Slot::of(i)).is_ok();
        if is_altered { Slot::default() } else { self.former[i] }
    }

    /// Whether more than a tenth of the grains come directly after a grain with a later place in the spatial order.
    fn is_unsorted(&self) -> bool {
        let places = self.body[self.free_rows()].iter().map(|body| self.order.place(body.position));
        10 * places.clone().zip(places.skip(1)).filter(|(one, next)| next < one).count() > self.free_end
    }
}

/// Interval between checks of the spatial order of slots, in steps.
pub const SORT_CHECK_INTERVAL: u64 = 1000;

fn sort_if_needed<V: Space>(store: Res<ParticleStore<V>>, mut population: ResMut<Population>) {
    if store.is_unsorted() {
        population.renumber();
    }
}

/// Run condition: a renumbering has happened since the last evaluation.
pub(crate) fn has_renumbered(count: Res<Renumberings>, mut last_seen: Local<u64>) -> bool {
    std::mem::replace(&mut *last_seen, count.0) != count.0
}

/// Number of renumberings.
#[derive(Resource, Default, Deserialize, Serialize)]
pub(crate) struct Renumberings(u64);

/// Run condition: true every [`SORT_CHECK_INTERVAL`] steps.
pub(crate) fn sort_check_is_due(clock: Res<Clock>) -> bool {
    clock.steps.is_multiple_of(SORT_CHECK_INTERVAL) && !clock.is_step_zero()
}

/// Assigns slots anew.
pub(super) fn renumber<V: Space>(
    mut store: ResMut<ParticleStore<V>>,
    mut population: ResMut<Population>,
    mut count: ResMut<Renumberings>,
    particles: Query<EntityRow<V>>,
    mut slots: Query<&mut Slot>,
    gravity: Option<Res<Gravity<V>>>,
) {
    let gravity = gravity.map_or(V::ZERO, |gravity| gravity.0);
    store.reorder(population.take(), &particles, &mut slots, gravity);
    count.0 += 1;
}

/// The schedule that assigns slots: first systems that need the old slots ([`BeforeRenumbering`]), then
/// the renumbering, then systems that update data by slot ([`AfterRenumbering`]).
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Renumber;

/// Systems of [`Renumber`] that need the store before slots are assigned anew.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct BeforeRenumbering;

/// Systems of [`Renumber`] that update data by slot, after slots were assigned anew.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct AfterRenumbering;

/// Runs a renumbering if the population has changed.
fn renumber_if_due(world: &mut World) {
    if world.resource::<Population>().is_due() {
        world.run_schedule(Renumber);
    }
}

/// Runs a renumbering for particles that entered or were altered between two steps, before systems of [`Phase::Spawn`]
/// read the store.
fn renumber_first(world: &mut World) {
    if world.resource::<Population>().has_touched() {
        world.run_schedule(Renumber);
    }
}

/// The set of [`Phase::Spawn`] after which particles that entered between two steps have slots.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct FirstRenumbering;

/// Adds the renumbering to the step.
pub(super) fn add<V: Space>(app: &mut App) {
    app.init_resource::<Renumberings>().persist_sound::<Renumberings>().add_schedule(serial(Renumber));
    app.edit_schedule(Renumber, |schedule| {
        schedule.configure_sets((KicksApplied, BeforeRenumbering, AfterRenumbering).chain());
    });
    app.add_systems(Renumber, renumber::<V>.after(BeforeRenumbering).before(AfterRenumbering));
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
