//! The kernel: the sum of pair forces over the columns.
//!
//! Each pair is evaluated once, walked i < j with both ascending, and added to both: a particle receives its partners in
//! ascending order of slots. Three things happen by turns: candidates are filtered by distance, without a branch, into a
//! batch; when it is full, the law answers for all its lanes at once; the answers are added one by one, in order. What a
//! law does not demand ([`Demands`]) is not compiled.
//!
//! Threads sum a range of rows each, and evaluate for themselves what rows of others do to theirs ([`PairList`]): the order
//! of every sum, and so its bits, do not depend on their number. Memories are written in pages of [`BLOCK`] rows, and a batch
//! ends with its block, so that neither do the books.

use rayon::prelude::*;

use crate::columns::{Columns, Load, Turn};
use crate::contact::batch::Batch;
use crate::contact::geometry::coincident;
use crate::contact::history::{BLOCK, History, Pages, Recall};
use crate::contact::lanes::LANES;
use crate::contact::{Demands, PairLaw, sums};
use crate::instructions::Instructions;
use crate::neighbours::list::{Candidate, PairList, Task};
use crate::periodic::Metric;
use crate::space::{Linear, Space};
use crate::threads::Threads;

/// How many candidates a batch takes at a time.
const PIECE: usize = 8;

/// What a pass needs besides the columns.
pub struct Pass<'a, V: Space, L, M> {
    /// The contact law.
    pub law: &'a L,
    /// How separations are measured.
    pub metric: M,
    /// Candidates.
    pub list: &'a PairList,
    /// By how much memories advance, s.
    pub dt: f64,
    /// m/s^2.
    pub gravity: V,
    /// What lanes are computed with.
    pub instructions: Instructions,
}

impl<V: Space, L: PairLaw<V> + Demands, M: Metric<V>> Pass<'_, V, L, M> {
    /// The same with separations measured otherwise.
    pub fn with<N>(&self, metric: N) -> Pass<'_, V, L, N> {
        let Self { law, list, dt, gravity, instructions, .. } = *self;
        Pass { law, metric, list, dt, gravity, instructions }
    }

    /// Sets the loads of `columns` to the sums of weight and all pair forces. `deepest` is the largest overlap so
    /// far over the smaller radius of its pair; gives that with these.
    pub fn sum(&self, columns: &mut Columns<V>, history: &mut History<V>, threads: &Threads, deepest: f64) -> f64 {
        let (mut loads, mut turns) = (std::mem::take(&mut columns.load), std::mem::take(&mut columns.turn));
        let mut contacts = std::mem::take(&mut columns.contacts);
        let mut rolling = std::mem::take(&mut columns.rolling_drag);
        if L::ROLLING {
            rolling.resize(columns.len(), V::Spin::ZERO);
        }
        let (before, mut now) = history.turn(columns);
        let view = &*columns;
        // What is left for the tasks to come; of what the law does not demand, nothing.
        let mut rest = (&mut loads[..], &mut turns[..], &mut contacts[..], &mut rolling[..]);
        let mut shares = Vec::with_capacity(self.list.tasks().len());
        for task in self.list.tasks() {
            let rows = task.rows.len();
            shares.push(Share {
                task,
                before,
                now: now.split_off_mut(..rows.div_ceil(BLOCK)).unwrap_or_default(),
                loads: rest.0.split_off_mut(..rows).unwrap_or_default(),
                turns: rest.1.split_off_mut(..rows).unwrap_or_default(),
                contacts: rest.2.split_off_mut(..rows).unwrap_or_default(),
                rolling: rest.3.split_off_mut(..rows).unwrap_or_default(),
            });
        }
        let work = |share: Share<V>| {
            let begun = share.task.rows.start;
            Worker { pass: self, view, share, batch: Batch::default(), largest: deepest, begun }.sum()
        };
        let largest = match threads.pool() {
            None => shares.into_iter().map(work).fold(deepest, f64::max),
            Some(pool) => pool.install(|| shares.into_par_iter().map(work).reduce(|| deepest, f64::max)),
        };
        (columns.load, columns.turn, columns.contacts, columns.rolling_drag) = (loads, turns, contacts, rolling);
        largest
    }
}

/// What one thread reads and writes.
struct Share<'a, V: Space> {
    task: &'a Task,
    before: &'a [Pages<V>],
    now: &'a mut [Pages<V>],
    loads: &'a mut [Load<V>],
    turns: &'a mut [Turn<V>],
    contacts: &'a mut [u32],
    rolling: &'a mut [V::Spin],
}

/// One thread at work.
struct Worker<'a, V: Space, L, M> {
    pass: &'a Pass<'a, V, L, M>,
    view: &'a Columns<V>,
    share: Share<'a, V>,
    batch: Batch<V>,
    largest: f64,
    /// Entries before this one have begun their sums.
    begun: usize,
}

impl<V: Space, L: PairLaw<V> + Demands, M: Metric<V>> Worker<'_, V, L, M> {
    fn sum(mut self) -> f64 {
        let task = self.share.task;
        for piece in task.incoming.chunks(PIECE) {
            self.begin_sums_up_to(piece.iter().fold(0, |last, pair| pair[1].max(last)) as usize);
            if self.offer(piece) {
                self.flush_incoming();
            }
        }
        self.flush_incoming();
        for (number, first) in task.rows.clone().step_by(BLOCK).enumerate() {
            let mut block = Block {
                number,
                first,
                recall: Recall::new(&self.share.before[first / BLOCK]),
                remembered: [false; LANES],
                lost: [0.0; 2],
                forgotten: [0.0; 2],
            };
            self.share.now[number].clear();
            for piece in self.pass.list.block(first / BLOCK).chunks(PIECE) {
                self.begin_sums_up_to(piece.iter().fold(0, |last, pair| pair[1].max(last)) as usize);
                if self.offer(piece) {
                    self.flush(&mut block);
                }
            }
            self.flush(&mut block);
            self.end(&mut block);
        }
        self.begin_sums_up_to(task.rows.end);
        self.largest
    }

    /// Begins the sums of all entries of the share up to this one, if they have not: shortly before they are added to, while
    /// their memory is at hand.
    #[inline]
    fn begin_sums_up_to(&mut self, entry: usize) {
        if entry < self.begun {
            return;
        }
        // Some more at once: how many each time is hard to foresee.
        let rows = &self.share.task.rows;
        let end = (entry + 64).min(rows.end);
        for entry in self.begun..end {
            let place = entry - rows.start;
            self.share.loads[place] = Load::weight(self.pass.gravity, self.view.mass[entry]);
            if L::SPIN {
                self.share.turns[place] = Turn::default();
                if L::ROLLING {
                    self.share.rolling[place] = V::Spin::ZERO;
                }
            }
            if L::AHEAD {
                self.share.contacts[place] = 0;
            }
        }
        self.begun = self.begun.max(end);
    }

    /// Adds those candidates to the batch that overlap, or that the law looks at ahead of that. Whether one does is hard to
    /// foresee, so there is no branch on it: each is written, and the end moves on if it counts. There is room for [`PIECE`]
    /// of them; tells whether there is none for as many again.
    #[inline]
    fn offer(&mut self, candidates: &[Candidate]) -> bool {
        let bodies = &self.view.body[..];
        let margin = if L::AHEAD { self.view.margin } else { 0.0 };
        let batch = &mut self.batch;
        let mut end = batch.len;
        for &[i, j] in candidates {
            let (body, other) = (&bodies[i as usize], &bodies[j as usize]);
            let separation = self.pass.metric.separation(body.position, other.position);
            let (squared, reach) = (separation.length_squared(), body.radius + other.radius);
            // Never beyond; so the compiler knows as well.
            let lane = end % LANES;
            batch.entries[0][lane] = i;
            batch.entries[1][lane] = j;
            batch.separation.set(lane, separation);
            batch.squared[lane] = squared;
            batch.reach[lane] = reach;
            let farthest = reach + margin;
            // Written so that a NaN does not touch: the finite-value check names it at the end of the step.
            end += usize::from(squared < farthest * farthest);
        }
        batch.len = end;
        end > LANES - PIECE
    }

    /// Gives coincident centres a normal: a separation so near to nothing that the overlap stays what it is.
    #[cold]
    fn part_coincident(&mut self) {
        for lane in 0..self.batch.len {
            if self.batch.squared[lane] > 0.0 {
                continue;
            }
            let [i, j] = self.batch.entries.map(|entries| entries[lane] as usize);
            let separation = coincident::<V>(self.view.id[i], self.view.id[j]) * 1e-150;
            self.batch.separation.set(lane, separation);
            self.batch.squared[lane] = separation.length_squared();
        }
    }

    /// Fills in what the law needs to know of the contacts besides separations.
    #[inline]
    fn describe_all(&mut self) {
        let squared = &self.batch.squared[..self.batch.len];
        if squared.iter().any(|&squared| squared <= 0.0) {
            self.part_coincident();
        }
        for lane in 0..self.batch.len.min(LANES) {
            self.describe(lane);
        }
    }

    #[inline]
    fn describe(&mut self, lane: usize) {
        let (batch, view) = (&mut self.batch, self.view);
        let [i, j] = [batch.entries[0][lane] as usize, batch.entries[1][lane] as usize];
        batch.relative_velocity.set(lane, view.velocity[i] - view.velocity[j]);
        for (side, entry) in [i, j].into_iter().enumerate() {
            let make = &view.make[entry];
            batch.inverse_masses[side][lane] = make.inverse_mass;
            if L::RADII {
                batch.radii[side][lane] = make.radius;
            }
            if L::SPECIES {
                batch.species[side][lane] = view.species[entry];
            }
            if L::SPIN {
                batch.spins[side].set(lane, view.spin[entry]);
            }
            if L::AHEAD {
                batch.ahead.lone[side][lane] = view.gain[entry].lone;
                if L::SPIN {
                    batch.ahead.spins[side].set(lane, view.spin_gain[entry].spin);
                    batch.ahead.inverse_inertias[side][lane] = view.spin_gain[entry].inverse_inertia;
                }
            }
        }
        if L::AHEAD {
            batch.ahead.velocity.set(lane, view.gain[i].velocity - view.gain[j].velocity);
        }
    }

    /// Asks the law, and takes records of overlap into account.
    #[inline]
    fn ask(&mut self) {
        // What may be a record is found by the smallest radius of all, a rounding off included; only then is divided.
        let nearly = self.largest * self.view.smallest_radius * (1.0 - 4.0 * f64::EPSILON);
        let Pass { law, dt, instructions, .. } = self.pass;
        if self.batch.ask(*law, *dt, *instructions, nearly) {
            for lane in 0..self.batch.len {
                let [a, b] = self.batch.entries.map(|entries| self.view.make[entries[lane] as usize].radius);
                let ratio = self.batch.answer.overlap[lane] / a.min(b);
                self.largest = self.largest.max(ratio);
            }
        }
    }

    /// Sums what the batch does to the particles of this share, the first ones being in others.
    fn flush_incoming(&mut self) {
        for lane in 0..if L::MEMORY { self.batch.len } else { 0 } {
            let (i, j) = (self.batch.entries[0][lane] as usize, self.batch.entries[1][lane]);
            let memory = self.share.before[i / BLOCK].look_up(i % BLOCK, j).unwrap_or_default();
            self.batch.memory.set::<L>(lane, &memory);
        }
        self.describe_all();
        self.ask();
        for lane in 0..self.batch.len.min(LANES) {
            if !L::AHEAD || self.batch.answer.touches[lane] > 0.0 {
                self.add_to_second(lane, self.batch.entries[1][lane] as usize - self.share.task.rows.start);
            }
        }
        self.batch.len = 0;
    }

    /// Sums what the batch does to both members, and keeps the books.
    fn flush(&mut self, block: &mut Block<'_, V>) {
        let forgotten = &mut block.forgotten;
        for lane in 0..self.batch.len.min(LANES) {
            if L::MEMORY {
                let (i, j) = (self.batch.entries[0][lane] as usize, self.batch.entries[1][lane]);
                let (row, first) = (i - block.first, block.first);
                let memory = block.recall.of::<L>(row, j, |row, partner, memory| {
                    self.pass.forget(self.view, first + row, partner, memory, forgotten);
                });
                block.remembered[lane] = memory.is_some();
                self.batch.memory.set::<L>(lane, &memory.unwrap_or_default());
            }
        }
        self.describe_all();
        self.ask();
        for lane in 0..self.batch.len.min(LANES) {
            self.add(block, lane);
        }
        self.batch.len = 0;
    }

    #[inline]
    fn add(&mut self, block: &mut Block<'_, V>, lane: usize) {
        let [i, j] = [self.batch.entries[0][lane] as usize, self.batch.entries[1][lane] as usize];
        let pages = &mut self.share.now[block.number];
        if L::AHEAD && self.batch.answer.touches[lane] <= 0.0 {
            if L::MEMORY && block.remembered[lane] {
                // It has ended, and its memory been moved on all the same: what it held before is lost.
                let partner = self.batch.entries[1][lane];
                let memory = self.share.before[i / BLOCK].look_up(i % BLOCK, partner).unwrap_or_default();
                self.pass.forget(self.view, i, partner, &memory, &mut block.lost);
            }
            return;
        }
        if L::MEMORY {
            let memory = self.batch.memory.get::<L>(lane);
            pages.push::<L>(i - block.first, self.batch.entries[1][lane], &memory);
        }
        let answer = &self.batch.answer;
        let first = i - self.share.task.rows.start;
        if L::SPIN {
            let more = [answer.lost[0][lane], if L::ROLLING { answer.lost[1][lane] } else { 0.0 }];
            sums::add(&mut block.lost, more);
            self.share.turns[first].add(answer, lane, 0);
            if L::ROLLING {
                self.share.rolling[first] += answer.rolling_drag_torque.get(lane);
            }
        }
        if L::AHEAD {
            self.share.contacts[first] += 1;
        }
        let load = &mut self.share.loads[first];
        load.force += answer.force.get(lane);
        load.drag += answer.drag.get(lane);
        if j < self.share.task.rows.end {
            self.add_to_second(lane, j - self.share.task.rows.start);
        }
    }

    #[inline]
    fn add_to_second(&mut self, lane: usize, second: usize) {
        let answer = &self.batch.answer;
        let load = &mut self.share.loads[second];
        load.force -= answer.force.get(lane);
        load.drag -= answer.drag.get(lane);
        if L::SPIN {
            self.share.turns[second].add(answer, lane, 1);
            if L::ROLLING {
                self.share.rolling[second] -= answer.rolling_drag_torque.get(lane);
            }
        }
        if L::AHEAD {
            self.share.contacts[second] += 1;
        }
    }

    /// Ends a block: what its contacts of the pass before have left is forgotten.
    fn end(&mut self, block: &mut Block<'_, V>) {
        let pages = &mut self.share.now[block.number];
        if L::MEMORY {
            let (first, forgotten) = (block.first, &mut block.forgotten);
            block.recall.finish::<L>(BLOCK, |row, partner, memory| {
                self.pass.forget(self.view, first + row, partner, memory, forgotten);
            });
            pages.end_rows(BLOCK);
        }
        pages.lost = block.lost;
        sums::add(&mut pages.lost, block.forgotten);
    }
}

/// The rows that are being summed.
struct Block<'a, V: Space> {
    /// Among those of the share.
    number: usize,
    /// Its first row.
    first: usize,
    recall: Recall<'a, V>,
    /// Which lanes are contacts of the pass before.
    remembered: [bool; LANES],
    /// What contacts lose, and what ended ones held, J: each in order, whenever the batch is full.
    lost: [f64; 2],
    forgotten: [f64; 2],
}
