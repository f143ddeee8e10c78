//! Chosen damping of Mindlin's friction: a contact that sticks under a constant load swings along the plane as a damped
//! oscillator with the surface's effective mass m/(1 + 1/q), stiffness k_t and drag c_t = share c.

use siloflow::dem::space::Solid;

use crate::{motion, simulation, sphere};

const R: f64 = 0.01;
const M: f64 = 0.01;
const YOUNG: f64 = 1.0e7;
const POISSON: f64 = 0.3;
const E: f64 = 0.5;
const G: f64 = 9.81;

#[test]
fn sticking_contact_swings_with_the_chosen_drag() {
    let modulus = YOUNG / (2.0 * (1.0 - POISSON * POISSON));
    let shear = YOUNG / (4.0 * (2.0 - POISSON) * (1.0 + POISSON));
    let overlap = (0.75 * M * G / (modulus * R.sqrt())).powf(2.0 / 3.0);
    let stiffness = 8.0 * shear * (R * overlap).sqrt();
    // Damping ratio of the normal force with attraction.
    let zeta = -E.ln() / E.ln().hypot(std::f64::consts::PI);
    let drag = 2.0 * (5.0f64 / 6.0).sqrt() * zeta * (2.0 * modulus * (R * overlap).sqrt() * M).sqrt();
    let mass = M / 3.5;
    for share in [0.0, 0.3, 1.2] {
        let keys = format!(
            "space: Solid, gravity: (0.0, 0.0, {:?}), walls: [HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))], \
             contact: Hertz(restitution: {E:?}, attraction: Allowed, tangential: Mindlin(friction: 1.0e3, damping: \
             OfNormal({share:?}))), materials: [(young: {YOUNG:?}, poisson: {POISSON:?})], step: Fixed(1.0e-6), until: 1.0",
            -G
        );
        let slip = 1.0e-3;
        let decay = 0.5 * share * drag / mass;
        let frequency = (stiffness / mass - decay * decay).sqrt();
        let mut simulation = simulation(&keys, vec![sphere(1, Solid::Z * (R - overlap), Solid::X * slip, R, M)]);
        for part in 1..=8 {
            let steps = (f64::from(part) / frequency * 1e6) as u64;
            simulation.run_steps(steps);
            let now = motion(&mut simulation)[0];
            let surface = now.velocity.x - R * now.spin.y;
            let t = steps as f64 * 1e-6;
            let exact = slip * (-decay * t).exp() * ((frequency * t).cos() - decay / frequency * (frequency * t).sin());
            // A contact that exists at the start gathers its spring from a first half step that counts as one of growing
            // stiffness: less than half a step of the phase. Later errors are of second order.
            let tolerance = (0.5 * frequency * 1e-6 + 1e-5) * slip;
            assert!((surface - exact).abs() < tolerance, "{share}, {part}: {surface} not {exact}");
        }
    }
}
