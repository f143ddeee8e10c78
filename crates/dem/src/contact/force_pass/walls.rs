//! Contacts with wall surfaces in the contact pass: block by block, in ascending order of rows, then in the scene's order
//! of walls.
//!
//! The loads on walls are summed too ([`WallLoad`]). A load is the force *on the wall*: the load on a floor under
//! gravity points down.

use crate::contact::force_pass::input::ForcePass;
use crate::contact::force_pass::worker::{Block, Worker, recall};
use crate::contact::geometry::{WallContacts, WallReach, touching_wall};
use crate::contact::law::LawRequirements;
use crate::contact::pair::Pair;
use crate::lanes::LANES;
use crate::neighbours::list::Candidate;
use crate::space::Space;
use crate::store::{ParticleStore, TOTAL, TOTAL_AND_DISSIPATIVE};
use crate::walls::surface_wall::WallLoad;

impl<V: Space, C: LawRequirements> Worker<'_, V, C> {
    /// Sums the contacts between walls and the rows of a block, which ends before `end`.
    pub(super) fn sum_walls(&mut self, end: usize, mut block: Block<'_>) {
        let pass = self.pass;
        let count = self.near.partition_point(|contact| contact.row() < end);
        let near = self.near.split_off(..count).unwrap_or_default();
        let view = self.view;
        let walls = pass.walls;
        let reach = WallReach { mass_root: self.mass_root, ahead: view.prediction.velocities_ahead };
        let mut contacts = WallContacts::default();
        let has_images = pass.needs.memory.is_some() && !pass.twins.is_empty();
        for row in near.chunk_by(|a, b| a.row() == b.row()) {
            let i = row[0].row();
            if has_images {
                self.follow_through_sides(row, reach, &mut block);
            }
            if let &[contact] = row {
                if let Some(pair) = touching_wall(view, i, &walls[contact.partner()], reach) {
                    self.push_wall(contact, &pair, &mut block);
                }
                continue;
            }
            // Memories follow the grain over a seam before any contact of the grain is recalled.
            let follow = |from: usize, to: usize| {
                if pass.needs.memory.is_some() {
                    block.cursor.rename(row[0].with_partner(from), to);
                }
            };
            contacts.find(view, i, (walls, row.iter().map(|contact| contact.partner())), reach.ahead, follow);
            for (wall, pair) in contacts.pairs(view, i, walls, reach.mass_root) {
                self.push_wall(row[0].with_partner(wall), &pair, &mut block);
            }
        }
        if self.batch.len > 0 {
            self.flush_walls(&mut block);
        }
        block.end(|contact, memory| pass.on_wall_contact_end(self.view, contact, memory));
    }

    /// Gives the memories of a grain to the images that it touches after it has passed through a periodic side: those of surfaces that it
    /// has left thereby.
    #[cold]
    fn follow_through_sides(&self, row: &[Candidate], reach: WallReach, block: &mut Block<'_>) {
        let view = self.view;
        let ForcePass { walls, twins, .. } = self.pass;
        let touches = |wall: usize| touching_wall(view, row[0].row(), &walls[wall], reach).is_some();
        for contact in row {
            for other in twins.of_surface(contact.partner()) {
                let former = contact.with_partner(other);
                if block.cursor.remembers(former) && touches(contact.partner()) && !touches(other) {
                    block.cursor.rename(former, contact.partner());
                }
            }
        }
    }

    /// Adds a contact to the batch, and evaluates the batch if it is full.
    #[inline(always)]
    fn push_wall(&mut self, contact: Candidate, pair: &Pair<V>, block: &mut Block<'_>) {
        let view = self.view;
        if view.predicts() {
            self.batch.lone |= u64::from(view.prediction.lone[contact.row()]) << self.batch.len;
        }
        if self.gathers() {
            self.batch
                .gathered
                .set(self.batch.len, view.gathered_with_wall(contact.row(), &self.pass.walls[contact.partner()], pair));
        }
        self.batch.push::<C>(contact, pair);
        if self.batch.len == LANES {
            self.flush_walls(block);
        }
    }

    /// Evaluates the batch, adds its forces to grains and walls, and stores memories and losses.
    fn flush_walls(&mut self, block: &mut Block<'_>) {
        let pass = self.pass;
        let view = self.view;
        if pass.needs.memory.is_some() {
            let Block { cursor, lost, .. } = block;
            recall(self.batch, cursor, |contact, memory| lost.add(pass.on_wall_contact_end(view, contact, memory)));
        }
        // For a wall contact the reach is the radius of the grain, so the share is 1.
        let predict = |store: &ParticleStore<V>, contact: Candidate, pair: &mut Pair<V>| {
            store.predict_with_wall(contact.row(), &pass.walls[contact.partner()], pair);
        };
        if self.evaluate_law(1.0, &predict) {
            for lane in 0..self.batch.len {
                self.largest = self.largest.max(self.batch.bodies.overlap[lane] / self.batch.bodies.reach[lane]);
            }
        }
        block.touching += self.batch.touching();
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
        let Self { sums, batch, of_walls, on_walls, pass, view, .. } = self;
        if let Some(held) = of_walls {
            held.extend::<C, NUMBERS>(batch, pass.counts, |_| true);
        } else {
            sums.add_to_rows::<C, NUMBERS>(batch);
            if pass.counts {
                sums.count::<false>(batch);
            }
        }
        // Neighbouring particles often touch the same wall.
        let mut sum: Option<(usize, WallLoad<V>)> = None;
        for lane in (0..batch.len).filter(|&lane| batch.output.is_contact(lane)) {
            let [i, wall] = batch.pairs[lane].row_and_partner();
            let force = batch.output.force::<NUMBERS>(lane);
            let body = &view.body[i];
            let point = body.position - batch.bodies.normal.get(lane) * (body.radius - batch.bodies.overlap[lane]);
            let dashpot = force.get(1).copied().unwrap_or(V::ZERO);
            let load = WallLoad::of(-force[0], -dashpot, point - pass.walls[wall].reference);
            match &mut sum {
                Some((same, sum)) if *same == wall => *sum += load,
                _ => on_walls.extend(sum.replace((wall, load))),
            }
        }
        on_walls.extend(sum);
    }
}
