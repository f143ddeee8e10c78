//! Draws density cells as a compact set of SVG strokes with few grey levels.
//!
//! Each column of cells is painted with vertical strokes one cell wide, lighter strokes first. A lighter stroke
//! continues below darker cells, so one stroke is enough if its grey appears on both sides of them. Coordinates are
//! whole numbers of cells, each relative to the previous one.
//!
//! Limits. All cells of a panel must have the size and grid that [`densities`](crate::lattice_silo::pictures::densities)
//! gives them. A density is rounded to one of 16 grey levels.

use std::fmt::Write as _;

use crate::lattice_silo::pictures::{DensityCell, grey};
use siloflow_figures::colour::Rgb;

/// Number of grey levels.
pub(super) const LEVELS: u8 = 16;

/// Number of particles of a full site.
const FULL: f64 = 13.0;

/// Returns the grey level of a density: 0 is white, 15 is black.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates; the result is capped")]
pub(super) fn level(density: f64) -> u8 {
    ((density / FULL * f64::from(LEVELS - 1)).round() as u8).min(LEVELS - 1)
}

/// Returns the colour of a grey level.
pub(super) fn shade(level: u8) -> Rgb {
    grey(FULL * f64::from(level) / f64::from(LEVELS - 1))
}

/// A vertical stroke: grey level, column, lowest row, first row above the stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stroke(u8, i32, i32, i32);

/// Returns an SVG path for each grey level except white, lightest first. The paths are in units of cells, from the
/// lower left corner of the first cell.
pub(super) fn paths(cells: &[DensityCell]) -> Vec<(u8, String)> {
    let mut paths = vec![String::new(); usize::from(LEVELS)];
    // End point of each path so far.
    let mut ends = [(0, 0); LEVELS as usize];
    for Stroke(level, column, from, to) in strokes(&grid(cells)) {
        let path = &mut paths[usize::from(level)];
        let end = &mut ends[usize::from(level)];
        let dx = column - end.0;
        let dy = from - end.1;
        let space = if dy < 0 { "" } else { " " };
        // Writing to a string cannot fail.
        let _ = write!(path, "m{dx}{space}{dy}v{}", to - from);
        *end = (column, to);
    }
    (0..LEVELS).zip(paths).filter(|(_, path)| !path.is_empty()).collect()
}

/// Returns column, row and grey level of each cell, sorted by column and row.
#[expect(clippy::cast_possible_truncation, reason = "numbers of cells")]
fn grid(cells: &[DensityCell]) -> Vec<(i32, i32, u8)> {
    let Some(first) = cells.first() else { return Vec::new() };
    let place = |cell: &DensityCell| ((cell.low - first.low) / (first.high - first.low)).round();
    let mut grid: Vec<_> =
        cells.iter().map(|cell| (place(cell).x as i32, place(cell).y as i32, level(cell.density))).collect();
    grid.sort_unstable();
    grid
}

/// Returns the strokes that paint the cells of a grid, if lighter strokes are painted first.
fn strokes(grid: &[(i32, i32, u8)]) -> Vec<Stroke> {
    let (mut strokes, mut open): (Vec<Stroke>, Vec<Stroke>) = (Vec::new(), Vec::new());
    let mut last = None;
    for &(column, row, level) in grid {
        // A gap ends all strokes.
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

    /// Paints a column of cells with its strokes. Returns the painted levels and the number of strokes.
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
    fn strokes_paint_the_levels_of_the_cells() {
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
