//! Settling: the second kick of a step, which is put off until somebody looks at velocities, or else until the next drift.
//!
//! Velocity Verlet ends a step with half a kick and begins the next one with another, by the same forces. Where columns lead and
//! nobody looks in between, both are made in one pass with the drift: what is not read and written twice for it is a third of
//! what a step moves (`docs/speed.md`). No bit hangs on who looks.
//!
//! So from the force pass on velocities and spins may be half a step old, and the books of energy a step. Who looks at them says
//! when it will ([`looks_when`]), before the kick is due. Who looks unforeseen settles: slots that are dealt out anew, the end of
//! a run, whoever is given the world between steps ([`Lead`](super::Lead)).
//!
//! Limit: what is not finite, and shows in the books, is found a step late where they are, in a state that has moved on with it. The
//! step that it is of is named.

use bevy_app::App;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{BoxedCondition, ScheduleConfigs, ScheduleLabel, SystemCondition};
use bevy_ecs::system::ScheduleSystem;

use crate::columns::SpinsDrifted;
use crate::measure::ObserveStage;
use crate::outcome::Outcome;
use crate::step::{Drifted, Phase, Step, is_step_zero, serial, time_moves};

/// What settles: kicks, and whatever goes by the velocities that they lead to. In step zero, without kicks, it begins the books.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Settling;

/// Before slots are dealt out anew, velocities are those of the step's end after this set.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Settled;

/// What goes by the velocities of the last step's end belongs here, in [`Phase::Drift`], if its second kick was made with the drift.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Late;

/// Second kicks, where they are made by [`Settling`].
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct SecondKicks;

/// The second kick of the last step; a resource where it may be put off.
#[derive(Resource, Default)]
pub(crate) struct SecondKick {
    /// Whether that of the last complete step has not been made.
    pub(crate) is_owed: bool,
}

/// Who looks at velocities between the kick and the next drift.
#[derive(Resource, Default)]
struct Lookers(Vec<BoxedCondition>);

/// Velocities, and what goes by them, are wanted at the end of steps in which this condition holds when the second kick is due.
pub(crate) fn looks_when<M>(app: &mut App, condition: impl SystemCondition<M>) {
    let world = app.world_mut();
    if world.contains_resource::<Lookers>() {
        let mut condition = IntoSystem::into_system(condition);
        condition.initialize(world);
        world.resource_mut::<Lookers>().0.push(Box::new(condition));
    }
}

/// Makes the second kick, if it is owed.
pub(crate) fn settle(world: &mut World) {
    if world.get_resource_mut::<SecondKick>().is_some_and(|mut kick| std::mem::take(&mut kick.is_owed)) {
        world.run_schedule(Settling);
    }
}

/// Puts the kick off, unless somebody looks.
fn put_off(world: &mut World) {
    // Not with `resource_scope`, which moves an entity.
    let mut lookers = std::mem::take(&mut world.resource_mut::<Lookers>().0);
    // Who cannot say looks.
    let is_wanted = lookers.iter_mut().any(|looker| looker.run_readonly((), world).unwrap_or(true));
    world.resource_mut::<Lookers>().0 = lookers;
    world.resource_mut::<SecondKick>().is_owed = !is_wanted;
    if is_wanted {
        world.run_schedule(Settling);
    }
}

/// Begins the books.
fn begin(world: &mut World) {
    world.run_schedule(Settling);
}

fn is_owed(kick: Res<SecondKick>) -> bool {
    kick.is_owed
}

fn has_ended(outcome: Res<Outcome>) -> bool {
    outcome.end().is_some()
}

/// All look then. A system of its own, so that each of the schedule has its own type: who times them tells them apart by it.
fn settle_at_end(world: &mut World) {
    settle(world);
}

/// Adds second kicks: to [`Phase::Kick`], or where they may be put off, to what settles.
pub(crate) fn add_second_kick(app: &mut App, kicks: ScheduleConfigs<ScheduleSystem>) {
    if app.world().contains_resource::<SecondKick>() {
        app.add_systems(Settling, kicks.in_set(SecondKicks).run_if(time_moves));
    } else {
        app.add_systems(Step, kicks.in_set(Phase::Kick));
    }
}

/// Adds what goes by the velocities of a step's end: to [`Phase::Control`], or to whatever kicks.
pub(crate) fn after_kicks(app: &mut App, systems: impl Fn() -> ScheduleConfigs<ScheduleSystem>) {
    if app.world().contains_resource::<SecondKick>() {
        app.add_systems(Settling, systems().after(SecondKicks));
        app.add_systems(Step, systems().in_set(Late));
    } else {
        app.add_systems(Step, systems().in_set(Phase::Control));
    }
}

/// Lets second kicks be put off.
pub(super) fn add(app: &mut App) {
    app.add_schedule(serial(Settling)).init_resource::<SecondKick>().init_resource::<Lookers>();
    app.edit_schedule(Step, |schedule| {
        let late = Late.in_set(Phase::Drift).after(Drifted).after(SpinsDrifted).run_if(is_owed);
        schedule.configure_sets(late);
    });
    app.add_systems(
        Step,
        (
            put_off.in_set(Phase::Kick),
            begin.after(Phase::Kick).before(Phase::Control).run_if(is_step_zero),
            settle.in_set(Settled),
            settle_at_end.in_set(ObserveStage::Settled).run_if(has_ended),
        ),
    );
}
