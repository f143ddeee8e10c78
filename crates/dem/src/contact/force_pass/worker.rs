//! The work of one thread in the contact pass.

use std::marker::PhantomData;

use crate::contact::batch::{Batch, Call, EventStep, Predict, Velocities};
use crate::contact::force_accumulation::ForceAccumulation;
use crate::contact::force_pass::exchange::Exchange;
use crate::contact::force_pass::input::ForcePass;
use crate::contact::geometry::coincident;
use crate::contact::held_forces::HeldForces;
use crate::contact::history::losses::{ContactLosses, EndLosses};
use crate::contact::history::{HistoryBlock, HistoryCursor};
use crate::contact::law::LawRequirements;
use crate::contact::memory::{Memory, MemoryLayout};
use crate::contact::pair::MemoryTimes;
use crate::lanes::LANES;
use crate::neighbours::list::{BLOCK, Candidate, Task};
use crate::space::Space;
use crate::store::{ParticleStore, TOTAL, TOTAL_AND_DISSIPATIVE};
use crate::walls::surface_wall::WallLoad;

/// The data that one thread reads and writes. `C` is the class of the law.
pub(super) struct Worker<'a, V: Space, C> {
    pub(super) pass: &'a ForcePass<'a, V>,
    pub(super) view: &'a ParticleStore<V>,
    pub(super) sums: ForceAccumulation<'a, V>,
    pub(super) batch: &'a mut Batch<V>,
    /// Forces on particles of earlier tasks.
    outgoing: &'a mut HeldForces<V>,
    /// Forces of walls on own particles, while these wait for forces of later tasks.
    pub(super) of_walls: Option<&'a mut HeldForces<V>>,
    pub(super) largest: f64,
    /// Pairs of an own row and a wall that may touch and are not yet summed.
    pub(super) near: &'a [Candidate],
    /// Loads of contacts with walls, summed over consecutive contacts with one wall, each with the index of the wall.
    pub(super) on_walls: &'a mut Vec<(usize, WallLoad<V>)>,
    /// Whether the law reads the root of the reduced mass.
    pub(super) mass_root: bool,
    /// [`PairLaw::overlap_without_events`](crate::contact::law::PairLaw::overlap_without_events) times half a step, s.
    event_time: f64,
    class: PhantomData<fn() -> C>,
}

/// The contact history of one task.
pub(super) struct OwnHistories<'a> {
    /// The blocks of contacts between particles.
    pub(super) pairs: &'a mut [HistoryBlock],
    /// The blocks of contacts with walls.
    pub(super) walls: &'a mut [HistoryBlock],
    /// A block for those that are rewritten.
    pub(super) spare: &'a mut HistoryBlock,
}

/// The data that one thread writes besides.
pub(super) struct OwnOutput<'a, V: Space> {
    pub(super) sums: ForceAccumulation<'a, V>,
    pub(super) batch: &'a mut Batch<V>,
    pub(super) outgoing: &'a mut HeldForces<V>,
    pub(super) of_walls: &'a mut HeldForces<V>,
    pub(super) on_walls: &'a mut Vec<(usize, WallLoad<V>)>,
}

impl<'a, V: Space, C: LawRequirements> Worker<'a, V, C> {
    /// `near` has the pairs of an own row and a wall that may touch. `largest` is the largest overlap so far by the smaller radius of its pair.
    pub(super) fn new(
        pass: &'a ForcePass<'a, V>,
        view: &'a ParticleStore<V>,
        near: &'a [Candidate],
        OwnOutput { sums, batch, outgoing, of_walls, on_walls }: OwnOutput<'a, V>,
        largest: f64,
    ) -> Self {
        outgoing.clear();
        of_walls.clear();
        on_walls.clear();
        let event_time = pass.law.overlap_without_events() * view.prediction.velocities_ahead;
        let mass_root = pass.law.needs_mass_root();
        let of_walls = Some(of_walls);
        let class = PhantomData;
        Self { pass, view, sums, batch, outgoing, of_walls, largest, near, on_walls, mass_root, event_time, class }
    }

    /// Returns the layout of the memories.
    pub(super) fn layout(&self) -> &'a MemoryLayout {
        self.pass.needs.memory.as_ref().unwrap_or(&MemoryLayout::NONE)
    }

    /// Evaluates the pairs of own rows and sums the forces on them, with the given history blocks. Returns the largest overlap so far divided
    /// by the smaller radius of its pair.
    pub(super) fn sum(mut self, histories: OwnHistories<'_>, exchange: &Exchange<'_, V>) -> f64 {
        let Task { rows, reaching_end, .. } = exchange.task();
        let OwnHistories { pairs, walls, spare } = histories;
        let blocks = || rows.clone().step_by(BLOCK);
        for (history, first) in pairs.iter_mut().zip(blocks()) {
            if first >= *reaching_end {
                exchange.post(self.outgoing);
            }
            // Sums are initialised block by block, so that they are still in the cache when forces are added.
            self.sums.initialise(first + BLOCK, self.pass.gravity, self.view);
            let (candidates, lowest) = self.pass.list.block(first / BLOCK);
            let foreign_end = if lowest < rows.start { rows.start } else { 0 };
            self.sum_pairs(candidates, Block::new(history, spare, self.layout()), foreign_end);
        }
        exchange.post(self.outgoing);
        // The forces of walls come last. They are held if those of later tasks are not there yet.
        if self.of_walls.take_if(|_| exchange.is_complete()).is_some() {
            self.take_over(exchange);
        }
        if !self.pass.walls.is_empty() {
            for (history, first) in walls.iter_mut().zip(blocks()) {
                self.sum_walls(first + BLOCK, Block::new(history, spare, self.layout()));
            }
        }
        if let Some(of_walls) = self.of_walls.take() {
            self.take_over(exchange);
            self.add_held(of_walls, Candidate::row);
        }
        self.largest
    }

    /// Adds the forces of later tasks on own particles. Waits for them.
    fn take_over(&mut self, exchange: &Exchange<'_, V>) {
        for outgoing in exchange.incoming() {
            self.add_held(outgoing, Candidate::partner);
        }
    }

    fn add_held(&mut self, held: &HeldForces<V>, slot: impl Fn(Candidate) -> usize) {
        if self.view.tracks_energy {
            self.sums.add_held::<C, TOTAL_AND_DISSIPATIVE>(held, slot);
        } else {
            self.sums.add_held::<C, TOTAL>(held, slot);
        }
    }

    /// Sums the contacts between particles of a block of rows. Particles in slots before `foreign_end` belong to earlier tasks; 0 if the block
    /// has none.
    fn sum_pairs(&mut self, mut candidates: &[Candidate], mut block: Block<'_>, foreign_end: usize) {
        while !candidates.is_empty() {
            candidates = self.fill_batch(candidates);
            self.flush(&mut block, foreign_end);
        }
        block.end(|contact, memory| self.pass.on_contact_end(self.view, contact, memory));
    }

    /// Adds candidates to the batch until it is full. Returns the candidates that are left.
    fn fill_batch<'c>(&mut self, candidates: &'c [Candidate]) -> &'c [Candidate] {
        self.batch.select(self.view, candidates, self.pass.needs, self.pass.instructions)
    }

    /// Whether springs advance with velocities of their own.
    #[inline]
    pub(super) fn gathers(&self) -> bool {
        self.pass.needs.memory.is_some() && self.view.prediction.springs_exact
    }

    /// Takes the marks of the pairs of the batch. With memory this comes before the history is read, which needs pairs without marks.
    /// Without memory it comes later, because a vector load waits for numbers that the filter has just written one by one.
    #[inline]
    fn take_marks(&mut self) {
        if self.view.predicts() {
            self.batch.take_marks(self.pass.needs.memory.is_some(), self.pass.instructions);
        }
    }

    /// Loads the data that the law requires besides bodies: species and spins.
    #[inline]
    fn load_requirements(&mut self) {
        let needs_species = self.pass.needs.species;
        let gathers = self.gathers();
        if !(needs_species || C::SPIN || gathers) {
            return;
        }
        let batch = &mut *self.batch;
        let view = self.view;
        // Copied to locals so that the compiler can prove that stores do not alias them.
        let rotations = &view.rotation[..];
        let species = &view.species[..];
        self.pass.instructions.run_narrow(
            #[inline(always)]
            || {
                let lanes = batch.len.min(LANES);
                for lane in 0..if needs_species { lanes } else { 0 } {
                    for (side, entry) in batch.pairs[lane].slots().into_iter().enumerate() {
                        batch.species[side][lane] = species[entry];
                    }
                }
                for lane in 0..if C::SPIN { lanes } else { 0 } {
                    batch.spins.take(lane, batch.pairs[lane].slots().map(|entry| &rotations[entry]));
                }
                for lane in 0..if gathers { lanes } else { 0 } {
                    batch.gathered.set(lane, view.gathered(batch.pairs[lane]));
                }
            },
        );
    }

    /// Evaluates the law for the batch and updates the largest overlap.
    #[inline]
    fn evaluate_batch(&mut self) {
        self.load_requirements();
        let lanes = self.batch.lanes();
        if self.batch.bodies.measure(lanes, self.pass.needs.bodies, self.mass_root, self.pass.instructions) {
            let id = &self.view.id;
            let pairs = &self.batch.pairs;
            let normal = |lane: usize| coincident(id[pairs[lane].partner()], id[pairs[lane].row()]);
            self.batch.bodies.part_coincident(self.batch.len, normal);
        }
        if self.pass.needs.memory.is_none() {
            self.take_marks();
        }
        // A possible record is detected without division and without the two radii.
        if self.evaluate_law(self.view.smallest_share, &ParticleStore::predict_pair) {
            for (pair, overlap) in self.batch.pairs.iter().zip(self.batch.bodies.overlap.iter()).take(self.batch.len) {
                let [i, j] = pair.slots().map(|entry| self.view.body[entry].radius);
                self.largest = self.largest.max(overlap / i.min(j));
            }
        }
    }

    /// Evaluates the law in all lanes. Returns whether any overlap may be a record. `smallest_share` is a lower bound
    /// on the smaller radius of a pair divided by the sum of its radii.
    #[inline]
    pub(super) fn evaluate_law(&mut self, smallest_share: f64, predict: Predict<'_, V>) -> bool {
        let ForcePass { law, needs, dt, starts, instructions, .. } = *self.pass;
        let view = self.view;
        // The last factor allows for rounding.
        let deepest = self.largest * smallest_share * (1.0 - 8.0 * f64::EPSILON);
        let times = MemoryTimes { dt, springs_ahead: view.springs_ahead() };
        let velocities = match (view.predicts(), view.prediction.springs_exact) {
            (false, _) => Velocities::Middle,
            (true, false) => Velocities::Predicted,
            (true, true) => Velocities::PredictedAndMiddle,
        };
        let call = Call { velocities, times, instructions, deepest, event_time: self.event_time };
        let evaluated = law.evaluate(self.batch, &call, view.tracks_energy);
        self.batch.output.clear_gaps();
        if needs.reaches {
            self.batch.mark_gaps();
        }
        // Without velocity prediction no contact is near an event.
        let near = std::mem::take(&mut self.batch.lone) | evaluated.near_events & !(u64::MAX << self.batch.len);
        if near != 0 {
            let step = EventStep { store: view, predict, starts, instructions };
            law.evaluate_events(self.batch, times, &step, near);
        }
        evaluated.deeper > 0
    }

    /// Evaluates the batch, adds its forces to both particles, and stores memories and losses. Forces on particles in slots before
    /// `foreign_end` go to their tasks.
    fn flush(&mut self, block: &mut Block<'_>, foreign_end: usize) {
        if self.pass.needs.memory.is_some() {
            self.take_marks();
            let Block { cursor, lost, .. } = block;
            recall(self.batch, cursor, |contact, memory| {
                lost.add(self.pass.on_contact_end(self.view, contact, memory));
            });
        }
        self.evaluate_batch();
        block.touching += self.batch.touching();
        self.store_results(block, |contact, memory| self.pass.on_contact_end(self.view, contact, memory));
        let tracks_energy = self.view.tracks_energy;
        let sums = &mut self.sums;
        let batch = &*self.batch;
        self.pass.instructions.run_narrow(
            #[inline(always)]
            || {
                if tracks_energy {
                    sums.add_to_both::<C, TOTAL_AND_DISSIPATIVE>(batch);
                } else {
                    sums.add_to_both::<C, TOTAL>(batch);
                }
            },
        );
        let counts = self.pass.counts;
        if counts {
            self.sums.count::<true>(batch);
        }
        let is_foreign = |pair: Candidate| pair.partner() < foreign_end;
        match (foreign_end, tracks_energy) {
            (0, _) => {}
            (_, true) => self.outgoing.extend::<C, TOTAL_AND_DISSIPATIVE>(batch, counts, is_foreign),
            (_, false) => self.outgoing.extend::<C, TOTAL>(batch, counts, is_foreign),
        }
        self.batch.len = 0;
    }

    /// Stores losses and memories of the batch. `on_end` returns the energy that a contact loses when it ends, J.
    #[inline]
    pub(super) fn store_results(
        &mut self,
        Block { cursor, lost, .. }: &mut Block<'_>,
        on_end: impl Fn(Candidate, &Memory) -> EndLosses,
    ) {
        let batch = &mut *self.batch;
        if C::SPIN && self.view.tracks_energy {
            *lost += batch.lost::<C>();
        }
        let Some(layout) = &self.pass.needs.memory else { return };
        let contacts = &batch.pairs[..batch.len.min(LANES)];
        cursor.remember_all(contacts, &batch.memory_after);
        if self.view.tracks_energy {
            for lane in batch.output.gaps() {
                lost.add(on_end(contacts[lane], &batch.memory.memory(layout, lane)));
            }
        }
    }
}

/// The contact history of a block of rows in this pass.
pub(super) struct Block<'a> {
    pub(super) cursor: HistoryCursor<'a>,
    /// Losses of contacts, including the energy stored in ended ones. Both are added in a fixed order, independent of
    /// how contacts are batched.
    pub(super) lost: ContactLosses,
    /// Number of contacts so far, without gaps.
    pub(super) touching: u32,
}

impl<'a> Block<'a> {
    pub(super) fn new(history: &'a mut HistoryBlock, spare: &'a mut HistoryBlock, layout: &'a MemoryLayout) -> Self {
        Self { cursor: HistoryCursor::new(history, spare, layout), lost: ContactLosses::default(), touching: 0 }
    }

    /// Ends the block. `on_end` returns the energy that an ended contact loses, J.
    pub(super) fn end(mut self, on_end: impl FnMut(Candidate, &Memory) -> EndLosses) {
        self.cursor.end(self.lost, on_end);
        self.cursor.set_touching(self.touching);
    }
}

/// Loads the memories of all contacts of a batch. Contacts that have ended are passed to `on_end` with their memories.
#[inline]
pub(super) fn recall<V: Space>(
    batch: &mut Batch<V>,
    cursor: &mut HistoryCursor<'_>,
    mut on_end: impl FnMut(Candidate, &Memory),
) {
    let contacts = &batch.pairs[..batch.len.min(LANES)];
    if cursor.recall_all(contacts, &mut batch.memory) {
        return;
    }
    for (lane, &contact) in contacts.iter().enumerate() {
        cursor.recall(contact, lane, &mut batch.memory, &mut on_end);
    }
}
