//! A dense bed of 400 grains of silo1 falls on a floor, with the contact law of the course assignment
//! ([`siloflow_dem::contact::assignment`]).
//!
//! The error is the rms position error after 12 contact durations. Over longer times chaotic motion would dominate it.

use glam::DVec2;

use super::super::case::{Case, Measure, Truth, disc};
use super::super::reference::closed::duration;
use super::super::reference::{Law, System};
use super::draw::draw;
use super::gas::walls;

const SIDE: u32 = 20;
const R: f64 = 0.04;
const M: f64 = 0.16;

/// Returns the case of the falling bed. It also serves to measure the cost of a step.
#[must_use]
pub fn bed() -> Case {
    let k = 1.0e4;
    let b = 5.0;
    // Damping with zeta = b/(2 sqrt(k m_eff)) makes a contact 0.4 % longer.
    let zeta: f64 = b / (2.0 * f64::sqrt(k * 0.5 * M));
    let contact_duration = duration(k, 1.0, true, 0.5 * M) / (1.0 - zeta * zeta).sqrt();
    Case {
        name: "bed",
        title: "silo1's bed, falling",
        systems: (1..=4).map(|seed| falling(seed, k, b)).collect(),
        contact_duration,
        end: 12.0 * contact_duration,
        truth: Truth::Integrated,
        measure: Measure::Place(R),
        finest: 500.0,
        touch: None,
    }
}

fn falling(seed: u64, k: f64, b: f64) -> System {
    let spacing = 2.08 * R;
    let mut state = seed;
    let mut discs = Vec::new();
    for row in 0..SIDE {
        for column in 0..SIDE {
            let mut around = |width: f64| DVec2::new(draw(&mut state) - 0.5, draw(&mut state) - 0.5) * width;
            let x = DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5) * spacing + around(0.06 * R);
            discs.push(disc(R, M, x, around(1.0) - DVec2::Y));
        }
    }
    let floors = walls(spacing * f64::from(SIDE), None);
    System { clumps: vec![], gravity: DVec2::new(0.0, -9.81), law: Law::Full { k, b }, discs, floors }
}
