//! Moves memories to the slots that a renumbering has just assigned.
//!
//! First the former blocks say where each of their contacts goes, then the new blocks are filled. Threads divide the blocks of both passes among
//! them. Between the two, the contacts are sorted, which takes one pass, because most keep their order.

use crate::contact::history::History;
use crate::contact::history::block::{HistoryBlock, Moved};
use crate::contact::memory::MemoryLayout;
use crate::nearly_sorted::sort_into;
use crate::neighbours::list::{BLOCK, Candidate};
use crate::space::Space;
use crate::store::ParticleStore;
use crate::threads::Threads;

/// Fewest blocks of a thread.
const BLOCKS_PER_THREAD: usize = 8;

impl History {
    /// Moves memories to the slots that a renumbering of `store` has just assigned. Memories of particles that left are dropped.
    pub(in crate::contact) fn move_to_new_slots<V: Space>(
        &mut self,
        store: &ParticleStore<V>,
        layout: &MemoryLayout,
        threads: &Threads,
    ) {
        if self.pair_blocks.iter().chain(&self.wall_blocks).all(HistoryBlock::is_empty) {
            return;
        }
        let mut slots = vec![None; self.pair_blocks.len() * BLOCK];
        for (slot, former) in (0u32..).zip(&store.former) {
            if let Some(entry) = slots.get_mut(former.index()) {
                *entry = Some(slot);
            }
        }
        let new_slot = |former: usize| slots.get(former).copied().flatten();
        let of_pair = |contact: Candidate| match contact.slots().map(new_slot) {
            [Some(i), Some(j)] => Some((Candidate::of_slots(i, j), i > j)),
            _ => None,
        };
        let on_wall = |contact: Candidate| {
            let wall = u32::try_from(contact.partner()).ok()?;
            Some((Candidate::new(new_slot(contact.row())?, wall), false))
        };
        let blocks = store.len().div_ceil(BLOCK);
        self.pair_blocks = moved(&self.pair_blocks, blocks, of_pair, layout, threads);
        self.wall_blocks = moved(&self.wall_blocks, blocks, on_wall, layout, threads);
    }
}

/// Returns `blocks` blocks with the memories of those `before`. `new` returns a contact in its new slots, and whether it is turned, or `None` if it
/// is dropped.
fn moved(
    before: &[HistoryBlock],
    blocks: usize,
    new: impl Fn(Candidate) -> Option<(Candidate, bool)> + Sync,
    layout: &MemoryLayout,
    threads: &Threads,
) -> Vec<HistoryBlock> {
    let parts = threads.share_rows(0..before.len(), BLOCKS_PER_THREAD, |part| {
        let mut moved = Vec::with_capacity(before[part.clone()].iter().map(HistoryBlock::len).sum());
        for (block, former) in (0..).zip(before).take(part.end).skip(part.start) {
            moved.extend((0..).zip(&former.contacts).filter_map(|(at, &contact)| {
                let (contact, is_turned) = new(contact)?;
                Some(Moved { contact, block, at, is_turned })
            }));
        }
        moved
    });
    let mut order = Vec::with_capacity(before.iter().map(HistoryBlock::len).sum());
    sort_into(&mut order, parts.into_iter().flatten(), |moved| moved.contact);
    let parts = threads.share_rows(0..blocks, BLOCKS_PER_THREAD, |part| {
        let end_of = |block: usize| order.partition_point(|moved| moved.contact.row() < (block + 1) * BLOCK);
        let mut start = order.partition_point(|moved| moved.contact.row() < part.start * BLOCK);
        let fill = |block: usize| {
            let own = start..end_of(block);
            start = own.end;
            let own = &order[own];
            let contacts = own.iter().map(|moved| (moved, &before[moved.block as usize]));
            HistoryBlock::of_moved(layout, contacts)
        };
        part.map(fill).collect::<Vec<_>>()
    });
    parts.into_iter().flatten().collect()
}
