//! Head-on bounces of two grains, and of one grain off a wall, against the closed forms of the damped oscillator.

use std::f64::consts::PI;

use crate::{grain, rms, simulation};
use siloflow::dem::contact::LargestOverlap;
use siloflow::dem::store::ParticleStore;
use siloflow::energy::EnergyFlows;
use siloflow::measure::totals;
use siloflow::prelude::*;

const K: f64 = 1.0e5;
const V: f64 = 1.0;
const R: f64 = 0.04;
pub const MASSES: [f64; 2] = [0.16, 0.09];
const PHASES: u32 = 40;

#[derive(Clone, Copy, Debug)]
pub enum Against {
    Grain,
    Wall,
}

impl Against {
    fn reduced_mass(self) -> f64 {
        match self {
            Self::Grain => MASSES[0] * MASSES[1] / (MASSES[0] + MASSES[1]),
            Self::Wall => MASSES[0],
        }
    }
}

/// Closed form of the bounce, derived here from the differential equation `delta'' + 2 beta delta' + w0^2 delta = 0`.
struct Exact {
    duration: f64,
    largest_overlap: f64,
}

/// Returns `zeta` for a restitution. With attraction e = exp(-pi zeta/sqrt(1 - zeta^2)). Without it e = exp(-zeta/s (pi
/// - atan2(2 zeta s, 1 - 2 zeta^2))) with s = sqrt(1 - zeta^2). Both are solved by bisection.
fn zeta(e: f64, attraction: bool) -> f64 {
    if e == 1.0 {
        return 0.0;
    }
    let restitution = |z: f64| {
        let s = (1.0 - z * z).sqrt();
        let angle = if attraction { PI } else { PI - (2.0 * z * s).atan2(1.0 - 2.0 * z * z) };
        (-z / s * angle).exp()
    };
    let mut low = 0.0;
    let mut high = 0.999_999;
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if restitution(middle) > e { low = middle } else { high = middle }
    }
    low
}

fn exact(e: f64, attraction: bool, m: f64) -> Exact {
    let z = zeta(e, attraction);
    let w0 = (K / m).sqrt();
    let beta = z * w0;
    let w = w0 * (1.0 - z * z).sqrt();
    let angle = if attraction { PI } else { PI - (2.0 * beta * w).atan2(w * w - beta * beta) };
    Exact { duration: angle / w, largest_overlap: V / w0 * (-beta / w * (w / beta).atan()).exp() }
}

pub struct Bounce {
    pub restitution: f64,
    duration: f64,
    largest_overlap: f64,
    balance_error: f64,
    dissipated: f64,
}

/// Simulates one bounce that begins a share `phase` of a step after a whole step.
fn bounce(scheme: &str, against: Against, e: f64, attraction: bool, dt: f64, phase: f64) -> Bounce {
    let rule = if attraction { "Allowed" } else { "Forbidden" };
    let gap = V * dt * (1.0 + phase);
    let wall = "walls: [HalfPlane(point: (0.0, 0.0), normal: (1.0, 0.0))],";
    let (walls, grains) = match against {
        Against::Wall => (wall, vec![grain(1, Vector::new(R + gap, 0.0), Vector::new(-V, 0.0), R, MASSES[0])]),
        Against::Grain => (
            "",
            vec![
                grain(1, Vector::new(0.0, 0.0), Vector::ZERO, R, MASSES[0]),
                grain(2, Vector::new(1.75 * R + gap, 0.0), Vector::new(-V, 0.0), 0.75 * R, MASSES[1]),
            ],
        ),
    };
    let keys = format!(
        "gravity: (0.0, 0.0), contact: Linear(k: {K:?}, damping: Restitution({e:?}), attraction: {rule}), {walls} \
         integrator: {scheme}, step: Fixed({dt:?}), until: 1.0"
    );
    let mut simulation = simulation(&keys, grains);
    let duration = exact(e, attraction, against.reduced_mass()).duration;
    let mut steps_in_force = 0u32;
    // Long enough for separation, even if the overlap outlasts the force.
    for step in 0..(6.0 * duration / dt).ceil() as u64 {
        simulation.run_steps(step);
        steps_in_force += u32::from(simulation.world().resource::<ParticleStore>().loads.force.of(0) != Vector::ZERO);
    }
    let world = simulation.world_mut();
    let store = world.resource::<ParticleStore>();
    let entries = store.by_id();
    let parting =
        store.body[entries[0]].velocity.x - entries.get(1).map_or(0.0, |&second| store.body[second].velocity.x);
    let smaller = if matches!(against, Against::Grain) { 0.75 * R } else { R };
    let largest_overlap = world.resource::<LargestOverlap>().0 * smaller;
    let flows = *world.resource::<EnergyFlows>();
    Bounce {
        restitution: parting.abs() / V,
        duration: f64::from(steps_in_force) * dt,
        largest_overlap,
        balance_error: totals::of_world(world).energy() - flows.expected(),
        dissipated: flows.dissipated,
    }
}

/// Simulates all phases of a bounce with Verlet and `n` steps per contact; `n` is not commensurate with the phases.
fn bounces(against: Against, e: f64, attraction: bool, n: f64) -> (f64, Exact, Vec<Bounce>) {
    let exact = exact(e, attraction, against.reduced_mass());
    (exact.duration / n, exact, bounces_by("Verlet", against, e, attraction, n))
}

/// Returns the contact duration, s.
pub fn duration_of(against: Against, e: f64, attraction: bool) -> f64 {
    exact(e, attraction, against.reduced_mass()).duration
}

/// Simulates all phases of a bounce with any scheme.
pub fn bounces_by(scheme: &str, against: Against, e: f64, attraction: bool, n: f64) -> Vec<Bounce> {
    let dt = exact(e, attraction, against.reduced_mass()).duration / n;
    let phases = (0..PHASES).map(|phase| f64::from(phase) / f64::from(PHASES));
    phases.map(|phase| bounce(scheme, against, e, attraction, dt, phase)).collect()
}

pub const CASES: [(f64, bool); 8] =
    [(0.9, true), (0.5, true), (0.2, true), (1.0, true), (0.9, false), (0.5, false), (0.2, false), (1.0, false)];

#[test]
fn restitution_duration_and_overlap_match_the_closed_forms() {
    for against in [Against::Grain, Against::Wall] {
        for (e, attraction) in CASES {
            let (dt, exact, all) = bounces(against, e, attraction, 400.0 + PI / 8.0);
            let w0 = (K / against.reduced_mass()).sqrt();
            // Damping evaluated half a step late, and its jump at each end, contribute a relative error of zeta w0 dt
            // each: 3 zeta w0 dt together. Without damping the error is (w0 dt)^2.
            let order_one = 3.0 * zeta(e, attraction) * w0 * dt + (w0 * dt).powi(2);
            for b in &all {
                let case = format!("{against:?}, e = {e}, attraction {attraction}");
                assert!((b.restitution - e).abs() < order_one, "{case}: restitution {}", b.restitution);
                // Both ends are resolved to one step each.
                assert!((b.duration - exact.duration).abs() <= 2.0 * dt, "{case}: duration {}", b.duration);
                let overlap_error = (b.largest_overlap / exact.largest_overlap - 1.0).abs();
                assert!(overlap_error < order_one, "{case}: overlap off by {overlap_error}");
            }
        }
    }
}

#[test]
fn verlet_is_of_first_order_with_damping_and_of_second_order_without() {
    for against in [Against::Grain, Against::Wall] {
        for (e, attraction) in CASES {
            let error = |n: f64| {
                let all = bounces(against, e, attraction, n).2;
                rms(&all.iter().map(|b| b.restitution - e).collect::<Vec<_>>())
            };
            let coarse = error(40.0 + PI / 8.0);
            let fine = error(160.0 + PI / 8.0);
            let order = (coarse / fine).ln() / ((160.0 + PI / 8.0) / (40.0 + PI / 8.0)).ln();
            let expected = if e == 1.0 { 2.0 } else { 1.0 };
            // The next order adds a share of about w0 dt = pi/40 to the coarse error: ln(1.08)/ln(4) = 0.06 in the
            // order. The mean over 40 phases of errors that scatter by their own size adds 1/sqrt(40)/ln(4) = 0.11.
            assert!((order - expected).abs() < 0.2, "{against:?}, e = {e}, attraction {attraction}: order {order:.3}");
        }
    }
}

#[test]
fn energy_balance_error_agrees_with_theory() {
    // The trapezoidal rule is exact for a linear spring except in the step in which the contact opens or closes. There
    // it errs by k D^2 s (1 - s)/2 with D = v dt and phase s, k D^2/12 on average. The sign at the end of the contact
    // is opposite to the sign at its start. A bounce therefore loses k dt^2 (v_in^2 - v_out^2)/12 from the balance.
    for against in [Against::Grain, Against::Wall] {
        for e in [0.5, 0.2] {
            let (dt, _, all) = bounces(against, e, true, 40.0 + PI / 8.0);
            let mean = all.iter().map(|b| b.balance_error).sum::<f64>() / all.len() as f64;
            let expected = -K * dt * dt * V * V * (1.0 - e * e) / 12.0;
            // The term at the end is e^2 of the term at the start. The damping still acts at separation, so this term
            // is known to its order only: half of it. A tenth is for the next order, w0 dt = pi/40.
            let tolerance = (0.5 * e * e + 0.1) * K * dt * dt * V * V / 12.0;
            assert!((mean - expected).abs() < tolerance, "{against:?}, e = {e}: {mean:e} J, not {expected:e} J");
            let lost = 0.5 * against.reduced_mass() * V * V * (1.0 - e * e);
            let taken = all.iter().map(|b| b.dissipated).sum::<f64>() / all.len() as f64;
            // First order, as the restitution.
            assert!((taken / lost - 1.0).abs() < 0.1, "{against:?}, e = {e}: dissipated {taken} J, not {lost} J");
        }
    }
}
