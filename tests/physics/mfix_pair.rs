//! The stacked pair: case DEM03 of MFiX's verification manual (Garg, Galvin, Li and Pannala, Powder Technology 220,
//! 122, 2012). Two balls, one on the other, are squeezed between a floor and a lid. They start at rest away from
//! equilibrium and oscillate. The reference is a Runge-Kutta solution. No contact opens, so the only error is the one
//! of the scheme.

use std::f64::consts::PI;

use siloflow::dem::space::Solid;
use siloflow::prelude::*;

use crate::{grain, motion, simulation, sphere};

const G: f64 = 9.81;
const RADIUS: f64 = 0.5e-3;
const K: f64 = 1.0e3;
const TOP: f64 = 3.6 * RADIUS;

/// Initial distance of both balls together from equilibrium: 0.4 R of overlap shared by three equal springs, against
/// 0.1 R at floor and lid. No oscillation is larger.
const AWAY: f64 = 2.0 * (0.4 * RADIUS / 3.0 - 0.1 * RADIUS);
const PERIODS: u32 = 6;

/// Returns zeta for the restitution `e`, with attraction.
fn zeta(e: f64) -> f64 {
    -e.ln() / (PI * PI + e.ln().powi(2)).sqrt()
}

/// Masses of the lower and the upper ball, kg.
fn masses() -> [f64; 2] {
    [20000.0, 10000.0].map(|density| density * 4.0 / 3.0 * PI * RADIUS.powi(3))
}

/// Returns the heights after `steps` steps of `dt` by Runge-Kutta, from rest at a quarter and three quarters of the
/// height. All three contacts must last.
fn reference(e: f64, dt: f64, steps: u32) -> [f64; 2] {
    let [m1, m2] = masses();
    let drag = |m: f64| 2.0 * zeta(e) * (K * m).sqrt();
    let wall_1 = drag(m1);
    let wall_2 = drag(m2);
    let between = drag(m1 * m2 / (m1 + m2));
    let rates = |[y1, y2, v1, v2]: [f64; 4]| {
        let pair = K * (2.0 * RADIUS - (y2 - y1)) + between * (v1 - v2);
        let floor = K * (RADIUS - y1) - wall_1 * v1;
        let lid = K * (RADIUS - (TOP - y2)) + wall_2 * v2;
        [v1, v2, (floor - pair) / m1 - G, (pair - lid) / m2 - G]
    };
    let mut y = [0.25 * TOP, 0.75 * TOP, 0.0, 0.0];
    for _ in 0..steps {
        let ahead = |rates: [f64; 4], h: f64| std::array::from_fn(|i| y[i] + h * rates[i]);
        let r1 = rates(y);
        let r2 = rates(ahead(r1, 0.5 * dt));
        let r3 = rates(ahead(r2, 0.5 * dt));
        let r4 = rates(ahead(r3, dt));
        y = std::array::from_fn(|i| y[i] + dt / 6.0 * (r1[i] + 2.0 * r2[i] + 2.0 * r3[i] + r4[i]));
        assert!(y[0] < RADIUS && TOP - y[1] < RADIUS && y[1] - y[0] < 2.0 * RADIUS, "a contact opened");
    }
    [y[0], y[1]]
}

/// Returns the largest distance of the heights from the reference, with `n` steps per period of the fastest mode.
fn largest_error(scheme: &str, space: &str, e: f64, n: u32) -> f64 {
    let [m1, m2] = masses();
    // The fastest mode is slower than sqrt(3 k/m) of the lighter ball (Gershgorin).
    let w = (3.0 * K / m2).sqrt();
    let dt = 2.0 * PI / w / f64::from(n);
    let contact = format!("contact: Linear(k: {K:?}, damping: Restitution({e:?}), attraction: Allowed)");
    let end = format!("integrator: {scheme}, step: Fixed({dt:?}), until: 1.0");
    let mut simulation = if space == "Solid" {
        let rows = vec![
            sphere(1, Solid::Z * 0.25 * TOP, Solid::ZERO, RADIUS, m1),
            sphere(2, Solid::Z * 0.75 * TOP, Solid::ZERO, RADIUS, m2),
        ];
        let keys = format!(
            "space: Solid, gravity: (0.0, 0.0, -{G}), {contact}, walls: [HalfPlane(point: (0.0, 0.0, 0.0), normal: \
             (0.0, 0.0, 1.0)), HalfPlane(point: (0.0, 0.0, {TOP:?}), normal: (0.0, 0.0, -1.0))], {end}"
        );
        simulation(&keys, rows)
    } else {
        let rows = vec![
            grain(1, Vector::Y * 0.25 * TOP, Vector::ZERO, RADIUS, m1),
            grain(2, Vector::Y * 0.75 * TOP, Vector::ZERO, RADIUS, m2),
        ];
        let keys = format!(
            "gravity: (0.0, -{G}), {contact}, walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0)), \
             HalfPlane(point: (0.0, {TOP:?}), normal: (0.0, -1.0))], {end}"
        );
        simulation(&keys, rows)
    };
    let mut largest = 0.0f64;
    for sample in 1..=10 * PERIODS {
        let steps = sample * n / 10;
        simulation.run_steps(u64::from(steps));
        let exact = reference(e, dt, steps);
        for (ball, exact) in motion(&mut simulation).iter().zip(exact) {
            let y = if space == "Solid" { ball.position.z } else { ball.position.y };
            largest = largest.max((y - exact).abs());
        }
    }
    largest
}

#[test]
fn stacked_pair_between_walls_converges_to_the_reference_solution() {
    for (scheme, space) in [("Verlet", "Solid"), ("Verlet", "Plane"), ("Centred", "Solid"), ("Centred", "Plane")] {
        for e in [1.0, 0.9, 0.7, 0.5] {
            let coarse = largest_error(scheme, space, e, 200);
            let fine = largest_error(scheme, space, e, 800);
            let w_dt = 2.0 * PI / 200.0;
            // Verlet's phase error is (w dt)^2/24 of w t. Centred damping has an error of second order too, which
            // matters up to w t = 1/zeta. In Verlet the damping acts at v(t - dt/2), which adds a force c a dt/2 in
            // resonance. It shifts an oscillation of amplitude A by dt/2 zeta w^2 t A exp(-zeta w t), at most A w dt/(2
            // e) = 0.18 A w dt. Damping that is not proportional to the stiffness couples the two modes, which adds a
            // third.
            let is_second = e == 1.0 || scheme == "Centred";
            let tolerance =
                AWAY * if is_second { w_dt * w_dt * 2.0 * PI * f64::from(PERIODS) / 24.0 } else { 0.25 * w_dt };
            assert!(coarse < tolerance, "{scheme}, {space}, e = {e}: {coarse:e} m off, not {tolerance:e}");
            let order = (coarse / fine).ln() / 4.0f64.ln();
            let expected = if is_second { 2.0 } else { 1.0 };
            // The next order adds a share w dt to the coarse error; its logarithm over ln(4) is 0.02.
            assert!((order - expected).abs() < 0.05, "{scheme}, {space}, e = {e}: order {order:.3}");
        }
    }
}
