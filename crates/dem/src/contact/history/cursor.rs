//! History cursor: moves along a history block in ascending order of contacts, with the force pass. It reads the memories
//! of the previous pass and writes the new ones.
//!
//! In a bed at rest a pass finds the contacts of the previous pass. As long as it does, memories are overwritten in
//! place. From the first new or ended contact on, the block is rewritten: it is swapped with a spare block.

use crate::contact::batch::MemoryLanes;
use crate::contact::history::block::HistoryBlock;
use crate::contact::history::losses::{ContactLosses, EndLosses};
use crate::contact::memory::{Memory, MemoryLayout};
use crate::neighbours::list::{Candidate, are_same};

/// A history block and the position of the force pass in it.
pub struct HistoryCursor<'a> {
    block: &'a mut HistoryBlock,
    /// The block of the previous pass, once the block is being rewritten.
    spare: &'a mut HistoryBlock,
    layout: &'a MemoryLayout,
    is_rewriting: bool,
    /// Number of contacts of the previous pass that have been visited.
    passed: usize,
}

impl<'a> HistoryCursor<'a> {
    /// Returns a cursor at the start of a block of memories of a layout.
    #[must_use]
    pub fn new(block: &'a mut HistoryBlock, spare: &'a mut HistoryBlock, layout: &'a MemoryLayout) -> Self {
        Self { block, spare, layout, is_rewriting: false, passed: 0 }
    }

    /// Starts to rewrite the block from the current position on.
    #[cold]
    fn start_rewrite(&mut self) {
        self.is_rewriting = true;
        std::mem::swap(self.block, self.spare);
        self.block.copy_front(self.layout, self.spare, self.passed);
    }

    /// Loads the memories of `contacts` if these are exactly the next contacts of the previous pass. Returns whether
    /// they are.
    #[inline]
    pub(in crate::contact) fn recall_all(&mut self, contacts: &[Candidate], memories: &mut MemoryLanes) -> bool {
        let before = if self.is_rewriting { &*self.spare } else { &*self.block };
        let next = self.passed..self.passed + contacts.len();
        let are_next = before.contacts.get(next.clone()).is_some_and(|known| are_same(known, contacts));
        if are_next {
            self.passed = next.end;
            before.read(self.layout, next, memories);
        }
        are_next
    }

    /// Loads the memory of a contact into a lane. Returns whether the contact has one; that of a new contact is empty. Contacts that are
    /// skipped have ended: `on_end` receives each of them with its memory.
    #[inline]
    pub(in crate::contact) fn recall(
        &mut self,
        contact: Candidate,
        lane: usize,
        memories: &mut MemoryLanes,
        mut on_end: impl FnMut(Candidate, &Memory),
    ) -> bool {
        if !self.is_rewriting {
            self.start_rewrite();
        }
        while let Some(&next) = self.spare.contacts.get(self.passed)
            && next <= contact
        {
            let at = self.passed;
            self.passed += 1;
            if next == contact {
                self.spare.read_one(self.layout, at, lane, memories);
                return true;
            }
            on_end(next, &self.spare.memory(at));
        }
        memories.clear(self.layout, lane);
        false
    }

    /// Whether a contact that has not been visited has an entry of the previous pass.
    pub(in crate::contact) fn remembers(&self, contact: Candidate) -> bool {
        let before = if self.is_rewriting { &*self.spare } else { &*self.block };
        before.contacts[self.passed..].binary_search(&contact).is_ok()
    }

    /// Gives the memory of a contact with a wall that has not been visited to the contact of the same row with the wall
    /// `other`, unless that contact has a memory of its own.
    #[cold]
    pub(in crate::contact) fn rename(&mut self, contact: Candidate, other: usize) {
        let before = if self.is_rewriting { &mut *self.spare } else { &mut *self.block };
        before.rename(self.passed, contact, other);
    }

    /// Stores the memories of `contacts`, which have just been recalled.
    #[inline]
    pub(crate) fn remember_all(&mut self, contacts: &[Candidate], memories: &MemoryLanes) {
        if self.is_rewriting {
            self.block.extend(self.layout, contacts, memories);
        } else {
            self.block.write(self.layout, self.passed - contacts.len()..self.passed, memories);
        }
    }

    /// Records the number of contacts of these rows in this pass.
    pub(in crate::contact) fn set_touching(&mut self, touching: u32) {
        self.block.touching = touching;
    }

    /// Ends the block: the remaining contacts of the previous pass have ended. `lost` is the energy lost in these rows;
    /// `on_end` returns the energy lost with an ended contact, J.
    pub fn end(&mut self, mut lost: ContactLosses, mut on_end: impl FnMut(Candidate, &Memory) -> EndLosses) {
        let before = if self.is_rewriting { &*self.spare } else { &*self.block };
        for at in self.passed..before.len() {
            lost.add(on_end(before.contacts[at], &before.memory(at)));
        }
        if !self.is_rewriting {
            self.block.truncate(self.passed);
        }
        self.block.lost = lost;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::history::tests::{SPRINGS, memory};

    /// Returns losses by sliding and by rolling, J.
    fn lost(sliding: f64, rolling: f64) -> ContactLosses {
        ContactLosses { sliding, rolling, ..ContactLosses::default() }
    }

    /// Returns the contact of slots i and j.
    fn pair(contact: [u32; 2]) -> Candidate {
        contact.into()
    }

    fn contacts() -> [Candidate; 4] {
        [[0, 1], [0, 3], [1, 2], [2, 3]].map(pair)
    }

    /// Returns the history of four particles, with springs of 0.1 to 0.4 m.
    fn block() -> HistoryBlock {
        let mut block = HistoryBlock::default();
        for (contact, spring) in contacts().into_iter().zip([0.1, 0.2, 0.3, 0.4]) {
            block.push(SPRINGS, contact, &memory(spring));
        }
        block
    }

    fn springs(block: &HistoryBlock) -> Vec<([usize; 2], f64)> {
        block.all().map(|(contact, memory)| (contact.row_and_partner(), memory.numbers[0])).collect()
    }

    #[test]
    fn lasting_contacts_are_overwritten_in_place() {
        let mut block = block();
        let mut spare = HistoryBlock::default();
        let mut cursor = HistoryCursor::new(&mut block, &mut spare, SPRINGS);
        let all = contacts();
        for contacts in [&all[..3], &all[3..]] {
            let mut memories = MemoryLanes::default();
            assert!(cursor.recall_all(contacts, &mut memories));
            for lane in 0..contacts.len() {
                memories.numbers[0][lane] *= 2.0;
            }
            cursor.remember_all(contacts, &memories);
        }
        cursor.end(lost(1.0, 0.0), |_, _| panic!("no contact has ended"));
        assert_eq!(springs(&block), [([0, 1], 0.2), ([0, 3], 0.4), ([1, 2], 0.6), ([2, 3], 0.8)]);
        assert_eq!(block.lost, lost(1.0, 0.0));
        assert!(spare.is_empty());
    }

    #[test]
    fn block_is_rewritten_from_the_first_change_on() {
        let mut block = block();
        let mut spare = HistoryBlock::default();
        let mut cursor = HistoryCursor::new(&mut block, &mut spare, SPRINGS);
        let mut memories = MemoryLanes::default();
        let mut gone = Vec::new();
        assert!(cursor.recall_all(&contacts()[..1], &mut memories));
        cursor.remember_all(&contacts()[..1], &memories);
        // One contact is new, one has ended, and one request goes beyond the end: each must be recalled one by one.
        for contacts in [&[[0, 2], [0, 3]][..], &[[1, 2]], &[[0, 3], [1, 2], [2, 3], [3, 4]]] {
            let contacts: Vec<_> = contacts.iter().copied().map(pair).collect();
            assert!(!cursor.recall_all(&contacts, &mut memories));
        }
        assert!(!cursor.recall(pair([0, 2]), 0, &mut memories, |_, _| panic!("no contact has ended")));
        assert_eq!(memories.memory(SPRINGS, 0), memory(0.0));
        let ended = |contact: Candidate, memory: &Memory| gone.push((contact.row_and_partner(), memory.numbers[0]));
        assert!(cursor.recall(pair([1, 2]), 1, &mut memories, ended));
        assert_eq!((memories.memory(SPRINGS, 1), &gone[..]), (memory(0.3), &[([0, 3], 0.2)][..]));
        [5.0, 6.0].into_iter().enumerate().for_each(|(lane, spring)| memories.numbers[0][lane] = spring);
        cursor.remember_all(&[[0, 2], [1, 2]].map(pair), &memories);
        // From here on a whole batch matches again.
        assert!(cursor.recall_all(&contacts()[3..], &mut memories));
        cursor.remember_all(&contacts()[3..], &memories);
        cursor.end(ContactLosses::default(), |_, _| panic!("all contacts have been visited"));
        assert_eq!(springs(&block), [([0, 1], 0.1), ([0, 2], 5.0), ([1, 2], 6.0), ([2, 3], 0.4)]);
    }

    #[test]
    fn contacts_left_at_the_end_of_a_block_are_discarded() {
        for is_rewriting in [false, true] {
            let mut block = block();
            let mut spare = HistoryBlock::default();
            let mut cursor = HistoryCursor::new(&mut block, &mut spare, SPRINGS);
            let mut memories = MemoryLanes::default();
            if is_rewriting {
                assert!(!cursor.recall(pair([0, 0]), 0, &mut memories, |_, _| panic!("no contact has ended")));
            }
            assert!(cursor.recall_all(&contacts()[..2], &mut memories));
            cursor.remember_all(&contacts()[..2], &memories);
            cursor.end(lost(1.0, 2.0), |_, memory| EndLosses { sliding: memory.numbers[0], ..EndLosses::default() });
            assert_eq!(springs(&block), [([0, 1], 0.1), ([0, 3], 0.2)]);
            assert_eq!(block.lost, lost(1.0 + 0.3 + 0.4, 2.0));
        }
    }
}
