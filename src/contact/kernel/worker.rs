//! One thread at work: candidates in, sums out.

use crate::columns::{BOOKED, Columns, WHOLE};
use crate::contact::batch::Batch;
use crate::contact::geometry::coincident;
use crate::contact::history::{Lost, Pages, Walk};
use crate::contact::kernel::{Arrivals, Pass};
use crate::contact::lanes::LANES;
use crate::contact::sums::Sums;
use crate::contact::{Demands, Memory, PairLaw};
use crate::neighbours::list::BLOCK;
use crate::neighbours::list::{self, Candidate, Task};
use crate::periodic::{Metric, Open};
use crate::space::Space;
use crate::walls::surfaces::WallLoad;

/// What one thread reads and writes.
pub(super) struct Worker<'a, V: Space, L> {
    pub(super) pass: &'a Pass<'a, V, L>,
    pub(super) view: &'a Columns<V>,
    pub(super) task: &'a Task,
    pub(super) arrivals: Arrivals<'a, V>,
    pub(super) sums: Sums<'a, V>,
    pub(super) batch: &'a mut Batch<V>,
    pub(super) largest: f64,
    /// Its particles and walls that may touch.
    pub(super) near: &'a [Candidate],
    /// What walls get of each block.
    pub(super) on_walls: &'a mut Vec<WallLoad<V>>,
}

impl<V: Space, L: PairLaw<V> + Demands> Worker<'_, V, L> {
    /// Sums its rows, whose contacts stand in these pages; gives the largest overlap over the smaller radius.
    pub(super) fn sum(mut self, pages: &mut [Pages<V>], wall_pages: &mut [Pages<V>], spare: &mut Pages<V>) -> f64 {
        let gravity = self.pass.gravity;
        self.sums.begin(list::end_of(&self.task.incoming), gravity, self.view);
        let mut left = &self.task.incoming[..];
        while !left.is_empty() {
            left = self.offer(left);
            self.flush_incoming();
        }
        let mut at_hand = self.task.rows.start;
        let blocks = pages.iter_mut().zip(wall_pages).zip(self.task.rows.clone().step_by(BLOCK));
        for ((page, wall_page), first) in blocks {
            let mut block = Block { walk: Walk::new(page, spare), lost: Lost::default() };
            let (mut left, end) = self.pass.list.block(first / BLOCK);
            // Not all at once: so they are at hand when they are added to.
            self.sums.begin(end, gravity, self.view);
            at_hand = self.fetch(at_hand, first + BLOCK);
            while !left.is_empty() {
                left = self.offer(left);
                self.flush(&mut block);
            }
            block.walk.end::<L>(block.lost, |contact, memory| self.pass.forget(self.view, contact, memory));
            if !self.pass.walls.is_empty() {
                self.sums.begin(first + BLOCK, gravity, self.view);
                self.sum_walls(first + BLOCK, Block { walk: Walk::new(wall_page, spare), lost: Lost::default() });
            }
        }
        self.sums.begin(self.task.rows.end, gravity, self.view);
        self.largest
    }

    /// Adds those candidates to the batch that overlap, or that the law looks at ahead of that, with what their bodies hold, until
    /// it is full; gives those that are left. Whether one overlaps is hard to foresee, so there is no branch on it: each is
    /// written, and the end moves on if it counts.
    fn offer<'c>(&mut self, candidates: &'c [Candidate]) -> &'c [Candidate] {
        match self.view.periodic {
            None => self.offer_by(Open, candidates),
            Some(periodic) => self.offer_by(periodic, candidates),
        }
    }

    /// The same, with separations measured so.
    #[inline(always)]
    fn offer_by<'c>(&mut self, metric: impl Metric<V>, candidates: &'c [Candidate]) -> &'c [Candidate] {
        let (bodies, batch, pass) = (&self.view.body[..], &mut *self.batch, self.pass);
        let margin = if L::AHEAD { self.view.margin } else { 0.0 };
        pass.instructions.run_narrow(
            #[inline(always)]
            || {
                let (mut end, mut left) = (batch.len, candidates.iter());
                while end < LANES
                    && let Some(&candidate) = left.next()
                {
                    let [body, other] = candidate.both().map(|entry| &bodies[entry]);
                    batch.pairs[end] = candidate;
                    let (squared, reach) = batch.bodies.take::<L>(end, &metric, [body, other]);
                    let farthest = if L::AHEAD { reach + margin } else { reach };
                    // Written so that a NaN does not touch: the finite-value check names it at the end of the step.
                    end += usize::from(squared < farthest * farthest);
                }
                batch.len = end;
                left.as_slice()
            },
        )
    }

    /// Fills in what the law needs to know besides what bodies hold.
    #[inline]
    fn describe(&mut self) {
        if !(L::SPECIES || L::SPIN || L::AHEAD) {
            return;
        }
        let (batch, view) = (&mut *self.batch, self.view);
        // What is of its own cannot change under the loop.
        let (rotations, species) = (&view.rotation[..], &view.species[..]);
        self.pass.instructions.run_narrow(
            #[inline(always)]
            || {
                for lane in 0..batch.len.min(LANES) {
                    let pair = batch.pairs[lane].both();
                    if L::SPECIES {
                        for (side, entry) in pair.into_iter().enumerate() {
                            batch.species[side][lane] = species[entry];
                        }
                    }
                    if L::SPIN {
                        batch.spins.take(lane, pair.map(|entry| &rotations[entry]));
                    }
                    if L::AHEAD {
                        batch.ahead.describe::<L>(lane, pair, view);
                    }
                }
            },
        );
    }

    /// Asks the law, and takes records of overlap into account.
    #[inline]
    fn ask(&mut self) {
        self.describe();
        let Pass { law, instructions, .. } = *self.pass;
        let lanes = self.batch.lanes();
        if self.batch.bodies.measure::<L>(lanes, law.takes_root(), instructions) {
            let (id, pairs) = (&self.view.id, &self.batch.pairs);
            let normal = |lane: usize| coincident(id[pairs[lane].first()], id[pairs[lane].second()]);
            self.batch.bodies.part_coincident::<L>(self.batch.len, normal);
        }
        // What may be a record is found without dividing, and without the two radii.
        if self.answer(self.view.smallest_share) {
            for (pair, overlap) in self.batch.pairs.iter().zip(self.batch.bodies.overlap.iter()).take(self.batch.len) {
                let [i, j] = pair.both().map(|entry| self.view.body[entry].radius);
                self.largest = self.largest.max(overlap / i.min(j));
            }
        }
    }

    /// Lets the law answer for all lanes; tells whether any overlap may be a record, the smaller radius of a pair being this share of the reach or
    /// more.
    #[inline]
    pub(super) fn answer(&mut self, smallest_share: f64) -> bool {
        let Pass { law, dt, instructions, .. } = *self.pass;
        // Some rounding included.
        let deepest = self.largest * smallest_share * (1.0 - 8.0 * f64::EPSILON);
        if self.view.has_books {
            self.batch.ask::<L, BOOKED>(law, dt, instructions, deepest)
        } else {
            self.batch.ask::<L, WHOLE>(law, dt, instructions, deepest)
        }
    }

    /// Sums what the batch does to the particles of this share, the first ones being in others.
    fn flush_incoming(&mut self) {
        for lane in 0..if L::MEMORY { self.batch.len } else { 0 } {
            let memory = self.arrivals.next(self.batch.pairs[lane]).unwrap_or_default();
            self.batch.memory.set::<L>(lane, &memory);
        }
        self.ask();
        if self.view.has_books {
            self.sums.add_to_one::<L, BOOKED, 1>(self.batch);
        } else {
            self.sums.add_to_one::<L, WHOLE, 1>(self.batch);
        }
        self.batch.len = 0;
    }

    /// Sums what the batch does to both members, and keeps the books.
    fn flush(&mut self, block: &mut Block<'_, V>) {
        if L::MEMORY {
            let Block { walk, lost } = block;
            self.batch.recall::<L>(walk, |contact, memory| lost.add(self.pass.forget(self.view, contact, memory)));
        }
        self.ask();
        self.keep(block, |contact, memory| self.pass.forget(self.view, contact, memory));
        let has_books = self.view.has_books;
        let (sums, batch) = (&mut self.sums, &*self.batch);
        self.pass.instructions.run_narrow(
            #[inline(always)]
            || if has_books { sums.add_to_both::<L, BOOKED>(batch) } else { sums.add_to_both::<L, WHOLE>(batch) },
        );
        self.batch.len = 0;
    }

    /// Keeps what contacts have lost and what they remember; `forgotten` tells what goes with one that has ended, J.
    #[inline]
    pub(super) fn keep(
        &mut self,
        Block { walk, lost }: &mut Block<'_, V>,
        forgotten: impl Fn(Candidate, &Memory<V>) -> [f64; 2],
    ) {
        let batch = &mut *self.batch;
        if L::SPIN && self.view.has_books {
            *lost += batch.lost::<L>();
        }
        if !L::MEMORY {
            return;
        }
        let contacts = &batch.pairs[..batch.len.min(LANES)];
        if !L::AHEAD || (0..contacts.len()).all(|lane| batch.answer.counts::<L>(lane)) {
            walk.remember_all::<L>(contacts, &batch.memory);
            return;
        }
        walk.part::<L>(contacts);
        for (lane, &contact) in contacts.iter().enumerate() {
            if batch.answer.counts::<L>(lane) {
                walk.remember::<L>(contact, &batch.memory.get::<L>(lane));
            } else if batch.is_known[lane] {
                // It has ended, and its memory been moved on all the same: what it held before is lost.
                lost.add(forgotten(contact, &walk.before(contact).unwrap_or_default()));
            }
        }
    }
}

/// What the contacts of a block of rows remember.
pub(super) struct Block<'a, V: Space> {
    pub(super) walk: Walk<'a, V>,
    /// What contacts lose, and what ended ones held: each in order, whenever the batch is full.
    pub(super) lost: Lost,
}
