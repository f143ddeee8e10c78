//! Draws a site and its particles: an arrow of the length of a step for each mover, a full dot for a particle at rest.

use super::paper::{FAINT, INK, Lattice, NEAREST, Paper, Pen, SECOND};
use siloflow_figures::colour::Rgb;
use siloflow_lattice::velocities::{MOVERS, STEPS, directions};

/// Gap between the site and the arrows, px.
const GAP: f64 = 5.0;

/// Returns the pen for the arrow of a velocity.
pub(super) fn pen(direction: usize) -> Pen {
    Pen { width: 1.6, colour: if direction <= 6 { NEAREST } else { SECOND } }
}

/// Draws the particles that arrive at the site.
pub(super) fn incoming(paper: &mut Paper, lattice: Lattice, state: u16) {
    middle(paper, lattice, state);
    for d in directions(state & MOVERS) {
        let from = lattice.at((-STEPS[d].0, -STEPS[d].1));
        let way = (lattice.origin - from).normalize();
        paper.arrow(from, lattice.origin - GAP * way, pen(d));
    }
}

/// Draws the particles that leave the site.
pub(super) fn outgoing(paper: &mut Paper, lattice: Lattice, state: u16) {
    middle(paper, lattice, state);
    for d in directions(state & MOVERS) {
        let to = lattice.at(STEPS[d]);
        let way = (to - lattice.origin).normalize();
        paper.arrow(lattice.origin + GAP * way, to, pen(d));
    }
}

/// Draws the site: a full dot if it has a particle at rest, else a ring.
fn middle(paper: &mut Paper, lattice: Lattice, state: u16) {
    if state & 1 == 1 {
        paper.dot(lattice.origin, 0.8 * GAP, INK);
    } else {
        paper.ring(lattice.origin, 0.4 * GAP, Pen { width: 1.0, colour: FAINT });
    }
}

/// Returns the pen for the arrow of a resultant.
pub(super) fn sum_pen(colour: Rgb) -> Pen {
    Pen { width: 2.4, colour }
}
