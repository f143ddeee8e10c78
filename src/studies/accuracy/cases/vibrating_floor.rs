//! Oblique impact on a floor that vibrates up, down and sideways: walls that move, with friction and drag.

use glam::DVec2;

use super::super::case::{Case, Measure, Truth, disc};
use super::super::reference::closed::duration;
use super::super::reference::{Floor, Friction, Law, System, Vibration};

pub(super) fn case() -> Case {
    let k = 1.0e6;
    let e = 0.5;
    let radius = 0.05;
    let mass = 1.3;
    let speed = 0.5;
    let contact_duration = duration(k, e, false, mass);
    let friction = Some(Friction { k: 0.29 * k, share: 0.5, mu: 0.3, rolling: None });
    let law = Law::Linear { k, e, attracts: false, friction };
    // A fifth of a period passes during the impact, at a third of the speed of the disc.
    let frequency = 0.2 / contact_duration;
    let amplitude = DVec2::new(0.02, 0.05) * speed / frequency;
    let floor = Floor { vibration: Some(Vibration { amplitude, frequency }), ..Floor::still(DVec2::ZERO, DVec2::Y) };
    // The floor is at its highest place after a quarter of a period.
    let start = DVec2::new(0.0, radius + amplitude.y + 0.3 * speed * contact_duration);
    Case {
        name: "vibrating-floor",
        title: "impact on a vibrating floor, e = 0.5",
        systems: vec![System {
            clumps: vec![],
            gravity: DVec2::ZERO,
            law,
            discs: vec![disc(radius, mass, start, DVec2::new(0.6, -1.0) * speed)],
            floors: vec![floor],
        }],
        contact_duration,
        end: 4.0 * contact_duration,
        truth: Truth::Integrated,
        measure: Measure::Velocity(speed),
        finest: 1000.0,
        touch: None,
    }
}
