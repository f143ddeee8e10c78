//! What a batch of contacts does to their two: what sums are made of, and what the books of energy want to know besides.

use crate::columns::BOOKED;
use crate::contact::history::Lost;
use crate::contact::lanes::{Lanes, Scalars};
use crate::contact::sums::{drag, total};
use crate::contact::{Demands, Pair, PairForce};
use crate::space::{Linear, Space};

/// What contacts do to their two, side by side.
#[derive(Clone, Debug, Default)]
pub struct Answer<V: Space> {
    /// Whether the two touch: 1 or 0. Where not, nothing else is to be read.
    pub touches: Scalars,
    /// Force on i, N: the whole, and the part of it that dashpots make.
    forces: [Lanes<V>; BOOKED],
    /// Torques that i gains and j loses, N m: of each the whole, and the part that tangential dashpots make.
    torques: [[Lanes<V::Spin>; BOOKED]; 2],
    /// Torque on i of the dashpots of rolling resistance, N m.
    pub rolling_drag_torque: Lanes<V::Spin>,
    /// What sliding, rolling beyond the cap and tangential dashpots took, J.
    lost: [Scalars; 3],
}

impl<V: Space> Answer<V> {
    /// Force on i, as an entry of a [`Tally`](crate::columns::Tally).
    #[inline(always)]
    pub fn force<const EACH: usize>(&self, lane: usize) -> [V; EACH] {
        std::array::from_fn(
            #[inline(always)]
            |part| self.forces[part].get(lane),
        )
    }

    /// Torque that i gains (side 0) or j loses (side 1), as an entry of one.
    #[inline(always)]
    pub fn torque<const EACH: usize>(&self, side: usize, lane: usize) -> [V::Spin; EACH] {
        std::array::from_fn(
            #[inline(always)]
            |part| self.torques[side][part].get(lane),
        )
    }

    /// Notes the whole.
    #[inline(always)]
    pub(super) fn note<L: Demands>(&mut self, lane: usize, pair: &Pair<V>, force: &PairForce<V>) {
        self.forces[0].set(lane, total::<L, V>(force));
        if L::SPIN {
            let turning = &force.turning;
            let moment = pair.normal.cross(turning.friction);
            let rolling = if L::ROLLING { turning.rolling } else { V::Spin::ZERO };
            let [arm_i, arm_j] = turning.arms;
            self.torques[0][0].set(lane, moment * -arm_i + rolling);
            self.torques[1][0].set(lane, moment * arm_j + rolling);
        }
    }

    /// Notes what serves the books alone.
    #[inline(always)]
    pub(super) fn book<L: Demands>(&mut self, lane: usize, pair: &Pair<V>, force: &PairForce<V>) {
        self.forces[1].set(lane, drag::<L, V>(force));
        if L::SPIN {
            let turning = &force.turning;
            let moment = pair.normal.cross(turning.friction_drag);
            let [arm_i, arm_j] = turning.arms;
            self.torques[0][1].set(lane, moment * -arm_i);
            self.torques[1][1].set(lane, moment * arm_j);
            self.lost[0][lane] = turning.lost_by_sliding;
            self.lost[2][lane] = pair.taken_by_dashpot::<L>(turning);
            if L::ROLLING {
                self.rolling_drag_torque.set(lane, turning.rolling_drag);
                self.lost[1][lane] = turning.lost_by_rolling;
            }
        }
    }

    /// Adds what a contact has lost.
    #[inline(always)]
    pub(super) fn add_lost<L: Demands>(&self, lane: usize, lost: &mut Lost) {
        let [sliding, rolling, dashpots] = &self.lost;
        lost.sliding += sliding[lane];
        lost.dashpots += dashpots[lane];
        if L::ROLLING {
            lost.rolling += rolling[lane];
        }
    }
}
