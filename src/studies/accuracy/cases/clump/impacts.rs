//! Rigid bodies of three discs in a row: one that hits a floor with its end, and two that meet off their centres.

use glam::DVec2;

use super::super::super::case::{Case, linear};
use super::super::super::reference::closed::duration;
use super::super::super::reference::{Floor, Friction, Law, System};
use super::body::{Body, Motion};

const K: f64 = 1.0e5;
const E: f64 = 0.5;
const R: f64 = 0.03;
/// Distance of neighbouring discs, m.
const APART: f64 = 0.035;

pub(super) fn cases() -> Vec<Case> {
    vec![end_on_floor(), pair()]
}

fn rod() -> Body {
    Body::row(0.5, R, 3, APART)
}

fn end_on_floor() -> Case {
    let axis = DVec2::from_angle(0.6);
    let arm = -axis * APART - DVec2::Y * R;
    let contact_duration = duration(K, E, false, 1.0 / rod().mobility(arm, DVec2::Y));
    let centre = DVec2::Y * (R + APART * axis.y + 0.3 * contact_duration);
    let friction = Some(Friction { k: 2.0 / 7.0 * K, share: 0.5, mu: 0.3, rolling: None });
    let system = System {
        clumps: vec![rod().clump(0, 0.0)],
        gravity: DVec2::ZERO,
        law: Law::Linear { k: K, e: E, attracts: false, friction },
        discs: rod().discs(&Motion { centre, axis, v: DVec2::new(0.5, -1.0) }),
        floors: vec![Floor::still(DVec2::ZERO, DVec2::Y)],
    };
    Case::integrated("clump-floor", "clump of three discs, end on floor, friction", system, contact_duration)
}

fn pair() -> Case {
    let up = DVec2::Y * 2.0 * R;
    let contact_duration = duration(K, E, false, 1.0 / (2.0 * rod().mobility(DVec2::new(APART, R), DVec2::Y)));
    // The last disc of the first clump meets the first disc of the second one, which lies above it and a little beside.
    let aside = DVec2::new(2.0 * APART + 0.3 * R, 0.0);
    let height = DVec2::Y * ((4.0 - 0.09_f64).sqrt() * R + 0.3 * contact_duration);
    let mut both = rod().discs(&Motion { centre: DVec2::ZERO, axis: DVec2::X, v: DVec2::ZERO });
    both.extend(rod().discs(&Motion { centre: aside + height, axis: DVec2::X, v: -up.normalize() }));
    let system = System {
        clumps: vec![rod().clump(0, 0.0), rod().clump(4, 0.0)],
        gravity: DVec2::ZERO,
        law: linear(K, E, false),
        discs: both,
        floors: vec![],
    };
    Case::integrated("clump-pair", "two clumps of three discs, off their centres", system, contact_duration)
}
