//! The check of the watchdog for energy without a source, every `every` steps and at the end of the run.
//!
//! *Created energy* is the kinetic, gravitational and part of the elastic energy, minus the energy expected from the
//! energy flows ([`EnergyFlows::expected`]), all in J. Velocity Verlet conserves K + (1 - q) E_elastic with
//! q = (w0 dt)^2/4, so a contact in progress seems to gain up to q of its elastic energy. The share [`APPARENT`] of
//! the elastic energy is therefore not counted; it equals q at three quarters of the stability limit.
//!
//! Drag cannot return energy, but an unstable drag does negative work. The largest dissipated energy so far therefore
//! stays dissipated, and any decrease counts as created. Energy in springs is excepted: if the dashpot alone of a
//! sliding contact exceeds the cap, it stretches its spring, and the balance counts the energy of the spring as
//! returned.
//!
//! The run stops if the created energy exceeds the share `energy` of the *input*. The input is the energy of motion
//! and springs of grains that entered, plus the work of gravity, walls, belts and added forces. It equals
//! expected - gravitational + dissipated; the largest value so far counts. Attraction between grains has negative
//! elastic energy; its largest magnitude so far is added. The input does not depend on the zero of height.
//!
//! Errors of the measure itself are tolerated:
//! + Round-off of heights, 1e-9 sum m |g.x|.
//! + Round-off of places. Without gravity nothing else may be left, as in a bed that touches exactly. A place x is known to eps |x|, and
//!   each step rounds anew. In each step each grain so may get the energy with which it would squeeze its contacts by d = 4 eps (|x| + R), for
//!   a linear law k d^2/2 each, with twelve contacts. That is far below all energies of a scene, whatever its units.
//! + The error of the dissipated energy where only some steps sum it: five standard errors, and what the steps since the last sample
//!   have added ([`crate::energy::sampling`]).
//!
//! Healthy runs stay far below the limit. Checked every 100 steps, these runs create less than 1e-3 of the input:
//! `silo1` with its mixture and polydisperse variants, `couette`, `column`, and the first tenth of a second of `silo2d`
//! and `bed3d` (`--set 'watchdog=(every: 100, energy: 1.0e-3)'` does not stop them).

use serde::{Deserialize, Serialize};

use crate::energy::EnergyFlows;
use siloflow_dem::contact::Bounce;
use siloflow_dem::outcome::Failure;
use siloflow_dem::space::Space;
use siloflow_dem::step::Clock;
use siloflow_dem::survey::Survey;
use siloflow_dem::threads::Threads;

/// Share of the elastic energy that may be apparent only: 0.75^2.
pub const APPARENT: f64 = 0.5625;

/// Tolerated share of sum m |g.x|: far above the round-off of the sums, far below any energy that matters.
const ROUND_OFF: f64 = 1e-9;

/// Contacts of a sphere with as many equal ones as can touch it.
const MOST_CONTACTS: f64 = 12.0;

/// Limit and state of the check.
#[derive(Debug, Deserialize, Serialize)]
pub(super) struct EnergyCheck {
    /// Largest created share of the energy input; infinite if energy is not checked.
    limit: f64,
    /// Largest energy dissipated so far, J.
    dissipated: f64,
    /// Largest energy input so far, J.
    input: f64,
    /// Largest energy released by attractive contacts so far, J: minus the lowest elastic energy.
    bound: f64,
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
    fn of<V: Space>(survey: &Survey<V>, threads: &Threads, gravity: V, uncertain: f64) -> Self {
        let store = survey.store;
        let mut held = Self { elastic: survey.whole_elastic_energy(threads), uncertain, ..Self::default() };
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

impl EnergyCheck {
    /// Returns the check with a limit, at the start of a run.
    pub(super) fn new(limit: f64) -> Self {
        Self { limit, dissipated: 0.0, input: 0.0, bound: 0.0 }
    }

    /// Whether energy is checked.
    pub(super) fn is_on(&self) -> bool {
        self.limit < f64::INFINITY
    }

    /// Returns the failure of a run that has created energy beyond the limit. `uncertain` is the tolerated error of the dissipated
    /// energy, J.
    pub(super) fn failure<V: Space>(
        &mut self,
        survey: &Survey<V>,
        threads: &Threads,
        clock: &Clock,
        gravity: V,
        flows: &EnergyFlows,
        uncertain: f64,
    ) -> Option<Failure> {
        let held = Energies::of(survey, threads, gravity, uncertain);
        let created = self.created(&held, flows, || round_off(survey, clock.steps))?;
        failure(survey, clock, created, self.input)
    }

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
        let limit = self.limit * (self.input + self.bound) + ROUND_OFF * held.magnitude + held.uncertain;
        let is_small = created <= limit || created <= limit + round_off();
        (!is_small).then_some(created)
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
fn failure<V: Space>(survey: &Survey<V>, clock: &Clock, created_j: f64, put_in_j: f64) -> Option<Failure> {
    let store = survey.store;
    let movable = store.integrated_rows();
    let fastest = movable.max_by(|&a, &b| {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn fresh() -> EnergyCheck {
        EnergyCheck::new(0.1)
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
