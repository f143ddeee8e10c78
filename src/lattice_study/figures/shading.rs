//! Cells as strokes of few greys and few characters.
//!
//! Each column of cells is painted with upright strokes one cell wide, lighter ones first: a stroke passes below all that is
//! darker, so that one is enough where its grey comes back behind darker cells. Coordinates are whole numbers of cells, one
//! relative to the next.
//!
//! Limits. The cells of a panel are of one size and on one grid, as [`densities`](crate::lattice::pictures::densities)
//! makes them; a density is shown to the nearest of 16 greys.

use std::fmt::Write as _;

use crate::lattice::pictures::{Cell, grey};
use crate::writers::colour::Rgb;

/// Greys.
pub(super) const LEVELS: u8 = 16;

/// Particles of a full site.
const FULL: f64 = 13.0;

/// The level of a density, 0 white and 15 black.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a float saturates, and is capped")]
pub(super) fn level(density: f64) -> u8 {
    ((density / FULL * f64::from(LEVELS - 1)).round() as u8).min(LEVELS - 1)
}

/// The grey of a level.
pub(super) fn shade(level: u8) -> Rgb {
    grey(FULL * f64::from(level) / f64::from(LEVELS - 1))
}

/// An upright stroke: grey, column, lowest row, first row above it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stroke(u8, i32, i32, i32);

/// Paths in units of cells from the lower left corner of the first cell, by level, lightest first; white is not painted.
pub(super) fn paths(cells: &[Cell]) -> Vec<(u8, String)> {
    let mut paths = vec![String::new(); usize::from(LEVELS)];
    // Where each path ends.
    let mut ends = [(0, 0); LEVELS as usize];
    for Stroke(level, column, from, to) in strokes(&grid(cells)) {
        let (path, end) = (&mut paths[usize::from(level)], &mut ends[usize::from(level)]);
        let (dx, dy) = (column - end.0, from - end.1);
        let space = if dy < 0 { "" } else { " " };
        // Writing to a string cannot fail.
        let _ = write!(path, "m{dx}{space}{dy}v{}", to - from);
        *end = (column, to);
    }
    (0..LEVELS).zip(paths).filter(|(_, path)| !path.is_empty()).collect()
}

/// Column, row and level of every cell, by column and row.
#[expect(clippy::cast_possible_truncation, reason = "numbers of cells")]
fn grid(cells: &[Cell]) -> Vec<(i32, i32, u8)> {
    let Some(first) = cells.first() else { return Vec::new() };
    let place = |cell: &Cell| ((cell.low - first.low) / (first.high - first.low)).round();
    let mut grid: Vec<_> =
        cells.iter().map(|cell| (place(cell).x as i32, place(cell).y as i32, level(cell.density))).collect();
    grid.sort_unstable();
    grid
}

fn strokes(grid: &[(i32, i32, u8)]) -> Vec<Stroke> {
    let (mut strokes, mut open): (Vec<Stroke>, Vec<Stroke>) = (Vec::new(), Vec::new());
    let mut last = None;
    for &(column, row, level) in grid {
        // Across a gap no stroke goes on.
        let keep = if last == Some((column, row - 1)) { level } else { 0 };
        while let Some(stroke) = open.pop_if(|stroke| stroke.0 > keep) {
            strokes.push(stroke);
        }
        for stroke in &mut open {
            stroke.3 = row + 1;
        }
        if level > 0 && open.last().is_none_or(|stroke| stroke.0 < level) {
            open.push(Stroke(level, column, row, row + 1));
        }
        last = Some((column, row));
    }
    strokes.extend(open.into_iter().rev());
    strokes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Levels of a column as its strokes paint it.
    fn painted(levels: &[u8]) -> (Vec<u8>, usize) {
        let grid: Vec<_> = (0..).zip(levels).map(|(row, &level)| (0, row, level)).collect();
        let mut strokes = strokes(&grid);
        strokes.sort_by_key(|stroke| stroke.0);
        let mut column = vec![0; levels.len()];
        for &Stroke(level, _, from, to) in &strokes {
            column[usize::try_from(from).unwrap()..usize::try_from(to).unwrap()].fill(level);
        }
        (column, strokes.len())
    }

    #[test]
    fn strokes_paint_what_the_cells_are() {
        for (levels, count) in [
            (vec![3, 3, 3], 1),
            (vec![3, 5, 3, 9, 3], 3),
            (vec![3, 2, 3], 3),
            (vec![0, 4, 0, 4], 2),
            (vec![1, 2, 3, 2, 1, 3], 4),
        ] {
            assert_eq!(painted(&levels), (levels, count));
        }
    }

    #[test]
    fn strokes_end_at_gaps() {
        let gap = strokes(&[(0, 0, 5), (0, 2, 5), (1, 3, 5)]);
        assert_eq!(gap, [Stroke(5, 0, 0, 1), Stroke(5, 0, 2, 3), Stroke(5, 1, 3, 4)]);
    }

    #[test]
    fn levels_go_from_white_to_black() {
        assert_eq!((shade(0), shade(15)), ([255; 3], [0; 3]));
        assert_eq!([0.0, 13.0, 6.5, -1.0, 99.0, f64::NAN].map(level), [0, 15, 8, 0, 15, 0]);
    }
}
