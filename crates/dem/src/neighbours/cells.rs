//! Hashed cells: space is divided into squares or cubes of side L, and only occupied cells cost memory.
//!
//! A particle belongs to the cell (floor(x/L), floor(y/L), ...). A periodic axis is divided into a whole number of
//! cells, and its last cell is next to its first. The assignment's footnote suggests a hash table. Instead of chains,
//! the buckets of this table are slices of one array, sorted by counting. Filling takes two passes over the particles.
//! A distant grain takes one entry, too.
//!
//! Cells of a row have adjacent buckets, so that a grain
//! reads three slices for its nine cells (in solid space, nine slices for 27 cells). Two cells may share a bucket, so
//! an entry counts only if its own cell is in the requested range.
//!
//! A pair is found if its cells are equal or adjacent. This is certain if the centres are at most L apart. L must
//! therefore be at least the largest distance at which two particles touch, 2 R_max for grains. A scheme with velocity
//! prediction adds the distance that the fastest grain moves in a step. If L is smaller than the sum, grains search
//! more cells around their own.
//!
//! Cell numbers are kept modulo 2^32, in 32 bits. So a search may also find a particle 2^32 cells away, which is too far to touch.

use std::ops::Range;

use crate::neighbours::list::PairList;
use crate::neighbours::range::contact_range;
use crate::outcome::Failure;
use crate::periodic::Periodic;
use crate::space::Space;
use crate::store::ParticleStore;

/// Largest search radius in cells. Beyond it, testing all particles costs no more.
pub(super) const MAX_REACH: u8 = 8;

/// Most cells across a periodic box, so that sums of two cell numbers fit into 32 bits.
const MOST_ACROSS: i64 = 1 << 30;

/// Cell number along x, and the row of cells.
type Cell<V> = (i32, <V as Space>::Row);

/// Cells of a row beside that of a cell: of the row that is `away` from it, and along x between `from` and `to`.
struct Span<V: Space> {
    away: V::Row,
    from: i32,
    to: i32,
}

/// Entries of consecutive cells.
pub(super) struct Entries<V: Space> {
    /// Their places among all entries.
    pub(super) places: Range<usize>,
    /// The row of the cells.
    row: V::Row,
    /// The first cell along x.
    from: i32,
    /// The number of the cells less one.
    cells: u32,
}

/// Particles sorted by cell.
pub struct Cells<V: Space> {
    size: f64,
    /// The periodic box.
    periodic: Option<Periodic<V>>,
    /// Number of cells across the box along each axis; 0 along an open axis.
    span: [i32; 3],
    /// Side of a cell along each axis, m.
    sides: V,
    /// The cell of each particle.
    cell: Vec<Cell<V>>,
    /// Largest distance at which two particles touch, m.
    range: f64,
    /// Search radius in cells.
    reach: u8,
    /// Start of each bucket in `entries`.
    starts: Vec<u32>,
    /// Slots, sorted by bucket.
    entries: Vec<u32>,
}

impl<V: Space> Cells<V> {
    /// Makes empty cells of side `size` (m). Along a periodic axis the side grows until a whole number of cells fits.
    pub(super) fn new(size: f64, periodic: Option<Periodic<V>>) -> Self {
        let mut span = [0; 3];
        let mut sides = V::ZERO;
        for (axis, span) in span.iter_mut().enumerate().take(V::COMPONENTS) {
            let length = periodic.and_then(|periodic| periodic.side(axis));
            *span = length.map_or(0, |length| low_bits(floor(length / size).clamp(1, MOST_ACROSS)));
            let whole = length.map_or(size, |length| length / f64::from(*span));
            sides = sides.with_axis(axis, whole);
        }
        Self {
            size,
            periodic,
            span,
            sides,
            cell: Vec::new(),
            range: 0.0,
            reach: 1,
            starts: vec![0, 0],
            entries: Vec::new(),
        }
    }

    pub(super) fn check_range(&mut self, store: &ParticleStore<V>) -> Result<(), Failure> {
        self.range = contact_range(store);
        let needed = self.range;
        if needed > self.size { Err(Failure::CellsTooSmall { size: self.size, needed }) } else { Ok(()) }
    }

    /// Sets the search radius so that pairs up to `margin` (m) away from touching are found.
    pub(super) fn set_reach(&mut self, margin: f64) {
        let cells = ((self.range + margin) / self.size).ceil();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 1 and 255")]
        {
            self.reach = cells.clamp(1.0, f64::from(u8::MAX)) as u8;
        }
    }

    #[inline]
    fn cell_of(&self, x: V) -> Cell<V> {
        let number = |axis: usize| {
            let low = self.periodic.filter(|_| self.span[axis] > 0).map_or(0.0, |periodic| periodic.low.axis(axis));
            let cell = floor((x.axis(axis) - low) / self.sides.axis(axis));
            // Rounding may put the last position below the upper end into the next cell.
            low_bits(if self.span[axis] > 0 { cell.clamp(0, i64::from(self.span[axis]) - 1) } else { cell })
        };
        (number(0), V::row(V::origin_row(), |axis, _| number(axis)))
    }

    /// Sorts the particles at `positions` (m) into the cells.
    pub(super) fn fill(&mut self, positions: impl Iterator<Item = V>) {
        let mut cell = std::mem::take(&mut self.cell);
        cell.clear();
        cell.extend(positions.map(|x| self.cell_of(x)));
        self.cell = cell;
        let buckets = (2 * self.cell.len()).next_power_of_two();
        self.starts.clear();
        self.starts.resize(buckets + 1, 0);
        for &cell in &self.cell {
            self.starts[bucket::<V>(cell, buckets) + 1] += 1;
        }
        for b in 0..buckets {
            self.starts[b + 1] += self.starts[b];
        }
        self.entries.clear();
        self.entries.resize(self.cell.len(), 0);
        // Iterates from the last particle to the first and fills each bucket from its end, so that buckets are
        // ascending.
        let particles = u32::try_from(self.cell.len()).expect("fewer than 2^32 particles");
        for i in (0..particles).rev() {
            let end = &mut self.starts[bucket::<V>(self.cell[i as usize], buckets) + 1];
            *end -= 1;
            self.entries[*end as usize] = i;
        }
        // Filling has moved each start down by its bucket's count. Shift the starts back into place.
        self.starts.rotate_left(1);
        self.starts[buckets] = particles;
    }

    /// Calls `visit` once with each particle that `wants` accepts in the cells at most `reach` cells away from the cell
    /// of particle `i`. Particle `i` itself is included.
    #[inline]
    pub(super) fn around(&self, i: usize, reach: u8, wants: impl Fn(u32) -> bool, visit: impl FnMut(u32)) {
        self.around_cell(self.cell[i], i32::from(reach), wants, visit);
    }

    /// Calls `visit` once with each particle that `wants` accepts in the cell of the place `x` (m) and in the adjacent ones. The place need
    /// not be that of a particle of the cells.
    #[inline]
    pub(super) fn around_place(&self, x: V, wants: impl Fn(u32) -> bool, visit: impl FnMut(u32)) {
        self.around_cell(self.cell_of(x), 1, wants, visit);
    }

    #[inline]
    fn around_cell(&self, cell: Cell<V>, reach: i32, wants: impl Fn(u32) -> bool, mut visit: impl FnMut(u32)) {
        let visit = |entries: Entries<V>| {
            for &j in &self.entries[entries.places.clone()] {
                // Rejected particles skip the lookup of their cell.
                if wants(j) && self.have(&entries, j) {
                    visit(j);
                }
            }
        };
        self.visit_spans(V::rows(reach).map(|away| Span { away, from: -reach, to: reach }), cell, visit);
    }

    /// Calls `visit` with the entries of the cells at most `reach` cells away from the cell of particle `i`. If `halves`, cells before its own
    /// are left out: those of earlier rows, and earlier ones of its own row. So each of two cells side by side is visited from one of them. The box must be
    /// [wide enough](Self::can_be_halved).
    ///
    /// Each particle of the cells is once among entries that [have](Self::have) it.
    #[inline]
    pub(super) fn entries_around(&self, i: usize, reach: u8, halves: bool, visit: impl FnMut(Entries<V>)) {
        let reach = i32::from(reach);
        let own = V::origin_row();
        let span = |away| Span { away, from: if halves && away == own { 0 } else { -reach }, to: reach };
        let rows = V::rows(reach).skip_while(|&away| halves && away != own);
        self.visit_spans(rows.map(span), self.cell[i], visit);
    }

    /// Whether cells at most one cell away are different cells on both sides of each cell.
    pub(super) fn can_be_halved(&self) -> bool {
        self.span.iter().all(|&span| span == 0 || span >= 3)
    }

    /// Whether two particles are in one cell.
    #[inline]
    pub(super) fn share_cell(&self, i: usize, j: usize) -> bool {
        self.cell[i] == self.cell[j]
    }

    /// Returns the slots of all particles, sorted by cell.
    #[inline]
    pub(super) fn entries(&self) -> &[u32] {
        &self.entries
    }

    /// Calls `visit` with the entries of the cells in `spans` beside a cell.
    #[inline]
    fn visit_spans(&self, spans: impl Iterator<Item = Span<V>>, (x, row): Cell<V>, mut visit: impl FnMut(Entries<V>)) {
        for Span { away, from, to } in spans {
            let Some(row) = self.row_at(row, away, to) else { continue };
            let span = self.span[0];
            if span == 0 {
                self.visit_row(row, x.wrapping_add(from), x.wrapping_add(to), &mut visit);
            } else if to - from + 1 >= span {
                self.visit_row(row, 0, span - 1, &mut visit);
            } else {
                let from = x + from;
                let to = x + to;
                self.visit_row(row, from.max(0), to.min(span - 1), &mut visit);
                if from < 0 {
                    self.visit_row(row, from + span, span - 1, &mut visit);
                }
                if to >= span {
                    self.visit_row(row, 0, to - span, &mut visit);
                }
            }
        }
    }

    /// Returns the row `away` from `row`, wrapped at periodic ends; `None` if another offset already gives that row.
    #[inline]
    fn row_at(&self, row: V::Row, away: V::Row, reach: i32) -> Option<V::Row> {
        let mut is_image = false;
        let mut steps = [0; 3];
        let _ = V::row(away, |axis, step| {
            steps[axis] = step;
            step
        });
        let wanted = V::row(row, |axis, number| {
            let span = self.span[axis];
            let step = steps[axis];
            if span == 0 {
                return number.wrapping_add(step);
            }
            // In a box narrower than the search range, each cell counts once: at offsets -reach to -reach + span - 1.
            is_image |= step + reach >= span;
            (number + step).rem_euclid(span)
        });
        (!is_image).then_some(wanted)
    }

    /// Visits the entries of the cells `from` to `to` of a row. Their buckets are adjacent, and may continue at the start of the
    /// table.
    #[inline(always)]
    fn visit_row(&self, row: V::Row, from: i32, to: i32, visit: &mut impl FnMut(Entries<V>)) {
        let buckets = self.starts.len() - 1;
        let cells = to.wrapping_sub(from).cast_unsigned();
        let first = bucket::<V>((from, row), buckets);
        let end = first + cells as usize + 1;
        for (first, end) in [(first, end.min(buckets)), (0, end.saturating_sub(buckets).min(first))] {
            let places = self.starts[first] as usize..self.starts[end] as usize;
            if !places.is_empty() {
                visit(Entries { places, row, from, cells });
            }
        }
    }

    /// Returns whether a particle among `entries` is in their cells. Particles of other cells share their buckets.
    #[inline(always)]
    pub(super) fn have(&self, entries: &Entries<V>, j: u32) -> bool {
        let (at, row) = self.cell[j as usize];
        row == entries.row && at.wrapping_sub(entries.from).cast_unsigned() <= entries.cells
    }
}

impl<V: Space> Cells<V> {
    /// Lists every pair that may touch.
    pub(super) fn find(&self, store: &ParticleStore<V>, list: &mut PairList) {
        list.clear();
        for j in 0..store.len() {
            let partners = j.min(store.free_end);
            let wants = |i: u32| (i as usize) < partners;
            let consider = |i: u32| {
                if store.may_touch(i as usize, j) {
                    list.push(i);
                }
            };
            if self.reach <= MAX_REACH {
                self.around(j, self.reach, wants, consider);
            } else {
                (0u32..).take(partners).for_each(consider);
            }
            list.end_row();
        }
    }
}

/// Returns the floor as an integer. On baseline processors `f64::floor` is a function call.
#[inline]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "saturates far outside any scene; NaN becomes 0 and touches nothing"
)]
pub(crate) fn floor(x: f64) -> i64 {
    let towards_zero = x as i64;
    towards_zero.saturating_sub(i64::from((towards_zero as f64) > x))
}

/// Returns the number of a cell modulo 2^32.
#[inline]
#[expect(clippy::cast_possible_truncation, reason = "keeps the lower 32 bits")]
fn low_bits(cell: i64) -> i32 {
    cell as i32
}

/// Returns the bucket of a cell. Rows are scattered over the table; cells along a row have consecutive buckets.
#[inline]
#[expect(clippy::cast_possible_truncation, reason = "a hash: any bits serve")]
fn bucket<V: Space>((x, row): Cell<V>, buckets: usize) -> usize {
    (V::scatter(row) as usize).wrapping_add(i64::from(x).cast_unsigned() as usize) & (buckets - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::periodic::PeriodicSides;
    use crate::space::{Plane, Solid};
    use proptest::prelude::*;

    #[test]
    fn floor_rounds_down_and_saturates() {
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

    /// Checks that each search finds all points within one cell side, and none twice.
    fn check<V: Space>(points: &[V], periodic: Option<Periodic<V>>) -> Result<(), TestCaseError> {
        let size = 0.7;
        let mut cells = Cells::new(size, periodic);
        cells.fill(points.iter().copied());
        prop_assert!(cells.entries.len() == points.len() && cells.starts.len() <= 4 * points.len() + 2);
        for i in 0..points.len() {
            let mut found = Vec::new();
            cells.around(i, 1, |_| true, |j| found.push(j as usize));
            let listed = found.len();
            found.sort_unstable();
            found.dedup();
            prop_assert_eq!(found.len(), listed, "a particle was visited twice");
            for j in 0..points.len() {
                let apart = points[i] - points[j];
                let apart = periodic.map_or(apart, |periodic| periodic.shortest(apart)).length();
                prop_assert!(apart > size || found.contains(&j));
            }
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn cells_around_a_point_hold_all_points_within_a_side(
            points in prop::collection::vec((-3.0..3.0, -3.0..3.0, -3.0..3.0), 1..80),
            far in -1e12..1e12,
        ) {
            let mut points: Vec<_> = points.into_iter().map(|(x, y, z)| Solid::new(x, y, z)).collect();
            points.push(Solid::new(far, -far, far));
            check(&points, None)?;
            check(&points.iter().map(|x| x.truncate()).collect::<Vec<Plane>>(), None)?;
        }

        /// Periodic boxes one, two and many cells wide.
        #[test]
        fn cells_of_a_periodic_box_hold_all_points_within_a_side(
            points in prop::collection::vec((0.0..1.0, 0.0..1.0, 0.0..1.0), 1..60),
            lengths in (1.41..6.0, 1.41..6.0),
        ) {
            let (x, y) = lengths;
            let sides = PeriodicSides { x: Some((-1.0, x - 1.0)), y: None, z: Some((2.0, y + 2.0)) };
            let points: Vec<_> =
                points.into_iter().map(|(a, b, c)| Solid::new(a * x - 1.0, 3.0 * b, c * y + 2.0)).collect();
            check(&points, Periodic::new(&sides))?;
            let sides = PeriodicSides { x: Some((-1.0, x - 1.0)), y: Some((0.0, 3.0)), z: None };
            check(&points.iter().map(|x| x.truncate()).collect::<Vec<Plane>>(), Periodic::new(&sides))?;
        }
    }
}
