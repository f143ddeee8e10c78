//! Detects rest: `hold` steps have passed since the last particle entered. If the scene sets `drift`, the mean height
//! of all particles must also have changed by less than `drift` over these `hold` steps; otherwise the next `hold`
//! steps are checked.
//!
//! Particles of a lattice gas never stop moving, so rest is defined by a time or by a mean value. Slow variants (p, q
//! or k of 0.8) are still settling after thousands of steps.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::grains::pending::Pending;
use crate::lattice_silo::series::means;
use siloflow_dem::messages::CameToRest;
use siloflow_dem::persist::{PersistApp as _, Problem};
use siloflow_dem::step::{Clock, Phase, Step};
use siloflow_dem::values::Positive;
use siloflow_lattice::gas::Gas;
use siloflow_lattice::sites::Sites;

/// The scene's key `rest`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Rest {
    /// Number of steps after which rest is checked.
    pub hold: u64,
    /// Upper limit for the change of the mean height in `hold` steps, m. Default: no limit.
    pub drift: Option<Positive>,
    /// Whether the run ends at rest.
    #[serde(default)]
    pub stop: bool,
}

/// State of the rest detector.
#[derive(Resource, Debug)]
pub struct RestDetector {
    config: Rest,
    since: Option<(u64, f64)>,
    /// Step in which rest was detected; `None` before.
    pub rest_step: Option<u64>,
}

/// Set of the rest detector. Systems of [`Phase::Control`] that react to rest run after this set.
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

/// Refuses a restored step that is still to come.
pub(super) fn not_later_than_now(world: &World, step: u64) -> Result<(), Problem> {
    let now = world.resource::<Clock>().steps;
    if step <= now { Ok(()) } else { Err(format!("it names step {step}, and {now} steps are done")) }
}

/// Plugin that detects rest, once per run.
pub(super) struct RestPlugin(pub Rest);

impl Plugin for RestPlugin {
    fn build(&self, app: &mut App) {
        app.persist_sound_part::<RestDetector, _>(
            |detector| Ok((detector.since, detector.rest_step)),
            |detector, state| {
                (detector.since, detector.rest_step) = state;
                Ok(())
            },
        );
        app.check_restored(|world| {
            let since = world.resource::<RestDetector>().since.map_or(0, |(since, _)| since);
            not_later_than_now(world, since)
        });
        app.insert_resource(RestDetector { config: self.0, since: None, rest_step: None })
            .add_systems(Step, detect.in_set(Phase::Control).in_set(RestDetection).run_if(everything_has_entered));
    }
}
