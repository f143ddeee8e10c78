//! Walls that forces move: an oblique impact on a floor that hangs on a spring, and a lid that falls on a row of discs.

use glam::DVec2;

use super::super::case::{Case, Measure, disc, linear};
use super::super::reference::closed::duration;
use super::super::reference::{Floor, Friction, Law, Piston, System};

const K: f64 = 1.0e6;
const E: f64 = 0.5;
const R: f64 = 0.05;
const M: f64 = 1.3;

pub(super) fn cases() -> Vec<Case> {
    vec![on_spring(), lid()]
}

/// A disc hits a floor of twice its mass at rest on a spring that would swing half a period within the contact. Friction slips and sticks.
fn on_spring() -> Case {
    let speed = 0.5;
    let mass = 2.0 * M;
    let contact_duration = duration(K, E, false, M * mass / (M + mass));
    let friction = Some(Friction { k: 0.29 * K, share: 0.5, mu: 0.3, rolling: None });
    let spring = mass * (std::f64::consts::PI / contact_duration).powi(2);
    let start = DVec2::new(0.0, R + 0.3 * speed * contact_duration);
    let floor = Floor { piston: Some(Piston { disc: 1, load: 0.0, spring }), ..Floor::still(DVec2::ZERO, DVec2::Y) };
    let system = System {
        clumps: vec![],
        gravity: DVec2::ZERO,
        law: Law::Linear { k: K, e: E, attracts: false, friction },
        discs: vec![disc(R, M, start, DVec2::new(0.6, -1.0) * speed), disc(0.0, mass, DVec2::ZERO, DVec2::ZERO)],
        floors: vec![floor],
    };
    Case {
        measure: Measure::Velocity(speed),
        ..Case::integrated("piston-floor", "impact on a floor on a spring, e = 0.5", system, contact_duration)
    }
}

/// Two discs on a floor, and a lid of twice their mass with a load, which falls on them.
fn lid() -> Case {
    let speed = 0.5;
    let mass = 2.0 * M;
    let contact_duration = duration(K, E, false, M * mass / (M + mass));
    let height = 4.0 * R;
    let gap = 0.3 * speed * contact_duration;
    let lid = Floor {
        piston: Some(Piston { disc: 2, load: 200.0, spring: 0.0 }),
        ..Floor::still(DVec2::new(0.0, height + gap), DVec2::NEG_Y)
    };
    let at = |y: f64| disc(R, M, DVec2::new(0.0, y), DVec2::ZERO);
    let system = System {
        clumps: vec![],
        gravity: DVec2::NEG_Y * 9.81,
        law: linear(K, E, false),
        discs: vec![at(R), at(3.0 * R), disc(0.0, mass, DVec2::new(0.0, height + gap), DVec2::NEG_Y * speed)],
        floors: vec![Floor::still(DVec2::ZERO, DVec2::Y), lid],
    };
    Case {
        measure: Measure::Velocity(speed),
        ..Case::integrated("piston-lid", "loaded lid that falls on two discs, e = 0.5", system, contact_duration)
    }
}
