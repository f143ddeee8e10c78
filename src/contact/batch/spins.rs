//! How the two of each contact spin.

use crate::contact::lanes::{Lanes, Quads, Scalars, spread};
use crate::space::quad;
use crate::space::{Linear, Space};
use crate::store::Rotation;

/// How the two spin.
#[derive(Clone, Debug, Default)]
pub struct Spins<V: Space> {
    /// As taken, where they have three components.
    taken: [Quads; 2],
    /// What lies beside them, which nobody reads.
    fourth: Scalars,
    lanes: [Lanes<V::Spin>; 2],
}

impl<V: Space> Spins<V> {
    /// Takes those of two into a lane.
    #[inline(always)]
    pub fn take(&mut self, lane: usize, pair: [&Rotation<V>; 2]) {
        for (side, Rotation { spin, inverse_inertia }) in pair.into_iter().enumerate() {
            if V::Spin::COUNT == 1 {
                self.lanes[side].set(lane, *spin);
            } else {
                // Four that lie side by side.
                let number = |axis| if axis < V::Spin::COUNT { spin.component(axis) } else { *inverse_inertia };
                self.taken[side][lane] = quad(number);
            }
        }
    }

    /// Spreads what was taken over so many lanes.
    #[inline(always)]
    pub(super) fn spread(&mut self, lanes: usize) {
        if V::Spin::COUNT > 1 {
            for (taken, spins) in self.taken.iter().zip(&mut self.lanes) {
                let [x, y, z] = spins.axes();
                spread(taken, lanes, x, y, z, &mut self.fourth);
            }
        }
    }

    /// Those of a lane.
    #[inline(always)]
    pub(super) fn get(&self, lane: usize) -> [V::Spin; 2] {
        [self.lanes[0].get(lane), self.lanes[1].get(lane)]
    }
}
