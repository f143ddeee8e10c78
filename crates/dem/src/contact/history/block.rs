//! History blocks: memories of the contacts of consecutive rows, in the order in which the kernel visits them.
//!
//! With centred contacts a block also has entries of gaps that may close in half a step, with empty memories. So the entries
//! change less often than the contacts do, and lasting ones are overwritten in place.

use serde::{Deserialize, Serialize};

use std::ops::Range;

use crate::contact::batch::MemoryLanes;
use crate::contact::history::ContactLosses;
use crate::contact::lanes::{LANES, Lanes};
use crate::contact::{Memory, MemoryParts};
use crate::neighbours::list::Candidate;
use crate::space::{Linear, Space};

/// Memories of the contacts of consecutive rows. Vectors that the law does not require stay empty.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(bound = "")]
pub struct HistoryBlock<V: Space> {
    /// Ascending.
    pub(super) contacts: Vec<Candidate>,
    spring: Vec<V>,
    rolling: Vec<V>,
    twist: Vec<f64>,
    stiffness: Vec<f64>,
    /// Energy lost in contacts of these rows in the last pass.
    pub lost: ContactLosses,
    /// Number of contacts of these rows in the last pass, without gaps. Every pass sets it, also without memories.
    #[serde(skip)]
    pub(super) touching: u32,
}

impl<V: Space> Default for HistoryBlock<V> {
    fn default() -> Self {
        Self {
            contacts: Vec::new(),
            spring: Vec::new(),
            rolling: Vec::new(),
            twist: Vec::new(),
            stiffness: Vec::new(),
            lost: ContactLosses::default(),
            touching: 0,
        }
    }
}

impl<V: Space> HistoryBlock<V> {
    /// Makes this block a copy of the first `first` contacts of `earlier`. Reserves space for slightly more contacts
    /// than `earlier` has: growth by doubling would take twice the memory.
    pub(super) fn copy_front(&mut self, parts: MemoryParts, earlier: &Self, first: usize) {
        fn copy_front<T: Copy>(column: &mut Vec<T>, earlier: &[T], first: usize) {
            let expected = earlier.len();
            if column.capacity() < expected || column.capacity() > 2 * expected + LANES {
                *column = Vec::with_capacity(expected + expected / 16);
            }
            column.clear();
            column.extend_from_slice(&earlier[..first]);
        }
        copy_front(&mut self.contacts, &earlier.contacts, first);
        if parts.spring {
            copy_front(&mut self.spring, &earlier.spring, first);
        }
        if parts.rolling {
            copy_front(&mut self.rolling, &earlier.rolling, first);
        }
        if parts.twist {
            copy_front(&mut self.twist, &earlier.twist, first);
        }
        if parts.stiffness {
            copy_front(&mut self.stiffness, &earlier.stiffness, first);
        }
    }

    /// Whether the contacts are those of the rows `own`, each once and ascending, with partners below `partners`, in pairs after the
    /// row itself; and whether they have the `parts` of a law, which may keep none.
    pub(super) fn fits(&self, own: Range<usize>, partners: usize, are_pairs: bool, parts: Option<MemoryParts>) -> bool {
        let fits = |contact: &Candidate| {
            let [row, partner] = contact.both();
            own.contains(&row) && partner < partners && !(are_pairs && partner <= row)
        };
        let length = |is_kept: bool| if is_kept { self.contacts.len() } else { 0 };
        let has_parts = match parts {
            Some(MemoryParts { spring, rolling, twist, stiffness }) => {
                [self.spring.len(), self.rolling.len(), self.twist.len(), self.stiffness.len()]
                    == [spring, rolling, twist, stiffness].map(length)
            }
            None => self.contacts.is_empty(),
        };
        has_parts && self.contacts.iter().all(fits) && self.contacts.is_sorted_by(|one, next| one < next)
    }

    /// Removes all contacts.
    pub fn clear(&mut self) {
        self.truncate(0);
        self.lost = ContactLosses::default();
    }

    /// Discards all but the first `first` contacts.
    pub(super) fn truncate(&mut self, first: usize) {
        self.contacts.truncate(first);
        self.spring.truncate(first);
        self.rolling.truncate(first);
        self.twist.truncate(first);
        self.stiffness.truncate(first);
    }

    /// Returns the memory at position `at`; components that are not stored are zero.
    #[inline]
    pub(super) fn memory(&self, at: usize) -> Memory<V> {
        Memory {
            spring: self.spring.get(at).copied().unwrap_or_default(),
            rolling: self.rolling.get(at).copied().unwrap_or_default(),
            twist: self.twist.get(at).copied().unwrap_or_default(),
            stiffness: self.stiffness.get(at).copied().unwrap_or_default(),
        }
    }

    /// Appends a contact, which must come after the last one in order.
    #[inline]
    pub fn push(&mut self, parts: MemoryParts, contact: Candidate, memory: &Memory<V>) {
        self.contacts.push(contact);
        if parts.spring {
            self.spring.push(memory.spring);
        }
        if parts.rolling {
            self.rolling.push(memory.rolling);
        }
        if parts.twist {
            self.twist.push(memory.twist);
        }
        if parts.stiffness {
            self.stiffness.push(memory.stiffness);
        }
    }

    /// Gives the memory of a contact to the contact of the same row with `other`, unless that has one that is not empty. The
    /// first `passed` contacts are left alone.
    pub(super) fn rename(&mut self, passed: usize, contact: Candidate, other: usize) {
        fn move_entry<T>(column: &mut [T], from: usize, to: usize) {
            // Vectors that the law does not require are empty.
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
        move_entry(&mut self.spring, from, to);
        move_entry(&mut self.rolling, from, to);
        move_entry(&mut self.twist, from, to);
        move_entry(&mut self.stiffness, from, to);
    }

    fn swap_memories(&mut self, one: usize, two: usize) {
        fn swap<T>(column: &mut [T], one: usize, two: usize) {
            // Vectors that the law does not require are empty.
            if !column.is_empty() {
                column.swap(one, two);
            }
        }
        swap(&mut self.spring, one, two);
        swap(&mut self.rolling, one, two);
        swap(&mut self.twist, one, two);
        swap(&mut self.stiffness, one, two);
    }

    /// Appends the contacts of `others` for which `is_wanted` returns true. They must come after the last one in order.
    pub(in crate::contact) fn copy(
        &mut self,
        parts: MemoryParts,
        others: &Self,
        is_wanted: impl Fn(Candidate) -> bool,
    ) {
        for (at, &contact) in others.contacts.iter().enumerate().filter(|&(_, &contact)| is_wanted(contact)) {
            self.push(parts, contact, &others.memory(at));
        }
    }

    /// Appends the contacts of a batch with their memories.
    #[inline]
    pub(super) fn extend(&mut self, parts: MemoryParts, contacts: &[Candidate], memories: &MemoryLanes<V>) {
        self.contacts.extend_from_slice(contacts);
        let lanes = 0..contacts.len().min(LANES);
        if parts.spring {
            self.spring.extend(lanes.clone().map(|lane| memories.spring.get(lane)));
        }
        if parts.rolling {
            self.rolling.extend(lanes.clone().map(|lane| memories.rolling.get(lane)));
        }
        if parts.twist {
            self.twist.extend_from_slice(&memories.twist[lanes.clone()]);
        }
        if parts.stiffness {
            self.stiffness.extend_from_slice(&memories.stiffness[lanes]);
        }
    }

    /// Loads the memories of the given contacts, at most [`LANES`], into lanes.
    #[inline]
    pub(super) fn read(&self, parts: MemoryParts, contacts: Range<usize>, memories: &mut MemoryLanes<V>) {
        fn read<T: Linear>(column: &[T], lanes: &mut Lanes<T>) {
            for (lane, memory) in column.iter().enumerate().take(LANES) {
                lanes.set(lane, *memory);
            }
        }
        if parts.spring {
            read(&self.spring[contacts.clone()], &mut memories.spring);
        }
        if parts.rolling {
            read(&self.rolling[contacts.clone()], &mut memories.rolling);
        }
        if parts.twist {
            memories.twist[..contacts.len()].copy_from_slice(&self.twist[contacts.clone()]);
        }
        if parts.stiffness {
            memories.stiffness[..contacts.len()].copy_from_slice(&self.stiffness[contacts]);
        }
    }

    /// Overwrites the memories of the given contacts, at most [`LANES`], from lanes.
    #[inline]
    pub(super) fn write(&mut self, parts: MemoryParts, contacts: Range<usize>, memories: &MemoryLanes<V>) {
        fn write<T: Linear>(column: &mut [T], lanes: &Lanes<T>) {
            for (lane, place) in column.iter_mut().enumerate().take(LANES) {
                *place = lanes.get(lane);
            }
        }
        if parts.spring {
            write(&mut self.spring[contacts.clone()], &memories.spring);
        }
        if parts.rolling {
            write(&mut self.rolling[contacts.clone()], &memories.rolling);
        }
        if parts.twist {
            self.twist[contacts.clone()].copy_from_slice(&memories.twist[..contacts.len()]);
        }
        if parts.stiffness {
            self.stiffness[contacts.clone()].copy_from_slice(&memories.stiffness[..contacts.len()]);
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
    pub fn look_up(&self, contact: Candidate) -> Option<Memory<V>> {
        Some(self.memory(self.contacts.binary_search(&contact).ok()?))
    }

    /// Returns the memory of a contact, for calls in ascending order of contacts. `from` is the position of the last
    /// look-up; start with 0.
    #[inline]
    #[must_use]
    pub fn look_up_next(&self, from: &mut usize, contact: Candidate) -> Option<Memory<V>> {
        while self.contacts.get(*from).is_some_and(|&before| before < contact) {
            *from += 1;
        }
        (self.contacts.get(*from) == Some(&contact)).then(|| self.memory(*from))
    }

    /// Returns every contact with its memory.
    pub(super) fn all(&self) -> impl Iterator<Item = (Candidate, Memory<V>)> {
        self.contacts.iter().enumerate().map(|(at, &contact)| (contact, self.memory(at)))
    }
}
