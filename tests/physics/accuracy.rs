//! Results of `siloflow accuracy`: orders and errors of the schemes on its cases. The error of each reference must be
//! far smaller than the errors that it measures.

use std::f64::consts::PI;

use siloflow::studies::accuracy::case::Case;
use siloflow::studies::accuracy::ladder::{Climb, prepare};
use siloflow::studies::accuracy::reference::closed::damping_ratio;
use siloflow::studies::accuracy::work_precision::ROUND_OFF;
use siloflow::studies::accuracy::{SCHEMES, cases};

/// Schemes of known order for damped contacts. A new scheme adds one line.
const ORDERS: [(&str, f64); 4] = [("Verlet", 1.0), ("Centred", 2.0), ("SymplecticEuler", 1.0), ("ExplicitEuler", 1.0)];

fn case(name: &str) -> Case {
    cases::all().into_iter().find(|case| case.name == name).unwrap()
}

fn number(scheme: &str) -> usize {
    SCHEMES.iter().position(|known| known.name() == scheme).unwrap()
}

/// Returns the error of the run nearest to `n` steps per contact.
fn error_at(climb: &Climb, n: f64) -> f64 {
    climb.points().into_iter().find(|point| (point.0 - n).abs() < 1.0).unwrap().1
}

const BOUNCES: [(&str, f64, bool); 7] = [
    ("bounce-0.9", 0.9, true),
    ("bounce-0.5", 0.5, true),
    ("bounce-0.2", 0.2, true),
    ("bounce-cut-0.9", 0.9, false),
    ("bounce-cut-0.5", 0.5, false),
    ("bounce-cut-0.2", 0.2, false),
    ("bounce-cut-0.05", 0.05, false),
];

#[test]
fn schemes_have_their_expected_order_on_bounces() {
    for (name, ..) in BOUNCES {
        let prepared = prepare(case(name), true);
        for (scheme, expected) in ORDERS {
            let climb = prepared.climb(number(scheme));
            if scheme != "Verlet" && climb.refusal.is_some() {
                continue; // The program refuses this scheme with contacts.
            }
            let order = climb.order.unwrap();
            // From t_c/20 to t_c/100 the next order adds a share w0 dt = pi/20 to the coarse error: ln(1.16)/ln(5) =
            // 0.09 in the order. The rms over 40 phases scatters by 1/sqrt(40), which is 0.1 in the order.
            assert!((order - expected).abs() < 0.2, "{name}, {scheme}: order {order:.2}");
        }
    }
}

#[test]
fn centred_scheme_is_of_second_order_and_never_worse_than_verlet() {
    let names = [
        "chain",
        "squeezed",
        "oblique-smooth",
        "oblique-slip",
        "oblique-stick",
        "oblique-rough",
        "oblique-stuck",
        "oblique-rolling",
        "clump-floor",
        "clump-pair",
        "clump-cross-slip",
        "clump-cross-stick",
        "clump-slide",
        "mindlin-slip",
        "mindlin-stick",
        "mindlin-stuck",
        "adhesive",
        "bounce-jkr",
        "bounce-at-start",
        "stacked-pair",
        "slip-to-roll",
        "vibrating-floor",
        "piston-floor",
        "piston-lid",
        "column",
    ];
    for name in names {
        let prepared = prepare(case(name), true);
        let [plain, centred] = ["Verlet", "Centred"].map(|scheme| prepared.climb(number(scheme)));
        let order = centred.order.unwrap();
        // Tolerance as in the test above; a case of several contacts adds their scatter. Errors happen to cancel at
        // single step sizes, which raises a single order. So the order has a lower bound only.
        // In `oblique-rough` slip at the end lasts 0.03 t_c: steps coarser than that do not resolve it, finer ones do.
        let least = if name == "oblique-rough" { 1.6 } else { 1.75 };
        assert!(order > least, "{name}: order {order:.2}");
        for (n, error) in centred.points().into_iter().filter(|point| point.0 > 20.0) {
            let of_plain = error_at(&plain, n);
            assert!(error <= of_plain, "{name}, t_c/{n:.0}: {error:e}, plain {of_plain:e}");
        }
        // The closed forms have no error.
        assert!(centred.reference_error < 1e-2 * error_at(&centred, 100.0), "{name}: {:e}", centred.reference_error);
    }
}

#[test]
fn verlet_is_of_first_order_in_every_damped_case() {
    let names = [
        "chain",
        "oblique-smooth",
        "oblique-slip",
        "oblique-stick",
        "oblique-rolling",
        "clump-floor",
        "clump-pair",
        "clump-cross-slip",
        "clump-cross-stick",
        "mindlin-slip",
        "mindlin-stick",
        "mindlin-stuck",
        "stacked-pair",
        "slip-to-roll",
        "vibrating-floor",
        "piston-floor",
        "piston-lid",
        "column",
    ];
    for name in names {
        let climb = prepare(case(name), true).climb(number("Verlet"));
        let order = climb.order.unwrap();
        // Tolerance as in the test above; a case of several contacts adds their scatter.
        assert!((order - 1.0).abs() < 0.25, "{name}: order {order:.2}");
        // The error of the reference is below a thousandth of the smallest measured error.
        let least = error_at(&climb, 100.0);
        assert!(climb.reference_error < 1e-3 * least, "{name}: {:e} of {least:e}", climb.reference_error);
    }
}

#[test]
fn a_pair_that_topples_slowly_is_of_second_order_with_centred_and_accurate_with_both() {
    let prepared = prepare(case("clump-topple"), true);
    let [plain, centred] = ["Verlet", "Centred"].map(|scheme| prepared.climb(number(scheme)));
    let order = centred.order.unwrap();
    assert!((order - 2.0).abs() < 0.25, "order {order:.2}");
    // No contact opens and loads change slowly, so that the old velocity of the drag hardly matters: here `Verlet` is more accurate.
    for climb in [&plain, &centred] {
        assert!(climb.points().iter().all(|point| point.1 < 1e-3), "{:?}", climb.points());
    }
    assert!(centred.reference_error < 1e-2 * error_at(&plain, 100.0), "{:e}", centred.reference_error);
}

#[test]
fn verlet_restitution_error_agrees_with_theory() {
    // The theory holds for damping below critical, e > 0.135.
    for (name, e, attracts) in BOUNCES.into_iter().filter(|&(_, e, _)| e > 0.135) {
        let climb = prepare(case(name), true).climb(number("Verlet"));
        let zeta = damping_ratio(e, attracts);
        for n in [20.0, 50.0, 100.0] {
            // Relative to the impact speed, damping evaluated half a step late contributes zeta w0 dt, each of its two
            // jumps as much, and the spring (w0 dt)^2. w0 t_c is at most pi/sqrt(1 - zeta^2).
            let w0_dt = PI / (1.0 - zeta * zeta).sqrt() / n;
            let error = error_at(&climb, n);
            let bound = 3.0 * zeta * w0_dt + w0_dt * w0_dt;
            assert!(error < bound, "{name}, t_c/{n}: {error:e}, not below {bound:e}");
            // The phases must not cancel: at least a tenth of the effect on e of damping evaluated half a step late.
            assert!(error > 0.1 * e * zeta * w0_dt, "{name}, t_c/{n}: {error:e}");
        }
    }
}

#[test]
fn free_flight_is_exact_with_verlet_and_too_high_with_explicit_euler() {
    let case = case("free-flight");
    let prepared = prepare(case.clone(), true);
    let exact = prepared.climb(number("Verlet"));
    assert!(exact.points().iter().all(|point| point.1 < ROUND_OFF), "{:?}", exact.points());
    let speed = case.systems[0].discs[0].v.length();
    for (n, error) in prepared.climb(number("ExplicitEuler")).points() {
        // The position is g T dt/2 too high, relative to the path |v| T. T is rounded up to whole steps, and so is the
        // time of the path: a share 1/(20 n).
        let dt = case.contact_duration / n;
        let expected = 9.81 * (case.steps(dt) as f64 * dt) * dt / 2.0 / (speed * case.end);
        assert!((error / expected - 1.0).abs() < 1e-8, "t_c/{n}: {error:e}, not {expected:e}");
    }
}

#[test]
fn scheme_without_rotation_refuses_friction() {
    let climb = prepare(case("oblique-slip"), true).climb(number("ExplicitEuler"));
    assert!(climb.rungs.is_empty() && climb.refusal.is_some());
}

#[test]
fn energy_error_of_an_undamped_gas_decreases_with_the_step() {
    let prepared = prepare(case("gas"), true);
    let plain = prepared.climb(number("Verlet"));
    // Verlet conserves a nearby energy except where a contact opens or closes within a step. Each such event changes
    // the energy by up to k (v dt)^2/2, (w0 dt)^2 of the pair's energy, with either sign. About a thousand events in a
    // gas of a hundred grains add up to sqrt(1000)/100 of that.
    for (n, error) in plain.points() {
        assert!(error < 0.3 * (PI / n).powi(2), "t_c/{n}: {error:e}");
    }
    let wrong = prepared.climb(number("ExplicitEuler"));
    assert!(
        wrong.points().iter().all(|point| point.1 > 1.0),
        "explicit Euler adds energy to springs: {:?}",
        wrong.points()
    );
}
