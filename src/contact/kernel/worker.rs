//! One thread at work: candidates in, sums out.

use crate::contact::batch::Batch;
use crate::contact::force_accumulation::ForceAccumulation;
use crate::contact::geometry::coincident;
use crate::contact::history::{ContactLosses, HistoryBlock, HistoryCursor};
use crate::contact::kernel::{HaloImport, Pass};
use crate::contact::lanes::LANES;
use crate::contact::{LawRequirements, Memory, PairLaw};
use crate::neighbours::list::BLOCK;
use crate::neighbours::list::{self, Candidate, Task};
use crate::periodic::{Metric, Open};
use crate::space::Space;
use crate::store::{ParticleStore, TOTAL, TOTAL_AND_DISSIPATIVE};
use crate::walls::surfaces::WallLoad;

/// What one thread reads and writes.
pub(super) struct Worker<'a, V: Space, L> {
    pub(super) pass: &'a Pass<'a, V, L>,
    pub(super) view: &'a ParticleStore<V>,
    pub(super) task: &'a Task,
    pub(super) halo: HaloImport<'a, V>,
    pub(super) sums: ForceAccumulation<'a, V>,
    pub(super) batch: &'a mut Batch<V>,
    pub(super) largest: f64,
    /// Its particles and walls that may touch.
    pub(super) near: &'a [Candidate],
    /// What walls get of each block.
    pub(super) on_walls: &'a mut Vec<WallLoad<V>>,
}

impl<V: Space, L: PairLaw<V> + LawRequirements> Worker<'_, V, L> {
    /// Sums its rows, whose contacts stand in these pages; gives the largest overlap over the smaller radius.
    pub(super) fn sum(
        mut self,
        pages: &mut [HistoryBlock<V>],
        wall_pages: &mut [HistoryBlock<V>],
        spare: &mut HistoryBlock<V>,
    ) -> f64 {
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
            let mut block = Block { cursor: HistoryCursor::new(page, spare), lost: ContactLosses::default() };
            let (mut left, end) = self.pass.list.block(first / BLOCK);
            // Not all at once: so they are at hand when they are added to.
            self.sums.begin(end, gravity, self.view);
            at_hand = self.fetch(at_hand, first + BLOCK);
            while !left.is_empty() {
                left = self.offer(left);
                self.flush(&mut block);
            }
            block.cursor.end::<L>(block.lost, |contact, memory| self.pass.on_contact_end(self.view, contact, memory));
            if !self.pass.walls.is_empty() {
                self.sums.begin(first + BLOCK, gravity, self.view);
                self.sum_walls(
                    first + BLOCK,
                    Block { cursor: HistoryCursor::new(wall_page, spare), lost: ContactLosses::default() },
                );
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
        let margin = if L::PREDICTION { self.view.margin } else { 0.0 };
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
                    let farthest = if L::PREDICTION { reach + margin } else { reach };
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
        if !(L::SPECIES || L::SPIN || L::PREDICTION) {
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
                    if L::PREDICTION {
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
        if self.batch.bodies.measure::<L>(lanes, law.needs_mass_root(), instructions) {
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
        if self.view.tracks_energy {
            self.batch.ask::<L, TOTAL_AND_DISSIPATIVE>(law, dt, instructions, deepest)
        } else {
            self.batch.ask::<L, TOTAL>(law, dt, instructions, deepest)
        }
    }

    /// Sums what the batch does to the particles of this share, the first ones being in others.
    fn flush_incoming(&mut self) {
        for lane in 0..if L::MEMORY { self.batch.len } else { 0 } {
            let memory = self.halo.next(self.batch.pairs[lane]).unwrap_or_default();
            self.batch.memory.set::<L>(lane, &memory);
        }
        self.ask();
        if self.view.tracks_energy {
            self.sums.add_to_one::<L, TOTAL_AND_DISSIPATIVE, 1>(self.batch);
        } else {
            self.sums.add_to_one::<L, TOTAL, 1>(self.batch);
        }
        self.batch.len = 0;
    }

    /// Sums what the batch does to both members, and keeps the books.
    fn flush(&mut self, block: &mut Block<'_, V>) {
        if L::MEMORY {
            let Block { cursor, lost } = block;
            self.batch
                .recall::<L>(cursor, |contact, memory| lost.add(self.pass.on_contact_end(self.view, contact, memory)));
        }
        self.ask();
        self.keep(block, |contact, memory| self.pass.on_contact_end(self.view, contact, memory));
        let tracks_energy = self.view.tracks_energy;
        let (sums, batch) = (&mut self.sums, &*self.batch);
        self.pass.instructions.run_narrow(
            #[inline(always)]
            || {
                if tracks_energy {
                    sums.add_to_both::<L, TOTAL_AND_DISSIPATIVE>(batch)
                } else {
                    sums.add_to_both::<L, TOTAL>(batch)
                }
            },
        );
        self.batch.len = 0;
    }

    /// Keeps what contacts have lost and what they remember; `forgotten` tells what goes with one that has ended, J.
    #[inline]
    pub(super) fn keep(
        &mut self,
        Block { cursor, lost }: &mut Block<'_, V>,
        forgotten: impl Fn(Candidate, &Memory<V>) -> [f64; 2],
    ) {
        let batch = &mut *self.batch;
        if L::SPIN && self.view.tracks_energy {
            *lost += batch.lost::<L>();
        }
        if !L::MEMORY {
            return;
        }
        let contacts = &batch.pairs[..batch.len.min(LANES)];
        if !L::PREDICTION || (0..contacts.len()).all(|lane| batch.answer.counts::<L>(lane)) {
            cursor.remember_all::<L>(contacts, &batch.memory);
            return;
        }
        cursor.part::<L>(contacts);
        for (lane, &contact) in contacts.iter().enumerate() {
            if batch.answer.counts::<L>(lane) {
                cursor.remember::<L>(contact, &batch.memory.get::<L>(lane));
            } else if batch.is_known[lane] {
                // It has ended, and its memory been moved on all the same: what it held before is lost.
                lost.add(forgotten(contact, &cursor.before(contact).unwrap_or_default()));
            }
        }
    }
}

/// What the contacts of a block of rows remember.
pub(super) struct Block<'a, V: Space> {
    pub(super) cursor: HistoryCursor<'a, V>,
    /// What contacts lose, and what ended ones held: each in order, whenever the batch is full.
    pub(super) lost: ContactLosses,
}
