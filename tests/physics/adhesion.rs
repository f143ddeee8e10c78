//! Adhesion by a pull between touching bodies, against closed forms.
//!
//! A body below a ceiling hangs on the pull P as long as its weight is less than P. In the linear law with drag the overlap
//! obeys delta'' + 2 beta delta' + w0^2 delta = P/m, so that a bounce has a closed form, and a speed below which it ends in
//! sticking.

use std::f64::consts::PI;

use siloflow::dem::space::Solid;
use siloflow::energy::EnergyFlows;
use siloflow::measure::totals;
use siloflow::prelude::*;

use crate::{grain, motion, simulation, sphere, state};

const R: f64 = 0.01;
const M: f64 = 0.01;
const YOUNG: f64 = 1.0e7;
const POISSON: f64 = 0.3;
const WORK: f64 = 5.0;
const K: f64 = 1.0e4;

fn hertz(adhesion: &str, friction: f64) -> String {
    format!(
        "contact: Hertz(restitution: 0.3, tangential: Mindlin(friction: {friction:?}), adhesion: {adhesion}), \
         materials: [(young: {YOUNG:?}, poisson: {POISSON:?})]"
    )
}

/// Returns whether a sphere with the weight `share` times 2 pi w R* hangs after the time of thirty contacts at its weight.
/// It hangs on a plane, or on a fixed sphere of `partner` (m) radius.
fn hangs(share: f64, partner: Option<f64>) -> bool {
    let reduced = partner.map_or(R, |radius| R * radius / (R + radius));
    let pull = 2.0 * PI * WORK * reduced;
    let gravity = share * pull / M;
    // The overlap at which spring and weight balance the pull; at touch if the weight is greater.
    let modulus = YOUNG / (2.0 * (1.0 - POISSON * POISSON));
    let overlap = (0.75 * ((1.0 - share) * pull).max(0.0) / (modulus * reduced.sqrt())).powf(2.0 / 3.0);
    let wall = partner.map_or_else(
        || "HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, -1.0))".to_owned(),
        |radius| format!("Disc(centre: (0.0, 0.0, {radius:?}), radius: {radius:?})"),
    );
    let keys = format!(
        "space: Solid, gravity: (0.0, 0.0, {:?}), walls: [{wall}], {}, step: Fixed(1.0e-5), until: 1.0",
        -gravity,
        hertz(&format!("Dmt({WORK:?})"), 0.5)
    );
    // A start slightly below the balance, for both outcomes.
    let start = -R + 0.999 * overlap;
    let mut simulation = simulation(&keys, vec![sphere(1, Solid::Z * start, Solid::ZERO, R, M)]);
    simulation.run_steps(5000);
    motion(&mut simulation)[0].position.z > -1.01 * R
}

#[test]
fn pull_off_force_of_dmt_is_two_pi_w_r() {
    for partner in [None, Some(2.0 * R)] {
        assert!(hangs(0.999, partner), "{partner:?}");
        assert!(!hangs(1.001, partner), "{partner:?}");
    }
}

/// The bounce of a mass on a wall with the linear law and a pull: overlap and closing speed at a time after touch.
#[derive(Clone, Copy)]
struct Swing {
    rest: f64,
    decay: f64,
    frequency: f64,
    speed: f64,
}

impl Swing {
    fn at(&self, t: f64) -> [f64; 2] {
        let Self { rest, decay, frequency: w, speed } = *self;
        let sine = (speed - decay * rest) / w;
        let s = (w * t).sin();
        let c = (w * t).cos();
        let fades = (-decay * t).exp();
        let from_rest = fades * (sine * s - rest * c);
        let rate = fades * w * (sine * c + rest * s) - decay * from_rest;
        [rest + from_rest, rate]
    }

    /// Returns the restitution; `None` if the mass sticks.
    fn restitution(&self) -> Option<f64> {
        let period = 2.0 * PI / self.frequency;
        let parts = (1..20_000).map(|part| f64::from(part) / 20_000.0 * period);
        let first = parts.into_iter().find(|&t| self.at(t)[0] < 0.0)?;
        let mut low = first - period / 20_000.0;
        let mut high = first;
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.at(middle)[0] > 0.0 { low = middle } else { high = middle }
        }
        Some(-self.at(high)[1] / self.speed)
    }
}

/// Restitution and pull of the linear law.
const E: f64 = 0.7;
const PULL: f64 = 2.0;

fn swing(speed: f64) -> Swing {
    let zeta = -E.ln() / E.ln().hypot(PI);
    let natural = (K / M).sqrt();
    Swing { rest: PULL / K, decay: zeta * natural, frequency: natural * (1.0 - zeta * zeta).sqrt(), speed }
}

/// Runs the bounce in steps of `dt` (s) that begin a share `phase` of a step before the touch; returns its restitution,
/// 0 if the grain sticks.
fn bounce(scheme: &str, speed: f64, dt: f64, phase: f64) -> f64 {
    let keys = format!(
        "gravity: (0.0, 0.0), walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))], contact: Linear(k: {K:?}, damping: \
         Restitution({E:?}), attraction: Allowed, tangential: Spring(k: 1.0e3, damping: B(0.0), friction: 0.0), adhesion: \
         Force({PULL:?})), integrator: {scheme}, step: Fixed({dt:?}), until: 1.0"
    );
    let start = Vector::Y * (R + (1.0 + phase) * speed * dt);
    let mut simulation = simulation(&keys, vec![grain(1, start, -Vector::Y * speed, R, M)]);
    simulation.run_steps((4.0 * PI * (M / K).sqrt() / dt) as u64);
    let (position, velocity) = state(&mut simulation)[0];
    if position.y > R { velocity.y / speed } else { 0.0 }
}

#[test]
fn linear_bounce_with_a_pull_follows_its_closed_form_with_second_order() {
    let speed = 0.4;
    let period = 2.0 * PI * (M / K).sqrt();
    let exact = swing(speed).restitution().unwrap();
    assert!(exact < E - 0.02, "the pull matters: {exact}");
    let error = |scheme: &str, n: f64| {
        let phases = (0..20).map(|phase| bounce(scheme, speed, period / n, f64::from(phase) / 20.0) - exact);
        crate::rms(&phases.collect::<Vec<_>>())
    };
    let [coarse, fine] = [40.0, 160.0].map(|n| error("Centred", n));
    let order = (coarse / fine).log2() / 2.0;
    // As in `accuracy`: the next order changes the order by 0.1, and so do 20 phases.
    assert!((order - 2.0).abs() < 0.25, "order {order}: {coarse:e}, {fine:e}");
    assert!(fine < 1e-3, "{fine:e}");
    let [coarse, fine] = [40.0, 160.0].map(|n| error("Verlet", n));
    let order = (coarse / fine).log2() / 2.0;
    assert!((order - 1.0).abs() < 0.25, "order {order}: {coarse:e}, {fine:e}");
}

#[test]
fn slow_grains_stick_and_fast_ones_leave() {
    // The speed at which the closed form begins to leave, by bisection.
    let mut low = 1e-3;
    let mut high = 1.0;
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if swing(middle).restitution().is_none() { low = middle } else { high = middle }
    }
    let dt = 2.0 * PI * (M / K).sqrt() / 400.0;
    for phase in [0.0, 0.3, 0.6] {
        assert!(bounce("Centred", 0.99 * high, dt, phase) == 0.0, "{high} m/s");
        assert!(bounce("Centred", 1.01 * high, dt, phase) > 0.0, "{high} m/s");
    }
}

#[test]
fn pull_counts_in_the_cap_of_friction() {
    // A sphere that a floor pulls down and gravity drags along: it slides with g - mu P/m, if that is more than it could
    // roll with, 5/7 g.
    let pull = 2.0 * PI * WORK * R;
    let mu = 0.4;
    let gravity = 2.0 * 3.5 * 0.4 * pull / M;
    let keys = format!(
        "space: Solid, gravity: ({gravity:?}, 0.0, 0.0), walls: [HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))], {}, \
         step: Fixed(1.0e-5), until: 1.0",
        hertz(&format!("Dmt({WORK:?})"), mu)
    );
    let modulus = YOUNG / (2.0 * (1.0 - POISSON * POISSON));
    let overlap = (0.75 * pull / (modulus * R.sqrt())).powf(2.0 / 3.0);
    let mut simulation = simulation(&keys, vec![sphere(1, Solid::Z * (R - overlap), Solid::ZERO, R, M)]);
    let speed = |simulation: &mut Simulation, step: u64| {
        simulation.run_steps(step);
        motion(simulation)[0].velocity.x
    };
    let [early, late] = [1000, 2000].map(|step| speed(&mut simulation, step));
    let acceleration = (late - early) / 0.01;
    let exact = gravity - mu * pull / M;
    // The overlap of the start has a rounding error of 1e-16 R, which is 1e-13 of it.
    assert!((acceleration / exact - 1.0).abs() < 1e-9, "{acceleration} {exact}");
}

#[test]
fn energy_balance_of_sticking_is_of_second_order() {
    let error = |dt: f64| {
        let keys = format!(
            "gravity: (0.0, 0.0), walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))], {}, step: Fixed({dt:?}), until: 1.0",
            hertz(&format!("Dmt({WORK:?})"), 0.3)
        );
        let errors = (0..20).map(|phase| {
            let start = Vector::new(0.0, R + (1.0 + f64::from(phase) / 20.0) * 0.2 * dt);
            let grains = vec![grain(1, start, Vector::new(0.05, -0.2), R, M)];
            let mut simulation = simulation(&keys, grains);
            simulation.run_steps((0.004 / dt) as u64);
            assert!(state(&mut simulation)[0].0.y < R, "it sticks");
            let world = simulation.world();
            totals::of_world(world).energy() - world.resource::<EnergyFlows>().expected()
        });
        crate::rms(&errors.collect::<Vec<_>>()) / (0.5 * M * 0.04)
    };
    let [coarse, fine] = [2.0e-5, 5.0e-6].map(error);
    let order = (coarse / fine).log2() / 2.0;
    assert!(order > 1.7, "order {order}: {coarse:e}, {fine:e}");
}
