//! What a contact adds to the loads of its two, and what ends with it.

use crate::columns::{Columns, Turn};
use crate::contact::batch::Answer;
use crate::contact::geometry::parted;
use crate::contact::kernel::Pass;
use crate::contact::{Demands, Memory, Pair, PairForce, PairLaw};
use crate::periodic::Metric;
use crate::space::Space;

impl<V: Space, L: PairLaw<V> + Demands, M: Metric<V>> Pass<'_, V, L, M> {
    /// What the springs of a contact that has ended held, J: it is lost to friction and rolling resistance.
    #[cold]
    pub(super) fn forget(&self, columns: &Columns<V>, i: usize, partner: u32, memory: &Memory<V>, lost: &mut [f64; 2]) {
        let pair = parted(&self.metric, columns, i, partner as usize, self.dt);
        add(lost, self.law.forget(&pair, memory));
    }
}

/// Adds losses by sliding and by rolling, J.
#[inline]
pub(crate) fn add(lost: &mut [f64; 2], more: [f64; 2]) {
    lost[0] += more[0];
    lost[1] += more[1];
}

/// The whole force on i.
#[inline(always)]
pub(crate) fn total<L: Demands, V: Space>(force: &PairForce<V>) -> V {
    let smooth = force.elastic + force.drag;
    if L::SPIN { smooth + force.turning.friction } else { smooth }
}

impl<V: Space> Turn<V> {
    /// Adds what the contact of a lane does to its first (`side` 0) or second member.
    #[inline]
    pub(super) fn add(&mut self, answer: &Answer<V>, lane: usize, side: usize) {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        self.torque += answer.torques[side].get(lane);
        self.friction_drag += answer.friction_drag.get(lane) * sign;
        self.friction_drag_torque += answer.friction_drag_torques[side].get(lane);
    }

    /// Adds what a wall does to a grain.
    #[inline]
    pub(crate) fn add_wall<L: Demands>(&mut self, pair: &Pair<V>, force: &PairForce<V>) {
        let turning = &force.turning;
        let arm = pair.normal * -turning.arms[0];
        self.torque += arm.cross(turning.friction);
        self.friction_drag += turning.friction_drag;
        self.friction_drag_torque += arm.cross(turning.friction_drag);
        if L::ROLLING {
            self.torque += turning.rolling;
        }
    }
}
