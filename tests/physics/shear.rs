//! A sheared bed with damping, friction and rolling resistance: where its energy goes, and how well the books balance.
//!
//! The books (trapezoidal rule, full-step velocities) are exact for springs of fixed direction, but for what this file bounds.

use crate::motion;
use crate::sheared_bed::{Bed, DT, E, K, K_R, K_T, MU, MU_R, Near};
use siloflow::energy::{Channels, EnergyFlows};
use siloflow::measure::totals;
use siloflow::prelude::*;

const STEPS: u64 = 10_000;
/// Steps between two looks at the books.
const LOOK: u64 = 100;

/// What the books may be off by, summed over the contacts that opened or closed, J.
#[derive(Default)]
struct Bound {
    touching: Vec<bool>,
    events: f64,
    /// What closing contacts put into their tangential and rolling springs at once.
    sprung: f64,
    fastest: f64,
}

impl Bound {
    fn look(&mut self, bed: &mut Bed) {
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
        // The normal spring begins or ends at a share s of the step, which the trapezoidal rule takes for a whole one:
        // k D^2 s (1 - s)/2 with D = v_n dt, k D^2/8 at most.
        self.events += K * (approach * DT).powi(2) / 8.0;
        if closes {
            // A contact closes with hardly any normal force, so a force cut to next to nothing: the law then sets the springs
            // against their dashpots, k S = -c v.
            self.sprung += (c * slip).powi(2) / (2.0 * K_T) + (c * roll).powi(2) / (2.0 * K_R);
        } else {
            // The force of the other two springs acts for half a step after they were last booked: on the speeds v_t and v_r.
            // k S = F + c v, where F was cut to mu F_n and F_n came from an overlap of v_n dt at most.
            let press = K * approach * DT;
            self.events += 0.5 * DT * (slip * (MU * press + c * slip) + roll * (MU_R * press + c * roll));
        }
    }

    /// All that the books may be off by, for the work lost along normals and the elastic energy so far, J.
    fn total(&self, normal: f64, elastic: f64) -> f64 {
        // The tangent turns by v dt/d in a step, of which springs see one end: a share v dt/(2 d) of mu times the work through
        // normal springs, (1 + e^2)/(1 - e^2) times what restitution takes of it. d is 0.072 m at least.
        let turning = 0.5 * MU * self.fastest * DT / 0.072 * (1.0 + E * E) / (1.0 - E * E) * normal;
        // Verlet conserves half-step energies; at full steps they differ by F^2 dt^2/(8 m) and the trapezoid's last half step
        // by twice that: (w0 dt)^2/2 of the elastic energy, for the lightest pair.
        let ends = 0.5 * K / (0.5 * 100.0 * 0.036f64.powi(2)) * DT * DT * elastic;
        self.events + turning + ends
    }
}

/// Normal, tangential and rolling dissipation so far, J.
fn dissipated(world: &World) -> [f64; 3] {
    let (flows, channels) = (world.resource::<EnergyFlows>(), world.resource::<Channels>());
    [flows.dissipated - channels.tangential - channels.rolling, channels.tangential, channels.rolling]
}

/// Shears a bed and checks its books every [`LOOK`] steps.
fn shear(solid: bool, gamma: f64, steps: u64) {
    let mut bed = Bed::new(solid, gamma);
    let (mut bound, mut last, mut sprung) = (Bound::default(), [0.0; 3], 0.0);
    for step in 0..=steps {
        bed.simulation.run_steps(step);
        bound.look(&mut bed);
        if step % LOOK > 0 {
            continue;
        }
        let totals = totals::of_world(bed.simulation.world_mut());
        let world = bed.simulation.world();
        let now = dissipated(world);
        let error = totals.energy() - world.resource::<EnergyFlows>().expected();
        // 1e-12: some ten joule, summed over as many terms, to round-off.
        let tolerance = bound.total(now[0], totals.elastic) + 1e-12;
        assert!(
            error.abs() < tolerance,
            "solid {solid}, gamma {gamma}, step {step}: off by {error:e} J, not {tolerance:e} J"
        );
        // Drag takes, friction takes, but for what closing contacts sprang into their springs, which comes back later; and
        // where a speed turns, its half-step value has the other sign still: a share (w0 dt)^2 dt/(8 t_c) < 1e-5 of a swing.
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
    assert!(work > 1.0 && last.iter().all(|&channel| channel > 0.1), "not sheared: {work} J, dissipated {last:?} J");
}

#[test]
fn the_books_of_a_sheared_plane_balance_to_second_order_without_tangential_dashpots() {
    shear(false, 0.0, STEPS);
}

#[test]
fn the_books_of_a_sheared_plane_balance() {
    shear(false, 50.0, STEPS);
}

#[test]
fn the_books_of_sheared_spheres_balance() {
    shear(true, 50.0, STEPS);
}

/// Fifty seconds of shear: `cargo test --release --test physics -- --ignored million`.
#[test]
#[ignore = "a million steps take minutes"]
fn the_books_of_a_sheared_bed_balance_for_a_million_steps() {
    shear(false, 50.0, 1_000_000);
    shear(true, 50.0, 1_000_000);
}
