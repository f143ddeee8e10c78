//! Sums: what contacts add to the loads of their two, and what ends with them. Each begins with the weight.

use std::ops::Range;

use crate::columns::{Columns, Load, Turn};
use crate::contact::batch::{Answer, Batch};
use crate::contact::geometry::parted;
use crate::contact::kernel::Pass;
use crate::contact::lanes::LANES;
use crate::contact::{Demands, Memory, Pair, PairForce, PairLaw, Turning};
use crate::neighbours::list::Candidate;
use crate::periodic::Metric;
use crate::space::{Linear, Space};

impl<V: Space, L: PairLaw<V> + Demands, M: Metric<V>> Pass<'_, V, L, M> {
    /// What the springs of a contact that has ended held, J: it is lost to friction and rolling resistance.
    #[cold]
    pub(super) fn forget(&self, columns: &Columns<V>, contact: Candidate, memory: &Memory<V>) -> [f64; 2] {
        let [i, j] = contact.both();
        self.law.forget(&parted(&self.metric, columns, i, j, self.dt), memory)
    }
}

impl<V: Space> Pair<V> {
    /// What the tangential dashpot takes in this step, J.
    #[inline(always)]
    pub(crate) fn taken_by_dashpot<L: Demands>(&self, turning: &Turning<V>) -> f64 {
        let pair = if L::AHEAD { self.predicted() } else { *self };
        -turning.friction_drag.dot(pair.sliding_velocity(turning.arms)) * self.dt
    }
}

/// The part of the force on i that dashpots make.
#[inline(always)]
pub(crate) fn drag<L: Demands, V: Space>(force: &PairForce<V>) -> V {
    if L::SPIN { force.drag + force.turning.friction_drag } else { force.drag }
}

/// The whole force on i.
#[inline(always)]
pub(crate) fn total<L: Demands, V: Space>(force: &PairForce<V>) -> V {
    let smooth = force.elastic + force.drag;
    if L::SPIN { smooth + force.turning.friction } else { smooth }
}

/// The sums of the particles of a share of rows, entry by entry; of what the law does not demand, nothing.
pub(super) struct Sums<'a, V: Space> {
    rows: Range<usize>,
    /// Entries before this one have begun.
    begun: usize,
    loads: &'a mut [Load<V>],
    turns: &'a mut [Turn<V>],
    contacts: &'a mut [u32],
    rolling: &'a mut [V::Spin],
}

impl<'a, V: Space> Sums<'a, V> {
    pub(super) fn new(
        rows: Range<usize>,
        loads: &'a mut [Load<V>],
        turns: &'a mut [Turn<V>],
        contacts: &'a mut [u32],
        rolling: &'a mut [V::Spin],
    ) -> Self {
        let begun = rows.start;
        Self { rows, begun, loads, turns, contacts, rolling }
    }

    /// Begins the sums of all entries before this one, if they have not.
    pub(super) fn begin<L: Demands>(&mut self, end: usize, gravity: V, columns: &Columns<V>) {
        let end = end.clamp(self.begun, self.rows.end);
        let (masses, start) = (&columns.mass[self.begun..end], self.rows.start);
        let places = self.begun - start..end - start;
        for (load, mass) in self.loads[places.clone()].iter_mut().zip(masses) {
            *load = Load::weight(gravity, *mass);
        }
        if L::SPIN {
            self.turns[places.clone()].fill(Turn::default());
        }
        if L::ROLLING {
            self.rolling[places.clone()].fill(V::Spin::ZERO);
        }
        if L::AHEAD {
            self.contacts[places].fill(0);
        }
        self.begun = end;
    }

    /// Adds what the contacts of a batch do to both, unless the second is in another share.
    #[inline(always)]
    pub(super) fn add_to_both<L: Demands>(&mut self, batch: &Batch<V>) {
        let start = self.rows.start;
        let Self { loads, turns, contacts, rolling, .. } = self;
        // What is of its own cannot change under the loop.
        let (loads, turns, contacts, rolling) = (&mut **loads, &mut **turns, &mut **contacts, &mut **rolling);
        let answer = &batch.answer;
        for lane in (0..batch.len.min(LANES)).filter(|&lane| batch.touches::<L>(lane)) {
            let [first, second] = batch.pairs[lane].both().map(|entry| entry - start);
            let (force, drag) = (answer.force.get(lane), answer.drag.get(lane));
            let load = &mut loads[first];
            load.force += force;
            load.drag += drag;
            let is_here = second < loads.len();
            if is_here {
                let load = &mut loads[second];
                load.force -= force;
                load.drag -= drag;
            }
            if L::SPIN {
                turns[first].gain(answer, lane);
                if is_here {
                    turns[second].lose(answer, lane);
                }
            }
            if L::ROLLING {
                let drag = answer.rolling_drag_torque.get(lane);
                rolling[first] += drag;
                if is_here {
                    rolling[second] -= drag;
                }
            }
            if L::AHEAD {
                contacts[first] += 1;
                if is_here {
                    contacts[second] += 1;
                }
            }
        }
    }

    /// Adds what the contacts of a batch do to their second members.
    pub(super) fn add_to_second<L: Demands>(&mut self, batch: &Batch<V>) {
        let answer = &batch.answer;
        for lane in (0..batch.len.min(LANES)).filter(|&lane| batch.touches::<L>(lane)) {
            let second = batch.pairs[lane].second() - self.rows.start;
            self.loads[second].force -= answer.force.get(lane);
            self.loads[second].drag -= answer.drag.get(lane);
            if L::SPIN {
                self.turns[second].lose(answer, lane);
            }
            if L::ROLLING {
                self.rolling[second] -= answer.rolling_drag_torque.get(lane);
            }
            if L::AHEAD {
                self.contacts[second] += 1;
            }
        }
    }
}

impl<V: Space> Turn<V> {
    /// Adds what the contact of a lane does to its first member.
    #[inline(always)]
    fn gain(&mut self, answer: &Answer<V>, lane: usize) {
        self.torque += answer.torques[0].get(lane);
        self.drag_torque += answer.drag_torques[0].get(lane);
    }

    /// Takes away what the contact of a lane takes from its second member.
    #[inline(always)]
    fn lose(&mut self, answer: &Answer<V>, lane: usize) {
        self.torque -= answer.torques[1].get(lane);
        self.drag_torque -= answer.drag_torques[1].get(lane);
    }

    /// Adds what a wall does to a grain.
    #[inline]
    pub(crate) fn add_wall<L: Demands>(&mut self, pair: &Pair<V>, force: &PairForce<V>) {
        let turning = &force.turning;
        let arm = pair.normal * -turning.arms[0];
        self.torque += arm.cross(turning.friction);
        self.drag_torque += arm.cross(turning.friction_drag);
        if L::ROLLING {
            self.torque += turning.rolling;
        }
    }
}
