//! When the gas is at rest: so many steps after the last particle has entered and, if the scene wants it, when the mean
//! height of all particles has changed by less than `drift` since as many steps.
//!
//! Particles of a lattice gas never stop moving, so rest is a matter of time or of the mean. Slow variants (p, q or k of
//! 0.8) still settle after thousands of steps.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::grains::spawner::Pending;
use crate::lattice::gas::Gas;
use crate::lattice::series::means;
use crate::lattice::sites::Sites;
use crate::messages::CameToRest;
use crate::step::{Clock, Phase, Step};
use crate::values::Positive;

/// The scene's `rest`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Rest {
    /// Steps.
    pub hold: u64,
    /// Largest change of the mean height in `hold` steps, m. Default: any.
    pub drift: Option<Positive>,
    /// Whether rest ends the run. Default false.
    #[serde(default)]
    pub stop: bool,
}

/// The rest detector's state.
#[derive(Resource, Debug)]
pub struct RestDetector {
    config: Rest,
    since: Option<(u64, f64)>,
    /// In which step rest was found.
    pub rest_step: Option<u64>,
}

/// Systems of [`Phase::Control`] that act on rest run after this set.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct RestDetection;

fn detect(
    clock: Res<Clock>,
    (sites, gas): (Res<Sites>, Res<Gas>),
    mut detector: ResMut<RestDetector>,
    mut at_rest: MessageWriter<CameToRest>,
) {
    let height = || if detector.config.drift.is_some() { means(&sites, &gas).centre.y } else { 0.0 };
    let Some((since, before)) = detector.since else {
        detector.since = Some((clock.steps, height()));
        return;
    };
    if clock.steps - since < detector.config.hold {
        return;
    }
    let now = height();
    if detector.config.drift.is_some_and(|drift| (now - before).abs() >= drift.get()) {
        detector.since = Some((clock.steps, now));
        return;
    }
    detector.rest_step = Some(clock.steps);
    at_rest.write(CameToRest);
}

fn everything_has_entered(pending: Res<Pending>, detector: Res<RestDetector>) -> bool {
    pending.0 == 0 && detector.rest_step.is_none()
}

/// Finds rest, once.
pub(super) struct RestPlugin(pub Rest);

impl Plugin for RestPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(RestDetector { config: self.0, since: None, rest_step: None })
            .add_systems(Step, detect.in_set(Phase::Control).in_set(RestDetection).run_if(everything_has_entered));
    }
}
