//! Oblique impacts on a wall: tests 4 and 5 of Chung and Ooi, Granular Matter 13, 643, 2011 (Hertz and Mindlin), and
//! case DEM05 of MFiX's verification manual (linear). References are the closed form of gross sliding, the differential
//! equations, and published values.
//!
//! Symbols as in `spring_slider`, and x = v_t/(mu v_n). If the contact slides throughout, the tangential impulse is mu
//! times the normal one: w = -q mu (1 + e) v_n/R, and v_t falls by mu (1 + e) v_n. The contact slides throughout at
//! least while v_s does not change sign, x > (1 + q)(1 + e).

use std::f64::consts::PI;

use crate::spring_slider::{Law, N, mindlin};

fn test_4() -> [Law; 2] {
    [[3.8e11, 0.23, 4000.0], [7.0e10, 0.33, 2700.0]].map(|material| mindlin(material, 0.0025, 0.98, 0.092))
}

fn test_5() -> [Law; 2] {
    [[2.08e11, 0.3, 7850.0], [1.0e9, 0.4, 1400.0]].map(|material| mindlin(material, 1.0e-5, 1.0, 0.3))
}

fn dem05() -> Law {
    let k = 1.72e7;
    let k_t = 1.48e7;
    let friction = 0.092;
    let radius = 0.0025f64;
    let keys = format!(
        "contact: Linear(k: {k:?}, damping: B(0.0), attraction: Allowed, \
         tangential: Spring(k: {k_t:?}, damping: B(0.0), friction: {friction:?})),"
    );
    Law { keys, p: 1.0, k, k_t, zeta: 0.0, friction, mass: 4.0 / 3.0 * PI * 4000.0 * radius.powi(3), radius }
}

/// Test 4, aluminium oxide at 3.9 m/s: angle from the normal (degrees). Then, as digitised by Kratos: e_t, spin (rad/s)
/// and the angle of the contact point's velocity after the impact (degrees).
const ANGLES: [f64; 13] = [5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 50.0, 60.0, 70.0, 80.0, 85.0];
const E_T: [f64; 13] = [0.948, 0.687, 0.624, 0.616, 0.634, 0.684, 0.737, 0.781, 0.845, 0.893, 0.932, 0.966, 0.983];
const SPINS: [f64; 13] =
    [-19.3, -213.0, -378.0, -511.0, -599.0, -617.0, -582.0, -545.0, -457.0, -357.0, -246.0, -126.0, -63.1];
const PARTING: [f64; 13] = [3.8, -1.6, -5.5, -7.5, -7.5, -3.5, 3.4, 11.6, 29.4, 47.8, 64.6, 78.7, 84.5];
/// Test 5, steel: x, and v_s/(mu v_n) after the impact.
const RATIOS: [f64; 7] = [1.01, 2.0, 2.99, 4.0, 5.0, 6.0, 10.0];
const RECOIL: [f64; 7] = [-0.747, -1.533, -2.44, -2.787, -2.0, -1.013, 3.01];
/// Angle (degrees) and e_t of the experiment of Kharaz, Gorham and Salman, Powder Technology 120, 281, 2001, which
/// DEM05 repeats.
const KHARAZ_ANGLES: [f64; 10] = [2.24, 4.22, 9.84, 20.2, 30.4, 39.5, 49.6, 71.1, 79.2, 85.2];
const KHARAZ_E_T: [f64; 10] = [0.797, 0.746, 0.675, 0.599, 0.690, 0.774, 0.848, 0.937, 0.970, 0.979];

fn at_angle(degrees: f64) -> [f64; 2] {
    [3.9 * degrees.to_radians().cos(), 3.9 * degrees.to_radians().sin()]
}

fn at_ratio(x: f64) -> [f64; 2] {
    [5.0, x * 0.3 * 5.0]
}

/// Returns every law with v_n and v_t of its impacts.
fn cases() -> Vec<(Law, Vec<[f64; 2]>)> {
    let mut cases = vec![(dem05(), KHARAZ_ANGLES.map(at_angle).to_vec())];
    cases.extend(test_4().map(|law| (law, ANGLES.map(at_angle).to_vec())));
    cases.extend(test_5().map(|law| (law, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0].map(at_ratio).to_vec())));
    cases
}

#[test]
fn gross_sliding_matches_its_closed_form() {
    for (space, q) in [("Solid", 2.5), ("Plane", 2.0)] {
        let mut impacts_checked = 0;
        for (law, impacts) in cases() {
            let e = (-PI * law.zeta / (1.0 - law.zeta * law.zeta).sqrt()).exp();
            let mu = law.friction;
            let r = law.radius;
            for [v_n, v_t] in impacts.into_iter().filter(|[v_n, v_t]| v_t / v_n > mu * (1.0 + q) * (1.0 + e)) {
                impacts_checked += 1;
                let after = law.simulate(space, v_n, v_t, 0.3);
                if law.zeta == 0.0 {
                    // The friction of each step is mu times its normal force. The changes of both velocities therefore
                    // agree to the rounding of N steps, even where the steps themselves are inaccurate.
                    let rubbed = mu * (v_n + after.normal);
                    let round_off = 4.0 * N * f64::EPSILON * v_t;
                    assert!((v_t - after.tangential - rubbed).abs() < round_off, "{} of {rubbed}", after.tangential);
                    assert!((r * after.spin + q * rubbed).abs() < q * round_off, "{} of {rubbed}", after.spin);
                }
                // The attraction at the end of a damped contact also causes friction. The speed it removes is the
                // difference between the restitutions with and without attraction.
                let end = PI - 2.0 * law.zeta.asin();
                let without = (-law.zeta / (1.0 - law.zeta * law.zeta).sqrt() * end).exp();
                let rubbed = mu * v_n * (1.0 + e + 2.0 * (without - e));
                // Error of the restitution: (w0 dt)^2 for the linear spring or N^-2.5 for Hertz, plus the error of the
                // damping.
                let elastic = if law.p == 1.0 { (PI / N).powi(2) } else { 1.03 * N.powf(-2.5) };
                let tolerance = mu * v_n * (elastic + law.zeta * 3.68 / N);
                let velocity = v_t - rubbed;
                let spin = -q * rubbed / r;
                assert!((after.tangential - velocity).abs() < tolerance, "v_t {}, not {velocity}", after.tangential);
                assert!((after.spin - spin).abs() < q * tolerance / r, "w {}, not {spin}", after.spin);
            }
        }
        assert!(impacts_checked >= 20, "only {impacts_checked} impacts slide throughout");
    }
}

#[test]
fn stick_and_slip_match_the_differential_equations() {
    let q = 2.5;
    for (law, impacts) in cases() {
        for [v_n, v_t] in impacts {
            let exact = law.integrate(v_n, v_t);
            let (step, drag) = law.steps_and_drag(v_n, q);
            // A contact that slides up to the deepest point, x > 1 + q, does not depend on how its spring was loaded. A
            // switch between slip and stick within a step then causes a kink: a force error k_t v_s dt for dt, (w_t
            // dt)^2 of v_s, at most three times. Otherwise the spring is off by up to v_s dt: it accumulates a whole
            // step in the step of touch, and displacement accumulated while it stiffens counts at the final stiffness.
            // The oscillator turns that into w_t dt of v_s.
            let slides = v_t / v_n > law.friction * (1.0 + q);
            let share = drag + if slides { 3.0 * step * step } else { step };
            for phase in 0..4 {
                let after = law.simulate("Solid", v_n, v_t, f64::from(phase) / 4.0);
                let velocity = after.tangential - exact.tangential;
                let spin = law.radius * (after.spin - exact.spin);
                let tolerance = share * v_t / (1.0 + q);
                assert!(velocity.abs() < tolerance, "{v_n}, {v_t} m/s: v_t off by {velocity:e}, not {tolerance:e}");
                assert!(spin.abs() < q * tolerance, "{v_n}, {v_t} m/s: R w off by {spin:e}, not {:e}", q * tolerance);
            }
        }
    }
}

#[test]
#[expect(clippy::print_stdout, reason = "figures beside published ones")]
fn published_impacts_are_matched_where_sliding_dominates() {
    // Kratos passes its validation within 5 %. Below 10 degrees (15 for the spin) and below x = 6 the result depends on
    // how a program treats a spring with a changing stiffness or cap. Programs differ in that, so these values are only
    // printed.
    let meets = |ours: f64, published: f64| (ours / published - 1.0).abs() < 0.05;
    let [oxide, _] = test_4();
    for (((degrees, e_t), spin), angle) in ANGLES.into_iter().zip(E_T).zip(SPINS).zip(PARTING) {
        let [v_n, v_t] = at_angle(degrees);
        let after = oxide.simulate("Solid", v_n, v_t, 0.3);
        let ours = after.tangential / v_t;
        let parting = ((after.tangential + oxide.radius * after.spin) / after.normal).atan().to_degrees();
        println!(
            "test 4, {degrees} deg: e_t {ours:.3} ({e_t}), {:.1} rad/s ({spin}), {parting:.1} deg ({angle})",
            after.spin
        );
        assert!(degrees < 10.0 || meets(ours, e_t), "{degrees} degrees: e_t {ours}, published {e_t}");
        assert!(degrees < 15.0 || meets(after.spin, spin), "{degrees} degrees: {} rad/s, published {spin}", after.spin);
    }
    let [steel, _] = test_5();
    for (x, recoil) in RATIOS.into_iter().zip(RECOIL) {
        let [v_n, v_t] = at_ratio(x);
        let after = steel.simulate("Solid", v_n, v_t, 0.3);
        let ours = (after.tangential + steel.radius * after.spin) / (steel.friction * after.normal);
        println!("test 5, x = {x}: v_s/(mu v_n) {ours:.3} ({recoil})");
        assert!(x < 6.0 || meets(ours, recoil), "x = {x}: {ours}, published {recoil}");
    }
    for (degrees, e_t) in KHARAZ_ANGLES.into_iter().zip(KHARAZ_E_T) {
        let [v_n, v_t] = at_angle(degrees);
        let ours = dem05().simulate("Solid", v_n, v_t, 0.3).tangential / v_t;
        println!("DEM05, {degrees} deg: e_t {ours:.3} ({e_t})");
        assert!(degrees < 9.0 || meets(ours, e_t), "{degrees} degrees: e_t {ours}, measured {e_t}");
    }
}
