//! Sums: what contacts add to the loads of their two, and what ends with them. Each begins with the weight.
//!
//! What serves the books of energy alone is added where they are kept.

use std::ops::Range;

use crate::columns::{Columns, Loads};
use crate::contact::batch::Batch;
use crate::contact::geometry::parted;
use crate::contact::kernel::Pass;
use crate::contact::lanes::LANES;
use crate::contact::{Demands, Memory, Pair, PairForce, PairLaw, Turning};
use crate::neighbours::list::Candidate;
use crate::periodic::Metric;
use crate::space::Space;

impl<V: Space, L: PairLaw<V> + Demands, M: Metric<V>> Pass<'_, V, L, M> {
    /// What the springs of a contact that has ended held, J: it is lost to friction and rolling resistance.
    #[cold]
    pub(super) fn forget(&self, columns: &Columns<V>, contact: Candidate, memory: &Memory<V>) -> [f64; 2] {
        if !columns.has_books {
            return [0.0; 2];
        }
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

/// A share of the loads: of consecutive particles.
pub(super) struct Share<'a, V: Space> {
    force: &'a mut [V],
    torque: &'a mut [V::Spin],
    drag: &'a mut [V],
    drag_torque: &'a mut [V::Spin],
    rolling_drag: &'a mut [V::Spin],
    contacts: &'a mut [u32],
}

impl<'a, V: Space> Share<'a, V> {
    /// Everybody's.
    pub(super) fn all(loads: &'a mut Loads<V>) -> Self {
        let Loads { force, torque, drag, drag_torque, rolling_drag, contacts } = loads;
        Self { force, torque, drag, drag_torque, rolling_drag, contacts }
    }

    /// Takes those of the first so many away.
    pub(super) fn cut_off(&mut self, particles: usize) -> Self {
        fn cut_off<'a, T>(column: &mut &'a mut [T], particles: usize) -> &'a mut [T] {
            // Of what is not asked for, nothing.
            column.split_off_mut(..particles).unwrap_or_default()
        }
        Self {
            force: cut_off(&mut self.force, particles),
            torque: cut_off(&mut self.torque, particles),
            drag: cut_off(&mut self.drag, particles),
            drag_torque: cut_off(&mut self.drag_torque, particles),
            rolling_drag: cut_off(&mut self.rolling_drag, particles),
            contacts: cut_off(&mut self.contacts, particles),
        }
    }

    /// Sets those of some places, from the start of the share, to what sums begin with.
    fn begin(&mut self, places: Range<usize>, weights: impl Iterator<Item = V>) {
        fn clear<T: Copy + Default>(column: &mut [T], places: &Range<usize>) {
            if let Some(sums) = column.get_mut(places.clone()) {
                sums.fill(T::default());
            }
        }
        for (force, weight) in self.force[places.clone()].iter_mut().zip(weights) {
            *force = weight;
        }
        clear(self.torque, &places);
        clear(self.drag, &places);
        clear(self.drag_torque, &places);
        clear(self.rolling_drag, &places);
        clear(self.contacts, &places);
    }
}

/// The sums of the particles of a share of rows, entry by entry.
pub(super) struct Sums<'a, V: Space> {
    rows: Range<usize>,
    /// Entries before this one have begun.
    begun: usize,
    share: Share<'a, V>,
}

impl<'a, V: Space> Sums<'a, V> {
    pub(super) fn new(rows: Range<usize>, share: Share<'a, V>) -> Self {
        Self { begun: rows.start, rows, share }
    }

    /// Begins the sums of all entries before this one, if they have not.
    pub(super) fn begin(&mut self, end: usize, gravity: V, columns: &Columns<V>) {
        let end = end.clamp(self.begun, self.rows.end);
        let weights = columns.mass[self.begun..end].iter().map(|mass| gravity * *mass);
        let start = self.rows.start;
        self.share.begin(self.begun - start..end - start, weights);
        self.begun = end;
    }

    /// Adds what the contacts of a batch do to both, unless the second is in another share. `BOOKS`: whether they are kept.
    #[inline(always)]
    pub(super) fn add_to_both<L: Demands, const BOOKS: bool>(&mut self, batch: &Batch<V>) {
        let start = self.rows.start;
        let Share { force, torque, drag, drag_torque, rolling_drag, contacts } = &mut self.share;
        // What is of its own cannot change under the loop.
        let (forces, torques, contacts) = (&mut **force, &mut **torque, &mut **contacts);
        let (drags, drag_torques, rolling) = (&mut **drag, &mut **drag_torque, &mut **rolling_drag);
        let answer = &batch.answer;
        for lane in (0..batch.len.min(LANES)).filter(|&lane| batch.touches::<L>(lane)) {
            let [first, second] = batch.pairs[lane].both().map(|entry| entry - start);
            let is_here = second < forces.len();
            let force = answer.force.get(lane);
            forces[first] += force;
            if is_here {
                forces[second] -= force;
            }
            if L::SPIN {
                torques[first] += answer.torques[0].get(lane);
                if is_here {
                    torques[second] -= answer.torques[1].get(lane);
                }
            }
            if L::AHEAD {
                contacts[first] += 1;
                if is_here {
                    contacts[second] += 1;
                }
            }
            if !BOOKS {
                continue;
            }
            let drag = answer.drag.get(lane);
            drags[first] += drag;
            if is_here {
                drags[second] -= drag;
            }
            if L::SPIN {
                drag_torques[first] += answer.drag_torques[0].get(lane);
                if is_here {
                    drag_torques[second] -= answer.drag_torques[1].get(lane);
                }
            }
            if L::ROLLING {
                let drag = answer.rolling_drag_torque.get(lane);
                rolling[first] += drag;
                if is_here {
                    rolling[second] -= drag;
                }
            }
        }
    }

    /// Adds what the contacts of a batch do to their second members.
    pub(super) fn add_to_second<L: Demands>(&mut self, batch: &Batch<V>) {
        let (answer, share) = (&batch.answer, &mut self.share);
        let has_books = !share.drag.is_empty();
        for lane in (0..batch.len.min(LANES)).filter(|&lane| batch.touches::<L>(lane)) {
            let second = batch.pairs[lane].second() - self.rows.start;
            share.force[second] -= answer.force.get(lane);
            if L::SPIN {
                share.torque[second] -= answer.torques[1].get(lane);
            }
            if L::AHEAD {
                share.contacts[second] += 1;
            }
            if has_books {
                share.drag[second] -= answer.drag.get(lane);
                if L::SPIN {
                    share.drag_torque[second] -= answer.drag_torques[1].get(lane);
                }
                if L::ROLLING {
                    share.rolling_drag[second] -= answer.rolling_drag_torque.get(lane);
                }
            }
        }
    }
}
