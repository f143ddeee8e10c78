//! Ends a run of the lattice gas: when the silo is empty, when the gas is at rest (if `rest.stop`), `discharge` steps
//! after the door has opened, after `until` steps, or at the request of the caller.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::ending::regular::{EmptyTime, end_at_rest};
use crate::ending::request::StopRequest;
use crate::grains::pending::Pending;
use crate::lattice_silo::door::DoorState;
use siloflow_dem::outcome::{End, Outcome};
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::step::{Clock, Phase, Step, time_moves};
use siloflow_lattice::gas::Gas;

#[derive(Resource)]
struct Until(u64);

fn end_when_empty(
    clock: Res<Clock>,
    (gas, pending): (Res<Gas>, Res<Pending>),
    mut empty: ResMut<EmptyTime>,
    mut outcome: ResMut<Outcome>,
) {
    if pending.0 == 0 && gas.entered() > 0 && gas.inside() == 0 {
        empty.0 = Some(clock.time());
        outcome.finish(End::Empty);
    }
}

fn end_at_step(clock: Res<Clock>, until: Res<Until>, stop: Res<StopRequest>, mut outcome: ResMut<Outcome>) {
    if clock.steps >= until.0 {
        outcome.finish(End::TimeReached);
    } else if stop.is_made() {
        outcome.finish(End::Interrupted);
    }
}

/// Plugin that ends the run when the silo is empty, after the last step, or at rest.
pub(super) struct EndingPlugin {
    /// Last step of the run.
    pub until: u64,
    /// Whether the run ends when the gas is at rest.
    pub stop_at_rest: bool,
}

impl Plugin for EndingPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(Until(self.until))
            .init_resource::<EmptyTime>()
            .persist_sound::<EmptyTime>()
            .add_systems(Step, (end_when_empty, end_at_step).chain().in_set(Phase::Cull).run_if(time_moves));
        if self.stop_at_rest {
            app.add_systems(Step, end_at_rest.in_set(Phase::Cull).before(end_when_empty));
        }
    }
}

#[derive(Resource)]
struct Discharge(u64);

fn end_after_opening(
    clock: Res<Clock>,
    (door, discharge): (Res<DoorState>, Res<Discharge>),
    mut outcome: ResMut<Outcome>,
) {
    if door.steps_since(&clock).is_some_and(|steps| steps >= discharge.0) {
        outcome.finish(End::TimeReached);
    }
}

/// Plugin that ends the run this number of steps after the door has opened.
pub(super) struct DischargePlugin(pub u64);

impl Plugin for DischargePlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(Discharge(self.0))
            .add_systems(Step, end_after_opening.in_set(Phase::Cull).after(end_at_step).run_if(time_moves));
    }
}
