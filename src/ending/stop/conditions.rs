//! The scene key `stop`, and its conditions on rest and on the outflow.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::door::DoorState;
use crate::ending::regular::{Endings, end_at_rest, end_at_time, end_when_empty};
use crate::ending::stop::avalanches::Avalanches;
use crate::ending::stop::stillness::is_still;
use crate::ledger::{GrainsAccounted, Ledger};
use siloflow_dem::outcome::{End, Outcome};
use siloflow_dem::step::{Clock, Phase, Step, time_moves};
use siloflow_dem::values::Positive;

/// One condition of the scene key `stop`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum StopCondition {
    /// The bed is at rest. The scene needs `rest`.
    AtRest,
    /// No grain has left for a time, and the door is open. The scene needs a `door` that opens.
    EndOfFlow {
        /// Time since the last grain left, or since the door began to open, s.
        still: Positive,
    },
    /// No grain has left for a time, the door is open, and grains are above the outlet. The scene needs a `door` that opens.
    Clogged {
        /// Time since the last grain left, or since the door began to open, s.
        still: Positive,
    },
    /// This number of grains have left through a door.
    Out(u32),
}

/// The conditions on the outflow, in the order of the scene.
#[derive(Resource)]
pub(super) struct FlowConditions(Vec<StopCondition>);

/// Ends the run when a condition on the outflow holds.
pub(super) fn end_by_flow(
    clock: Res<Clock>,
    (conditions, ledger): (Res<FlowConditions>, Res<Ledger>),
    (door, avalanches): (Option<Res<DoorState>>, Option<Res<Avalanches>>),
    mut outcome: ResMut<Outcome>,
) {
    let is_still = |still| is_still(&clock, &ledger, door.as_deref(), avalanches.as_deref(), still);
    for condition in &conditions.0 {
        match *condition {
            StopCondition::EndOfFlow { still } if is_still(still.get()) => {
                outcome.finish(End::FlowEnded { still_s: still.get() });
            }
            StopCondition::Out(count) if ledger.out() >= count => outcome.finish(End::OutReached { count }),
            _ => {}
        }
    }
}

/// Ends the run by the conditions of the scene.
pub struct StopPlugin(pub Vec<StopCondition>);

impl Plugin for StopPlugin {
    fn build(&self, app: &mut App) {
        let (at_rest, of_flow): (Vec<_>, Vec<_>) =
            self.0.iter().partition(|condition| matches!(condition, StopCondition::AtRest));
        if !at_rest.is_empty() {
            app.add_systems(Step, end_at_rest.in_set(Phase::Cull).before(end_when_empty));
        }
        if !of_flow.is_empty() {
            // A silo that is empty is reported as empty.
            app.insert_resource(FlowConditions(of_flow)).add_systems(
                Step,
                end_by_flow
                    .in_set(Phase::Cull)
                    .in_set(Endings)
                    .after(GrainsAccounted)
                    .after(end_when_empty)
                    .before(end_at_time)
                    .run_if(time_moves),
            );
        }
    }
}
