//! Hashed cells: the plane is divided into squares of side L, and only occupied squares cost memory.
//!
//! A particle belongs to the cell (floor(x/L), floor(y/L)). Cells are kept in a hash table as the assignment's
//! footnote suggests, but instead of chains its buckets are slices of one array, sorted by counting: filling is two
//! passes over the particles, and a grain a kilometre away takes one entry like any other. Cells of a row have
//! adjacent buckets, so that a grain looks into three slices for its nine cells. Two cells may share a bucket, so an
//! entry is taken only if its own cell is one that was asked for.
//!
//! A pair is found if its cells are the same or neighbours, so for certain if its centres are at most L apart:
//! L must be at least the largest distance at which two particles touch, 2 R_max for grains.

use crate::columns::Columns;
use crate::contact::kernel::Partners;
use crate::neighbours::contact_range;
use crate::outcome::Failure;
use crate::space::Vector;

type Cell = [i64; 2];

/// Particles sorted by cell.
pub struct Cells {
    size: f64,
    full: bool,
    cell: Vec<Cell>,
    starts: Vec<u32>,
    entries: Vec<u32>,
}

impl Cells {
    pub(super) fn new(size: f64, full: bool) -> Self {
        Self { size, full, cell: Vec::new(), starts: vec![0, 0], entries: Vec::new() }
    }

    pub(super) fn check_range(&self, columns: &Columns) -> Result<(), Failure> {
        let needed = contact_range(columns);
        if needed > self.size { Err(Failure::CellsTooSmall { size: self.size, needed }) } else { Ok(()) }
    }

    /// Sorts the particles at `positions` (m) into the cells.
    pub(super) fn fill(&mut self, positions: impl Iterator<Item = Vector>) {
        self.cell.clear();
        self.cell.extend(positions.map(|x| cell_of(x, self.size)));
        let buckets = (2 * self.cell.len()).next_power_of_two();
        self.starts.clear();
        self.starts.resize(buckets + 1, 0);
        for &cell in &self.cell {
            self.starts[bucket(cell, buckets) + 1] += 1;
        }
        for b in 0..buckets {
            self.starts[b + 1] += self.starts[b];
        }
        self.entries.clear();
        self.entries.resize(self.cell.len(), 0);
        // From the last to the first, each to the end of what is left of its bucket: buckets come out ascending.
        let particles = u32::try_from(self.cell.len()).expect("fewer than 2^32 particles");
        for i in (0..particles).rev() {
            let end = &mut self.starts[bucket(self.cell[i as usize], buckets) + 1];
            *end -= 1;
            self.entries[*end as usize] = i;
        }
        // Each start has moved down by its own count; shift them back into place.
        self.starts.rotate_left(1);
        self.starts[buckets] = particles;
    }

    /// Calls `visit` with every particle that `wants` accepts in the cells at most `reach` cells away from that of
    /// particle `i`, itself included.
    #[inline]
    pub(super) fn around(&self, i: usize, reach: u8, wants: impl Fn(u32) -> bool, mut visit: impl FnMut(u32)) {
        let buckets = self.starts.len() - 1;
        let [x, y] = self.cell[i];
        let cells = usize::from(reach);
        for row in -i64::from(reach)..=i64::from(reach) {
            let wanted = y.wrapping_add(row);
            let mut take = |from: usize, to: usize| {
                for &j in &self.entries[self.starts[from] as usize..self.starts[to] as usize] {
                    // What is not wanted need not be looked up.
                    if !wants(j) {
                        continue;
                    }
                    let [at, line] = self.cell[j as usize];
                    if line == wanted && at.wrapping_sub(x).unsigned_abs() <= u64::from(reach) {
                        visit(j);
                    }
                }
            };
            // Cells of a row lie in adjacent buckets, around the end of the table if need be.
            let first = bucket([x.wrapping_sub(i64::from(reach)), wanted], buckets);
            let end = first + 2 * cells + 1;
            take(first, end.min(buckets));
            if end > buckets {
                take(0, (end - buckets).min(first));
            }
        }
    }
}

impl Partners for Cells {
    #[inline]
    fn of<'a>(&'a self, columns: &Columns, i: usize, scratch: &'a mut Vec<u32>) -> &'a [u32] {
        scratch.clear();
        let body = &columns.body[i];
        let wants = |j: u32| if self.full { j as usize != i } else { j as usize > i };
        self.around(i, 1, wants, |j| {
            let other = &columns.body[j as usize];
            let reach = body.radius + other.radius;
            if body.position.distance_squared(other.position) < reach * reach {
                scratch.push(j);
            }
        });
        scratch.sort_unstable();
        scratch
    }
}

fn cell_of(x: Vector, size: f64) -> Cell {
    [floor(x.x / size), floor(x.y / size)]
}

/// The floor as an integer. `f64::floor` is a function call on processors of the baseline.
#[inline]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "saturates far outside any scene; NaN becomes 0 and touches nothing"
)]
fn floor(x: f64) -> i64 {
    let towards_zero = x as i64;
    towards_zero.saturating_sub(i64::from((towards_zero as f64) > x))
}

/// Rows are scattered over the table; along a row, buckets follow each other.
#[inline]
#[expect(clippy::cast_sign_loss, clippy::cast_possible_truncation, reason = "a hash: any bits will do")]
fn bucket([x, y]: Cell, buckets: usize) -> usize {
    let row = ((y as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32) as usize;
    row.wrapping_add(x as usize) & (buckets - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn floor_is_the_floor() {
        for (x, floored) in [
            (-1.5, -2),
            (-1.0, -1),
            (-0.0, 0),
            (0.5, 0),
            (3.0, 3),
            (f64::INFINITY, i64::MAX),
            (-1e300, i64::MIN),
            (f64::NAN, 0),
        ] {
            assert_eq!(floor(x), floored);
        }
    }

    proptest! {
        #[test]
        fn nine_cells_hold_everyone_within_a_side(
            points in prop::collection::vec((-3.0..3.0, -3.0..3.0), 1..80),
            far in -1e12..1e12,
        ) {
            let mut points: Vec<_> = points.into_iter().map(|(x, y)| Vector::new(x, y)).collect();
            points.push(Vector::new(far, -far));
            let size = 0.7;
            let mut cells = Cells::new(size, true);
            cells.fill(points.iter().copied());
            prop_assert!(cells.entries.len() == points.len() && cells.starts.len() <= 4 * points.len() + 2);
            for i in 0..points.len() {
                let mut found = Vec::new();
                cells.around(i, 1, |_| true, |j| found.push(j as usize));
                let listed = found.len();
                found.sort_unstable();
                found.dedup();
                prop_assert_eq!(found.len(), listed, "a particle was offered twice");
                for j in 0..points.len() {
                    prop_assert!(points[i].distance(points[j]) > size || found.contains(&j));
                }
            }
        }
    }
}
