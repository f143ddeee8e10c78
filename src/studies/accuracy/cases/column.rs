//! Ten grains, one above the other, fall on a floor and settle, e = 0.5. The error is evaluated while they still move.

use glam::DVec2;

use super::super::case::{Case, Measure, Truth, disc, linear};
use super::super::reference::closed::duration;
use super::super::reference::{Floor, System};

pub(super) fn case() -> Case {
    let k = 1.0e5;
    let e = 0.5;
    let radius = 0.04;
    let mass = 0.16;
    let speed = 0.5;
    let contact_duration = duration(k, e, false, 0.5 * mass);
    let gap = 0.3 * speed * contact_duration;
    let height = |i: u32| f64::from(i) * (2.0 * radius + 0.3 * gap) + radius + 1.5 * gap;
    let discs = (0..10).map(|i| disc(radius, mass, DVec2::new(0.0, height(i)), DVec2::new(0.0, -speed))).collect();
    let floors = vec![Floor::still(DVec2::ZERO, DVec2::Y)];
    Case {
        name: "column",
        title: "settling column of ten, e = 0.5",
        systems: vec![System {
            clumps: vec![],
            gravity: DVec2::new(0.0, -9.81),
            law: linear(k, e, false),
            discs,
            floors,
        }],
        contact_duration,
        end: 20.0 * contact_duration,
        truth: Truth::Integrated,
        measure: Measure::Velocity(speed),
        finest: 500.0,
        touch: None,
    }
}
