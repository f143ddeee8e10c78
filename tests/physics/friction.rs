//! Friction of one grain on a plane: from sliding to rolling, sticking, sliding, creeping.
//!
//! With q = I/(m R^2) a tangential force F_t changes the slip v_s = u - R w by F_t (1 + 1/q)/m.

use std::f64::consts::E;

use crate::ride::{Case, G, M, MU, press_round_off, way_round_off};

const K_T: f64 = 2.9e4;

fn spring(k_t: f64, gamma: f64) -> String {
    format!("tangential: Spring(k: {k_t:?}, damping: PerMass({gamma:?}), friction: {MU:?})")
}

#[test]
fn a_sliding_grain_rolls_at_five_sevenths_of_its_speed_a_disc_at_two_thirds() {
    for case in Case::both(0.0) {
        let (q, u0, dt) = (case.q(), 1.0, 2.0e-5);
        let slip_ends = u0 / (MU * G * (1.0 + 1.0 / q));
        let steps = (2.0 * slip_ends / dt) as u64;
        // F_t and its torque change u and q R w by opposite amounts, whatever F_t is: u + q R w = u0, of which each of two
        // kicks a step rounds both terms by half an ulp.
        let round_off = 2.0 * steps as f64 * f64::EPSILON * u0;

        // Without a dashpot the force first grows to its cap as k_t u0 t, so the cap acts as if it began half of
        // mu m g/(k_t u0) late. Steps resolve both ends of the slide: one step each.
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

        // What is left of the slip, at most the cap's spring let go, v_s = w_t mu m g/k_t, rings down with
        // beta = gamma (1 + 1/q)/2 once the slide is over; of it u holds q/(1 + q).
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
fn a_grain_that_cannot_turn_sticks_below_its_friction_angle() {
    // Let go at once, the spring's force would overshoot m g sin to its double and slip. Overdamped it overshoots by
    // 1/(4 zeta^2) at most (the deceleration of a body whose speed (g sin/gamma) decays at the rate w^2/gamma): 1.6 % here.
    for case in Case::both(0.98 * MU) {
        let (zeta, w) = (4.0, (K_T / M).sqrt());
        let slow = w * (zeta - f64::sqrt(zeta * zeta - 1.0));
        let (dt, end) = (0.05 / (zeta * w), 40.0 / slow);
        let steps = (end / dt) as u64;
        let now = case.start(&spring(K_T, 2.0 * zeta * w), dt, 0.0, 0.0).never_turning().after(steps);
        // The slow root's share of the approach is below 1.1, and e^-40 of it is left.
        let expected = M * case.drive() / K_T;
        let tolerance = 1.1 * expected * (-slow * (end - dt)).exp() + way_round_off(steps);
        assert!((now.way - expected).abs() < tolerance, "{case:?}: crept {:e} m, not {expected:e} m", now.way);
    }
}

#[test]
fn a_grain_that_cannot_turn_slides_above_its_friction_angle() {
    for case in Case::both(1.02 * MU) {
        let (zeta, w) = (4.0, (K_T / M).sqrt());
        let (dt, half) = (0.05 / (zeta * w), 12_000);
        let mut ride = case.start(&spring(K_T, 2.0 * zeta * w), dt, 0.0, 0.0).never_turning();
        let (first, then) = (ride.after(half), ride.time());
        let last = ride.after(2 * half);
        let acceleration = (last.u - first.u) / (ride.time() - then);
        let expected = case.drive() - MU * case.press();
        // Once slipping the force is mu m g cos in every step, but for the rounding of the overlap; and each kick rounds the
        // speed by half an ulp.
        let rounded = 2.0 * half as f64 * f64::EPSILON * last.u / (ride.time() - then);
        let tolerance = MU * press_round_off(last.way) + rounded;
        assert!((acceleration - expected).abs() < tolerance, "{case:?}: {acceleration} m/s^2, not {expected}");
        // Until then the dashpot's force grew towards it at the rate gamma: ahead by g sin/gamma at most.
        let ahead = last.u - expected * ride.time();
        assert!((0.0..case.drive() / (2.0 * zeta * w)).contains(&ahead), "{case:?}: {ahead} m/s ahead");
    }
}

#[test]
fn an_undamped_grain_that_is_let_go_swings_about_its_place() {
    // At most to twice m g sin/k_t, so it sticks if tan < mu/2: one step short of that here.
    for case in Case::both(0.49 * MU) {
        let w = (K_T / M).sqrt();
        let (dt, steps) = (0.05 / w, 2000);
        let amplitude = M * case.drive() / K_T;
        let mut ride = case.start(&spring(K_T, 0.0), dt, 0.0, 0.0).never_turning();
        for step in 0..steps {
            let now = ride.after(step);
            let expected = amplitude * (1.0 - (w * ride.time()).cos());
            // Verlet's frequency is too high by a share (w dt)^2/24, and no other error is made at full steps.
            let phase = (w * dt).powi(2) / 24.0 * w * ride.time();
            let tolerance = 1.01 * amplitude * phase + way_round_off(steps);
            assert!((now.way - expected).abs() <= tolerance, "{case:?}, step {step}: {:e} m", now.way);
        }
    }
}

/// gamma of the memoryless dashpot, 1/s, and a step in which it takes a fiftieth of a slip.
const GAMMA: f64 = 400.0;
const CREEP_STEP: f64 = 0.02 / GAMMA;

fn dashpot() -> String {
    format!("tangential: Dashpot(damping: PerMass({GAMMA:?}), friction: {MU:?})")
}

/// What the half-step velocities, an explicit Euler sum with x = rate dt, lag behind an exponential approach to 1: x/2 (s e^-s),
/// at most x/(2 e); the next order adds less than x^2.
fn lag(rate: f64, dt: f64) -> f64 {
    let x = rate * dt;
    x / (2.0 * E) + x * x
}

#[test]
fn a_dashpot_without_memory_lets_a_grain_creep_down_any_slope() {
    for case in Case::both(0.5 * MU) {
        let creep = case.drive() / GAMMA;
        let mut ride = case.start(&dashpot(), CREEP_STEP, 0.0, 0.0).never_turning();
        // 40 times 1/gamma: nothing but round-off is left of the approach then.
        for step in 0..2000 {
            let now = ride.after(step);
            let expected = creep * (1.0 - (-GAMMA * ride.time()).exp());
            assert!((now.u - expected).abs() < creep * lag(GAMMA, CREEP_STEP), "{case:?}, step {step}: {} m/s", now.u);
        }
        // In a fixed point only the last steps' roundings are left: 1/(gamma dt) = 50 of them, half an ulp each.
        let last = ride.after(2000).u;
        assert!((last / creep - 1.0).abs() < 50.0 * f64::EPSILON, "{case:?}: creeps at {last} m/s, not {creep} m/s");
    }
}

#[test]
fn a_dashpot_without_memory_ends_a_slip_exponentially() {
    for case in Case::both(0.0) {
        // Half of the slip at which the force would reach its cap.
        let (q, u0) = (case.q(), 0.5 * MU * G / GAMMA);
        let rate = GAMMA * (1.0 + 1.0 / q);
        let dt = 0.02 / rate;
        let mut ride = case.start(&dashpot(), dt, u0, 0.0);
        for step in 0..2000 {
            let now = ride.after(step);
            let expected = u0 * (-rate * ride.time()).exp();
            let slip = now.u - now.roll;
            assert!((slip - expected).abs() < u0 * lag(rate, dt), "{case:?}, step {step}: slip {slip} m/s");
        }
        // e^-40 of the slip is left; and round-off as in the slide above.
        let tolerance = u0 * ((-40.0f64).exp() + 2.0 * 2000.0 * f64::EPSILON);
        assert!((ride.after(2000).u - u0 / (1.0 + q)).abs() < tolerance, "{case:?}");
    }
}
