//! Three grains in a row with two simultaneous contacts.
//!
//! In `chain` a grain hits two grains that nearly touch. In `squeezed` two heavy grains squeeze a light one: the two
//! forces on the light grain nearly cancel, so it hardly moves.

use glam::DVec2;

use super::super::case::{Case, Measure, Truth, disc, linear};
use super::super::reference::System;
use super::super::reference::closed::duration;

const K: f64 = 1.0e5;
const E: f64 = 0.5;
const V: f64 = 1.0;

pub(super) fn cases() -> [Case; 2] {
    // The contact duration is the one of a contact between the two lightest grains.
    let hit = chain("chain", "chain of three, e = 0.5", [0.12, 0.09, 0.16], 0.09 * 0.12 / 0.21, 6.0);
    let squeezed = chain(
        "squeezed",
        "a light grain between two a hundred times as heavy",
        [0.16, 0.0016, 0.16],
        0.0016 / 1.01,
        40.0,
    );
    [hit, squeezed]
}

/// Returns a chain of grains stacked upwards. The third grain moves down onto the other two; `end` is in contact
/// durations.
fn chain(name: &'static str, title: &'static str, masses: [f64; 3], reduced_mass: f64, end: f64) -> Case {
    let contact_duration = duration(K, E, false, reduced_mass);
    let lead = 0.3 * V * contact_duration;
    let gap = 0.1 * V * contact_duration;
    let at = |y: f64| DVec2::new(0.0, y);
    let discs = vec![
        disc(0.03, masses[0], DVec2::ZERO, DVec2::ZERO),
        disc(0.03, masses[1], at(0.06 + gap), DVec2::ZERO),
        disc(0.04, masses[2], at(0.13 + gap + lead), at(-V)),
    ];
    Case {
        name,
        title,
        systems: vec![System { clumps: vec![], gravity: DVec2::ZERO, law: linear(K, E, false), discs, floors: vec![] }],
        contact_duration,
        end: end * contact_duration,
        truth: Truth::Integrated,
        measure: Measure::Velocity(V),
        finest: 1000.0,
        touch: None,
    }
}
