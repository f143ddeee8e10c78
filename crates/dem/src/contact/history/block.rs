//! History blocks: memories of the contacts of consecutive rows, in the order in which the force pass visits them.
//!
//! Under the scheme `Centred` a block also has entries of gaps that may close in half a step, with empty memories. So the entries
//! change less often than the contacts do, and lasting ones are overwritten in place.

use serde::{Deserialize, Serialize};

use std::ops::Range;

use crate::contact::batch::MemoryLanes;
use crate::contact::history::losses::ContactLosses;
use crate::contact::memory::{MOST_NUMBERS, Memory, MemoryLayout};
use crate::lanes::LANES;
use crate::neighbours::list::Candidate;

/// Memories of the contacts of consecutive rows. Columns that the law does not remember stay empty.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct HistoryBlock {
    /// Ascending.
    pub(super) contacts: Vec<Candidate>,
    /// [`Memory::numbers`] of the contacts, a column for each.
    numbers: [Vec<f64>; MOST_NUMBERS],
    /// [`Memory::exists`] of the contacts.
    exists: Vec<bool>,
    /// Energy lost in contacts of these rows in the last pass.
    pub lost: ContactLosses,
    /// Number of contacts of these rows in the last pass, without gaps. Every pass sets it, also without memories.
    #[serde(skip)]
    pub(super) touching: u32,
}

/// A contact in its new slots, and where its memory was.
pub(super) struct Moved {
    pub(super) contact: Candidate,
    /// Number of the former block.
    pub(super) block: u32,
    /// Place in that block.
    pub(super) at: u32,
    /// Whether the particle that had the lower slot has the higher one now.
    pub(super) is_turned: bool,
}

impl HistoryBlock {
    /// Makes this block a copy of the first `first` contacts of `earlier`. Reserves space for slightly more contacts
    /// than `earlier` has: growth by doubling would take twice the memory.
    pub(super) fn copy_front(&mut self, layout: &MemoryLayout, earlier: &Self, first: usize) {
        fn copy_front<T: Copy>(column: &mut Vec<T>, earlier: &[T], first: usize) {
            let expected = earlier.len();
            if column.capacity() < expected || column.capacity() > 2 * expected + LANES {
                *column = Vec::with_capacity(expected + expected / 16);
            }
            column.clear();
            column.extend_from_slice(&earlier[..first]);
        }
        copy_front(&mut self.contacts, &earlier.contacts, first);
        for (column, earlier) in self.numbers.iter_mut().zip(&earlier.numbers).take(layout.count) {
            copy_front(column, earlier, first);
        }
        if layout.keeps_existence {
            copy_front(&mut self.exists, &earlier.exists, first);
        }
    }

    /// Returns a block of moved contacts, ascending, each with its former block.
    pub(super) fn of_moved<'a>(
        layout: &MemoryLayout,
        moved: impl ExactSizeIterator<Item = (&'a Moved, &'a Self)> + Clone,
    ) -> Self {
        // Slightly more than there are, as in `copy_front`.
        fn column<T>(rows: impl ExactSizeIterator<Item = T>) -> Vec<T> {
            let mut column = Vec::with_capacity(rows.len() + rows.len() / 16);
            column.extend(rows);
            column
        }
        let mut block = Self { contacts: column(moved.clone().map(|(moved, _)| moved.contact)), ..Self::default() };
        for (number, numbers) in block.numbers.iter_mut().enumerate().take(layout.count) {
            *numbers = column(moved.clone().map(|(moved, former)| {
                let before = former.numbers[number][moved.at as usize];
                if moved.is_turned && layout.is_odd(number) { -before } else { before }
            }));
        }
        if layout.keeps_existence {
            block.exists = column(moved.map(|(moved, former)| former.exists[moved.at as usize]));
        }
        block
    }

    /// Whether the block is one that a pass of this scene can have left. Its contacts must belong to the rows `own`, be ascending without a
    /// repeat, and have partners below `partners`; if `are_pairs`, partners must come before the row. Their memories must have the layout
    /// of the law. For a law without memory, `None`, the block must be empty.
    pub(super) fn fits(
        &self,
        own: Range<usize>,
        partners: usize,
        are_pairs: bool,
        layout: Option<&MemoryLayout>,
    ) -> bool {
        let fits = |contact: &Candidate| {
            let [row, partner] = contact.row_and_partner();
            own.contains(&row) && partner < partners && !(are_pairs && partner >= row)
        };
        let none = MemoryLayout::default();
        let MemoryLayout { count, keeps_existence, .. } = *layout.unwrap_or(&none);
        let length = |is_kept: bool| if is_kept { self.contacts.len() } else { 0 };
        let has_columns = self.numbers.iter().enumerate().all(|(at, column)| column.len() == length(at < count))
            && self.exists.len() == length(keeps_existence)
            && (layout.is_some() || self.contacts.is_empty());
        has_columns && self.contacts.iter().all(fits) && self.contacts.is_sorted_by(|one, next| one < next)
    }

    /// Removes all contacts.
    pub fn clear(&mut self) {
        self.truncate(0);
        self.lost = ContactLosses::default();
        self.touching = 0;
    }

    /// Discards all but the first `first` contacts.
    pub(super) fn truncate(&mut self, first: usize) {
        self.contacts.truncate(first);
        self.numbers.iter_mut().for_each(|column| column.truncate(first));
        self.exists.truncate(first);
    }

    /// Returns the memory at position `at`; numbers that are not stored are zero.
    #[inline]
    pub(super) fn memory(&self, at: usize) -> Memory {
        let mut memory = Memory { exists: self.exists.get(at) == Some(&true), ..Memory::default() };
        for (number, column) in memory.numbers.iter_mut().zip(&self.numbers) {
            *number = column.get(at).copied().unwrap_or_default();
        }
        memory
    }

    /// Appends a contact, which must come after the last one in order.
    #[inline]
    pub fn push(&mut self, layout: &MemoryLayout, contact: Candidate, memory: &Memory) {
        self.contacts.push(contact);
        for (column, number) in self.numbers.iter_mut().zip(&memory.numbers).take(layout.count) {
            column.push(*number);
        }
        if layout.keeps_existence {
            self.exists.push(memory.exists);
        }
    }

    /// Gives the memory of a contact to the contact of the same row with `other`, unless that has one that is not empty. The
    /// first `passed` contacts are left alone.
    pub(super) fn rename(&mut self, passed: usize, contact: Candidate, other: usize) {
        fn move_entry<T>(column: &mut [T], from: usize, to: usize) {
            // Columns that the law does not remember are empty.
            if column.is_empty() {
                return;
            }
            if from < to {
                column[from..to].rotate_left(1);
            } else {
                column[to..=from].rotate_right(1);
            }
        }
        let renamed = contact.with_partner(other);
        let left = &self.contacts[passed..];
        let Ok(from) = left.binary_search(&contact) else { return };
        let from = passed + from;
        let to = match left.binary_search(&renamed) {
            Ok(to) => {
                let to = passed + to;
                if self.memory(to).is_empty() {
                    self.swap_memories(from, to);
                }
                return;
            }
            Err(to) => passed + to,
        };
        self.contacts[from] = renamed;
        move_entry(&mut self.contacts, from, to);
        self.numbers.iter_mut().for_each(|column| move_entry(column, from, to));
        move_entry(&mut self.exists, from, to);
    }

    fn swap_memories(&mut self, one: usize, two: usize) {
        fn swap<T>(column: &mut [T], one: usize, two: usize) {
            // Columns that the law does not remember are empty.
            if !column.is_empty() {
                column.swap(one, two);
            }
        }
        self.numbers.iter_mut().for_each(|column| swap(column, one, two));
        swap(&mut self.exists, one, two);
    }

    /// Appends the contacts of a batch with their memories.
    #[inline]
    pub(super) fn extend(&mut self, layout: &MemoryLayout, contacts: &[Candidate], memories: &MemoryLanes) {
        self.contacts.extend_from_slice(contacts);
        let lanes = contacts.len().min(LANES);
        for (column, numbers) in self.numbers.iter_mut().zip(&memories.numbers).take(layout.count) {
            column.extend_from_slice(&numbers[..lanes]);
        }
        if layout.keeps_existence {
            self.exists.extend((0..lanes).map(|lane| memories.exists >> lane & 1 == 1));
        }
    }

    /// Loads the memories of the given contacts, at most [`LANES`], into lanes.
    #[inline]
    pub(super) fn read(&self, layout: &MemoryLayout, contacts: Range<usize>, memories: &mut MemoryLanes) {
        for (numbers, column) in memories.numbers.iter_mut().zip(&self.numbers).take(layout.count) {
            copy(&mut numbers[..contacts.len()], &column[contacts.clone()]);
        }
        if layout.keeps_existence {
            for (lane, exists) in self.exists[contacts].iter().enumerate() {
                memories.set_exists(lane, *exists);
            }
        }
    }

    /// Loads the memory at position `at` into a lane.
    #[inline]
    pub(in crate::contact) fn read_one(
        &self,
        layout: &MemoryLayout,
        at: usize,
        lane: usize,
        memories: &mut MemoryLanes,
    ) {
        for (numbers, column) in memories.numbers.iter_mut().zip(&self.numbers).take(layout.count) {
            numbers[lane] = column[at];
        }
        if layout.keeps_existence {
            memories.set_exists(lane, self.exists[at]);
        }
    }

    /// Overwrites the memories of the given contacts, at most [`LANES`], from lanes.
    #[inline]
    pub(super) fn write(&mut self, layout: &MemoryLayout, contacts: Range<usize>, memories: &MemoryLanes) {
        for (column, numbers) in self.numbers.iter_mut().zip(&memories.numbers).take(layout.count) {
            copy(&mut column[contacts.clone()], &numbers[..contacts.len()]);
        }
        if layout.keeps_existence {
            for (lane, exists) in self.exists[contacts].iter_mut().enumerate() {
                *exists = memories.exists >> lane & 1 == 1;
            }
        }
    }

    /// Returns the number of contacts.
    #[must_use]
    pub fn len(&self) -> usize {
        self.contacts.len()
    }

    /// Returns whether there are no contacts.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.contacts.is_empty()
    }

    /// Returns the memory of a contact.
    #[must_use]
    pub fn look_up(&self, contact: Candidate) -> Option<Memory> {
        Some(self.memory(self.contacts.binary_search(&contact).ok()?))
    }

    /// Returns the memory of a contact, for calls in ascending order of contacts. `from` is the position of the last
    /// look-up; start with 0.
    #[inline]
    #[must_use]
    pub fn look_up_next(&self, from: &mut usize, contact: Candidate) -> Option<Memory> {
        while self.contacts.get(*from).is_some_and(|&before| before < contact) {
            *from += 1;
        }
        (self.contacts.get(*from) == Some(&contact)).then(|| self.memory(*from))
    }

    /// Returns every contact with its memory.
    pub(super) fn all(&self) -> impl Iterator<Item = (Candidate, Memory)> {
        self.contacts.iter().enumerate().map(|(at, &contact)| (contact, self.memory(at)))
    }
}

/// Copies numbers. A full batch of lanes takes a few instructions in place of a call.
#[inline]
fn copy(to: &mut [f64], from: &[f64]) {
    match (to.as_mut_array::<LANES>(), from.as_array::<LANES>()) {
        (Some(to), Some(from)) => *to = *from,
        _ => to.copy_from_slice(from),
    }
}
