//! The spatial order of slots: row by row, so that neighbours in space are mostly neighbours in memory, in whatever
//! order grains entered.
//!
//! Positions are put on a grid with cells as wide as the largest grain. Cells are ordered along the axis of the largest
//! extent, slice by slice. A force pass then reads two or three rows side by side, each from beginning to end, which
//! hardware prefetchers predict. The slot ranges of two threads meet in one cross-section, or at the side of a beam.
//!
//! A force pass works on two slices at a time, and the data of their grains should stay in the cache. If slices are
//! large, the axis of the second largest extent is therefore cut into beams, one after the other. A beam has about
//! [`GRAINS_PER_SLICE`] grains per slice and is at least [`MIN_BEAM_WIDTH`] cells wide, so that few grains are at its
//! side. Grains at a side are loaded again for the next beam.

use serde::{Deserialize, Serialize};

use crate::persist::Problem;
use crate::space::Space;

/// Grains of a slice that fit easily into the cache, about one per cell. A step needs about 200 B per grain, so two
/// active slices and the next one take 230 kB: a quarter of a second-level cache of 1 MB.
const GRAINS_PER_SLICE: f64 = 384.0;

/// Smallest width of a beam, in cells.
const MIN_BEAM_WIDTH: f64 = 8.0;

/// The cell size (m), the axes by descending extent, and the width of beams along the second axis in cells, if there
/// are beams.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub struct SpatialOrder {
    cell: f64,
    axes: [usize; 3],
    beam: Option<i32>,
}

impl Default for SpatialOrder {
    fn default() -> Self {
        Self { cell: 1.0, axes: [0, 1, 2], beam: None }
    }
}

/// Number of the beam, and of the cell along each axis by descending extent.
pub type Place = [i32; 4];

impl SpatialOrder {
    /// The order for grains at `positions` (m) with this largest diameter (m).
    #[inline]
    pub fn of<V: Space>(positions: impl Iterator<Item = V>, diameter: f64) -> Self {
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for x in positions {
            for axis in 0..V::COMPONENTS {
                low[axis] = low[axis].min(x.axis(axis));
                high[axis] = high[axis].max(x.axis(axis));
            }
        }
        let mut axes = [0, 1, 2];
        // Axes that a planar scene does not have get the extent minus infinity, so they come last.
        axes.sort_by(|&a, &b| (high[b] - low[b]).total_cmp(&(high[a] - low[a])));
        let cell = diameter.max(f64::MIN_POSITIVE);
        let [_, wide, deep] = axes.map(|axis| ((high[axis] - low[axis]) / cell).max(1.0));
        let width = (GRAINS_PER_SLICE / deep).max(MIN_BEAM_WIDTH);
        #[expect(clippy::cast_possible_truncation, reason = "at least MIN_BEAM_WIDTH, at most GRAINS_PER_SLICE")]
        let beam = (wide > 2.0 * width).then_some(width as i32);
        Self { cell, axes, beam }
    }

    /// Refuses a restored order in which grains have no place.
    pub(super) fn check(&self) -> Result<(), Problem> {
        let has_axes = (0..3).all(|axis| self.axes.contains(&axis));
        let has_beam = self.beam.is_none_or(|width| width > 0);
        if has_axes && has_beam && self.cell > 0.0 { Ok(()) } else { Err("its spatial order is none".to_owned()) }
    }

    /// The place of `x` (m) in the order.
    #[must_use]
    #[inline]
    pub fn place<V: Space>(&self, x: V) -> Place {
        let [first, second, third] = self.axes.map(|axis| {
            #[expect(clippy::cast_possible_truncation, reason = "saturates; NaN becomes 0")]
            if axis < V::COMPONENTS { (x.axis(axis) / self.cell).floor() as i32 } else { 0 }
        });
        [self.beam.map_or(0, |width| second.div_euclid(width)), first, second, third]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::{Plane, Solid};

    #[test]
    fn rows_lie_across_the_longest_axis() {
        let grains = [Plane::new(0.0, 0.0), Plane::new(2.0, 7.0)];
        let order = SpatialOrder::of(grains.into_iter(), 0.5);
        assert_eq!(order.place(Plane::new(1.3, -0.2)), [0, -1, 2, 0]);
        let grains = [Solid::new(0.0, 0.0, 0.0), Solid::new(2.0, 1.0, 7.0)];
        let order = SpatialOrder::of(grains.into_iter(), 0.5);
        assert_eq!(order.place(Solid::new(0.6, 1.2, 3.1)), [0, 6, 1, 2]);
    }

    #[test]
    fn large_slices_are_cut_into_beams() {
        // 100 x 60 x 40 cells: beams are 384/40 = 9 cells wide (truncated).
        let grains = [Solid::ZERO, Solid::new(40.0, 100.0, 60.0)];
        let order = SpatialOrder::of(grains.into_iter(), 1.0);
        assert_eq!(order.place(Solid::new(3.5, 70.5, 17.5)), [1, 70, 17, 3]);
        assert_eq!(order.place(Solid::new(3.5, 70.5, 18.5)), [2, 70, 18, 3]);
        // Beams keep the smallest width, however deep the slices are.
        let order = SpatialOrder::of([Solid::ZERO, Solid::new(900.0, 900.0, 1000.0)].into_iter(), 1.0);
        assert_eq!(order.place(Solid::new(8.5, 1.5, 3.5))[0], 1);
    }

    #[test]
    fn extreme_positions_and_empty_input_have_a_place() {
        let order = SpatialOrder::of(std::iter::empty::<Plane>(), 0.0);
        assert!(order.place(Plane::new(1e300, f64::NAN)).contains(&i32::MAX));
    }
}
