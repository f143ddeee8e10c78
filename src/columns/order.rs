//! The order of slots in space: row by row, so that neighbours in space are mostly neighbours in memory, whatever the
//! order in which grains entered.
//!
//! Positions are put on a grid whose cells are as wide as the largest grain. Cells are ordered along the axis on which the
//! grains reach farthest, slice by slice. A force pass then reads two or three rows side by side, each from its beginning to
//! its end, which processors foresee. Ranges of slots, the shares of threads, meet in one cross-section.

use crate::space::Space;

/// The cells, and which axis comes first.
#[derive(Clone, Copy, Debug)]
pub struct Order {
    cell: f64,
    axes: [usize; 3],
}

impl Default for Order {
    fn default() -> Self {
        Self { cell: 1.0, axes: [0, 1, 2] }
    }
}

/// Number of a cell along each axis, the first one first.
pub type Place = [i32; 3];

impl Order {
    /// For grains at `positions` (m), the widest of which has this diameter (m).
    pub fn of<V: Space>(positions: impl Iterator<Item = V>, diameter: f64) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for x in positions {
            for axis in 0..V::COMPONENTS {
                low[axis] = low[axis].min(x.axis(axis));
                high[axis] = high[axis].max(x.axis(axis));
            }
        }
        let mut axes = [0, 1, 2];
        // Axes that a planar scene does not have reach nowhere: infinitely little.
        axes.sort_by(|&a, &b| (high[b] - low[b]).total_cmp(&(high[a] - low[a])));
        Self { cell: diameter.max(f64::MIN_POSITIVE), axes }
    }

    /// Where `x` (m) comes.
    #[must_use]
    pub fn place<V: Space>(&self, x: V) -> Place {
        self.axes.map(|axis| {
            #[expect(clippy::cast_possible_truncation, reason = "saturates; NaN becomes 0")]
            if axis < V::COMPONENTS { (x.axis(axis) / self.cell).floor() as i32 } else { 0 }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::{Plane, Solid};

    #[test]
    fn rows_lie_across_the_longest_axis() {
        let grains = [Plane::new(0.0, 0.0), Plane::new(2.0, 7.0)];
        let order = Order::of(grains.into_iter(), 0.5);
        assert_eq!(order.place(Plane::new(1.3, -0.2)), [-1, 2, 0]);
        let grains = [Solid::new(0.0, 0.0, 0.0), Solid::new(2.0, 1.0, 7.0)];
        let order = Order::of(grains.into_iter(), 0.5);
        assert_eq!(order.place(Solid::new(0.6, 1.2, 3.1)), [6, 1, 2]);
    }

    #[test]
    fn nothing_is_too_far_or_too_few() {
        let order = Order::of(std::iter::empty::<Plane>(), 0.0);
        assert!(order.place(Plane::new(1e300, f64::NAN)).contains(&i32::MAX));
    }
}
