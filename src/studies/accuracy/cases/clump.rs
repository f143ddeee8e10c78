//! Rigid bodies of three discs in a row: one that hits a floor with its end, and two that meet off their centres.

use glam::DVec2;

use super::super::case::{Case, Measure, Truth, disc, linear};
use super::super::reference::closed::duration;
use super::super::reference::{Clump, Disc, Floor, Friction, Law, System};

const K: f64 = 1.0e5;
const E: f64 = 0.5;
const M: f64 = 0.5;
const R: f64 = 0.03;
/// Distance of neighbouring discs, m.
const APART: f64 = 0.035;

pub(super) fn cases() -> Vec<Case> {
    vec![end_on_floor(), pair()]
}

/// Square of the radius of gyration of the union of three discs in a row, m^2: integrals over its length of the width 2 h(x).
fn gyration() -> f64 {
    let count = 400_000;
    let half = APART + R;
    let mut area = 0.0;
    let mut moment = 0.0;
    for number in 0..count {
        let x = half * ((2.0 * f64::from(number) + 1.0) / f64::from(count) - 1.0);
        let squared = |centre: f64| R * R - (x - centre).powi(2);
        let h = squared(-APART).max(squared(0.0)).max(squared(APART)).max(0.0).sqrt();
        area += h;
        moment += h * x * x + h.powi(3) / 3.0;
    }
    moment / area
}

/// Returns the centre and the three discs of a clump with its axis along `axis`.
fn discs(centre: DVec2, axis: DVec2, v: DVec2) -> Vec<Disc> {
    let middle = disc(0.0, M, centre, v);
    std::iter::once(middle).chain([-APART, 0.0, APART].map(|at| disc(R, M, centre + axis * at, v))).collect()
}

fn clump(first: usize) -> Clump {
    Clump { centre: first, members: first + 1..first + 4, inertia: M * gyration() }
}

/// Returns 1/m (1/kg) of a clump for a force along n at the end of the arm r.
fn mobility(arm: DVec2, n: DVec2) -> f64 {
    (1.0 + arm.perp_dot(n).powi(2) / gyration()) / M
}

fn end_on_floor() -> Case {
    let axis = DVec2::from_angle(0.6);
    let arm = -axis * APART - DVec2::Y * R;
    let contact_duration = duration(K, E, false, 1.0 / mobility(arm, DVec2::Y));
    let centre = DVec2::Y * (R + APART * axis.y + 0.3 * contact_duration);
    let friction = Some(Friction { k: 2.0 / 7.0 * K, share: 0.5, mu: 0.3, rolling: None });
    let system = System {
        clumps: vec![clump(0)],
        gravity: DVec2::ZERO,
        law: Law::Linear { k: K, e: E, attracts: false, friction },
        discs: discs(centre, axis, DVec2::new(0.5, -1.0)),
        floors: vec![Floor::still(DVec2::ZERO, DVec2::Y)],
    };
    case("clump-floor", "clump of three discs, end on floor, friction", system, contact_duration)
}

fn pair() -> Case {
    let up = DVec2::Y * 2.0 * R;
    let contact_duration = duration(K, E, false, 1.0 / (2.0 * mobility(DVec2::new(APART, R), DVec2::Y)));
    // The last disc of the first clump meets the first disc of the second one, which lies above it and a little beside.
    let aside = DVec2::new(2.0 * APART + 0.3 * R, 0.0);
    let height = DVec2::Y * ((4.0 - 0.09_f64).sqrt() * R + 0.3 * contact_duration);
    let mut both = discs(DVec2::ZERO, DVec2::X, DVec2::ZERO);
    both.extend(discs(aside + height, DVec2::X, -up.normalize()));
    let system = System {
        clumps: vec![clump(0), clump(4)],
        gravity: DVec2::ZERO,
        law: linear(K, E, false),
        discs: both,
        floors: vec![],
    };
    case("clump-pair", "two clumps of three discs, off their centres", system, contact_duration)
}

fn case(name: &'static str, title: &'static str, system: System, contact_duration: f64) -> Case {
    Case {
        name,
        title,
        systems: vec![system],
        contact_duration,
        end: 4.0 * contact_duration,
        truth: Truth::Integrated,
        measure: Measure::Velocity(1.0),
        finest: 1000.0,
        touch: None,
    }
}
