//! Component sync: copies mirrored components from and to the store, around the phases in which systems use them and
//! between steps.
//!
//! Before the systems of a phase run, the stale components that they use are refreshed, and forces and torques are added to particles
//! that lack these components (`store/load_components.rs`). After them, values that they wrote are written back to the store. A
//! phase whose systems use no mirrored component has neither copy. Change ticks show which rows a system wrote. A write that bypasses
//! change detection (`bypass_change_detection`) declares that it does not count, and it is lost.
//!
//! Between steps the caller owns the world ([`publish_to_world`]): all components are up to date. Values that the
//! caller writes count from the next step on ([`collect_from_world`]).

use bevy_app::App;
use bevy_ecs::change_detection::Tick;
use bevy_ecs::prelude::*;
use bevy_ecs::system::{SystemId, SystemState};

use crate::persist::PersistApp as _;
use crate::space::Space;
use crate::step::{Part, Phase, Step};
use crate::store::ParticleStore;
use crate::store::access_markers::{AddsLoads, ReadsMotion, ReadsPlaces};
use crate::store::deferred_kick::apply_pending_kick;
use crate::store::foreign_code::ForeignObservers;
use crate::store::load_components::{AddLoads, add_loads};
use crate::store::mirror::{Refresh, WriteBack};
use crate::store::mirror_set::MirrorSet;
use crate::store::predictable_conditions::PredictableConditions;
use crate::store::sync_plan::Plan;
use siloflow_text::fault::Fault;

/// Mirrored components that the systems of a phase use in a step.
struct Use {
    /// The components that the systems read.
    reads: MirrorSet,
    /// The components that the systems may write.
    writes: MirrorSet,
}

/// Returns the use of mirrored components by the systems of phase number `phase` in this step.
fn used_components(world: &mut World, phase: usize, observers: &mut ForeignObservers) -> Use {
    let plan = &mut world.resource_mut::<Plan>().phases[phase];
    let needs = std::mem::take(&mut plan.needs);
    let has_commands = plan.has_commands;
    let mut uses = Use { reads: MirrorSet::NONE, writes: MirrorSet::NONE };
    for need in &needs {
        if PredictableConditions::are_open(world, &need.gates) {
            uses.reads.add(need.reads);
            uses.writes.add(need.writes);
        }
    }
    world.resource_mut::<Plan>().phases[phase].needs = needs;
    if has_commands && Plan::foreign_code_may_run(world, observers) {
        uses = Use { reads: MirrorSet::ALL, writes: MirrorSet::ALL };
    }
    uses
}

fn refresh<V: Space, const PHASE: usize>(
    world: &mut World,
    state: &mut SystemState<Refresh<V>>,
    loads: &mut SystemState<AddLoads<V>>,
    observers: &mut ForeignObservers,
) {
    let Use { reads, writes } = used_components(world, PHASE, observers);
    if !reads.is_none() {
        add_loads(world, loads, reads);
        state.get_mut(world).expect("the store plugin inserts the store").refresh(reads);
    }
    let since = world.increment_change_tick();
    let mut plan = world.resource_mut::<Plan>();
    plan.writes = writes;
    plan.since = since;
}

fn write_back<V: Space, const PHASE: usize>(world: &mut World, state: &mut SystemState<WriteBack<V>>) {
    let &Plan { writes, since, .. } = world.resource();
    if PHASE == FORCES {
        world.resource_mut::<ParticleStore<V>>().begin_added(writes.meets(MirrorSet::FORCE));
    }
    if !writes.is_none() {
        state.get_mut(world).expect("the store plugin inserts the store").write_back(writes, since);
    }
    if PHASE == FORCES {
        world.resource_mut::<ParticleStore<V>>().end_added();
    }
}

const FORCES: usize = 3;

impl<V: Space> ParticleStore<V> {
    /// Clears the forces that systems have added in this step. Allocates them if the phase may write `Force`.
    fn begin_added(&mut self, may_write_force: bool) {
        self.added.clear();
        if may_write_force {
            self.added.resize(self.len(), V::ZERO);
        }
    }

    /// Evaluates the power of the added forces, W, with the velocities of the step's end (after the second kick).
    fn end_added(&mut self) {
        let rows = self.added.iter().zip(&self.body).enumerate().take(self.integrated_rows().end);
        let power = rows.map(|(i, (added, body))| {
            added.dot(self.middle_velocity(i) + self.loads.force.of(i) * (self.half_step * body.inverse_mass))
        });
        self.added_power = (!self.added.is_empty()).then(|| power.fold(0.0, |sum, power| sum + power));
    }
}

/// The systems that sync all components between steps.
#[derive(Resource)]
struct BetweenSteps {
    add_loads: SystemId,
    refresh: SystemId,
    write_back: SystemId,
    extend: SystemId,
    /// The change tick at which the caller got the world to change it.
    published_at: Option<Tick>,
}

fn add_all_loads<V: Space>(world: &mut World, state: &mut SystemState<AddLoads<V>>) {
    add_loads(world, state, MirrorSet::ALL);
}

fn refresh_all<V: Space>(store: Refresh<V>) {
    store.refresh(MirrorSet::ALL);
}

fn write_all_back<V: Space>(between: Res<BetweenSteps>, store: WriteBack<V>) {
    if let Some(since) = between.published_at {
        store.write_back(MirrorSet::ALL, since);
    }
}

fn run_registered(world: &mut World, system: SystemId) {
    world.run_system(system).expect("the system is registered, and its parameters always exist");
}

/// Refreshes all components, after applying a pending kick. Particles that lack forces and torques as components get none.
pub fn refresh_world(world: &mut World) {
    apply_pending_kick(world);
    if let Some(&BetweenSteps { refresh, .. }) = world.get_resource() {
        run_registered(world, refresh);
    }
}

/// Like [`refresh_world`], for a caller from outside: adds forces and torques to the particles that lack these components.
pub fn complete_world(world: &mut World) {
    refresh_world(world);
    if let Some(&BetweenSteps { add_loads, .. }) = world.get_resource() {
        run_registered(world, add_loads);
    }
}

/// Like [`complete_world`], for a caller that may change components: records from which tick on changes count.
pub fn publish_to_world(world: &mut World) {
    complete_world(world);
    let now = world.increment_change_tick();
    if let Some(mut between) = world.get_resource_mut::<BetweenSteps>() {
        between.published_at.get_or_insert(now);
    }
}

/// Writes back the components that the caller changed since [`publish_to_world`].
pub fn collect_from_world(world: &mut World) {
    let Some(&BetweenSteps { write_back, extend, published_at: Some(_), .. }) = world.get_resource() else { return };
    run_registered(world, write_back);
    run_registered(world, extend);
    world.resource_mut::<BetweenSteps>().published_at = None;
}

/// Registers the sync between steps.
pub(super) fn add<V: Space>(app: &mut App) {
    let world = app.world_mut();
    let refresh = world.register_system(refresh_all::<V>);
    let write_back = world.register_system(write_all_back::<V>);
    let add_loads = world.register_system(add_all_loads::<V>);
    let extend = world.register_system(extend_schedule::<V>);
    world.insert_resource(BetweenSteps { add_loads, refresh, write_back, extend, published_at: None });
    world.init_resource::<ReadsPlaces>();
    world.init_resource::<ReadsMotion>();
    world.init_resource::<AddsLoads>();
    world.init_resource::<PredictableConditions>();
    app.derived::<BetweenSteps>().derived::<Plan>();
}

/// Derives the sync plan of a complete schedule, and adds refresh and write-back systems to the phases that need them.
///
/// # Errors
/// If a system is in no phase.
pub fn plan<V: Space>(schedule: &mut Schedule, world: &mut World) -> Result<(), Fault> {
    schedule.graph_mut().initialize(world);
    let plan = Plan::of::<V>(schedule.graph(), world)?;
    world.insert_resource(plan);
    // Behaviours have added their observers and hooks by now.
    let mut observers = world.query_filtered();
    Plan::check_for_foreign_code(world, &mut observers);
    add_sync_systems::<V>(schedule, world);
    Ok(())
}

/// Returns whether a system of the step uses forces or torques of particles as components.
pub fn uses_loads<V: Space>(world: &mut World) -> bool {
    world.schedule_scope(Step, |world, schedule| {
        schedule.graph_mut().initialize(world);
        // Faults of the schedule are reported when it is complete.
        Plan::of::<V>(schedule.graph(), world).is_ok_and(|plan| plan.uses(MirrorSet::FORCE.or(MirrorSet::TORQUE)))
    })
}

/// Adds refresh and write-back to the phases that need them and do not have them yet.
fn add_sync_systems<V: Space>(schedule: &mut Schedule, world: &mut World) {
    let plan = &mut *world.resource_mut::<Plan>();
    add_phase::<V, 0>(schedule, plan);
    add_phase::<V, 1>(schedule, plan);
    add_phase::<V, 2>(schedule, plan);
    add_phase::<V, FORCES>(schedule, plan);
    add_phase::<V, 4>(schedule, plan);
    add_phase::<V, 5>(schedule, plan);
    add_phase::<V, 6>(schedule, plan);
    add_phase::<V, 7>(schedule, plan);
}

fn add_phase<V: Space, const PHASE: usize>(schedule: &mut Schedule, plan: &mut Plan) {
    if plan.needs_sync(PHASE) {
        let phase = Phase::ALL[PHASE];
        schedule.add_systems((
            refresh::<V, PHASE>.in_set(Part::Refresh(phase)),
            write_back::<V, PHASE>.in_set(Part::WriteBack(phase)),
        ));
        plan.phases[PHASE].is_synchronised = true;
    }
}

/// Extends the schedule if observers or hooks were added between two steps.
fn extend_schedule<V: Space>(world: &mut World, observers: &mut ForeignObservers) {
    if Plan::check_for_foreign_code(world, observers) {
        world.schedule_scope(Step, |world, schedule| add_sync_systems::<V>(schedule, world));
    }
}
