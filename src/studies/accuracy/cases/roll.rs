//! A disc set down on a rough floor with a horizontal speed: it slides until it rolls.

use glam::DVec2;

use super::super::case::{Case, Measure, Truth, disc};
use super::super::reference::closed::duration;
use super::super::reference::{Floor, Friction, Law, System};

pub(super) fn case() -> Case {
    let k = 1.0e6;
    let e = 0.5;
    let radius = 0.05;
    let mass = 1.3;
    let g = 9.81;
    let speed = 0.1;
    let contact_duration = duration(k, e, false, mass);
    // The disc falls for half a contact duration, so that it presses on the floor at once without bouncing far. It
    // slides for about speed/(3 mu g), which is three contact durations.
    let drop = 0.5 * g * (0.5 * contact_duration).powi(2);
    let friction = Some(Friction { k: 0.29 * k, share: 0.5, mu: 0.3, rolling: None });
    let law = Law::Linear { k, e, attracts: false, friction };
    let floors = vec![Floor::still(DVec2::ZERO, DVec2::Y)];
    let discs = vec![disc(radius, mass, DVec2::new(0.0, radius + drop), DVec2::new(speed, 0.0))];
    Case {
        name: "slip-to-roll",
        title: "from slip to roll",
        systems: vec![System { clumps: vec![], gravity: DVec2::new(0.0, -g), law, discs, floors }],
        contact_duration,
        end: 4.5 * contact_duration,
        truth: Truth::Integrated,
        measure: Measure::Velocity(speed),
        finest: 1000.0,
        touch: None,
    }
}
