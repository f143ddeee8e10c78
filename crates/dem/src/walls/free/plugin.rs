//! Moves free walls: their coordinates with the drift, their rates after the force pass.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;

use crate::gravity::Gravity;
use crate::outcome::{Failure, Outcome};
use crate::space::Space;
use crate::step::{Clock, ClockAdvanced, ForceStage, Part, Phase, Step};
use crate::store::AfterDeferredKick;
use crate::walls::moving::{Meeting, WallsPlaced};
use crate::walls::surfaces::Surfaces;

fn drift<V: Space>(clock: Res<Clock>, meeting: Res<Meeting>, mut walls: ResMut<Surfaces<V>>) {
    walls.bypass_change_detection().drift_free(clock.dt, clock.time(), meeting.is_predicted);
}

fn kick<V: Space>(
    clock: Res<Clock>,
    gravity: Res<Gravity<V>>,
    mut walls: ResMut<Surfaces<V>>,
    mut outcome: ResMut<Outcome>,
) {
    let dt = (!clock.is_step_zero()).then_some(clock.dt);
    if let Err(name) = walls.bypass_change_detection().kick_free(dt, clock.time(), gravity.0) {
        let text = format!(
            "step {}: the free wall {name:?} is not finite; its `mass` or `gain` does not suit the step: `check` prints the limit",
            clock.steps
        );
        outcome.fail(Failure::Behaviour(text));
    }
}

/// Moves the free walls, beside the plugin of moving walls.
pub struct FreeWallsPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for FreeWallsPlugin<V> {
    fn build(&self, app: &mut App) {
        let drift = drift::<V>.in_set(Part::Engine(Phase::Drift)).after(ClockAdvanced).after(AfterDeferredKick);
        app.add_systems(Step, drift.before(WallsPlaced));
        app.add_systems(Step, kick::<V>.in_set(Part::Engine(Phase::Forces)).after(ForceStage::Contacts));
    }
}
