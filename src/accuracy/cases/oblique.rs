//! Oblique impacts with e = 0.5: two smooth discs, and one disc with friction on a floor.
//!
//! The disc with friction slides throughout in one case and first sticks in the other.

use glam::DVec2;

use super::super::case::{Case, Measure, Truth, disc, linear};
use super::super::reference::closed::duration;
use super::super::reference::{Floor, Friction, Law, System};

const K: f64 = 1.0e5;
const E: f64 = 0.5;
const M: f64 = 0.16;
const R: f64 = 0.04;

pub(super) fn cases() -> Vec<Case> {
    // Sliding throughout needs v_t/v_n > mu (1 + 1/q) (1 + e) = 1.35, where q = 1/2 is the moment of inertia over m
    // R^2.
    vec![
        smooth(),
        rough("oblique-slip", "oblique with friction, sliding", DVec2::new(3.0, -1.0)),
        rough("oblique-stick", "oblique with friction, sticking", DVec2::new(0.5, -1.0)),
    ]
}

fn smooth() -> Case {
    let contact_duration = duration(K, E, false, 0.16 * 0.09 / 0.25);
    let v = DVec2::new(0.0, -1.0);
    // The lateral offset of the centres is half the sum of the radii.
    let (aside, lead) = (0.5 * 0.07, 0.3 * contact_duration);
    let up = (0.07f64.powi(2) - aside * aside).sqrt() + lead;
    let discs = vec![disc(R, M, DVec2::ZERO, DVec2::ZERO), disc(0.03, 0.09, DVec2::new(aside, up), v)];
    Case {
        name: "oblique-smooth",
        title: "oblique, smooth, e = 0.5",
        systems: vec![System { gravity: DVec2::ZERO, law: linear(K, E, false), discs, floors: vec![] }],
        contact_duration,
        end: 4.0 * contact_duration,
        truth: Truth::Integrated,
        measure: Measure::Velocity(1.0),
        finest: 1000.0,
    }
}

fn rough(name: &'static str, title: &'static str, v: DVec2) -> Case {
    let contact_duration = duration(K, E, false, M);
    let friction = Some(Friction { k: 2.0 / 7.0 * K, share: 0.5, mu: 0.3 });
    let law = Law::Linear { k: K, e: E, attracts: false, friction };
    let start = DVec2::new(0.0, R + 0.3 * contact_duration * -v.y);
    let floors = vec![Floor { point: DVec2::ZERO, normal: DVec2::Y }];
    Case {
        name,
        title,
        systems: vec![System { gravity: DVec2::ZERO, law, discs: vec![disc(R, M, start, v)], floors }],
        contact_duration,
        end: 4.0 * contact_duration,
        truth: Truth::Integrated,
        measure: Measure::Velocity(v.length()),
        finest: 1000.0,
    }
}
