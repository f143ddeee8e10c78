//! Three grains in a row, the third nearly touching the second: two damped contacts at once.

use glam::DVec2;

use super::super::case::{Case, Measure, Truth, disc, linear};
use super::super::reference::System;
use super::super::reference::closed::duration;

pub(super) fn case() -> Case {
    let (k, e, v) = (1.0e5, 0.5, 1.0);
    let contact_duration = duration(k, e, false, 0.09 * 0.12 / 0.21);
    let (lead, gap) = (0.3 * v * contact_duration, 0.1 * v * contact_duration);
    let at = |y: f64| DVec2::new(0.0, y);
    let discs = vec![
        disc(0.03, 0.12, DVec2::ZERO, DVec2::ZERO),
        disc(0.03, 0.09, at(0.06 + gap), DVec2::ZERO),
        disc(0.04, 0.16, at(0.13 + gap + lead), at(-v)),
    ];
    Case {
        name: "chain",
        title: "chain of three, e = 0.5",
        systems: vec![System { gravity: DVec2::ZERO, law: linear(k, e, false), discs, floors: vec![] }],
        contact_duration,
        end: 6.0 * contact_duration,
        truth: Truth::Integrated,
        measure: Measure::Velocity(v),
        finest: 1000.0,
    }
}
