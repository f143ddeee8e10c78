//! Rest detector: finds the time at which all released grains have come to rest.
//!
//! Rest has three conditions. Every grain is slower than `speed` sqrt(g R). The total kinetic energy is below `energy`
//! times the sum of m g R. No grain is still to be released. All must hold for `hold` seconds without a break.
//!
//! In these units the thresholds do not depend on the grain size. With `speed` 2e-3, a grain of 4 cm on Earth moves at
//! 1.3 mm/s; the kinetic energy 1e-6 m g R would lift it by 1e-6 of its radius. One quiet step proves nothing, because
//! a grain thrown upwards is at rest at the top of its path. Therefore the conditions must hold for a time.
//!
//! Limit: grains that are out or lost but not yet culled count too. A scene that goes on after losses needs `cull` to
//! come to rest.

use std::marker::PhantomData;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::grains::pending::Pending;
use siloflow_dem::gravity::Gravity;
use siloflow_dem::messages::CameToRest;
use siloflow_dem::particles::Motion;
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::space::Space;
use siloflow_dem::step::{Clock, Phase, Step};
use siloflow_dem::store::register_predictable;
use siloflow_dem::values::{NonNegative, Positive};

/// The scene key `rest`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Rest {
    /// Threshold of the largest speed, in units of sqrt(g R).
    pub speed: Positive,
    /// Threshold of the kinetic energy per grain, in units of m g R.
    pub energy: Positive,
    /// Time for which both conditions must hold, s.
    pub hold: NonNegative,
    /// Whether rest ends the run, as the stop condition `AtRest` does.
    #[serde(default)]
    pub stop: bool,
}

/// State of the rest detector.
#[derive(Resource, Debug)]
pub struct RestDetector {
    thresholds: Rest,
    quiet_since: Option<f64>,
    /// When rest was detected, s; `None` before.
    pub rest_time: Option<f64>,
}

/// Systems of [`Phase::Control`] that act on rest run after this set.
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct RestDetection;

fn detect<V: Space>(
    clock: Res<Clock>,
    gravity: Res<Gravity<V>>,
    motion: Motion<V>,
    mut detector: ResMut<RestDetector>,
    mut at_rest: MessageWriter<CameToRest>,
) {
    if !is_quiet(&motion, &detector.thresholds, gravity.0.length()) {
        detector.quiet_since = None;
        return;
    }
    let since = *detector.quiet_since.get_or_insert(clock.time());
    if clock.has_reached(since + detector.thresholds.hold.get()) {
        detector.rest_time = Some(clock.time());
        at_rest.write(CameToRest);
    }
}

fn is_quiet<V: Space>(motion: &Motion<V>, thresholds: &Rest, g: f64) -> bool {
    let speed_limit = thresholds.speed.get().powi(2) * g;
    let mut kinetic = 0.0;
    let mut scale = 0.0;
    for grain in motion.grains() {
        if motion.velocity(grain).length_squared() > speed_limit * motion.radius(grain) {
            return false;
        }
        kinetic += motion.kinetic_energy(grain);
        scale += motion.mass(grain) * g * motion.radius(grain);
    }
    kinetic <= thresholds.energy.get() * scale
}

fn may_come_to_rest(pending: Res<Pending>, detector: Res<RestDetector>) -> bool {
    pending.0 == 0 && detector.rest_time.is_none()
}

/// Detects rest once.
pub struct RestPlugin<V: Space>(pub Rest, pub PhantomData<V>);

impl<V: Space> Plugin for RestPlugin<V> {
    fn build(&self, app: &mut App) {
        app.persist_sound_part::<RestDetector, _>(
            |detector| Ok((detector.quiet_since, detector.rest_time)),
            |detector, times| {
                (detector.quiet_since, detector.rest_time) = times;
                Ok(())
            },
        );
        app.insert_resource(RestDetector { thresholds: self.0, quiet_since: None, rest_time: None }).add_systems(
            Step,
            detect::<V>
                .in_set(Phase::Control)
                .in_set(RestDetection)
                .run_if(may_come_to_rest)
                .run_if(siloflow_dem::step::time_moves),
        );
        register_predictable(app, may_come_to_rest, may_come_to_rest);
    }
}
