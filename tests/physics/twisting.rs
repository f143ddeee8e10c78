//! Twisting resistance: a sphere that spins about the normal of its contact slows at the rate of the capped torque,
//! mu_w R* F_n/I, and then swings with the spring and the dashpot until it rests.

use siloflow::dem::space::Solid;
use siloflow::energy::EnergyFlows;
use siloflow::measure::totals;

use crate::{motion, simulation, sphere};

const R: f64 = 0.01;
const M: f64 = 0.01;
const K: f64 = 1.0e4;
const K_W: f64 = 2.0e3;
const MU_W: f64 = 0.04;
const G: f64 = 9.81;
const INERTIA: f64 = 0.4 * M * R * R;

fn law(gamma: f64, adhesion: &str) -> String {
    format!(
        "space: Solid, contact: Linear(k: {K:?}, damping: Restitution(0.5), tangential: Spring(k: 3.0e3, damping: OfNormal(0.5), \
         friction: 0.3), twisting: (k: {K_W:?}, damping: PerMass({gamma:?}), friction: {MU_W:?}){adhesion}), until: 10.0"
    )
}

#[test]
fn spin_about_the_normal_slows_at_the_rate_of_the_cap() {
    let dt = 1.0e-5;
    let keys = format!(
        "{}, gravity: (0.0, 0.0, {:?}), walls: [HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))], step: Fixed({dt:?})",
        law(200.0, ""),
        -G
    );
    let mut ball = sphere(1, Solid::Z * (R - M * G / K), Solid::ZERO, R, M);
    let first = 50.0;
    ball.spin = Solid::Z * first;
    let mut simulation = simulation(&keys, vec![ball]);
    simulation.run_steps(0);
    // R* of a sphere on a plane is R.
    let rate = MU_W * M * G * R / INERTIA;
    let lasts = first / rate;
    let spin = |simulation: &mut siloflow::prelude::Simulation, step: u64| {
        simulation.run_steps(step);
        motion(simulation)[0].spin.z
    };
    let [early, late] = [0.2, 0.8].map(|share| (share * lasts / dt) as u64);
    let slowed = spin(&mut simulation, early) - spin(&mut simulation, late);
    // The cap is as accurate as the overlap, 1e-16 R of 1e-5 m.
    let exact = rate * (late - early) as f64 * dt;
    assert!((slowed / exact - 1.0).abs() < 1e-9, "{slowed} {exact}");
    // Then it swings with (k_w/(q m))^(1/2) and decays with gamma/(2 q): 250/s.
    let rest = spin(&mut simulation, (2.0 * lasts / dt) as u64);
    assert!(rest.abs() < 1e-9 * first, "{rest}");
    let world = simulation.world();
    let error = totals::of_world(world).energy() - world.resource::<EnergyFlows>().expected();
    // The first step loads the spring to its cap, and the swing at the end has at most the energy of the full spring.
    let swing = 0.5 * (MU_W * M * G).powi(2) / K_W;
    assert!(error.abs() < 2.0 * swing, "{error:e} {swing:e}");
}

#[test]
fn a_spring_below_its_cap_swings_with_its_frequency() {
    // Two spheres that a pull holds together at k delta = P spin against each other: m R*^2/I = 5/8 for each, so that the relative
    // velocity swings with w^2 = k_w R*^2 2/I.
    let pull = 20.0;
    let dt = 1.0e-6;
    let overlap = pull / K;
    let half = R - 0.5 * overlap;
    let keys =
        format!("{}, gravity: (0.0, 0.0, 0.0), step: Fixed({dt:?})", law(0.0, &format!(", adhesion: Force({pull:?})")));
    let [mut one, mut other] =
        [1.0, -1.0].map(|side| sphere(if side > 0.0 { 1 } else { 2 }, Solid::X * half * side, Solid::ZERO, R, M));
    let spin = 1.0;
    (one.spin, other.spin) = (Solid::X * spin, Solid::X * -spin);
    let mut simulation = simulation(&keys, vec![one, other]);
    let frequency = (K_W * (0.5 * R).powi(2) * 2.0 / INERTIA).sqrt();
    for part in 1..=6 {
        let steps = (f64::from(part) / frequency / dt) as u64;
        simulation.run_steps(steps);
        let now = motion(&mut simulation);
        let exact = spin * (frequency * steps as f64 * dt).cos();
        // Second order, w dt = 1.6e-3 here, and an empty spring at the start.
        assert!((now[0].spin.x - exact).abs() < 1e-5, "{part}: {} {exact}", now[0].spin.x);
        assert!((now[0].spin + now[1].spin).length() < 1e-12);
    }
}
