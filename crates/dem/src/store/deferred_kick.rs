//! The deferred kick: the second kick of a step is deferred until a system reads velocities, or else until the next
//! drift.
//!
//! Velocity Verlet ends a step with half a kick and begins the next step with another half, both by the same forces. If
//! no system reads velocities in between, one pass applies both kicks and the drift. One pass reads and writes less
//! memory than two. The motion is the same to the last bit.
//!
//! From the force pass on, velocities and spins in the store may therefore be half a step old, and the energy balance
//! one step old. The sync plan finds the steps in which a system reads velocities. The engine's own systems declare
//! this with [`reads_velocities_when`].
//!
//! A pending kick is applied at once ([`apply_pending_kick`]) before a renumbering, at the end of a run, and before the
//! world is passed to a caller.
//!
//! Limit: with a deferred kick, a value that is not finite and shows only in the energy balance is found one step late.
//! The error names the step in which it arose.

use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{BoxedCondition, ScheduleConfigs, ScheduleLabel, SystemCondition};
use bevy_ecs::system::ScheduleSystem;

use crate::outcome::Outcome;
use crate::persist::PersistApp as _;
use crate::step::{Drifted, Part, Phase, Step, is_step_zero, serial, time_moves};
use crate::store::foreign_code::ForeignObservers;
use crate::store::pending_kick::PendingKick;
use crate::store::renumbering::Renumber;
use crate::store::sets::{KicksApplied, SpinsDrifted};
use crate::store::sync_plan::Plan;

/// The schedule of second kicks and of all systems that use the resulting velocities. In step zero it runs no kicks,
/// and it starts the energy balance.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub struct DeferredKick;

/// Systems that use the velocities of the last step's end. They are in [`Phase::Drift`] and run if the drift has
/// applied the second kick.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct AfterDeferredKick;

/// Second kicks, in [`DeferredKick`].
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct SecondKicks;

/// The set of [`Phase::Observe`] that applies a pending kick in the last step of a run. After it, velocities belong to
/// the step's end.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct KickAppliedAtEnd;

/// Conditions under which the engine's own systems read velocities between the kick and the next drift.
#[derive(Resource, Default)]
struct VelocityReaders(Vec<BoxedCondition>);

/// Declares that a system of the engine reads velocities or the energy balance at the end of some steps. These are the
/// steps in which `condition` holds when the second kick is due.
pub fn reads_velocities_when<M>(app: &mut App, condition: impl SystemCondition<M>) {
    let world = app.world_mut();
    let mut condition = IntoSystem::into_system(condition);
    condition.initialize(world);
    world.get_resource_or_init::<VelocityReaders>().0.push(Box::new(condition));
}

/// Applies the second kick, if it is pending. Afterwards the store's velocities and spins belong to the step's end.
pub fn apply_pending_kick(world: &mut World) {
    if world.get_resource_mut::<PendingKick>().is_some_and(|mut kick| std::mem::take(&mut kick.is_pending)) {
        world.run_schedule(DeferredKick);
    }
}

/// Whether a system of the engine will read velocities in this step.
fn engine_reads_velocities(world: &mut World) -> bool {
    // `resource_scope` would move an entity.
    let mut conditions = std::mem::take(&mut world.resource_mut::<VelocityReaders>().0);
    // A condition that cannot be evaluated counts as true.
    let is_read = conditions.iter_mut().any(|condition| condition.run_readonly((), world).unwrap_or(true));
    world.resource_mut::<VelocityReaders>().0 = conditions;
    is_read
}

/// Applies the second kick, or defers it if no system will read velocities.
fn kick_or_defer(world: &mut World, observers: &mut ForeignObservers) {
    let may_be_deferred = world.resource::<PendingKick>().may_be_deferred;
    let is_wanted = !may_be_deferred || engine_reads_velocities(world) || Plan::motion_will_be_read(world, observers);
    world.resource_mut::<PendingKick>().is_pending = !is_wanted;
    if is_wanted {
        world.run_schedule(DeferredKick);
    }
}

/// Starts the energy balance, in step zero.
fn start_energy_balance(world: &mut World) {
    world.run_schedule(DeferredKick);
}

fn is_pending(kick: Res<PendingKick>) -> bool {
    kick.is_pending
}

fn has_ended(outcome: Res<Outcome>) -> bool {
    outcome.end().is_some()
}

/// Applies a pending kick in the last step, in which systems of all kinds read velocities. It is a separate system so
/// that every system of the schedule has its own type, by which profilers tell systems apart.
fn apply_pending_kick_at_end(world: &mut World) {
    apply_pending_kick(world);
}

/// Adds second kicks. The drift applies a pending one.
pub(crate) fn add_second_kick(app: &mut App, kicks: ScheduleConfigs<ScheduleSystem>) {
    app.world_mut().resource_mut::<PendingKick>().may_be_deferred = true;
    app.add_systems(DeferredKick, kicks.in_set(SecondKicks).run_if(time_moves));
}

/// Adds systems that use the velocities of a step's end.
pub fn after_kicks(app: &mut App, systems: impl Fn() -> ScheduleConfigs<ScheduleSystem>) {
    app.add_systems(DeferredKick, systems().after(SecondKicks));
    app.add_systems(Step, systems().in_set(AfterDeferredKick));
}

/// Adds the schedule and the systems that defer kicks.
pub(super) fn add(app: &mut App) {
    app.add_schedule(serial(DeferredKick)).init_resource::<PendingKick>();
    // A checkpoint applies a pending kick first.
    app.derived::<PendingKick>().derived::<VelocityReaders>();
    app.world_mut().init_resource::<VelocityReaders>();
    app.edit_schedule(Step, |schedule| {
        let late_systems =
            AfterDeferredKick.in_set(Part::Engine(Phase::Drift)).after(Drifted).after(SpinsDrifted).run_if(is_pending);
        schedule.configure_sets(late_systems);
        schedule.configure_sets(KickAppliedAtEnd.in_set(Part::Engine(Phase::Observe)));
        let control = (BalanceStarted, EngineBalance, EngineChecks).chain().in_set(Part::Engine(Phase::Control));
        schedule.configure_sets(control);
    });
    app.add_systems(
        Step,
        (
            kick_or_defer.in_set(Part::Engine(Phase::Kick)),
            start_energy_balance.in_set(BalanceStarted).run_if(is_step_zero),
            apply_pending_kick_at_end.in_set(KickAppliedAtEnd).run_if(has_ended),
        ),
    );
    app.add_systems(Renumber, apply_pending_kick.in_set(KicksApplied));
}

/// The set of [`Phase::Control`] that starts the energy balance in step zero.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
struct BalanceStarted;

/// Parts of the energy balance in [`Phase::Control`] that do not depend on the velocities of the step's end.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct EngineBalance;

/// Checks of [`Phase::Control`], after the energy balance.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct EngineChecks;
