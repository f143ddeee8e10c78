//! Contacts with flat walls, in the contact pass: block by block, in ascending order of rows, then in the scene's order of walls.
//!
//! What the grains do to a wall is summed too ([`WallLoad`]): the force *on the wall*, so a floor under gravity has one that points down.

use crate::contact::geometry::touching_wall;
use crate::contact::kernel::worker::{Block, Worker};
use crate::contact::lanes::LANES;
use crate::contact::{LawRequirements, PairLaw};
use crate::space::Space;
use crate::store::{TOTAL, TOTAL_AND_DISSIPATIVE};
use crate::walls::surfaces::{Surfaces, WallLoad};

impl<V: Space, L: PairLaw<V> + LawRequirements> Worker<'_, V, L> {
    /// Sums what happens between walls and those rows before `end` that are still to come.
    pub(super) fn sum_walls(&mut self, end: usize, mut block: Block<'_, V>) {
        let pass = self.pass;
        let of_block = self.near.partition_point(|contact| contact.first() < end);
        let near = self.near.split_off(..of_block).unwrap_or_default();
        if !near.is_empty() {
            self.on_walls.resize(self.on_walls.len() + pass.walls.len(), WallLoad::default());
        }
        let root = pass.law.needs_mass_root();
        for &contact in near {
            let ([i, wall], view) = (contact.both(), self.view);
            let pair = if L::PREDICTION {
                touching_wall::<true, V>(view, i, &pass.walls[wall], root, pass.dt)
            } else {
                touching_wall::<false, V>(view, i, &pass.walls[wall], root, pass.dt)
            };
            if let Some(pair) = pair {
                self.batch.push::<L>(contact, &pair);
                if self.batch.len == LANES {
                    self.flush_walls(&mut block);
                }
            }
        }
        if self.batch.len > 0 {
            self.flush_walls(&mut block);
        }
        block.cursor.end::<L>(block.lost, |contact, memory| pass.on_wall_contact_end(self.view, contact, memory));
    }

    /// Sums what the batch does to grains and walls, and keeps the books.
    fn flush_walls(&mut self, block: &mut Block<'_, V>) {
        let (pass, view) = (self.pass, self.view);
        if L::MEMORY {
            let Block { cursor, lost } = block;
            self.batch.recall::<L>(cursor, |contact, memory| lost.add(pass.on_wall_contact_end(view, contact, memory)));
        }
        // Of a wall the reach is the radius of the grain.
        if self.answer(1.0) {
            for lane in 0..self.batch.len {
                self.largest = self.largest.max(self.batch.bodies.overlap[lane] / self.batch.bodies.reach[lane]);
            }
        }
        self.keep(block, |contact, memory| pass.on_wall_contact_end(view, contact, memory));
        if view.tracks_energy {
            self.add_at_walls::<TOTAL_AND_DISSIPATIVE>();
        } else {
            self.add_at_walls::<TOTAL>();
        }
        self.batch.len = 0;
    }

    /// Adds what the batch does, so many numbers to an entry.
    fn add_at_walls<const NUMBERS: usize>(&mut self) {
        let Self { sums, batch, on_walls, pass, .. } = self;
        sums.add_to_one::<L, NUMBERS, 0>(batch);
        let of_block = on_walls.len() - pass.walls.len();
        for lane in (0..batch.len).filter(|&lane| batch.answer.counts::<L>(lane)) {
            let (load, force) =
                (&mut on_walls[of_block + batch.pairs[lane].second()], batch.answer.force::<NUMBERS>(lane));
            load.force -= force[0];
            if let Some(&drag) = force.get(1) {
                load.drag -= drag;
            }
        }
    }
}

impl<V: Space> Surfaces<V> {
    /// Sets what the grains do to each wall to the sum of what they do block by block: `on_walls` has one entry a wall for each block.
    pub(in crate::contact) fn gather<'a>(&mut self, on_walls: impl Iterator<Item = &'a [WallLoad<V>]>) {
        self.0.iter_mut().for_each(|wall| wall.load = WallLoad::default());
        for of_task in on_walls {
            for of_block in of_task.chunks(self.0.len()) {
                self.0.iter_mut().zip(of_block).for_each(|(wall, load)| wall.load += *load);
            }
        }
    }
}
