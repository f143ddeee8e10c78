//! What a contact adds to the loads of its two, and to the books of friction.

use crate::columns::{Columns, Turn};
use crate::contact::geometry::parted;
use crate::contact::kernel::Pass;
use crate::contact::{Demands, Memory, Pair, PairForce, PairLaw};
use crate::periodic::Metric;
use crate::space::Space;

/// What the springs of contacts that ended held, J: it is lost to friction and rolling resistance.
#[derive(Default)]
pub(crate) struct Ended {
    sliding: f64,
    rolling: f64,
}

impl Ended {
    /// Adds a contact of entry `i`; that with a lower entry is booked there.
    #[cold]
    pub(super) fn add<V: Space, L: PairLaw<V> + Demands, M: Metric<V>>(
        &mut self,
        pass: &Pass<V, L, M>,
        columns: &Columns<V>,
        i: usize,
        partner: u32,
        memory: &Memory<V>,
    ) {
        let j = partner as usize;
        if i < j {
            self.add_pair(pass.law, &parted(&pass.metric, columns, i, j, pass.dt), memory);
        }
    }

    /// Adds a contact whose two have parted.
    pub(crate) fn add_pair<V: Space, L: PairLaw<V>>(&mut self, law: &L, pair: &Pair<V>, memory: &Memory<V>) {
        let [sliding, rolling] = law.forget(pair, memory);
        self.sliding += sliding;
        self.rolling += rolling;
    }

    /// Whether there was one.
    pub(crate) fn is_any(&self) -> bool {
        self.sliding != 0.0 || self.rolling != 0.0
    }

    pub(crate) fn book<V: Space>(&self, turn: &mut Turn<V>) {
        turn.lost_by_sliding += self.sliding;
        turn.lost_by_rolling += self.rolling;
    }
}

/// The whole force on i.
#[inline]
pub(crate) fn total<L: Demands, V: Space>(force: &PairForce<V>) -> V {
    let smooth = force.elastic + force.drag;
    if L::SPIN { smooth + force.turning.friction } else { smooth }
}

/// Adds the torques of a contact on its first (`side` 0) or second member.
#[inline]
pub(crate) fn turn<L: Demands, V: Space>(turn: &mut Turn<V>, pair: &Pair<V>, force: &PairForce<V>, side: usize) {
    let friction = &force.turning;
    let arm = pair.normal * -friction.arms[side];
    // Forces and torques of rolling on the second are opposite; torques of friction are not, for arm and force are.
    let sign = if side == 0 { 1.0 } else { -1.0 };
    turn.torque += arm.cross(friction.friction);
    turn.friction_drag_torque += arm.cross(friction.friction_drag);
    turn.friction_drag += friction.friction_drag * sign;
    if L::ROLLING {
        turn.torque += friction.rolling * sign;
        turn.rolling_drag_torque += friction.rolling_drag * sign;
    }
}

/// Books what sliding took at one of the two.
#[inline]
pub(crate) fn book_losses<L: Demands, V: Space>(turn: &mut Turn<V>, force: &PairForce<V>) {
    turn.lost_by_sliding += force.turning.lost_by_sliding;
    if L::ROLLING {
        turn.lost_by_rolling += force.turning.lost_by_rolling;
    }
}
