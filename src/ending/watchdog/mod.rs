//! Watchdog: stops a run with meaningless results, and reports step, grain and remedy.
//!
//! [`finite`](crate::ending::finite) checks in every step that values are finite. The watchdog checks two more things: that no energy
//! appears without a source ([`energy`]), and that overlaps stay within the reach of the contact law ([`overlap`]).
//!
//! Limits:
//!
//! * Energy created by a nearly unstable drag cannot be distinguished from its loss.
//! * Energy is checked as a whole. A few wild grains among many with much energy are found late, by their overlap or by
//!   the grain accounting. Without energy balance (`energy_balance: false`) energy is not checked.
//! * If a behaviour sets velocities, or fixes and frees grains, energy changes without a force and seems to grow. The
//!   scene must then say `watchdog: (energy: None)`.
//! * Output written before the stop remains.

pub mod energy;
pub mod overlap;

use std::marker::PhantomData;
use std::num::NonZeroU32;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use self::energy::EnergyCheck;
use self::overlap::OverlapCheck;
use crate::ending::regular::Endings;
use crate::energy::EnergyFlows;
use crate::energy::sampling::DissipationError;
use crate::ledger::GrainsAccounted;
use siloflow_dem::contact::LargestOverlap;
use siloflow_dem::gravity::Gravity;
use siloflow_dem::outcome::{End, Outcome};
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::space::Space;
use siloflow_dem::step::{Clock, Phase, Step};
use siloflow_dem::store::register_predictable;
use siloflow_dem::survey::SurveyParam;
use siloflow_dem::threads::Threads;
use siloflow_dem::values::Positive;

/// The scene key `watchdog`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Watchdog {
    /// Steps between two checks of the energy. Default 500.
    pub every: NonZeroU32,
    /// Largest share of the energy input that may appear without a source, dimensionless; `None` disables the check. Default 0.1.
    pub energy: Option<Positive>,
    /// Largest ratio of overlap to the smaller radius, dimensionless; `None` disables the check. Default 1.
    pub overlap: Option<Positive>,
}

impl Default for Watchdog {
    fn default() -> Self {
        let share = |number: f64| Positive::try_from(number).ok();
        Self { every: NonZeroU32::new(500).unwrap_or(NonZeroU32::MIN), energy: share(0.1), overlap: share(1.0) }
    }
}

/// Tolerated standard errors of the dissipated energy.
const DEVIATIONS: f64 = 5.0;

/// Limits and state of the watchdog.
#[derive(Resource, Debug, Deserialize, Serialize)]
struct WatchdogState {
    /// Steps between two checks of the energy.
    every: u64,
    energy: EnergyCheck,
    overlap: OverlapCheck,
}

/// Run condition: a check is due. Most steps cost no more than this test.
fn is_check_due(
    clock: Res<Clock>,
    largest: Res<LargestOverlap>,
    state: Res<WatchdogState>,
    outcome: Res<Outcome>,
) -> bool {
    clock.steps.is_multiple_of(state.every) || state.overlap.is_due(largest.0) || outcome.end().is_some()
}

/// Checks overlap and energy.
fn check<V: Space>(
    (clock, gravity, threads): (Res<Clock>, Res<Gravity<V>>, Res<Threads>),
    (flows, error): (Option<Res<EnergyFlows>>, DissipationError),
    largest: Res<LargestOverlap>,
    survey_param: SurveyParam<V>,
    mut state: ResMut<WatchdogState>,
    mut outcome: ResMut<Outcome>,
) {
    let is_energy_due = clock.steps.is_multiple_of(state.every) || outcome.end().is_some();
    if matches!(outcome.end(), Some(End::Failed(_))) {
        return;
    }
    let survey = survey_param.survey();
    let uncertain = DEVIATIONS * error.standard() + error.pending();
    if state.overlap.is_due(largest.0)
        && let Some(failure) = state.overlap.failure(&survey, &clock, largest.0)
    {
        outcome.fail(failure);
    }
    if is_energy_due
        && state.energy.is_on()
        && let Some(flows) = flows
        && let Some(failure) = state.energy.failure(&survey, &threads, &clock, gravity.0, &flows, uncertain)
    {
        outcome.fail(failure);
    }
}

/// Checks energy and overlap.
pub struct WatchdogPlugin<V: Space>(pub Watchdog, pub PhantomData<V>);

impl<V: Space> Plugin for WatchdogPlugin<V> {
    fn build(&self, app: &mut App) {
        let Watchdog { every, energy, overlap } = self.0;
        app.insert_resource(WatchdogState {
            every: u64::from(every.get()),
            energy: EnergyCheck::new(energy.map_or(f64::INFINITY, Positive::get)),
            overlap: OverlapCheck::new(overlap.map(Positive::get)),
        });
        app.persist::<WatchdogState>();
        // After the energy balance of the step is complete, and before the end of the run is written.
        app.add_systems(
            Step,
            check::<V>.in_set(Phase::Cull).after(GrainsAccounted).after(Endings).run_if(is_check_due),
        );
        register_predictable(app, is_check_due, is_check_due);
    }
}
