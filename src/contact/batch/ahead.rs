//! What is to come for the two of each contact until the end of the step.

use crate::columns::Columns;
use crate::contact::Demands;
use crate::contact::centred::Ahead;
use crate::contact::lanes::{Lanes, Scalars, of_both};
use crate::space::Space;

/// As [`Ahead`].
#[derive(Clone, Debug, Default)]
pub struct AheadLanes<V: Space> {
    velocity: Lanes<V>,
    spins: [Lanes<V::Spin>; 2],
    inverse_inertias: [Scalars; 2],
    lone: [Scalars; 2],
}

impl<V: Space> AheadLanes<V> {
    /// Fills in what is to come for a pair of entries.
    #[inline]
    pub fn describe<L: Demands>(&mut self, lane: usize, pair: [usize; 2], columns: &Columns<V>) {
        let [i, j] = pair.map(|entry| columns.gain[entry]);
        self.velocity.set(lane, i.velocity - j.velocity);
        for (side, entry) in pair.into_iter().enumerate() {
            self.lone[side][lane] = columns.gain[entry].lone;
            if L::SPIN {
                self.spins[side].set(lane, columns.spin_gain[entry].spin);
                self.inverse_inertias[side][lane] = columns.spin_gain[entry].inverse_inertia;
            }
        }
    }

    /// Sets what is to come for the two of a lane.
    #[inline]
    pub fn set<L: Demands>(&mut self, lane: usize, ahead: &Ahead<V>) {
        self.velocity.set(lane, ahead.velocity);
        for side in 0..2 {
            self.lone[side][lane] = ahead.lone[side];
            if L::SPIN {
                self.spins[side].set(lane, ahead.spins[side]);
                self.inverse_inertias[side][lane] = ahead.inverse_inertias[side];
            }
        }
    }

    /// What is to come for the two of a lane, of these inverse masses (1/kg).
    #[inline(always)]
    pub(super) fn get<L: Demands>(&self, lane: usize, inverse_masses: [f64; 2]) -> Ahead<V> {
        let mut ahead = Ahead {
            velocity: self.velocity.get(lane),
            inverse_masses,
            lone: of_both(&self.lone, lane),
            ..Ahead::default()
        };
        if L::SPIN {
            ahead.spins = [self.spins[0].get(lane), self.spins[1].get(lane)];
            ahead.inverse_inertias = of_both(&self.inverse_inertias, lane);
        }
        ahead
    }
}
