//! The deferred kick: the second kick of a step is put off until a system looks at velocities, or else until the next drift.
//!
//! Velocity Verlet ends a step with half a kick and begins the next one with another, by the same forces. Where no system looks at
//! velocities in between, both are made in one pass with the drift: a third less is read and written in a step (`docs/explanation/speed.md`). No bit
//! of the motion depends on it.
//!
//! So from the force pass on, velocities and spins in the store may be half a step old, and the books of energy a step. The plan of
//! synchronisation tells in which steps a system looks at velocities; the engine's own systems tell it by [`reads_velocities_when`]. In all
//! other places the kick is made at once ([`apply_pending_kick`]): before slots are dealt out anew, at the end of a run, and before the world is handed
//! to a caller.
//!
//! Limit: a value that is not finite, and shows in the books, is found a step late where the kick was put off. The step in which it arose is
//! named.

use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{BoxedCondition, ScheduleConfigs, ScheduleLabel, SystemCondition};
use bevy_ecs::system::ScheduleSystem;

use crate::outcome::Outcome;
use crate::step::{Drifted, Part, Phase, Step, is_step_zero, serial, time_moves};
use crate::store::SpinsDrifted;
use crate::store::renumbering::KicksApplied;
use crate::store::sync_plan::{ForeignObservers, Plan};

/// Second kicks, and all systems that work on the velocities that follow. In step zero, without kicks, it begins the books.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct DeferredKick;

/// Systems that work on the velocities of the last step's end stand here, in [`Phase::Drift`], if its second kick was made with the drift.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct AfterDeferredKick;

/// Second kicks, in [`DeferredKick`].
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct SecondKicks;

/// The set of [`Phase::Observe`] after which velocities are those of the last step's end in the last step of a run.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct KickAppliedAtEnd;

/// The second kick of the last step.
#[derive(Resource, Default)]
pub(crate) struct PendingKick {
    /// Whether the drift makes it if it is owed.
    pub(crate) may_be_deferred: bool,
    /// Whether that of the last complete step has not been made.
    pub(crate) is_pending: bool,
}

/// When the engine's own systems look at velocities between the kick and the next drift.
#[derive(Resource, Default)]
struct VelocityReaders(Vec<BoxedCondition>);

/// An engine's system looks at velocities, or at the books, at the end of steps in which this condition holds when the second kick is due.
pub(crate) fn reads_velocities_when<M>(app: &mut App, condition: impl SystemCondition<M>) {
    let world = app.world_mut();
    let mut condition = IntoSystem::into_system(condition);
    condition.initialize(world);
    world.get_resource_or_init::<VelocityReaders>().0.push(Box::new(condition));
}

/// Makes the second kick, if it is owed.
pub(crate) fn apply_pending_kick(world: &mut World) {
    if world.get_resource_mut::<PendingKick>().is_some_and(|mut kick| std::mem::take(&mut kick.is_pending)) {
        world.run_schedule(DeferredKick);
    }
}

/// Whether an engine's system will look.
fn engine_looks(world: &mut World) -> bool {
    // Not with `resource_scope`, which moves an entity.
    let mut lookers = std::mem::take(&mut world.resource_mut::<VelocityReaders>().0);
    // A condition that cannot be evaluated holds.
    let looks = lookers.iter_mut().any(|looker| looker.run_readonly((), world).unwrap_or(true));
    world.resource_mut::<VelocityReaders>().0 = lookers;
    looks
}

/// Makes the second kick, or puts it off if no system will look.
fn kick_or_defer(world: &mut World, observers: &mut ForeignObservers) {
    let may_wait = world.resource::<PendingKick>().may_be_deferred;
    let is_wanted = !may_wait || engine_looks(world) || Plan::motion_is_looked_at(world, observers);
    world.resource_mut::<PendingKick>().is_pending = !is_wanted;
    if is_wanted {
        world.run_schedule(DeferredKick);
    }
}

/// Begins the books.
fn begin(world: &mut World) {
    world.run_schedule(DeferredKick);
}

fn is_pending(kick: Res<PendingKick>) -> bool {
    kick.is_pending
}

fn has_ended(outcome: Res<Outcome>) -> bool {
    outcome.end().is_some()
}

/// In the last step all systems look. A system of its own, so that each in the schedule has its own type, by which a stopwatch tells them
/// apart.
fn apply_pending_kick_at_end(world: &mut World) {
    apply_pending_kick(world);
}

/// Adds second kicks. The drift makes one that is owed.
pub(crate) fn add_second_kick(app: &mut App, kicks: ScheduleConfigs<ScheduleSystem>) {
    app.world_mut().resource_mut::<PendingKick>().may_be_deferred = true;
    app.add_systems(DeferredKick, kicks.in_set(SecondKicks).run_if(time_moves));
}

/// Adds systems that work on the velocities of a step's end.
pub(crate) fn after_kicks(app: &mut App, systems: impl Fn() -> ScheduleConfigs<ScheduleSystem>) {
    app.add_systems(DeferredKick, systems().after(SecondKicks));
    app.add_systems(Step, systems().in_set(AfterDeferredKick));
}

/// Lets second kicks be put off.
pub(super) fn add(app: &mut App) {
    app.add_schedule(serial(DeferredKick)).init_resource::<PendingKick>();
    app.world_mut().init_resource::<VelocityReaders>();
    app.edit_schedule(Step, |schedule| {
        let late =
            AfterDeferredKick.in_set(Part::Engine(Phase::Drift)).after(Drifted).after(SpinsDrifted).run_if(is_pending);
        schedule.configure_sets(late);
        schedule.configure_sets(KickAppliedAtEnd.in_set(Part::Engine(Phase::Observe)));
        let control = (BalanceStarted, EngineBalance, EngineChecks).chain().in_set(Part::Engine(Phase::Control));
        schedule.configure_sets(control);
    });
    app.add_systems(
        Step,
        (
            kick_or_defer.in_set(Part::Engine(Phase::Kick)),
            begin.in_set(BalanceStarted).run_if(is_step_zero),
            apply_pending_kick_at_end.in_set(KickAppliedAtEnd).run_if(has_ended),
        ),
    );
    app.add_systems(super::Renumber, apply_pending_kick.in_set(KicksApplied));
}

/// The books begin in this set of [`Phase::Control`] of step zero.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
struct BalanceStarted;

/// Books of [`Phase::Control`] that do not go by velocities of the step's end.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct EngineBalance;

/// Checks of [`Phase::Control`], after all books.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct EngineChecks;
