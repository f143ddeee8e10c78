//! Head-on bounce of two unequal grains, with and without attraction: error of the restitution against its closed form.

use std::f64::consts::PI;

use glam::DVec2;

use super::super::case::{Case, Measure, Truth, disc, linear};
use super::super::reference::closed::{after_bounce, duration};
use super::super::reference::{Law, State, System};

const K: f64 = 1.0e5;
const V: f64 = 1.0;
/// Time until the contact begins, in contact durations: the grains do not touch within the first step, even if the step is
/// t_c/5.
const GAP: f64 = 0.3;
const MASSES: [f64; 2] = [0.16, 0.09];

const CASES: [(&str, &str, f64, bool); 7] = [
    ("bounce-0.9", "bounce, e = 0.9", 0.9, true),
    ("bounce-0.5", "bounce, e = 0.5", 0.5, true),
    ("bounce-0.2", "bounce, e = 0.2", 0.2, true),
    ("bounce-cut-0.9", "bounce, no attraction, e = 0.9", 0.9, false),
    ("bounce-cut-0.5", "bounce, no attraction, e = 0.5", 0.5, false),
    ("bounce-cut-0.2", "bounce, no attraction, e = 0.2", 0.2, false),
    ("bounce-cut-0.05", "bounce, strong drag, e = 0.05", 0.05, false),
];

pub(super) fn cases() -> Vec<Case> {
    let mut cases = CASES.map(|(name, title, e, attracts)| case(name, title, e, attracts)).to_vec();
    let mut at_start = case("bounce-at-start", "bounce that begins in the first half step, e = 0.5", 0.5, false);
    at_start.touch = Some(GAP * at_start.contact_duration);
    cases.push(at_start);
    cases.push(jkr());
    cases
}

/// Returns the bounce of elastic spheres with adhesion beyond touch. The work of adhesion takes 8 % of the energy.
fn jkr() -> Case {
    let young = 4.0e6;
    let poisson = 0.3;
    let work = 70.0;
    // At 1 m/s; the contact lasts longer with adhesion.
    let reduced = MASSES[0] * MASSES[1] / (MASSES[0] + MASSES[1]);
    let stiffness = 4.0 / 3.0 * young / (2.0 * (1.0 - poisson * poisson)) * (0.04f64 * 0.03 / 0.07).sqrt();
    let contact_duration = 2.943_275 * (1.25 * reduced * V * V / stiffness).powf(0.4) / V;
    let bounce = case("bounce-jkr", "bounce with adhesion beyond touch", 1.0, true);
    let mut system = bounce.systems[0].clone();
    system.law = Law::Jkr { young, poisson, work };
    system.discs[1].x.y = 0.07 + GAP * V * contact_duration;
    Case { systems: vec![system], contact_duration, end: 6.0 * contact_duration, ..bounce }
}

fn case(name: &'static str, title: &'static str, e: f64, attracts: bool) -> Case {
    let contact_duration = duration(K, e, attracts, MASSES[0] * MASSES[1] / (MASSES[0] + MASSES[1]));
    let gap = GAP * V * contact_duration;
    let discs = vec![
        disc(0.04, MASSES[0], DVec2::ZERO, DVec2::ZERO),
        disc(0.03, MASSES[1], DVec2::new(0.0, 0.07 + gap), DVec2::new(0.0, -V)),
    ];
    Case {
        name,
        title,
        systems: vec![System {
            clumps: vec![],
            gravity: DVec2::ZERO,
            law: linear(K, e, attracts),
            discs,
            floors: vec![],
        }],
        contact_duration,
        end: 4.0 * contact_duration,
        truth: Truth::Closed(state_after_bounce),
        measure: Measure::Parting(V),
        finest: 1000.0,
        touch: None,
    }
}

/// Returns the state after the bounce. Only its velocities are meaningful; the error ignores positions.
fn state_after_bounce(system: &System, _: f64) -> State {
    let d = &system.discs;
    let e = match system.law {
        Law::Linear { e, .. } => e,
        Law::Jkr { young, poisson, work } => {
            // Thornton and Ning, Powder Technology 99, 154, 1998: a breaking contact loses pi w a_0^2 (3/5 + 4^(-1/3)/10).
            let radius = d[0].radius * d[1].radius / (d[0].radius + d[1].radius);
            let modulus = young / (2.0 * (1.0 - poisson * poisson));
            let touch = (2.0 * PI * work * radius * radius / modulus).cbrt();
            let lost = PI * work * touch * touch * (0.6 + 0.1 * 0.25f64.cbrt());
            let mass = d[0].mass * d[1].mass / (d[0].mass + d[1].mass);
            (1.0 - 2.0 * lost / (mass * (d[0].v - d[1].v).length_squared())).sqrt()
        }
        _ => 1.0,
    };
    let v = after_bounce([d[0].mass, d[1].mass], [d[0].v, d[1].v], e);
    State { x: vec![d[0].x, d[1].x], v: v.to_vec(), w: vec![0.0; 2] }
}
