//! Rolling resistance of one grain on a plane: an elastic-plastic spring and dashpot on v_r = R w, with a cap mu_r F_n
//! on its force. The force acts as a torque only.
//!
//! While a grain rolls, u = R w. With friction F_t at the contact and the rolling force F_r, both uphill, m u' = m g
//! sin - F_t and q m u' = F_t - F_r. So (1 + q) m u' = m g sin - F_r for any F_t below its cap.

use crate::ride::{Case, G, M, MU, press_round_off, way_round_off};

const MU_R: f64 = 0.05;
/// Stiffness of both springs, N/m.
const K: f64 = 1.0e4;

/// Returns the keys of both springs, with gamma of their dashpots in 1/s, and the same with a rolling spring that takes its
/// stiffness from friction.
fn laws(gamma_t: f64, gamma_r: f64) -> [String; 2] {
    let given = law(gamma_t, gamma_r);
    let elastic = given.replace(&format!("rolling: (k: {K:?}"), "rolling: (kind: Elastic");
    assert_ne!(given, elastic);
    [given, elastic]
}

fn law(gamma_t: f64, gamma_r: f64) -> String {
    format!(
        "tangential: Spring(k: {K:?}, damping: PerMass({gamma_t:?}), friction: {MU:?}), \
         rolling: (k: {K:?}, damping: PerMass({gamma_r:?}), friction: {MU_R:?})"
    )
}

#[test]
fn rolling_grain_decelerates_by_its_closed_form_and_stops() {
    for (case, kind) in Case::both(0.0).into_iter().flat_map(|case| [(case, 0), (case, 1)]) {
        let q = case.q();
        let u0 = 0.3;
        let dt = 4.0e-5;
        let inertia = 1.0 + q;
        let gamma = 170.0;
        let lasts = inertia * u0 / (MU_R * G);
        let mut ride = case.start(&laws(gamma, gamma)[kind], dt, u0, u0);
        let first = ride.after((lasts / 6.0 / dt) as u64);
        let then = ride.time();
        let second = ride.after((lasts / 2.0 / dt) as u64);
        let deceleration = (first.u - second.u) / (ride.time() - then);
        let expected = MU_R * G / inertia;
        // The start excites an oscillation with a speed of at most mu_r g/(1 + q) over w_t, which has decayed with
        // beta_t since. Each of two kicks per step rounds u by half an ulp. The cap has the error of the overlap.
        let beta = 0.5 * gamma * (1.0 + 1.0 / q);
        let ringing = expected * (M / K).sqrt() * (-beta * then).exp();
        let rounded = ride.time() / dt * f64::EPSILON * u0;
        let tolerance = (2.0 * ringing + rounded) / (ride.time() - then) + MU_R * press_round_off(second.way);
        assert!((deceleration - expected).abs() < tolerance, "{case:?}: slows by {deceleration}, not {expected} m/s^2");

        // The cap is reached after xi = mu_r m g/k at the latest, which delays by half that distance. At the end the
        // spring rolls the grain back by at most twice that. Two steps are for the ends.
        let spring = MU_R * M * G / K;
        let last = ride.after((2.0 * lasts / dt) as u64);
        let way = 0.5 * u0 * lasts;
        assert!((last.way - way).abs() < 3.0 * spring + 2.0 * u0 * dt, "{case:?}: went {} m, not {way} m", last.way);
        // Afterwards both springs oscillate, starting from at most half of k (xi^2 + S^2), S < xi. With m w^2/k = x, (1
        // - x)(2 - q x) = 1. Both dashpots have c = gamma m/k of their springs, so the slow mode decays with gamma x/2.
        // The fast mode has zeta = 0.8, so the speed of a mode is at most 1/sqrt(1 - zeta^2) < 2 times the one from its
        // energy. The time of one oscillation is for the stop.
        let x = 0.5 * ((2.0 + q) - ((2.0 + q).powi(2) - 4.0 * q).sqrt()) / q;
        let decayed = (-0.5 * gamma * x * (lasts - 2.0 * (M / (x * K)).sqrt())).exp();
        let rest = 4.0 * spring * (K / (q * M)).sqrt() * decayed + 2.0 * lasts / dt * f64::EPSILON * u0;
        assert!(last.u.abs() < rest && last.roll.abs() < rest, "{case:?}: still rolls at {:e} m/s", last.u);
    }
}

/// Damping ratio of each of two springs in series under the same force. Released at once, either overshoots by at most
/// 1/(4 zeta^2) = 2.8 %, so F_r exceeds m g sin by 6 % at most. A distance of a tenth from the cap is enough.
const ZETA: f64 = 3.0;

/// Returns gamma_t that gives this zeta to the slip of a grain with fixed spin, and gamma_r that gives it to rolling.
fn gammas(case: Case) -> (f64, f64) {
    let inertia = 1.0 + case.q();
    (2.0 * ZETA * (K / M).sqrt(), 2.0 * ZETA * inertia * (K / (inertia * M)).sqrt())
}

/// Returns a step that resolves the faster of the two dashpots, and the relaxation rate of the slower of the two
/// springs.
fn pace(case: Case) -> (f64, f64) {
    let (gamma_t, gamma_r) = gammas(case);
    let fast = (gamma_t * (1.0 + 1.0 / case.q())).max(gamma_r / case.q());
    (0.5 / fast, K / (M * gamma_t.max(gamma_r)))
}

#[test]
fn grain_stays_at_rest_on_a_slope_below_its_rolling_resistance() {
    for (case, kind) in Case::both(0.9 * MU_R).into_iter().flat_map(|case| [(case, 0), (case, 1)]) {
        let (gamma_t, gamma_r) = gammas(case);
        let (dt, slow) = pace(case);
        let steps = (40.0 / slow / dt) as u64;
        let now = case.start(&laws(gamma_t, gamma_r)[kind], dt, 0.0, 0.0).after(steps);
        // The contact slips by m g sin/k_t and rolls by m g sin/k_r.
        let expected = 2.0 * M * case.drive() / K;
        // Both relax at least at the rate `slow`, so less than e^-40 is left of either. The springs gather velocities that
        // are predicted with the acceleration of the step before. So each is off by up to h^2 times the change of the
        // acceleration of its contact since the start, when the grain was free: g sin (1 + 1/q).
        let predicted = 2.0 * (0.5 * dt).powi(2) * case.drive() * (1.0 + 1.0 / case.q());
        let tolerance = predicted + 2.0 * expected * (-40.0f64).exp() + 2.0 * way_round_off(steps);
        assert!((now.way - expected).abs() < tolerance, "{case:?}: went {:e} m, not {expected:e} m", now.way);
        let settling = 2.0 * way_round_off(steps) * gamma_t.max(gamma_r);
        assert!(now.u.abs() < settling && now.roll.abs() < settling, "{case:?}: still moves at {:e} m/s", now.u);
    }
}

#[test]
fn grain_rolls_down_a_slope_above_its_rolling_resistance() {
    for case in Case::both(1.1 * MU_R) {
        let (gamma_t, gamma_r) = gammas(case);
        let (dt, slow) = pace(case);
        let steps = (40.0 / slow / dt) as u64;
        let mut ride = case.start(&law(gamma_t, gamma_r), dt, 0.0, 0.0);
        let first = ride.after(steps);
        let then = ride.time();
        let last = ride.after(2 * steps);
        let acceleration = (last.u - first.u) / (ride.time() - then);
        let expected = (case.drive() - MU_R * case.press()) / (1.0 + case.q());
        // The friction spring has relaxed to e^-40, each kick rounds the speed, and the cap has the error of the
        // overlap.
        let rounded = 2.0 * last.u * (steps as f64 * f64::EPSILON + (-40.0f64).exp());
        let tolerance = rounded / (ride.time() - then) + MU_R * press_round_off(last.way);
        assert!((acceleration - expected).abs() < tolerance, "{case:?}: {acceleration} m/s^2, not {expected}");
    }
}

#[test]
fn constant_torque_slows_and_stops_a_grain_and_lets_it_creep_on_a_slope() {
    let gamma = 170.0;
    let torque = format!(
        "tangential: Spring(k: {K:?}, damping: PerMass({gamma:?}), friction: {MU:?}), rolling: (kind: Torque, friction: {MU_R:?})"
    );
    for case in Case::both(0.0) {
        let inertia = 1.0 + case.q();
        let u0 = 0.3;
        let dt = 4.0e-5;
        let expected = MU_R * G / inertia;
        let lasts = u0 / expected;
        let mut ride = case.start(&torque, dt, u0, u0);
        let first = ride.after((lasts / 6.0 / dt) as u64);
        let then = ride.time();
        let second = ride.after((lasts / 2.0 / dt) as u64);
        let deceleration = (first.u - second.u) / (ride.time() - then);
        // The tolerance of the first test of this file.
        let beta = 0.5 * gamma * (1.0 + 1.0 / case.q());
        let ringing = expected * (M / K).sqrt() * (-beta * then).exp();
        let rounded = ride.time() / dt * f64::EPSILON * u0;
        let tolerance = (2.0 * ringing + rounded) / (ride.time() - then) + MU_R * press_round_off(second.way);
        assert!((deceleration - expected).abs() < tolerance, "{case:?}: slows by {deceleration}, not {expected} m/s^2");
        // Below v* = mu_r g dt/0.05 the torque is proportional to the speed: the way to rest is longer by half of the
        // decay there. The friction spring shifts it by its displacement.
        let last = ride.after((2.0 * lasts / dt) as u64);
        let slowest = MU_R * G * dt / 0.05;
        let way = 0.5 * u0 * lasts + 0.5 * slowest * slowest / expected;
        let spring = MU_R * M * G / K;
        assert!((last.way - way).abs() < 2.0 * spring + 2.0 * u0 * dt, "{case:?}: went {} m, not {way} m", last.way);
        assert!(last.u.abs() < 1e-9, "{case:?}: still rolls at {:e} m/s", last.u);
    }
    // On a slope with half of the tangent mu_r it creeps at v*/2, in proportion to the step.
    for case in Case::both(0.5 * MU_R) {
        for dt in [4.0e-5, 2.0e-5] {
            let mut ride = case.start(&torque, dt, 0.0, 0.0);
            let [early, late] = [0.2, 0.4].map(|time| ride.after((time / dt) as u64).way);
            let creep = (late - early) / 0.2;
            let expected = case.drive() * dt / 0.05;
            assert!((creep / expected - 1.0).abs() < 1e-3, "{case:?}: creeps at {creep:e}, not {expected:e} m/s");
        }
    }
}
