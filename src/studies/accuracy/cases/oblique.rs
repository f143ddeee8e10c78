//! Oblique impacts: two smooth discs, and one disc with friction on a floor.
//!
//! The disc with friction slides throughout, sticks first and slides at the end, or sticks until it parts. The laws are the
//! spring slider, the spring slider with rolling resistance, and the law of Hertz and Mindlin with and without adhesion.

use glam::DVec2;

use super::super::case::{Case, Measure, disc, linear};
use super::super::reference::closed::duration;
use super::super::reference::{Floor, Friction, Law, Rolling, System};

const K: f64 = 1.0e5;
const E: f64 = 0.5;
const M: f64 = 0.16;
const R: f64 = 0.04;
/// Young's modulus of the law of Hertz and Mindlin, Pa.
const YOUNG: f64 = 4.0e6;

pub(super) fn cases() -> Vec<Case> {
    // Sliding throughout needs v_t/v_n > mu (1 + 1/q) (1 + e) = 1.35, where q = 1/2 is the moment of inertia over m
    // R^2.
    let rolling = Some(Rolling { k: 0.1 * K, b: 100.0 * M, mu: 0.2 });
    vec![
        smooth(),
        rough("oblique-slip", "oblique with friction, sliding", spring(E, 0.3, None), DVec2::new(3.0, -1.0)),
        rough("oblique-stick", "oblique with friction, sticking", spring(E, 0.3, None), DVec2::new(0.5, -1.0)),
        rough("oblique-rough", "oblique, mu = 1, e = 0.9", spring(0.9, 1.0, None), DVec2::new(1.0, -1.0)),
        // At e = 0.5 the tangential spring happens to be empty when the disc parts.
        rough(
            "oblique-stuck",
            "oblique, stuck until parting, e = 0.9",
            spring(0.9, 1.0e3, None),
            DVec2::new(1.0, -1.0),
        ),
        rough("oblique-rolling", "oblique with rolling resistance", spring(E, 0.5, rolling), DVec2::new(1.0, -1.0)),
        rough("mindlin-slip", "Hertz and Mindlin, sliding", mindlin(0.1), DVec2::new(1.0, -1.0)),
        rough("mindlin-stick", "Hertz and Mindlin, sticking", mindlin(0.5), DVec2::new(0.5, -1.0)),
        rough("adhesive", "Hertz and Mindlin with adhesion", adhesive(0.3), DVec2::new(1.0, -1.0)),
        rough("mindlin-stuck", "Hertz and Mindlin, stuck until parting", mindlin(1.0e3), DVec2::new(0.5, -1.0)),
    ]
}

/// Returns the linear law with a spring slider and rolling resistance.
fn spring(e: f64, mu: f64, rolling: Option<Rolling>) -> Law {
    Law::Linear { k: K, e, attracts: false, friction: Some(Friction { k: 2.0 / 7.0 * K, share: 0.5, mu, rolling }) }
}

fn mindlin(mu: f64) -> Law {
    Law::Hertz { young: YOUNG, poisson: 0.3, e: E, mu }
}

/// Returns the same law with a pull of 10 N, an eighth of the largest force at 1 m/s.
fn adhesive(mu: f64) -> Law {
    Law::Adhesive { young: YOUNG, poisson: 0.3, e: E, mu, work: 40.0 }
}

fn smooth() -> Case {
    let contact_duration = duration(K, E, false, 0.16 * 0.09 / 0.25);
    let v = DVec2::new(0.0, -1.0);
    // The lateral offset of the centres is half the sum of the radii.
    let aside = 0.5 * 0.07;
    let lead = 0.3 * contact_duration;
    let up = (0.07f64.powi(2) - aside * aside).sqrt() + lead;
    let discs = vec![disc(R, M, DVec2::ZERO, DVec2::ZERO), disc(0.03, 0.09, DVec2::new(aside, up), v)];
    let system = System { clumps: vec![], gravity: DVec2::ZERO, law: linear(K, E, false), discs, floors: vec![] };
    Case::integrated("oblique-smooth", "oblique, smooth, e = 0.5", system, contact_duration)
}

fn rough(name: &'static str, title: &'static str, law: Law, v: DVec2) -> Case {
    let contact_duration = match law {
        Law::Linear { e, .. } => duration(K, e, false, M),
        // Such a contact lasts 5.6 ms at 1 m/s.
        _ => 5.6e-3,
    };
    let start = DVec2::new(0.0, R + 0.3 * contact_duration * -v.y);
    let floors = vec![Floor::still(DVec2::ZERO, DVec2::Y)];
    let system = System { clumps: vec![], gravity: DVec2::ZERO, law, discs: vec![disc(R, M, start, v)], floors };
    let measure = Measure::Velocity(v.length());
    Case { measure, ..Case::integrated(name, title, system, contact_duration) }
}
