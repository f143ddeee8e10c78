//! The plugin of contacts: the system that runs the force pass with the scene's law, neighbour search and threads.

use std::marker::PhantomData;
use std::sync::Arc;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::contact::batch_law::AnyLaw;
use crate::contact::force_pass::{ForcePass, ScratchPerThread};
use crate::contact::history::History;
use crate::contact::history::remembered::RememberedContacts;
use crate::contact::law::{LawRequirements, PairLaw};
use crate::contact::needs::{Needs, TorqueClass};
use crate::gravity::Gravity;
use crate::instruction_set::InstructionSet;
use crate::integrate::rotation::SpinPlugin;
use crate::neighbours::Search;
use crate::persist::{PersistApp as _, Problem};
use crate::space::{Plane, Space};
use crate::spin::InertiaLaw;
use crate::step::{Clock, ForceStage, Part, Phase, Step, is_step_zero};
use crate::store::{AfterRenumbering, MirrorSet, ParticleStore, Renumber, VelocitiesPredicted};
use crate::threads::Threads;
use crate::walls::near::NearWalls;
use crate::walls::surfaces::Surfaces;

/// The largest overlap of the run so far divided by the smaller radius of its pair, over grains and walls.
#[derive(Resource, Default, Deserialize, Serialize)]
pub struct LargestOverlap(pub f64);

/// System set of the contact pass.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct ContactForces;

/// Interval between counts of contacts, in steps. Counts only select the contacts whose prediction is refined.
const COUNT_INTERVAL: u64 = 8;

/// Returns the time by which memories advance in this run of the schedule, s. In step zero it is the time by which they are
/// ahead.
fn memory_step(clock: &Clock, springs_ahead: f64) -> f64 {
    if clock.is_step_zero() { springs_ahead } else { clock.dt }
}

fn contact_forces<V: Space>(
    law: Res<AnyLaw<V>>,
    (clock, gravity, mut search): (Res<Clock>, Res<Gravity<V>>, ResMut<Search<V>>),
    (threads, instructions, mut scratches): (Res<Threads>, Res<InstructionSet>, ResMut<ScratchPerThread<V>>),
    (mut walls, mut near): (ResMut<Surfaces<V>>, ResMut<NearWalls>),
    mut store: ResMut<ParticleStore<V>>,
    mut history: ResMut<History>,
    mut largest: ResMut<LargestOverlap>,
) {
    // Change detection does not report this system's own writes, here the wall loads, as changes.
    let have_changed = walls.is_changed();
    if store.predicts() {
        search.list.mark_lone(&store.prediction);
    }
    let needs = law.0.needs();
    let pass = ForcePass {
        law: &*law.0,
        needs,
        list: &search.list,
        walls: &walls.all,
        twins: walls.twins(),
        near: near.of(&store, &walls, &threads, have_changed),
        dt: memory_step(&clock, store.springs_ahead()),
        starts: clock.is_step_zero(),
        counts: store.predicts() && clock.steps.is_multiple_of(COUNT_INTERVAL),
        gravity: gravity.0,
        instructions: *instructions,
    };
    let has_torques = needs.torques != TorqueClass::None || !store.bodies.is_empty();
    store.stale.add(if has_torques { MirrorSet::FORCE.or(MirrorSet::TORQUE) } else { MirrorSet::FORCE });
    largest.0 = pass.sum(&mut store, &mut history, &threads, &mut scratches.0, largest.0);
    if !walls.all.is_empty() {
        walls.set_loads(scratches.0.iter().flat_map(|scratch| &scratch.on_walls));
        near.note(walls.last_changed());
    }
}

/// Moves memories to the new slots of their particles after a renumbering.
fn move_memories<V: Space>(
    law: Res<AnyLaw<V>>,
    store: Res<ParticleStore<V>>,
    threads: Res<Threads>,
    mut history: ResMut<History>,
) {
    history.move_to_new_slots(&store, &law.0.needs().memory.unwrap_or_default(), &threads);
}

/// Memories of contacts that exist at the start of a run.
#[derive(Resource, Default)]
pub struct ContactsAtStart(pub RememberedContacts);

/// Takes over the memories of contacts that exist at the start.
fn recall_from_start<V: Space>(
    law: Res<AnyLaw<V>>,
    (store, walls): (Res<ParticleStore<V>>, Res<Surfaces<V>>),
    start: Option<ResMut<ContactsAtStart>>,
    mut history: ResMut<History>,
) {
    if let Some(mut start) = start {
        history.replace(
            &store,
            walls.all.len(),
            &std::mem::take(&mut start.0),
            &law.0.needs().memory.unwrap_or_default(),
        );
    }
}

/// Adds contacts with the law `law`, between particles and with wall surfaces. Laws from other crates are added here:
/// `app.add_plugins(ContactPlugin::plane(Arc::new(MyLaw)))`.
pub struct ContactPlugin<V: Space, L: PairLaw<V>> {
    law: Arc<L>,
    /// How far contacts reach beyond touch, m, as far as the app does not know it yet.
    range: f64,
    space: PhantomData<V>,
}

impl<V: Space, L: PairLaw<V>> ContactPlugin<V, L> {
    /// Uses the law in the space `V`.
    #[must_use]
    pub fn new(law: Arc<L>) -> Self {
        Self { law, range: 0.0, space: PhantomData }
    }

    /// Returns the plugin with a law whose contacts reach up to `range` (m) beyond touch. The neighbour search then finds particles and
    /// walls that are so far apart.
    #[must_use]
    pub fn reaching(self, range: f64) -> Self {
        Self { range, ..self }
    }
}

impl<L: PairLaw<Plane>> ContactPlugin<Plane, L> {
    /// Uses the law in the plane.
    #[must_use]
    pub fn plane(law: Arc<L>) -> Self {
        Self::new(law)
    }
}

impl<V: Space, L: PairLaw<V> + LawRequirements> Plugin for ContactPlugin<V, L> {
    fn build(&self, app: &mut App) {
        let prediction = &mut app.world_mut().resource_mut::<ParticleStore<V>>().into_inner().prediction;
        prediction.range = prediction.range.max(self.range);
        AnyLaw::<V>(self.law.clone()).add_to(app);
    }
}

/// Refuses restored memories that do not fit the restored particles, the walls or the law.
fn check_history<V: Space>(world: &mut World) -> Result<(), Problem> {
    let (Some(history), Some(store)) = (world.get_resource::<History>(), world.get_resource::<ParticleStore<V>>())
    else {
        return Ok(());
    };
    let walls = world.get_resource::<Surfaces<V>>().map_or(0, |walls| walls.all.len());
    let layout = world.get_resource::<AnyLaw<V>>().and_then(|law| law.0.needs().memory);
    history.check(store.len(), walls, layout.as_ref())
}

impl<V: Space> AnyLaw<V> {
    /// Adds the law and the systems of contacts.
    fn add_to(self, app: &mut App) {
        let Needs { torques, memory, .. } = self.0.needs();
        // The law of a behaviour may need spins in a scene that has none.
        if torques != TorqueClass::None && !app.is_plugin_added::<SpinPlugin<V>>() {
            app.add_plugins(SpinPlugin::<V> { inertia: InertiaLaw::usual(V::DIMENSION), space: PhantomData });
        }
        app.world_mut().resource_mut::<ParticleStore<V>>().prediction.sweeps |= memory.is_some();
        app.insert_resource(self)
            .init_resource::<History>()
            .init_resource::<ScratchPerThread<V>>()
            .init_resource::<LargestOverlap>()
            .init_resource::<NearWalls>()
            .init_resource::<InstructionSet>()
            .persist_sound::<History>()
            .persist_sound::<LargestOverlap>()
            .check_restored(check_history::<V>)
            .derived::<ScratchPerThread<V>>()
            .derived::<NearWalls>()
            .add_systems(Step, contact_forces::<V>.in_set(ForceStage::Contacts).in_set(ContactForces));
        if memory.is_some() {
            app.derived::<ContactsAtStart>().add_systems(
                Step,
                recall_from_start::<V>
                    .in_set(Part::Engine(Phase::Neighbours))
                    .after(VelocitiesPredicted)
                    .run_if(is_step_zero),
            );
            app.add_systems(Renumber, move_memories::<V>.in_set(AfterRenumbering));
        }
    }
}
