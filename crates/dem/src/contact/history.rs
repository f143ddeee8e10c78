//! Contact history: the memories of contacts between steps.
//!
//! Each force pass reads the memories of the contacts that it finds and writes them back ([`HistoryCursor`]). So a
//! memory lives exactly as long as its contact, whatever the neighbour search does. The memory of a contact that ends
//! is discarded. With centred contacts the pass also finds gaps that may close; their memories are empty.
//!
//! A contact is stored once, as a [`Candidate`]: in the row of its higher slot, or of the particle at a wall. A contact of two particles is seen
//! from the particle in the lower slot. Rows are slots in ascending order, each with its partners in ascending order. The force pass visits
//! contacts in this order, so a look-up only moves a cursor forward. History blocks have [`BLOCK`] rows each, so that each thread owns whole blocks. After a
//! renumbering, the blocks are rewritten by the previous slot of each particle.

mod block;
mod cursor;
pub(crate) mod losses;
pub mod remembered;
mod renumbering;

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

pub use self::block::HistoryBlock;
pub use self::cursor::HistoryCursor;
pub use self::losses::ContactLosses;
use crate::contact::memory::{Memory, MemoryLayout};
use crate::neighbours::list::{BLOCK, Candidate};
use crate::persist::Problem;
use crate::space::Space;
use crate::store::ParticleStore;

/// The memories of all contacts between particles and with wall surfaces.
#[derive(Resource, Clone, Debug, Default, Deserialize, Serialize)]
pub struct History {
    /// History blocks of contacts between particles.
    pair_blocks: Vec<HistoryBlock>,
    /// History blocks of contacts with wall surfaces; the partner is the index of the wall.
    wall_blocks: Vec<HistoryBlock>,
}

impl History {
    /// Returns the memory of the contact between slots `i` and `j`, seen from the lower slot. It is empty, or `None`, if they
    /// do not touch.
    #[must_use]
    pub fn of_pair(&self, i: usize, j: usize) -> Option<Memory> {
        let contact = Candidate::of_slots(u32::try_from(i).ok()?, u32::try_from(j).ok()?);
        self.pair_blocks.get(contact.row() / BLOCK)?.look_up(contact)
    }

    /// Returns the memory of the contact of slot `i` with a wall surface. It is empty, or `None`, if they do not touch.
    #[must_use]
    pub fn of_wall(&self, i: usize, wall: usize) -> Option<Memory> {
        self.wall_blocks.get(i / BLOCK)?.look_up(Candidate::new(u32::try_from(i).ok()?, u32::try_from(wall).ok()?))
    }

    /// Refuses memories that do not fit `rows` particles, `walls` wall surfaces, and a law with memories of this layout.
    pub(super) fn check(&self, rows: usize, walls: usize, layout: Option<&MemoryLayout>) -> Result<(), Problem> {
        let fit = |blocks: &[HistoryBlock], partners: usize, is_ordered: bool| {
            let block = |(number, block): (usize, &HistoryBlock)| {
                let own = number * BLOCK..rows.min((number + 1) * BLOCK);
                block.fits(own, partners, is_ordered, layout)
            };
            // Blocks beyond the rows are empty: they are removed by the next pass.
            blocks.iter().enumerate().all(block)
        };
        if fit(&self.pair_blocks, rows, true) && fit(&self.wall_blocks, walls, false) {
            Ok(())
        } else {
            Err("the memories of contacts belong to other particles, walls or laws".to_owned())
        }
    }

    /// Returns a reader of contacts between particles, for look-ups in ascending order.
    #[must_use]
    pub fn read_pairs(&self) -> HistoryReader<'_> {
        HistoryReader { blocks: &self.pair_blocks, block: 0, position: 0 }
    }

    /// Returns a reader of contacts with wall surfaces, for look-ups in ascending order.
    #[must_use]
    pub fn read_walls(&self) -> HistoryReader<'_> {
        HistoryReader { blocks: &self.wall_blocks, block: 0, position: 0 }
    }

    /// Returns the energy lost in contacts in the last step.
    #[must_use]
    pub fn lost(&self) -> ContactLosses {
        let mut all = ContactLosses::default();
        self.pair_blocks.iter().chain(&self.wall_blocks).for_each(|block| all += block.lost);
        all
    }

    /// Returns the number of contacts of the last pass in each block of rows: those between particles, then those with walls.
    pub fn touching(&self) -> impl Iterator<Item = u32> {
        self.pair_blocks.iter().chain(&self.wall_blocks).map(|block| block.touching)
    }

    /// Returns the history blocks for the particles of `store`: of contacts between particles, and of contacts with
    /// wall surfaces.
    pub fn blocks_mut<V: Space>(&mut self, store: &ParticleStore<V>) -> (&mut [HistoryBlock], &mut [HistoryBlock]) {
        (resized(&mut self.pair_blocks, store), resized(&mut self.wall_blocks, store))
    }
}

/// A reader of memories in ascending order of contacts, faster than [`History::of_pair`] and [`History::of_wall`].
#[derive(Clone, Debug)]
pub struct HistoryReader<'a> {
    blocks: &'a [HistoryBlock],
    /// Index of the block of the last look-up.
    block: usize,
    /// Position of the last look-up in its block.
    position: usize,
}

impl HistoryReader<'_> {
    /// Returns the memory of the contact of a row with a partner: a lower slot, or the index of a wall.
    #[inline]
    #[must_use]
    pub fn look_up(&mut self, row: usize, partner: usize) -> Option<Memory> {
        let contact = Candidate::new(u32::try_from(row).ok()?, u32::try_from(partner).ok()?);
        if row / BLOCK != self.block {
            (self.block, self.position) = (row / BLOCK, 0);
        }
        self.blocks.get(self.block)?.look_up_next(&mut self.position, contact)
    }
}

/// Resizes `blocks` to the number of blocks that the particles of `store` need.
fn resized<'p, V: Space>(blocks: &'p mut Vec<HistoryBlock>, store: &ParticleStore<V>) -> &'p mut [HistoryBlock] {
    blocks.resize_with(store.len().div_ceil(BLOCK), HistoryBlock::default);
    blocks
}

#[cfg(test)]
pub(super) mod tests {
    use std::num::NonZeroUsize;

    use super::*;
    use crate::contact::memory::{MemoryVariable, Parity};
    use crate::particle::GrainId;
    use crate::space::Plane;
    use crate::store::{Body, Slot};
    use crate::threads::Threads;

    /// A vector that changes its sign: a tangential spring.
    pub const SPRINGS: &MemoryLayout =
        &MemoryLayout::new::<Plane>(&[MemoryVariable::vector("spring", Parity::Odd)], false);

    /// Returns a store of grains of radius 0.5 m with the ids `names`, at x = id and y = 0.5 m, after a renumbering from the ids `before`.
    pub fn store(names: &[u32], before: &[u32]) -> ParticleStore {
        let id = names.iter().map(|&name| GrainId::grain(name).unwrap()).collect();
        let body = |&name: &u32| Body {
            position: Plane::new(f64::from(name), 0.5),
            velocity: Plane::ZERO,
            radius: 0.5,
            inverse_mass: 1.0,
            middle: Plane::default(),
        };
        let body = names.iter().map(body).collect();
        let former = |name| before.iter().zip(0..).find(|(before, _)| *before == name).map(|(_, slot)| Slot::new(slot));
        let former = names.iter().map(|name| former(name).unwrap_or_default()).collect();
        ParticleStore { id, former, body, ..ParticleStore::default() }
    }

    pub fn memory(x: f64) -> Memory {
        let mut memory = Memory::default();
        memory.numbers[0] = x;
        memory
    }

    #[test]
    fn sequential_look_up_agrees_with_search() {
        let mut page = HistoryBlock::default();
        for (contact, spring) in [([0, 1], 0.1), ([0, 3], 0.2), ([1, 2], 0.3)] {
            page.push(SPRINGS, contact.into(), &memory(spring));
        }
        let mut from = 0;
        for contact in [[0, 0], [0, 1], [0, 2], [1, 2], [1, 2], [1, 3], [7, 8]].map(Candidate::from) {
            assert_eq!(page.look_up_next(&mut from, contact), page.look_up(contact), "{contact:?}");
        }
    }

    #[test]
    fn a_memory_passes_to_another_wall_without_one() {
        let springs = |page: &HistoryBlock| {
            page.all().map(|(contact, memory)| (contact.row_and_partner(), memory.numbers[0])).collect::<Vec<_>>()
        };
        let block = |springs: &[([u32; 2], f64)]| {
            let mut page = HistoryBlock::default();
            for &(contact, spring) in springs {
                page.push(SPRINGS, contact.into(), &memory(spring));
            }
            page
        };
        // From wall 1 to walls that the grain does not touch, that it is only near to, and that it touches.
        for (other, after) in [
            (4, [([5, 2], 0.0), ([5, 3], 0.3), ([5, 4], 0.1)]),
            (2, [([5, 1], 0.0), ([5, 2], 0.1), ([5, 3], 0.3)]),
            (3, [([5, 1], 0.1), ([5, 2], 0.0), ([5, 3], 0.3)]),
        ] {
            let mut page = block(&[([5, 1], 0.1), ([5, 2], 0.0), ([5, 3], 0.3)]);
            page.rename(0, [5, 1].into(), other);
            assert_eq!(springs(&page), after);
        }
    }

    #[test]
    fn memories_move_with_their_particles() {
        let old: Vec<u32> = (0..3000).map(|n| 10 * n).collect();
        let before = store(&old, &[]);
        let mut history = History::default();
        history.move_to_new_slots(&before, SPRINGS, &Threads::one());
        for (contact, spring) in [([1, 0], 0.1), ([1024, 1023], 2.5), ([1501, 1500], 5.2), ([2999, 1], 1.5)] {
            history.blocks_mut(&before).0[contact[0] as usize / BLOCK].push(SPRINGS, contact.into(), &memory(spring));
        }
        history.blocks_mut(&before).1[1500 / BLOCK].push(SPRINGS, [1500, 2].into(), &memory(7.0));
        // Grain 0 leaves, two grains enter, and the order is reversed: the lower slot of each pair becomes the upper
        // one.
        let new: Vec<u32> = [5, 7].into_iter().chain(old[1..].iter().rev().copied()).collect();
        let after = store(&new, &old);
        let three = Threads::new(const { NonZeroUsize::new(3).unwrap() }).unwrap();
        history.move_to_new_slots(&after, SPRINGS, &three);
        let slot = |name: u32| new.iter().position(|&other| other == name).unwrap();
        let spring = |a: u32, b: u32| history.of_pair(slot(a), slot(b)).map(|memory| memory.numbers[0]);
        assert_eq!(spring(10, 29990), Some(-1.5));
        assert_eq!(spring(10230, 10240), Some(-2.5));
        assert_eq!(spring(15000, 15010), Some(-5.2));
        assert_eq!(spring(5, 10), None);
        assert_eq!(history.of_wall(slot(15000), 2).map(|memory| memory.numbers[0]), Some(7.0));
        let mut reader = history.read_pairs();
        for (contact, _) in history.pair_blocks.iter().flat_map(HistoryBlock::all) {
            let [row, partner] = contact.row_and_partner();
            assert_eq!(reader.look_up(row, partner), history.of_pair(partner, row));
        }
        let kept: usize = history.pair_blocks.iter().map(HistoryBlock::len).sum();
        assert_eq!(kept, 3);
    }
}
