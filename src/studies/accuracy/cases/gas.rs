//! An undamped gas of discs in a box, with four sets of initial velocities. The error is the relative change of the
//! energy.

use glam::DVec2;

use super::super::case::{Case, Measure, Truth, disc, linear};
use super::super::reference::closed::duration;
use super::super::reference::{Floor, System};
use super::draw::draw;

const SIDE: u32 = 10;

pub(super) fn case() -> Case {
    let contact_duration = duration(1.0e4, 1.0, true, 0.08);
    Case {
        name: "gas",
        title: "undamped gas: energy drift",
        systems: (1..=4).map(system).collect(),
        contact_duration,
        end: 100.0 * contact_duration,
        truth: Truth::Energy,
        measure: Measure::Energy,
        finest: 200.0,
        touch: None,
    }
}

/// Returns 100 discs that cover a fraction 0.6 of a square box.
fn system(seed: u64) -> System {
    let r = 0.04;
    let m = 0.16;
    let mut state = seed;
    let spacing = r * (std::f64::consts::PI / 0.6).sqrt();
    let width = spacing * f64::from(SIDE);
    let mut discs = Vec::new();
    for row in 0..SIDE {
        for column in 0..SIDE {
            let x = DVec2::new(f64::from(column) + 0.5, f64::from(row) + 0.5) * spacing;
            let v = DVec2::new(2.0 * draw(&mut state) - 1.0, 2.0 * draw(&mut state) - 1.0);
            discs.push(disc(r, m, x, v));
        }
    }
    System {
        clumps: vec![],
        gravity: DVec2::ZERO,
        law: linear(1.0e4, 1.0, true),
        discs,
        floors: walls(width, Some(width)),
    }
}

/// Returns two side walls, a floor, and a lid if `height` is given (m).
pub(super) fn walls(width: f64, height: Option<f64>) -> Vec<Floor> {
    let wall = |x: f64, y: f64, normal: DVec2| Floor::still(DVec2::new(x, y), normal);
    let mut walls = vec![wall(0.0, 0.0, DVec2::Y), wall(0.0, 0.0, DVec2::X), wall(width, 0.0, DVec2::NEG_X)];
    walls.extend(height.map(|height| wall(0.0, height, DVec2::NEG_Y)));
    walls
}
