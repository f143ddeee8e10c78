//! Regular ends of every run of grains: the silo is empty, the time is over, or the caller asked for the end.
//! [`stop`](crate::ending::stop) has the conditions that a scene may add.
//!
//! The silo is empty if grains have been released, none is still to be released, and none is inside.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::ending::request::StopRequest;
use crate::grains::pending::Pending;
use crate::ledger::{GrainsAccounted, Ledger};
use siloflow_dem::messages::CameToRest;
use siloflow_dem::outcome::{End, Outcome};
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::step::{Clock, Phase, Step, time_moves};
use siloflow_dem::store::reads_velocities_when;

#[derive(Resource)]
pub(crate) struct Until(f64);

/// Time at which the silo was found empty, s.
#[derive(Resource, Default, Debug, Deserialize, Serialize)]
pub struct EmptyTime(pub Option<f64>);

pub(crate) fn end_when_empty(
    clock: Res<Clock>,
    pending: Res<Pending>,
    ledger: Res<Ledger>,
    mut empty: ResMut<EmptyTime>,
    mut outcome: ResMut<Outcome>,
) {
    if pending.0 == 0 && ledger.released > 0 && ledger.inside() == 0 {
        // A silo that lost all of its grains was not emptied through its orifice.
        empty.0 = (ledger.out() > 0).then(|| clock.time());
        outcome.finish(End::Empty);
    }
}

fn is_time_over(clock: Res<Clock>, until: Res<Until>, stop: Res<StopRequest>) -> bool {
    stop.is_made() || clock.has_reached(until.0)
}

pub(crate) fn end_at_time(clock: Res<Clock>, until: Res<Until>, mut outcome: ResMut<Outcome>) {
    outcome.finish(if clock.has_reached(until.0) { End::TimeReached } else { End::Interrupted });
}

/// Ends the run when the bed has come to rest.
pub(crate) fn end_at_rest(mut rest: MessageReader<CameToRest>, mut outcome: ResMut<Outcome>) {
    if rest.read().next().is_some() {
        outcome.finish(End::AtRest);
    }
}

/// After this set of [`Phase::Cull`], a run that ends regularly in this step has its end set.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Endings;

/// Regular ends of a run.
pub struct EndingPlugin {
    /// Latest end, s.
    pub until: f64,
}

impl Plugin for EndingPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(Until(self.until)).init_resource::<EmptyTime>().persist_sound::<EmptyTime>().add_systems(
            Step,
            (end_when_empty, end_at_time.run_if(is_time_over))
                .chain()
                .in_set(Phase::Cull)
                .in_set(Endings)
                .after(GrainsAccounted)
                .run_if(time_moves),
        );
        reads_velocities_when(app, is_time_over);
    }
}
