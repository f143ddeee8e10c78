//! Head-on impacts of elastic spheres on cylinders, cones and spheres, thin and solid.
//!
//! The program replaces Hertz's ellipse of contact by a circle, with the reduced radius R/(1 + R H) of the mean curvature H. Its impacts
//! must have the closed forms of that circle, to the error of the scheme. The circle itself is compared with the exact ellipse (Johnson,
//! Contact Mechanics, 1985, section 4.2).

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use siloflow::dem::space::Solid;
use siloflow::dem::store::ParticleStore;

use crate::hertz::DURATION;
use crate::{simulation, sphere};

/// Radius (m), mass (kg) and speed (m/s) of the sphere, and Young's modulus (Pa) and Poisson's ratio of both; the wall is a thousand times as
/// stiff.
const RADIUS: f64 = 0.01;
const MASS: f64 = 0.0105;
const SPEED: f64 = 0.3;
const YOUNG: f64 = 1.0e8;
const POISSON: f64 = 0.3;
/// Radius of the walls at the contact, m.
const WALL: f64 = 0.05;

/// A wall, the point that the sphere meets, the direction from there to the sphere, and the mean curvature there, 1/m.
type Case = (&'static str, Solid, Solid, f64);

fn cases() -> [Case; 8] {
    let cylinder = "Cylinder(from: (0.0, -0.1, 0.0), to: (0.0, 0.1, 0.0), radius: 0.05, species: 1)";
    let cone = "Cone(from: (0.0, 0.0, 0.0), to: (0.0, 0.0, 0.1), radii: (0.0, 0.1), species: 1)";
    let shell = "SphericalZone(centre: (0.0, 0.0, 0.0), radius: 0.05, species: 1)";
    let slope = FRAC_1_SQRT_2 * Solid::new(-1.0, 0.0, 1.0);
    let at = Solid::new(WALL, 0.0, WALL);
    [
        (cylinder, -WALL * Solid::Z, Solid::Z, -0.5 / WALL),
        (cylinder, WALL * Solid::Z, Solid::Z, 0.5 / WALL),
        // Around the axis, the curvature of a cone is that of the normal's radial part over the distance from the axis.
        (cone, at, slope, -0.5 * FRAC_1_SQRT_2 / WALL),
        (cone, at, -slope, 0.5 * FRAC_1_SQRT_2 / WALL),
        (shell, -WALL * Solid::Z, Solid::Z, -1.0 / WALL),
        (shell, WALL * Solid::Z, Solid::Z, 1.0 / WALL),
        ("Sphere(centre: (0.0, 0.0, 0.0), radius: 0.05, species: 1)", WALL * Solid::Z, Solid::Z, 1.0 / WALL),
        (
            "Sphere(centre: (0.0, 0.0, 0.0), radius: 0.05, species: 1, name: \"knob\")",
            WALL * Solid::Z,
            Solid::Z,
            1.0 / WALL,
        ),
    ]
}

fn modulus() -> f64 {
    YOUNG / (1.001 * (1.0 - POISSON * POISSON))
}

/// Largest force, largest overlap and duration of an impact whose force is k d^(3/2), SI.
fn closed_form(k: f64) -> [f64; 3] {
    let overlap = (1.25 * MASS * SPEED * SPEED / k).powf(0.4);
    [k * overlap.powf(1.5), overlap, DURATION * overlap / SPEED]
}

/// The same bounce, as sampled at the steps of a bounce with `n` steps that begins a share `phase` into the second one.
fn measured((wall, foot, normal, _): Case, duration: f64, n: f64, phase: f64) -> [f64; 3] {
    let dt = duration / n;
    let gap = SPEED * dt * (1.0 + phase);
    let keys = format!(
        "space: Solid, gravity: (0.0, 0.0, 0.0), walls: [{wall}], contact: Hertz(restitution: 1.0), materials: \
         [(young: {YOUNG:?}, poisson: {POISSON:?}), (young: {:?}, poisson: {POISSON:?})], step: Fixed({dt:?}), until: 1.0",
        1000.0 * YOUNG
    );
    let mut run = simulation(&keys, vec![sphere(1, foot + normal * (RADIUS + gap), -SPEED * normal, RADIUS, MASS)]);
    let mut force = 0.0f64;
    let mut overlap = 0.0f64;
    for step in 0..(6.0 * n) as u64 {
        run.run_steps(step);
        let store = run.world().resource::<ParticleStore<Solid>>();
        let slot = (0..store.len()).find(|&slot| store.body[slot].inverse_mass > 0.0).unwrap();
        let body = &store.body[slot];
        let depth = RADIUS - (body.position - foot).dot(normal);
        let parting = body.velocity.dot(normal);
        // The impact is along the normal, so nothing moves across it.
        assert!((body.velocity - normal * parting).length() < 1e-12 * SPEED, "{wall}");
        force = force.max(store.loads.force.of(slot).dot(normal));
        overlap = overlap.max(depth);
        if parting > 0.0 && depth < 0.0 {
            return [force, overlap, step as f64 * dt + depth / parting - gap / SPEED];
        }
    }
    panic!("{wall}: the contact did not end");
}

#[test]
fn impacts_on_curved_walls_match_the_closed_forms_of_the_mean_curvature() {
    let n = 200.0 + PI / 8.0;
    for case in cases() {
        let exact = closed_form(4.0 / 3.0 * modulus() * (RADIUS / (1.0 + RADIUS * case.3)).sqrt());
        for phase in [0.0, 0.3, 0.7] {
            let seen = measured(case, exact[2], n, phase);
            // The bounds of `hertz::elastic_impacts_match_hertz_closed_forms`.
            let ends = 1.03 * n.powf(-2.5);
            for (i, (up, down)) in [(0.677, 2.030), (0.451, 1.353)].into_iter().enumerate() {
                let error = seen[i] / exact[i] - 1.0;
                assert!(
                    (up - down) / (n * n) - ends < error && error < up / (n * n) + ends,
                    "{}: {} not {} ({error:e})",
                    case.0,
                    seen[i],
                    exact[i]
                );
            }
            let shift = seen[2] / exact[2] - 1.0 + 0.510 / (n * n);
            assert!(shift.abs() < ends, "{}: duration {} s, not {} s", case.0, seen[2], exact[2]);
        }
        // A flat wall would give a force of another size: the bounds above can tell the difference.
        let flat = closed_form(4.0 / 3.0 * modulus() * RADIUS.sqrt());
        assert!((exact[0] / flat[0] - 1.0).abs() > 5e-3, "{}", case.0);
    }
}

/// Complete elliptic integrals K and E of the parameter m = e^2, by the arithmetic-geometric mean.
fn elliptic(m: f64) -> [f64; 2] {
    let mut means = [1.0, (1.0 - m).sqrt()];
    let mut half_difference = m.sqrt();
    let mut power = 0.5;
    let mut sum = power * m;
    while half_difference > 1e-12 {
        let [one, other] = means;
        (means, half_difference) = ([0.5 * (one + other), (one * other).sqrt()], 0.5 * (one - other));
        power *= 2.0;
        sum += power * half_difference * half_difference;
    }
    let first = 0.5 * PI / means[0];
    [first, first * (1.0 - sum)]
}

/// F/(E* d^(3/2)) of Hertz's ellipse for a gap A x^2 + B y^2, A < B, m^(1/2).
fn stiffness_of_ellipse(a: f64, b: f64) -> f64 {
    let terms = |ratio: f64| {
        let [k, e] = elliptic(1.0 - ratio * ratio);
        [e / (ratio * ratio) - k, k - e, k]
    };
    // The ratio of the half-axes, by bisection.
    let mut low = 0.1;
    let mut high = 1.0 - 1e-6;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let [long, short, _] = terms(middle);
        if long / short > b / a { low = middle } else { high = middle }
    }
    let [long, short, k] = terms(low);
    let f1 = (4.0 / (PI * (1.0 - low * low))).cbrt() * low.sqrt() * (long * short).powf(1.0 / 6.0);
    let reduced = 0.5 / (a * b).sqrt();
    (1.5 * k * low.sqrt() / (PI * (0.75 * reduced).cbrt() * f1)).powf(-1.5)
}

#[test]
fn the_circle_of_the_mean_curvature_is_near_the_ellipse() {
    // Nearly a circle: 4/3 R^(1/2) of two equal curvatures.
    assert!((stiffness_of_ellipse(0.5 - 1e-6, 0.5) - 4.0 / 3.0).abs() < 1e-5);
    // x = R/a of a cylinder of radius a, inside and, with a minus, outside. The circle agrees to first order in x.
    for x in [0.05f64, 0.1, 0.2, -0.05, -0.1, -0.2] {
        let [a, b] = if x > 0.0 { [0.5 * (1.0 - x), 0.5] } else { [0.5, 0.5 * (1.0 - x)] };
        let circle = 4.0 / 3.0 * (1.0 / (1.0 - 0.5 * x)).sqrt();
        let excess = stiffness_of_ellipse(a, b) / circle - 1.0;
        assert!(excess > 0.05 * x * x && excess < 0.12 * x * x, "R/a = {x}: {excess:e}");
    }
}
