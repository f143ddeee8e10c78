//! Hashed cells: the plane is divided into squares of side L, and only occupied squares cost memory.
//!
//! A particle belongs to the cell (floor(x/L), floor(y/L)). Cells are kept in a hash table as the assignment's
//! footnote suggests, but instead of chains its buckets are slices of one array, sorted by counting: filling is two
//! passes over the particles, and a grain a kilometre away takes one entry like any other. Two cells may share a
//! bucket, so an entry is taken only if its own cell is the one asked for.
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
    pub(super) fn fill(&mut self, positions: &[Vector]) {
        self.cell.clear();
        self.cell.extend(positions.iter().map(|&x| cell_of(x, self.size)));
        let buckets = (2 * positions.len()).next_power_of_two();
        self.starts.clear();
        self.starts.resize(buckets + 1, 0);
        for &cell in &self.cell {
            self.starts[bucket(cell, buckets) + 1] += 1;
        }
        for b in 0..buckets {
            self.starts[b + 1] += self.starts[b];
        }
        self.entries.clear();
        self.entries.resize(positions.len(), 0);
        // From the last to the first, each to the end of what is left of its bucket: buckets come out ascending.
        let particles = u32::try_from(positions.len()).expect("fewer than 2^32 particles");
        for i in (0..particles).rev() {
            let end = &mut self.starts[bucket(self.cell[i as usize], buckets) + 1];
            *end -= 1;
            self.entries[*end as usize] = i;
        }
        // Each start has moved down by its own count; shift them back into place.
        self.starts.rotate_left(1);
        self.starts[buckets] = particles;
    }

    /// Calls `visit` with every particle of the nine cells around particle `i`, itself included.
    #[inline]
    pub(super) fn around(&self, i: usize, mut visit: impl FnMut(u32)) {
        let buckets = self.starts.len() - 1;
        let [x, y] = self.cell[i];
        for dy in -1..=1 {
            for dx in -1..=1 {
                let wanted = [x.wrapping_add(dx), y.wrapping_add(dy)];
                let b = bucket(wanted, buckets);
                for &j in &self.entries[self.starts[b] as usize..self.starts[b + 1] as usize] {
                    if self.cell[j as usize] == wanted {
                        visit(j);
                    }
                }
            }
        }
    }

    /// Fills `near` with what `i` pairs with at a distance below R_i + R_j + `margin`, ascending.
    pub(super) fn near(&self, columns: &Columns, i: usize, margin: f64, full: bool, near: &mut Vec<u32>) {
        near.clear();
        let (centre, radius, fixed) = (columns.position[i], columns.radius[i] + margin, columns.is_fixed(i));
        self.around(i, |j| {
            let other = j as usize;
            let reach = radius + columns.radius[other];
            let wanted = if full { other != i } else { other > i };
            if wanted
                && centre.distance_squared(columns.position[other]) < reach * reach
                && !(fixed && columns.is_fixed(other))
            {
                near.push(j);
            }
        });
        near.sort_unstable();
    }
}

impl Partners for Cells {
    #[inline]
    fn of<'a>(&'a self, columns: &Columns, i: usize, scratch: &'a mut Vec<u32>) -> &'a [u32] {
        self.near(columns, i, 0.0, self.full, scratch);
        scratch
    }
}

#[expect(clippy::cast_possible_truncation, reason = "saturates far outside any scene; NaN becomes 0 and touches nothing")]
fn cell_of(x: Vector, size: f64) -> Cell {
    [(x.x / size).floor() as i64, (x.y / size).floor() as i64]
}

#[inline]
#[expect(clippy::cast_sign_loss, clippy::cast_possible_truncation, reason = "a hash: any bits will do")]
fn bucket([x, y]: Cell, buckets: usize) -> usize {
    let mixed = (x as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (y as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
    (mixed >> 32) as usize & (buckets - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

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
            cells.fill(&points);
            prop_assert!(cells.entries.len() == points.len() && cells.starts.len() <= 4 * points.len() + 2);
            for i in 0..points.len() {
                let mut found = Vec::new();
                cells.around(i, |j| found.push(j as usize));
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
