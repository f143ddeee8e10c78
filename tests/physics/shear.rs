//! A sheared bed with damping, friction and rolling resistance: where its energy goes, and the error of the energy
//! balance.
//!
//! The energy balance (trapezoidal rule, full-step velocities) is exact for springs of fixed direction, apart from the
//! errors bounded in this file.

use crate::motion;
use crate::sheared_bed::{Bed, DT, E, K, K_R, K_T, MU, MU_R, Near};
use siloflow::energy::{Channels, EnergyFlows};
use siloflow::measure::totals;
use siloflow::prelude::*;

const STEPS: u64 = 10_000;
/// Steps between two checks of the energy balance.
const CHECK_INTERVAL: u64 = 100;

/// Bound of the error of the energy balance, summed over the contacts that opened or closed, J.
#[derive(Default)]
struct Bound {
    touching: Vec<bool>,
    events: f64,
    /// Energy that closing contacts put into their tangential and rolling springs at once, J.
    sprung: f64,
    fastest: f64,
}

impl Bound {
    fn update(&mut self, bed: &mut Bed) {
        let state = motion(&mut bed.simulation);
        self.fastest = state.iter().map(|now| now.velocity.length()).fold(self.fastest, f64::max);
        let mut touching = std::mem::take(&mut self.touching);
        let first = touching.is_empty();
        bed.each_pair(&state, |pair, near| {
            let touches = near.gap < 0.0;
            if first {
                touching.push(touches);
            } else if touches != touching[pair] {
                touching[pair] = touches;
                self.event(near, bed.gamma, touches);
            }
        });
        self.touching = touching;
    }

    fn event(&mut self, near: &Near, gamma: f64, closes: bool) {
        let n = near.normal.normalize();
        let approach = near.velocity.dot(n).abs();
        let slip = (near.velocity - near.velocity.dot(n) * n - near.turning.cross(n)).length();
        let roll = near.rolling.cross(n).length();
        let c = gamma * near.mass;
        // The normal spring begins or ends at a share s of a step, which the trapezoidal rule counts as a whole step.
        // The error is k D^2 s (1 - s)/2 with D = v_n dt, at most k D^2/8.
        self.events += K * (approach * DT).powi(2) / 8.0;
        if closes {
            // A contact closes with almost no normal force, so its tangential force is cut to almost zero. The law then
            // sets the springs against their dashpots: k S = -c v.
            self.sprung += (c * slip).powi(2) / (2.0 * K_T) + (c * roll).powi(2) / (2.0 * K_R);
        } else {
            // The forces of the other two springs act for half a step after they were last counted, on the speeds v_t
            // and v_r. k S = F + c v, where F was cut to mu F_n and F_n came from an overlap of v_n dt at most.
            let press = K * approach * DT;
            self.events += 0.5 * DT * (slip * (MU * press + c * slip) + roll * (MU_R * press + c * roll));
        }
    }

    /// Returns the bound of the error of the energy balance, J, given the normal dissipation and the elastic energy so
    /// far, J.
    fn total(&self, normal: f64, elastic: f64) -> f64 {
        // The tangent turns by v dt/d in a step, and springs are evaluated at one end of it. The error is a share v
        // dt/(2 d) of mu times the work through normal springs. That work is (1 + e^2)/(1 - e^2) times the normal
        // dissipation. d is 0.072 m or more.
        let turning = 0.5 * MU * self.fastest * DT / 0.072 * (1.0 + E * E) / (1.0 - E * E) * normal;
        // Verlet conserves half-step energies. At full steps they differ by F^2 dt^2/(8 m), and the last half step of
        // the trapezoid by twice that: (w0 dt)^2/2 of the elastic energy, for the lightest pair.
        let ends = 0.5 * K / (0.5 * 100.0 * 0.036f64.powi(2)) * DT * DT * elastic;
        self.events + turning + ends
    }
}

/// Returns normal, tangential and rolling dissipation so far, J.
fn dissipated(world: &World) -> [f64; 3] {
    let flows = world.resource::<EnergyFlows>();
    let channels = world.resource::<Channels>();
    [flows.dissipated - channels.tangential - channels.rolling, channels.tangential, channels.rolling]
}

/// Shears a bed and checks its energy balance every [`CHECK_INTERVAL`] steps.
fn shear(solid: bool, gamma: f64, steps: u64) {
    let mut bed = Bed::new(solid, gamma);
    let mut bound = Bound::default();
    let mut last = [0.0; 3];
    let mut sprung = 0.0;
    for step in 0..=steps {
        bed.simulation.run_steps(step);
        bound.update(&mut bed);
        if step % CHECK_INTERVAL > 0 {
            continue;
        }
        let totals = totals::of_world(bed.simulation.world_mut());
        let world = bed.simulation.world();
        let now = dissipated(world);
        let error = totals.energy() - world.resource::<EnergyFlows>().expected();
        // 1e-12: the round-off of about ten joule summed over as many terms.
        let tolerance = bound.total(now[0], totals.elastic) + 1e-12;
        assert!(
            error.abs() < tolerance,
            "solid {solid}, gamma {gamma}, step {step}: off by {error:e} J, not {tolerance:e} J"
        );
        // Dissipation does not decrease, apart from the energy that closing contacts put into their springs, which is
        // returned later. Where a speed changes sign, its half-step value still has the old sign: a share (w0 dt)^2
        // dt/(8 t_c) < 1e-5 of an oscillation.
        for (channel, (before, after)) in ["normal", "tangential", "rolling"].iter().zip(last.iter().zip(now)) {
            let back = if *channel == "normal" { 0.0 } else { bound.sprung - sprung };
            assert!(
                after - before > -back - 1e-5 * after - 1e-12,
                "{channel}, step {step}: from {before} to {after} J"
            );
        }
        (last, sprung) = (now, bound.sprung);
    }
    let work = bed.simulation.world().resource::<EnergyFlows>().wall_work;
    assert!(
        work > 1.0 && last.iter().all(|&channel| channel > 0.1),
        "too little shear: {work} J, dissipated {last:?} J"
    );
}

#[test]
fn energy_balance_of_sheared_discs_closes_to_second_order_without_tangential_dashpots() {
    shear(false, 0.0, STEPS);
}

#[test]
fn energy_balance_of_sheared_discs_closes() {
    shear(false, 50.0, STEPS);
}

#[test]
fn energy_balance_of_sheared_spheres_closes() {
    shear(true, 50.0, STEPS);
}

/// Fifty seconds of shear. Run with `cargo test --release --test physics -- --ignored million`.
#[test]
#[ignore = "a million steps take minutes"]
fn energy_balance_of_a_sheared_bed_closes_for_a_million_steps() {
    shear(false, 50.0, 1_000_000);
    shear(true, 50.0, 1_000_000);
}
