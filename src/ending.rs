//! When a run ends regularly: the silo is empty, the bed is at rest (if the scene says so), or time is up.
//!
//! Empty means that grains have been released, none is to come, and none is inside.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::grains::spawner::Pending;
use crate::ledger::{GrainsAccounted, Ledger};
use crate::messages::CameToRest;
use crate::outcome::{End, Outcome};
use crate::step::{Clock, Phase, Step, time_moves};
use crate::store::reads_velocities_when;

#[derive(Resource)]
struct Until(f64);

/// When the silo was found empty, s.
#[derive(Resource, Default, Debug)]
pub struct EmptyTime(pub Option<f64>);

fn end_when_empty(
    clock: Res<Clock>,
    pending: Res<Pending>,
    ledger: Res<Ledger>,
    mut empty: ResMut<EmptyTime>,
    mut outcome: ResMut<Outcome>,
) {
    if pending.0 == 0 && ledger.released > 0 && ledger.inside() == 0 {
        // A silo whose grains are all lost has not been emptied.
        empty.0 = (ledger.out() > 0).then(|| clock.time());
        outcome.finish(End::Empty);
    }
}

fn time_is_up(clock: Res<Clock>, until: Res<Until>) -> bool {
    clock.has_reached(until.0)
}

fn end_at_time(mut outcome: ResMut<Outcome>) {
    outcome.finish(End::TimeReached);
}

/// Ends the run when rest is found.
pub(crate) fn end_at_rest(mut rest: MessageReader<CameToRest>, mut outcome: ResMut<Outcome>) {
    if rest.read().next().is_some() {
        outcome.finish(End::AtRest);
    }
}

/// After this set of [`Phase::Cull`], a run that ends regularly in this step has ended.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct Endings;

/// Ends the run.
pub struct EndingPlugin {
    /// At the latest, s.
    pub until: f64,
    /// Whether rest ends it.
    pub at_rest: bool,
}

impl Plugin for EndingPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(Until(self.until)).init_resource::<EmptyTime>().add_systems(
            Step,
            (end_when_empty, end_at_time.run_if(time_is_up))
                .chain()
                .in_set(Phase::Cull)
                .in_set(Endings)
                .after(GrainsAccounted)
                .run_if(time_moves),
        );
        reads_velocities_when(app, time_is_up);
        if self.at_rest {
            app.add_systems(Step, end_at_rest.in_set(Phase::Cull).before(end_when_empty));
        }
    }
}
