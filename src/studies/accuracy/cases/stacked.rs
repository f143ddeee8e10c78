//! Two grains squeezed between a floor and a lid, the lower one twice as heavy. The contacts oscillate and never open.

use glam::DVec2;

use super::super::case::{Case, Measure, Truth, disc, linear};
use super::super::reference::closed::duration;
use super::super::reference::{Floor, System};

pub(super) fn case() -> Case {
    let k = 1.0e5;
    let e = 0.8;
    let radius = 0.04;
    let mass = 0.16;
    let top = 3.6 * radius;
    let g = 9.81;
    let contact_duration = duration(k, e, true, 2.0 / 3.0 * mass);
    let at = |share: f64| DVec2::new(0.0, share * top);
    let floors = vec![Floor::still(DVec2::ZERO, DVec2::Y), Floor::still(at(1.0), DVec2::NEG_Y)];
    let discs = vec![disc(radius, 2.0 * mass, at(0.27), DVec2::ZERO), disc(radius, mass, at(0.75), DVec2::ZERO)];
    Case {
        name: "stacked-pair",
        title: "stacked pair between walls, e = 0.8",
        systems: vec![System { clumps: vec![], gravity: DVec2::new(0.0, -g), law: linear(k, e, true), discs, floors }],
        contact_duration,
        end: 6.0 * contact_duration,
        truth: Truth::Integrated,
        // The start is about 0.02 of the length away from the rest positions.
        measure: Measure::Place(0.02 * top),
        finest: 1000.0,
        touch: None,
    }
}
