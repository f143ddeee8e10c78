//! Watchdog: stops a run with meaningless results, and reports step, grain and remedy.
//!
//! [`crate::ending::finite`] checks in every step that values are finite. This file checks two more things.
//!
//! * **Energy without a source.** Checked every `every` steps and at the end.
//!
//!   *Created energy* is the kinetic, gravitational and part of the elastic energy, minus the energy expected from the
//!   energy flows ([`EnergyFlows::expected`]), all in J. Velocity Verlet conserves K + (1 - q) E_elastic with
//!   q = (w0 dt)^2/4, so a contact in progress seems to gain up to q of its elastic energy. The share [`APPARENT`] of
//!   the elastic energy is therefore not counted; it equals q at three quarters of the stability limit.
//!
//!   Drag cannot return energy, but an unstable drag does negative work. The largest dissipated energy so far therefore
//!   stays dissipated, and any decrease counts as created. Energy in springs is excepted: if the dashpot alone of a
//!   sliding contact exceeds the cap, it stretches its spring, and the balance counts the energy of the spring as
//!   returned.
//!
//!   The run stops if the created energy exceeds the share `energy` of the *input*. The input is the energy of motion
//!   and springs of grains that entered, plus the work of gravity, walls, belts and added forces. It equals
//!   expected - gravitational + dissipated; the largest value so far counts. Attraction between grains has negative
//!   elastic energy; its largest magnitude so far is added. The input does not depend on the zero of height.
//!
//!   Errors of the measure itself are tolerated:
//!   + Round-off of heights, 1e-9 sum m |g.x|.
//!   + Round-off of places. Without gravity nothing else may be left, as in a bed that touches exactly. A place x is known to eps |x|, and
//!     each step rounds anew. In each step each grain so may get the energy with which it would squeeze its contacts by d = 4 eps (|x| + R), for
//!     a linear law k d^2/2 each, with twelve contacts. That is far below all energies of a scene, whatever its units.
//!   + The error of the dissipated energy where only some steps sum it: five standard errors, and what the steps since the last sample
//!     have added ([`crate::energy::sampling`]).
//!
//!   Healthy runs stay far below the limit. Checked every 100 steps, these runs create less than 1e-3 of the input:
//!   `silo1` with its mixture and polydisperse variants, `couette`, `column`, and the first tenth of a second of `silo2d`
//!   and `bed3d` (`--set 'watchdog=(every: 100, energy: 1.0e-3)'` does not stop them).
//! * **Overlap beyond the contact law.** Checked every step, by the largest ratio of overlap to the smaller radius in
//!   the force pass.
//!
//!   Both contact laws are meant for small overlaps. From 0.586 (2 - sqrt 2, solid space) or 0.845 (2 - 2/sqrt 3,
//!   plane) on, equal grains in dense order touch their second neighbours through the first. At 1 the centre of a grain
//!   reaches the surface of its partner, a thin wall would push it to the other side, and the direction of the force is
//!   meaningless. The default limit is 1. From 0.3 on the run warns once. (The assignment's silo reaches 0.73, where a
//!   grain falls 4 m.)
//!
//! Limits:
//!
//! * Energy created by a nearly unstable drag cannot be distinguished from its loss.
//! * Energy is checked as a whole. A few wild grains among many with much energy are found late, by their overlap or by
//!   the grain accounting. Without energy balance (`energy_balance: false`) energy is not checked.
//! * If a behaviour sets velocities, or fixes and frees grains, energy changes without a force and seems to grow. The
//!   scene must then say `watchdog: (energy: None)`.
//! * Output written before the stop remains.

use std::marker::PhantomData;
use std::num::NonZeroU32;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::ending::Endings;
use crate::energy::EnergyFlows;
use crate::energy::sampling::DissipationError;
use crate::ledger::GrainsAccounted;
use siloflow_dem::contact::{Bounce, LargestOverlap};
use siloflow_dem::gravity::Gravity;
use siloflow_dem::outcome::{End, Failure, Outcome};
use siloflow_dem::particle::GrainId;
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::space::Space;
use siloflow_dem::step::{Clock, Phase, Step};
use siloflow_dem::store::register_predictable;
use siloflow_dem::survey::{Partner, Survey, SurveyParam};
use siloflow_dem::values::Positive;

/// The scene key `watchdog`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Watchdog {
    /// Steps between two checks of the energy.
    pub every: NonZeroU32,
    /// Largest share of the energy input that may appear without a source; `None` disables the check.
    pub energy: Option<Positive>,
    /// Largest ratio of overlap to the smaller radius; `None` disables the check.
    pub overlap: Option<Positive>,
}

impl Default for Watchdog {
    fn default() -> Self {
        let share = |number: f64| Positive::try_from(number).ok();
        Self { every: NonZeroU32::new(500).unwrap_or(NonZeroU32::MIN), energy: share(0.1), overlap: share(1.0) }
    }
}

/// Overlap ratio from which on a run warns.
pub(crate) const LARGE_OVERLAP: f64 = 0.3;

/// Share of the elastic energy that may be apparent only: 0.75^2.
pub const APPARENT: f64 = 0.5625;

/// Tolerated share of sum m |g.x|: far above the round-off of the sums, far below any energy that matters.
const ROUND_OFF: f64 = 1e-9;

/// Contacts of a sphere with as many equal ones as can touch it.
const MOST_CONTACTS: f64 = 12.0;

/// Tolerated standard errors of the dissipated energy.
const DEVIATIONS: f64 = 5.0;

/// Limits and state of the watchdog.
#[derive(Resource, Debug, Deserialize, Serialize)]
struct WatchdogState {
    /// Steps between two checks of the energy.
    every: u64,
    /// Largest created share of the energy input.
    energy: f64,
    /// Largest overlap ratio.
    overlap: f64,
    /// Largest energy dissipated so far, J.
    dissipated: f64,
    /// Largest energy input so far, J.
    input: f64,
    /// Largest energy released by attractive contacts so far, J: minus the lowest elastic energy.
    bound: f64,
    has_warned: bool,
}

/// Energies of all grains, J.
#[derive(Clone, Copy, Debug, Default)]
struct Energies {
    kinetic: f64,
    potential: f64,
    elastic: f64,
    /// Sum of m |g.x|.
    magnitude: f64,
    /// Tolerated error of the dissipated energy.
    uncertain: f64,
}

impl Energies {
    fn of<V: Space>(survey: &Survey<V>, gravity: V, uncertain: f64) -> Self {
        let store = survey.store;
        let mut held = Self { elastic: survey.elastic_energy(|_, _| true), uncertain, ..Self::default() };
        for i in store.integrated_rows() {
            let body = &store.body[i];
            let fall = store.mass[i] * gravity.dot(body.position);
            held.kinetic += 0.5 * store.mass[i] * body.velocity.length_squared() + store.rotational_energy(i);
            held.potential -= fall;
            held.magnitude += fall.abs();
        }
        held
    }
}

impl WatchdogState {
    /// Returns the created energy, J, if it exceeds the limit. `round_off` returns the energy that round-off of places may have created.
    fn created(&mut self, held: &Energies, flows: &EnergyFlows, round_off: impl FnOnce() -> f64) -> Option<f64> {
        self.dissipated = self.dissipated.max(flows.dissipated);
        self.bound = self.bound.max(-held.elastic);
        let in_springs = held.elastic.max(0.0);
        let returned = (self.dissipated - flows.dissipated - in_springs).max(0.0);
        let expected = flows.expected() - returned;
        self.input = self.input.max(expected - held.potential + flows.dissipated + returned);
        let elastic = if held.elastic > 0.0 { (1.0 - APPARENT) * held.elastic } else { held.elastic };
        let counted = held.kinetic + held.potential + elastic;
        let created = if counted - expected < returned { returned } else { counted - expected };
        // Written so that the check fails if sums overflow to infinity or their difference is NaN.
        let limit = self.energy * (self.input + self.bound) + ROUND_OFF * held.magnitude + held.uncertain;
        let is_small = created <= limit || created <= limit + round_off();
        (!is_small).then_some(created)
    }
}

impl WatchdogState {
    /// Returns whether an overlap ratio calls for a failure or for the first warning.
    fn needs_report(&self, ratio: f64) -> bool {
        ratio > self.overlap || (ratio > LARGE_OVERLAP && !self.has_warned)
    }
}

/// Run condition: a check is due. Most steps cost no more than this test.
fn is_check_due(
    clock: Res<Clock>,
    largest: Res<LargestOverlap>,
    state: Res<WatchdogState>,
    outcome: Res<Outcome>,
) -> bool {
    clock.steps.is_multiple_of(state.every) || state.needs_report(largest.0) || outcome.end().is_some()
}

/// Checks overlap and energy.
fn check<V: Space>(
    (clock, gravity): (Res<Clock>, Res<Gravity<V>>),
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
    let ratio = largest.0;
    let uncertain = DEVIATIONS * error.standard() + error.pending();
    if state.needs_report(ratio) {
        state.has_warned = true;
        if let Some(failure) = check_overlap(&survey, &clock, ratio, state.overlap) {
            outcome.fail(failure);
        }
    }
    if is_energy_due
        && state.energy < f64::INFINITY
        && let Some(flows) = flows
        && let Some(created_j) =
            state.created(&Energies::of(&survey, gravity.0, uncertain), &flows, || round_off(&survey, clock.steps))
        && let Some(failure) = energy_failure(&survey, &clock, created_j, state.input)
    {
        outcome.fail(failure);
    }
}

/// Returns the energy that round-off of places may have created in so many steps, J.
fn round_off<V: Space>(survey: &Survey<V>, steps: u64) -> f64 {
    let store = survey.store;
    let in_a_step = |i: usize| {
        let body = &store.body[i];
        let reduced_mass = store.mass[i];
        let depth = 4.0 * f64::EPSILON * (body.position.length() + body.radius);
        // The speed v of an impact that is so deep, v = w0(v) d. It converges fast, because w0 hardly depends on v, for Hertz as v^(1/5).
        let speed = (0..8).fold(depth, |speed, _| {
            depth * survey.law.frequency(&Bounce { reduced_mass, reduced_radius: body.radius, speed })
        });
        Some(0.5 * reduced_mass * speed * speed).filter(|energy| energy.is_finite()).unwrap_or(0.0)
    };
    let all: f64 = store.integrated_rows().map(in_a_step).sum();
    #[expect(clippy::cast_precision_loss, reason = "2^53 steps are out of reach")]
    let steps = steps as f64 + 1.0;
    steps * MOST_CONTACTS * all
}

/// Returns the failure; `None` if no grain is left.
fn energy_failure<V: Space>(survey: &Survey<V>, clock: &Clock, created_j: f64, put_in_j: f64) -> Option<Failure> {
    let store = survey.store;
    let fastest = store.integrated_rows().max_by(|&a, &b| {
        let speed = |i: usize| store.body[i].velocity.length_squared();
        speed(a).total_cmp(&speed(b))
    })?;
    let speed_m_s = store.body[fastest].velocity.length();
    let reduced_mass = store.mass[fastest];
    let reduced_radius = store.body[fastest].radius;
    let stiffness = clock.dt * survey.law.frequency(&Bounce { reduced_mass, reduced_radius, speed: speed_m_s });
    let grain = store.id[fastest];
    Some(Failure::EnergyGrew { step: clock.steps, grain, speed_m_s, created_j, put_in_j, stiffness })
}

/// Returns a failure if the overlap ratio exceeds `limit`, and warns otherwise.
fn check_overlap<V: Space>(survey: &Survey<V>, clock: &Clock, ratio: f64, limit: f64) -> Option<Failure> {
    let step = clock.steps;
    let (grain, partner) = deepest(survey)?;
    if ratio > limit {
        let remedy = if clock.is_step_zero() {
            "they overlap at the start: move them apart"
        } else {
            "stiffen the contacts, lower `step`, or let grains fall less far"
        };
        return Some(Failure::TooDeep { step, grain, partner, ratio, limit, remedy });
    }
    tracing::warn!(
        "step {step}: {grain} and {partner} overlap by {ratio:.2} of the smaller radius; the contact law is meant for \
         small overlaps"
    );
    None
}

/// Returns the grain of the deepest present contact, and its partner in words.
fn deepest<V: Space>(survey: &Survey<V>) -> Option<(GrainId, String)> {
    let mut deepest = 0.0;
    let mut contact = None;
    survey.contacts(|i, partner, pair, _| {
        let ratio = pair.overlap / pair.radii[0].min(pair.radii[1]);
        if ratio > deepest {
            (deepest, contact) = (ratio, Some((i, partner)));
        }
    });
    let store = survey.store;
    contact.map(|(i, partner)| match partner {
        Partner::Particle(j) => (store.id[i], store.id[j].to_string()),
        Partner::Wall(_) => (store.id[i], "a wall surface".to_owned()),
    })
}

/// Checks energy and overlap.
pub struct WatchdogPlugin<V: Space>(pub Watchdog, pub PhantomData<V>);

impl<V: Space> Plugin for WatchdogPlugin<V> {
    fn build(&self, app: &mut App) {
        let Watchdog { every, energy, overlap } = self.0;
        let limit = |share: Option<Positive>| share.map_or(f64::INFINITY, Positive::get);
        app.insert_resource(WatchdogState {
            every: u64::from(every.get()),
            energy: limit(energy),
            overlap: limit(overlap),
            dissipated: 0.0,
            input: 0.0,
            bound: 0.0,
            has_warned: overlap.is_none(),
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

#[cfg(test)]
mod tests {
    use super::*;

    fn fresh() -> WatchdogState {
        WatchdogState {
            every: 100,
            energy: 0.1,
            overlap: 1.0,
            dissipated: 0.0,
            input: 0.0,
            bound: 0.0,
            has_warned: false,
        }
    }

    fn held(kinetic: f64, potential: f64) -> Energies {
        Energies { kinetic, potential, magnitude: potential.abs(), ..Energies::default() }
    }

    #[test]
    fn only_energy_without_a_source_counts() {
        // A grain enters with 2 J of motion at 10 J of height and falls to 4 J. The input is 8 J, so K may be 8 J plus
        // a tenth.
        let flows = EnergyFlows { released: 12.0, ..EnergyFlows::default() };
        assert_eq!(fresh().created(&held(8.7, 4.0), &flows, || 0.0), None);
        let created = fresh().created(&held(8.9, 4.0), &flows, || 0.0).expect("too much");
        // Three sums of numbers around 10.
        assert!((created - 0.9).abs() < 1e-14, "{created}");
        // Only 0.4375 of the apparent elastic energy counts: 1.75 J of 4 J.
        let springs = |kinetic: f64| Energies { elastic: 4.0, ..held(kinetic, 4.0) };
        assert_eq!(fresh().created(&springs(7.0), &flows, || 0.0), None);
        assert!(fresh().created(&springs(7.1), &flows, || 0.0).is_some());
        // Missing energy is a loss, not a gain.
        assert_eq!(fresh().created(&held(1.0, 4.0), &flows, || 0.0), None);
        // The work of a wall is energy input.
        assert_eq!(fresh().created(&held(8.9, 4.0), &EnergyFlows { wall_work: 1.0, ..flows }, || 0.0), None);
    }

    #[test]
    fn drag_cannot_return_energy() {
        let mut state = fresh();
        let flows = |dissipated: f64| EnergyFlows { released: 2.0, dissipated, ..EnergyFlows::default() };
        assert_eq!(state.created(&held(1.0, 0.0), &flows(1.0), || 0.0), None);
        // The balance closes, 2 J = 1.5 J + 0.5 J, because an unstable drag has returned the energy that it dissipated.
        assert!(state.created(&held(1.5, 0.0), &flows(0.5), || 0.0).is_some());
        // The present form of the energy does not matter.
        assert_eq!(state.created(&held(0.0, 0.0), &flows(0.5), || 0.0), Some(0.5));
        // A spring stretched by a sliding dashpot will return its energy to the drag.
        assert_eq!(state.created(&Energies { elastic: 0.5, ..held(1.0, 0.0) }, &flows(0.5), || 0.0), None);
    }

    #[test]
    fn attraction_is_an_energy_input() {
        let bound = |kinetic: f64, elastic: f64| Energies { elastic, ..held(kinetic, 0.0) };
        let mut state = fresh();
        // The grains start 1 J below zero, and their motion has the energy that the attraction released.
        let flows = EnergyFlows { released: -1.0, ..EnergyFlows::default() };
        assert_eq!(state.created(&bound(0.0, -1.0), &flows, || 0.0), None);
        assert_eq!(state.created(&bound(1.0, -2.0), &flows, || 0.0), None);
        assert_eq!(state.created(&bound(1.1, -2.0), &flows, || 0.0), None);
        assert!(state.created(&bound(1.3, -2.0), &flows, || 0.0).is_some());
        // Drag has dissipated the energy.
        assert_eq!(state.created(&bound(0.0, -2.0), &EnergyFlows { dissipated: 1.0, ..flows }, || 0.0), None);
    }

    #[test]
    fn infinite_energies_exceed_the_limit() {
        let flows = EnergyFlows { released: f64::INFINITY, ..EnergyFlows::default() };
        assert!(fresh().created(&held(f64::INFINITY, 0.0), &flows, || 0.0).is_some());
    }

    #[test]
    fn the_height_of_zero_does_not_matter_beyond_round_off() {
        for zero in [0.0, 1e6, -1e6] {
            let flows = EnergyFlows { released: zero + 1.0, ..EnergyFlows::default() };
            assert_eq!(fresh().created(&held(1.0, zero), &flows, || 0.0), None, "{zero}");
            assert!(fresh().created(&held(1.2, zero), &flows, || 0.0).is_some(), "{zero}");
        }
    }

    #[test]
    fn errors_of_the_measure_are_tolerated() {
        let flows = EnergyFlows { dissipated: 0.2, ..EnergyFlows::default() };
        let unsure = |uncertain: f64| Energies { uncertain, ..held(0.0, 0.0) };
        // The energy balance has dissipated 0.2 J that never were there.
        assert_eq!(fresh().created(&unsure(0.2), &flows, || 0.0), None);
        assert!(fresh().created(&unsure(0.1), &flows, || 0.0).is_some());
        assert_eq!(fresh().created(&unsure(0.0), &flows, || 0.2), None);
        assert!(fresh().created(&unsure(0.0), &flows, || 0.1).is_some());
        assert!(fresh().created(&held(f64::NAN, 0.0), &flows, || f64::INFINITY).is_some());
    }
}
