//! Contacts with wall surfaces in the contact pass: block by block, in ascending order of rows, then in the scene's order
//! of walls.
//!
//! The loads on walls are summed too ([`WallLoad`]). A load is the force *on the wall*: the load on a floor under
//! gravity points down.

use crate::contact::geometry::{WallTouch, touching_wall};
use crate::contact::kernel::worker::{Block, Worker};
use crate::contact::lanes::LANES;
use crate::contact::{LawRequirements, Pair, PairLaw};
use crate::neighbours::list::Candidate;
use crate::space::Space;
use crate::store::{ParticleStore, TOTAL, TOTAL_AND_DISSIPATIVE};
use crate::walls::surfaces::{Surfaces, WallLoad};

impl<V: Space, L: PairLaw<V> + LawRequirements> Worker<'_, V, L> {
    /// Sums the contacts between walls and the rows before `end` that have not been summed yet.
    pub(super) fn sum_walls(&mut self, end: usize, mut block: Block<'_, V>) {
        let pass = self.pass;
        let count = self.near.partition_point(|contact| contact.first() < end);
        let near = self.near.split_off(..count).unwrap_or_default();
        if !near.is_empty() {
            self.on_walls.resize(self.on_walls.len() + pass.walls.len(), WallLoad::default());
        }
        let mut beside_several = Vec::new();
        for row in near.chunk_by(|a, b| a.first() == b.first()) {
            if let &[contact] = row {
                if let WallTouch::Touches(pair) = self.touch(contact, row) {
                    self.push_wall(contact, &pair, &mut block);
                }
                continue;
            }
            // Memories follow the grain over a seam before any contact of the grain is recalled.
            for &contact in row {
                match self.touch(contact, row) {
                    WallTouch::Touches(pair) => beside_several.push((contact, pair)),
                    WallTouch::ContinuedBy(other) if L::MEMORY => block.cursor.rename::<L>(contact, other),
                    WallTouch::ContinuedBy(_) | WallTouch::Apart => {}
                }
            }
            for (contact, pair) in beside_several.drain(..) {
                self.push_wall(contact, &pair, &mut block);
            }
        }
        if self.batch.len > 0 {
            self.flush_walls(&mut block);
        }
        block.cursor.end::<L>(block.lost, |contact, memory| pass.on_wall_contact_end(self.view, contact, memory));
    }

    /// Returns the contact of a grain with a wall. `row` are the pairs of the grain with walls near it.
    #[inline(always)]
    fn touch(&self, contact: Candidate, row: &[Candidate]) -> WallTouch<V> {
        let [i, wall] = contact.both();
        let near = row.iter().map(|contact| contact.second());
        let limits = (self.pass.law.needs_mass_root(), self.view.prediction.lookahead);
        touching_wall(self.view, i, (self.pass.walls, wall), near, limits)
    }

    /// Adds a contact to the batch, and evaluates the batch if it is full.
    #[inline(always)]
    fn push_wall(&mut self, contact: Candidate, pair: &Pair<V>, block: &mut Block<'_, V>) {
        let view = self.view;
        if view.predicts() {
            self.batch.lone |= u64::from(view.prediction.lone[contact.first()]) << self.batch.len;
        }
        self.batch.push::<L>(contact, pair);
        if self.batch.len == LANES {
            self.flush_walls(block);
        }
    }

    /// Evaluates the batch, adds its forces to grains and walls, and stores memories and losses.
    fn flush_walls(&mut self, block: &mut Block<'_, V>) {
        let (pass, view) = (self.pass, self.view);
        if L::MEMORY {
            let Block { cursor, lost } = block;
            self.batch.recall::<L>(cursor, |contact, memory| lost.add(pass.on_wall_contact_end(view, contact, memory)));
        }
        // For a wall contact the reach is the radius of the grain, so the share is 1.
        if self.evaluate_law(1.0, ParticleStore::predict_with_wall) {
            for lane in 0..self.batch.len {
                self.largest = self.largest.max(self.batch.bodies.overlap[lane] / self.batch.bodies.reach[lane]);
            }
        }
        self.store_results(block, |contact, memory| pass.on_wall_contact_end(view, contact, memory));
        if view.tracks_energy {
            self.add_to_walls::<TOTAL_AND_DISSIPATIVE>();
        } else {
            self.add_to_walls::<TOTAL>();
        }
        self.batch.len = 0;
    }

    /// Adds the forces of the batch to grains and walls; `NUMBERS` per accumulator entry.
    fn add_to_walls<const NUMBERS: usize>(&mut self) {
        let Self { sums, batch, on_walls, pass, view, .. } = self;
        sums.add_to_one::<L, NUMBERS, 0>(batch);
        if pass.counts {
            sums.count::<true, false>(batch);
        }
        let block_start = on_walls.len() - pass.walls.len();
        for lane in (0..batch.len).filter(|&lane| batch.output.is_contact(lane)) {
            let ([i, wall], force) = (batch.pairs[lane].both(), batch.output.force::<NUMBERS>(lane));
            let body = &view.body[i];
            let point = body.position - batch.bodies.normal.get(lane) * (body.radius - batch.bodies.overlap[lane]);
            let drag = force.get(1).copied().unwrap_or(V::ZERO);
            on_walls[block_start + wall].add(-force[0], -drag, point - pass.walls[wall].surface.reference());
        }
    }
}

impl<V: Space> Surfaces<V> {
    /// Sets the load on each wall to the sum of its loads over all blocks. Each item of `on_walls` holds the loads of a
    /// task: one entry per wall for each of its blocks.
    pub(in crate::contact) fn gather<'a>(&mut self, on_walls: impl Iterator<Item = &'a [WallLoad<V>]>) {
        self.0.iter_mut().for_each(|wall| wall.load = WallLoad::default());
        for task_loads in on_walls {
            for block_loads in task_loads.chunks(self.0.len()) {
                self.0.iter_mut().zip(block_loads).for_each(|(wall, load)| wall.load += *load);
            }
        }
    }
}
