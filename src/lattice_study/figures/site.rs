//! A site and its particles: an arrow for every mover, as long as a step, a full dot for one at rest.

use super::paper::{FAINT, INK, Lattice, NEAREST, Paper, Pen, SECOND};
use crate::lattice::velocities::{MOVERS, STEPS, directions};
use crate::writers::colour::Rgb;

/// What arrows leave free around the site, px.
const GAP: f64 = 5.0;

/// The pen of a velocity.
pub(super) fn pen(direction: usize) -> Pen {
    Pen { width: 1.6, colour: if direction <= 6 { NEAREST } else { SECOND } }
}

/// The particles that come to the site.
pub(super) fn incoming(paper: &mut Paper, lattice: Lattice, state: u16) {
    middle(paper, lattice, state);
    for d in directions(state & MOVERS) {
        let from = lattice.at((-STEPS[d].0, -STEPS[d].1));
        let way = (lattice.origin - from).normalize();
        paper.arrow(from, lattice.origin - GAP * way, pen(d));
    }
}

/// The particles that leave the site.
pub(super) fn outgoing(paper: &mut Paper, lattice: Lattice, state: u16) {
    middle(paper, lattice, state);
    for d in directions(state & MOVERS) {
        let to = lattice.at(STEPS[d]);
        let way = (to - lattice.origin).normalize();
        paper.arrow(lattice.origin + GAP * way, to, pen(d));
    }
}

fn middle(paper: &mut Paper, lattice: Lattice, state: u16) {
    if state & 1 == 1 {
        paper.dot(lattice.origin, 0.8 * GAP, INK);
    } else {
        paper.ring(lattice.origin, 0.4 * GAP, Pen { width: 1.0, colour: FAINT });
    }
}

/// Pen of a resultant.
pub(super) fn sum_pen(colour: Rgb) -> Pen {
    Pen { width: 2.4, colour }
}
