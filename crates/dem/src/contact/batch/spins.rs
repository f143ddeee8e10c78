//! Spins of the particles of the contacts of a batch.

use crate::lanes::{Lanes, Quads, Scalars, spread};
use crate::space::quad;
use crate::space::{Linear, Space};
use crate::store::Rotation;

/// Spins of i and j in lanes, rad/s.
#[derive(Clone, Debug, Default)]
pub struct Spins<V: Space> {
    /// Spins as loaded, before the transposition; used in solid space, where spins have three components.
    loaded: [Quads; 2],
    /// The fourth loaded number. Never read.
    unused: Scalars,
    lanes: [Lanes<V::Spin>; 2],
}

impl<V: Space> Spins<V> {
    /// Loads the spins of two particles into a lane.
    #[inline(always)]
    pub fn take(&mut self, lane: usize, pair: [&Rotation<V>; 2]) {
        for (side, Rotation { spin, inverse_inertia }) in pair.into_iter().enumerate() {
            if V::Spin::COUNT == 1 {
                self.lanes[side].set(lane, *spin);
            } else {
                // Four adjacent numbers, so that one instruction loads them.
                let number = |axis| if axis < V::Spin::COUNT { spin.component(axis) } else { *inverse_inertia };
                self.loaded[side][lane] = quad(number);
            }
        }
    }

    /// Transposes the loaded spins of the first `lanes` lanes.
    #[inline(always)]
    pub(super) fn spread(&mut self, lanes: usize) {
        if V::Spin::COUNT > 1 {
            for (loaded, spins) in self.loaded.iter().zip(&mut self.lanes) {
                let [x, y, z] = spins.axes();
                spread(loaded, lanes, x, y, z, &mut self.unused);
            }
        }
    }

    /// Returns the spins of i and j in a lane.
    #[inline(always)]
    pub(super) fn get(&self, lane: usize) -> [V::Spin; 2] {
        [self.lanes[0].get(lane), self.lanes[1].get(lane)]
    }
}
