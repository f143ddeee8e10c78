//! The bouncing ball: cases DEM01 and DEM02 of MFiX's verification manual (Garg, Galvin, Li and Pannala, Powder
//! Technology 220, 122, 2012), against closed forms.
//!
//! A ball falls on a floor of stiffness k. The restitution e sets c = 2 zeta sqrt(k m). With u the height above the
//! position of first touch, u'' + 2 zeta w0 u' + w0^2 u = -g while u < 0. As in the manual, attraction is allowed.

use std::f64::consts::PI;

use siloflow::dem::space::Solid;
use siloflow::prelude::*;

use crate::{grain, motion, simulation, sphere};

const G: f64 = 9.81;
const RADIUS: f64 = 0.1;
const START: f64 = 0.5;
/// Steps per undamped contact.
const N: f64 = 200.0 + PI / 8.0;

fn mass() -> f64 {
    2600.0 * 4.0 / 3.0 * PI * RADIUS.powi(3)
}

/// Returns zeta for the restitution `e`, with attraction.
fn zeta(e: f64) -> f64 {
    -e.ln() / (PI * PI + e.ln().powi(2)).sqrt()
}

/// The ball in contact with the floor.
#[derive(Clone, Copy)]
struct Contact {
    w0: f64,
    zeta: f64,
    speed: f64,
}

impl Contact {
    /// Returns u and u' at time `t` after the touch: a damped oscillation about -g/w0^2.
    fn at(&self, t: f64) -> (f64, f64) {
        let beta = self.zeta * self.w0;
        let w = self.w0 * (1.0 - self.zeta * self.zeta).sqrt();
        let sag = G / (self.w0 * self.w0);
        let a = sag;
        let b = (beta * sag - self.speed) / w;
        let (sin, cos) = (w * t).sin_cos();
        let decay = (-beta * t).exp();
        (decay * (a * cos + b * sin) - sag, decay * ((w * b - beta * a) * cos - (w * a + beta * b) * sin))
    }

    /// Returns the time at which the ball leaves, if it does. Gravity delays it beyond the half period.
    fn end(&self) -> Option<f64> {
        let stride = 0.01 / self.w0;
        let mut low = PI / self.w0;
        while self.at(low + stride).0 < 0.0 {
            low += stride;
            if self.at(low).1 < 0.0 {
                return None;
            }
        }
        let mut high = low + stride;
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.at(middle).0 < 0.0 { low = middle } else { high = middle }
        }
        Some(low)
    }
}

/// Returns a simulation of the ball, its time step, and w0 of the floor contact.
fn ball(space: &str, k: f64, e: f64) -> (Simulation, f64, f64) {
    let w0 = (k / mass()).sqrt();
    let dt = PI / w0 / N;
    let contact = format!("contact: Linear(k: {k:?}, damping: Restitution({e:?}), attraction: Allowed)");
    let end = format!("step: Fixed({dt:?}), until: 100.0");
    let simulation = if space == "Solid" {
        let wall = "walls: [HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))]";
        let row = sphere(1, Solid::Z * START, Solid::ZERO, RADIUS, mass());
        simulation(&format!("space: Solid, gravity: (0.0, 0.0, -{G}), {contact}, {wall}, {end}"), vec![row])
    } else {
        let wall = "walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))]";
        let row = grain(1, Vector::Y * START, Vector::ZERO, RADIUS, mass());
        simulation(&format!("gravity: (0.0, -{G}), {contact}, {wall}, {end}"), vec![row])
    };
    (simulation, dt, w0)
}

/// Returns height and vertical velocity after `steps` steps.
fn flight(space: &str, simulation: &mut Simulation, steps: u64) -> (f64, f64) {
    simulation.run_steps(steps);
    let ball = motion(simulation).remove(0);
    if space == "Solid" { (ball.position.z, ball.velocity.z) } else { (ball.position.y, ball.velocity.y) }
}

/// Returns the relative error of the speed after a bounce.
fn bounce_error(zeta: f64, e: f64, w0_dt: f64) -> f64 {
    // The jump of the damping force is off by half a step of c v at either end: zeta w0 dt of the speed there. Damping
    // evaluated half a step late acts like a mass smaller by zeta w0 dt: e = exp(-pi zeta/sqrt(1 - zeta^2)) with zeta
    // larger by half of that. The spring adds (w0 dt)^2.
    zeta * w0_dt * (2.0 + 0.5 * e.ln().abs() / (1.0 - zeta * zeta)) + w0_dt * w0_dt
}

#[test]
fn falling_and_bouncing_ball_matches_its_closed_form() {
    for (space, e) in [("Solid", 1.0), ("Solid", 0.9), ("Solid", 0.5), ("Plane", 1.0), ("Plane", 0.9), ("Plane", 0.5)] {
        let (mut simulation, dt, w0) = ball(space, 5.0e5, e);
        let touch = (2.0 * (START - RADIUS) / G).sqrt();
        let contact = Contact { w0, zeta: zeta(e), speed: G * touch };
        let end = contact.end().unwrap();
        let parting = contact.at(end).1;
        let error = bounce_error(contact.zeta, e, w0 * dt) * contact.speed;
        for sample in 0.. {
            let steps = 7 * sample;
            let t = steps as f64 * dt;
            let (y, v) = flight(space, &mut simulation, steps);
            let (exact_y, exact_v, tolerance_y, tolerance_v) = if t <= touch {
                // Verlet is exact in free flight up to round-off: n eps |x| and n eps |v| t.
                let round_off = 2.0 * steps as f64 * f64::EPSILON * 3.0;
                (START - 0.5 * G * t * t, -G * t, round_off, round_off)
            } else if t < touch + end {
                let (u, v) = contact.at(t - touch);
                (RADIUS + u, v, error / w0, error)
            } else {
                let rise = t - touch - end;
                let y = RADIUS + parting * rise - 0.5 * G * rise * rise;
                let v = parting - G * rise;
                (y, v, error * (1.0 / w0 + rise), error)
            };
            assert!((y - exact_y).abs() <= tolerance_y, "{space}, e = {e}, {t} s: y = {y}, not {exact_y}");
            assert!((v - exact_v).abs() <= tolerance_v, "{space}, e = {e}, {t} s: v = {v}, not {exact_v}");
            if t > touch + end + parting / G {
                break;
            }
        }
    }
}

#[test]
fn bounce_heights_match_the_soft_sphere_and_approach_the_hard_sphere() {
    let fall = START - RADIUS;
    for k in [0.5e5, 5.0e5, 50.0e5] {
        for e in [0.5, 0.6, 0.7, 0.8, 0.9, 1.0] {
            let (mut simulation, dt, w0) = ball("Plane", k, e);
            let zeta = zeta(e);
            let mut speed = (2.0 * G * fall).sqrt();
            let mut now = (2.0 * fall / G).sqrt();
            let mut error = 0.0;
            for bounce in 1..=5 {
                // To first order in g, the contact lasts longer by (1 + e)/e g/(w0^2 v); `delay` is that times w0.
                // Beyond a quarter, gravity dominates the contact.
                let delay = (1.0 + e) / e * G / (w0 * speed);
                if delay > 0.25 {
                    assert!(bounce > 1 && e < 1.0);
                    break;
                }
                let contact = Contact { w0, zeta, speed };
                let end = contact.end().unwrap();
                let parting = contact.at(end).1;
                now += end + parting / G;
                let (y, v) = flight("Plane", &mut simulation, (now / dt) as u64);
                let height = y + v * v / (2.0 * G) - RADIUS;
                // A slower ball loses more: d(ln v')/d(ln v) = 1 + 2 zeta w0 times the delay; doubled for higher
                // orders.
                error = error * (1.0 + 4.0 * zeta * delay) + bounce_error(zeta, e, w0 * dt);
                let soft = parting * parting / (2.0 * G);
                let off = height / soft - 1.0;
                assert!(off.abs() < 2.0 * error, "k = {k}, e = {e}, bounce {bounce}: {height}, not {soft} ({off:e})");
                if bounce == 1 {
                    // Damping during the delay reduces e by 2 zeta w0 times the delay. The height is the hard sphere's,
                    // less twice that share.
                    let hard = fall * e * e * (1.0 - 4.0 * zeta * delay);
                    let tolerance = 2.0 * error + delay * delay;
                    assert!((height / hard - 1.0).abs() < tolerance, "k = {k}, e = {e}: {height}, hard sphere {hard}");
                }
                now += parting / G;
                speed = parting;
            }
        }
    }
}
