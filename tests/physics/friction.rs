//! Friction of one grain on a plane: sliding that turns into rolling, sticking, steady sliding and creep.
//!
//! With q = I/(m R^2), a tangential force F_t changes the slip v_s = u - R w at the rate F_t (1 + 1/q)/m.

use std::f64::consts::E;

use crate::ride::{Case, G, M, MU, press_round_off, way_round_off};

const K_T: f64 = 2.9e4;

fn spring(k_t: f64, gamma: f64) -> String {
    format!("tangential: Spring(k: {k_t:?}, damping: PerMass({gamma:?}), friction: {MU:?})")
}

#[test]
fn sliding_sphere_ends_rolling_at_five_sevenths_and_disc_at_two_thirds_of_its_speed() {
    for case in Case::both(0.0) {
        let q = case.q();
        let u0 = 1.0;
        let dt = 2.0e-5;
        let slip_ends = u0 / (MU * G * (1.0 + 1.0 / q));
        let steps = (2.0 * slip_ends / dt) as u64;
        // F_t and its torque change u and q R w by opposite amounts for any F_t. So u + q R w = u0 holds up to
        // rounding: each of the two kicks of a step rounds both terms by half an ulp.
        let round_off = 2.0 * steps as f64 * f64::EPSILON * u0;

        // Without a dashpot the force first grows to its cap as k_t u0 t. The cap therefore acts as if it began half of
        // mu m g/(k_t u0) late. The steps resolve each end of the slide to one step.
        let late = 0.5 * MU * M * G / (K_T * u0);
        let mut ride = case.start(&spring(K_T, 0.0), dt, u0, 0.0);
        let halfway = ride.after((0.5 * slip_ends / dt) as u64);
        let expected = u0 - MU * G * (ride.time() - late);
        assert!((halfway.u - expected).abs() < MU * G * dt, "{case:?}: {} m/s, not {expected}", halfway.u);
        let sticks = ((0.5 * slip_ends / dt) as u64..steps).find(|&step| {
            let now = ride.after(step);
            assert!((now.u + q * now.roll - u0).abs() < round_off, "{case:?}, step {step}");
            now.u <= now.roll
        });
        let slid_for = sticks.unwrap() as f64 * dt;
        assert!((slid_for - slip_ends - late).abs() < 2.0 * dt, "{case:?}: slid for {slid_for} s, not {slip_ends} s");

        // The slip left at the end of the slide is at most the one released by a spring at its cap, v_s = w_t mu m
        // g/k_t. It decays with beta = gamma (1 + 1/q)/2 after the slide. The share of it in u is q/(1 + q).
        let gamma = 400.0;
        let last = case.start(&spring(K_T, gamma), dt, u0, 0.0).after(steps);
        let ringing = MU * G * (M / K_T * (1.0 + 1.0 / q)).sqrt();
        let beta = 0.5 * gamma * (1.0 + 1.0 / q);
        let left = ringing * (-beta * (steps as f64 * dt - slip_ends)).exp();
        let tolerance = q / (1.0 + q) * left + round_off;
        assert!((last.u - u0 / (1.0 + q)).abs() < tolerance, "{case:?}: ends at {} m/s", last.u);
        assert!((last.roll - u0 / (1.0 + q)).abs() < tolerance / q, "{case:?}: rolls at {} m/s", last.roll);
    }
}

#[test]
fn non_rotating_grain_sticks_below_its_friction_angle() {
    // Released at rest without damping, the spring's force would overshoot m g sin to twice its value and the grain
    // would slip. With overdamping the overshoot is at most 1/(4 zeta^2), 1.6 % here. That is the deceleration of a
    // body with speed g sin/gamma that decays at the rate w^2/gamma.
    for case in Case::both(0.98 * MU) {
        let zeta = 4.0;
        let w = (K_T / M).sqrt();
        let slow = w * (zeta - f64::sqrt(zeta * zeta - 1.0));
        let dt = 0.05 / (zeta * w);
        let end = 40.0 / slow;
        let steps = (end / dt) as u64;
        let now = case.start(&spring(K_T, 2.0 * zeta * w), dt, 0.0, 0.0).never_turning().after(steps);
        // The slow root contributes less than 1.1 of the approach, and e^-40 of it is left.
        let expected = M * case.drive() / K_T;
        let tolerance = 1.1 * expected * (-slow * (end - dt)).exp() + way_round_off(steps);
        assert!((now.way - expected).abs() < tolerance, "{case:?}: crept {:e} m, not {expected:e} m", now.way);
    }
}

#[test]
fn non_rotating_grain_slides_above_its_friction_angle() {
    for case in Case::both(1.02 * MU) {
        let zeta = 4.0;
        let w = (K_T / M).sqrt();
        let dt = 0.05 / (zeta * w);
        let half = 12_000;
        let mut ride = case.start(&spring(K_T, 2.0 * zeta * w), dt, 0.0, 0.0).never_turning();
        let first = ride.after(half);
        let then = ride.time();
        let last = ride.after(2 * half);
        let acceleration = (last.u - first.u) / (ride.time() - then);
        let expected = case.drive() - MU * case.press();
        // While the grain slips, the force is mu m g cos in every step up to the rounding of the overlap. Each kick
        // also rounds the speed by half an ulp.
        let rounded = 2.0 * half as f64 * f64::EPSILON * last.u / (ride.time() - then);
        let tolerance = MU * press_round_off(last.way) + rounded;
        assert!((acceleration - expected).abs() < tolerance, "{case:?}: {acceleration} m/s^2, not {expected}");
        // Before the slip the force of the dashpot grew towards that value at the rate gamma. The grain therefore
        // gained at most g sin/gamma of speed.
        let ahead = last.u - expected * ride.time();
        assert!((0.0..case.drive() / (2.0 * zeta * w)).contains(&ahead), "{case:?}: {ahead} m/s ahead");
    }
}

#[test]
fn undamped_grain_released_on_a_slope_oscillates_about_its_rest_position() {
    // The displacement reaches at most twice m g sin/k_t, so the grain sticks if tan < mu/2. The slope here is just
    // below that.
    for case in Case::both(0.49 * MU) {
        let w = (K_T / M).sqrt();
        let dt = 0.05 / w;
        let steps = 2000;
        let amplitude = M * case.drive() / K_T;
        let mut ride = case.start(&spring(K_T, 0.0), dt, 0.0, 0.0).never_turning();
        for step in 0..steps {
            let now = ride.after(step);
            let expected = amplitude * (1.0 - (w * ride.time()).cos());
            // Verlet's frequency is too high by the share (w dt)^2/24. At full steps the scheme makes no other error.
            let phase = (w * dt).powi(2) / 24.0 * w * ride.time();
            let tolerance = 1.01 * amplitude * phase + way_round_off(steps);
            assert!((now.way - expected).abs() <= tolerance, "{case:?}, step {step}: {:e} m", now.way);
        }
    }
}

/// gamma of the dashpot without memory, 1/s; and a step during which the dashpot removes a fiftieth of the slip.
const GAMMA: f64 = 400.0;
const CREEP_STEP: f64 = 0.02 / GAMMA;

fn dashpot() -> String {
    format!("tangential: Dashpot(damping: PerMass({GAMMA:?}), friction: {MU:?})")
}

/// Returns the error of the half-step velocities relative to an exponential approach to 1. They form an explicit Euler
/// sum with x = rate dt and lag by x/2 (s e^-s), at most x/(2 e). The next order adds less than x^2.
fn euler_lag(rate: f64, dt: f64) -> f64 {
    let x = rate * dt;
    x / (2.0 * E) + x * x
}

#[test]
fn with_a_memoryless_dashpot_a_grain_creeps_down_any_slope() {
    for case in Case::both(0.5 * MU) {
        let creep = case.drive() / GAMMA;
        let mut ride = case.start(&dashpot(), CREEP_STEP, 0.0, 0.0).never_turning();
        // 40 times 1/gamma: after that only round-off is left of the approach.
        for step in 0..2000 {
            let now = ride.after(step);
            let expected = creep * (1.0 - (-GAMMA * ride.time()).exp());
            assert!(
                (now.u - expected).abs() < creep * euler_lag(GAMMA, CREEP_STEP),
                "{case:?}, step {step}: {} m/s",
                now.u
            );
        }
        // At the fixed point only the roundings of the last 1/(gamma dt) = 50 steps remain, half an ulp each.
        let last = ride.after(2000).u;
        assert!((last / creep - 1.0).abs() < 50.0 * f64::EPSILON, "{case:?}: creeps at {last} m/s, not {creep} m/s");
    }
}

#[test]
fn with_a_memoryless_dashpot_the_slip_decays_exponentially() {
    for case in Case::both(0.0) {
        // Half the slip at which the force would reach its cap.
        let q = case.q();
        let u0 = 0.5 * MU * G / GAMMA;
        let rate = GAMMA * (1.0 + 1.0 / q);
        let dt = 0.02 / rate;
        let mut ride = case.start(&dashpot(), dt, u0, 0.0);
        for step in 0..2000 {
            let now = ride.after(step);
            let expected = u0 * (-rate * ride.time()).exp();
            let slip = now.u - now.roll;
            assert!((slip - expected).abs() < u0 * euler_lag(rate, dt), "{case:?}, step {step}: slip {slip} m/s");
        }
        // e^-40 of the slip is left, plus round-off as derived for the sliding grain above.
        let tolerance = u0 * ((-40.0f64).exp() + 2.0 * 2000.0 * f64::EPSILON);
        assert!((ride.after(2000).u - u0 / (1.0 + q)).abs() < tolerance, "{case:?}");
    }
}
