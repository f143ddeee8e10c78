//! Examples of collision rules for four particles (the paper's figure 3).

use super::examples::{Example, examples};
use super::paper::{Anchor, FAINT, Lattice, Paper, Pen};
use super::site::{incoming, outgoing};
use siloflow_dem::space::Vector;
use siloflow_lattice::collisions::Collisions;
use siloflow_lattice::velocities::momentum;

const CELL: f64 = 80.0;
const ROW: f64 = 124.0;
const LEFT: f64 = 16.0;
const TOP: f64 = 44.0;
const GAP: f64 = 18.0;
const BOTTOM: f64 = 48.0;

/// Length of a bond in a cell, px. Two steps of length sqrt 3 fit into a cell.
const BOND: f64 = 20.5;

/// Draws example collisions, one per row: the incoming state, then some possible outgoing states, elastic and with one
/// particle stopped. The sum is below each state.
#[must_use]
pub fn collisions() -> String {
    let examples = examples(&Collisions::default());
    let rows = examples.iter().fold(0.0, |rows, _| rows + 1.0);
    let width = 2.0 * LEFT + 11.0 * CELL + 2.0 * GAP;
    let height = TOP + rows * ROW + BOTTOM;
    let mut paper = Paper::new(width, height);
    let heads = [
        (left(0), "incoming"),
        (left(1), "outgoing: elastic, four movers"),
        (left(6), "outgoing: one stopped, three movers"),
    ];
    for (x, head) in heads {
        paper.text(Vector::new(x, TOP - 18.0), 16.0, Anchor::Start, head);
    }
    let mut top = TOP;
    for example in &examples {
        draw_row(&mut paper, top, width, example);
        top += ROW;
    }
    let notes = [
        "Arrows: directions of movers, as long as a step; full dots: particles at rest. Below each state its sum (X, Y): X √3/2 to the right, Y/2 up.",
        "Of each class the first state in ascending order and the last with another sum, if one particle can stop; of their outgoing states up to five.",
    ];
    for (y, note) in [28.0, 10.0].into_iter().zip(notes) {
        paper.text(Vector::new(LEFT, height - y), 12.5, Anchor::Start, note);
    }
    paper.finish()
}

/// Returns the left side of a cell of a row, px. Cell 0 is the incoming state, 1 to 5 are elastic outgoing states, 6 to
/// 10 have one particle stopped.
fn left(cell: u8) -> f64 {
    let gaps = [0.0, GAP, 2.0 * GAP][usize::from(cell > 0) + usize::from(cell > 5)];
    LEFT + f64::from(cell) * CELL + gaps
}

fn draw_row(paper: &mut Paper, top: f64, width: f64, example: &Example) {
    paper.line(Vector::new(LEFT, top), Vector::new(width - LEFT, top), Pen { width: 0.8, colour: FAINT });
    let shown = |shown: &[u16], count: usize| match shown.len() {
        1 if count == 1 => "the only state".to_owned(),
        all if all == count => format!("all {count} states"),
        some => format!("{some} of {count} states"),
    };
    let heads = [
        (left(0), example.class.to_owned()),
        (left(1), shown(&example.elastic, example.elastic_count)),
        (left(6), shown(&example.stopped, example.stopped_count)),
    ];
    for (x, head) in heads {
        paper.text(Vector::new(x, top + 16.0), 13.0, Anchor::Start, &head);
    }
    let states = (1..).zip(&example.elastic).chain((6..).zip(&example.stopped));
    draw_cell(paper, 0, top, example.incoming, incoming);
    for (n, &state) in states {
        draw_cell(paper, n, top, state, outgoing);
    }
}

fn draw_cell(paper: &mut Paper, n: u8, top: f64, state: u16, draw: fn(&mut Paper, Lattice, u16)) {
    let middle = Vector::new(left(n) + 0.5 * CELL, top + 62.0);
    draw(paper, Lattice { origin: middle, bond: BOND }, state);
    let (x, y) = momentum(state);
    paper.text(Vector::new(middle.x, top + 117.0), 12.0, Anchor::Middle, &format!("({x}, {y})"));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_state_is_drawn_with_its_sum() {
        let svg = collisions();
        super::super::renders(&svg);
        let drawn: usize = examples(&Collisions::default()).iter().map(|e| 1 + e.elastic.len() + e.stopped.len()).sum();
        // The pattern leaves out the parentheses of the note, which are not at the start of a text.
        assert_eq!(svg.matches(">(").count(), drawn);
    }
}
