//! History blocks: memories of the contacts of consecutive rows, in the order in which the kernel visits them.
//!
//! With centred contacts a block also has entries of gaps that may close in half a step, with empty memories. So the entries
//! change less often than the contacts do, and lasting ones are overwritten in place.

use serde::{Deserialize, Serialize};

use std::ops::Range;

use crate::contact::batch::MemoryLanes;
use crate::contact::history::ContactLosses;
use crate::contact::lanes::LANES;
use crate::contact::{LawRequirements, Memory};
use crate::neighbours::list::Candidate;
use crate::space::Space;

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
        }
    }
}

impl<V: Space> HistoryBlock<V> {
    /// Makes this block a copy of the first `first` contacts of `earlier`. Reserves space for slightly more contacts
    /// than `earlier` has: growth by doubling would take twice the memory.
    pub(super) fn copy_front<L: LawRequirements>(&mut self, earlier: &Self, first: usize) {
        fn copy_front<T: Copy>(column: &mut Vec<T>, earlier: &[T], first: usize) {
            let expected = earlier.len();
            if column.capacity() < expected || column.capacity() > 2 * expected + LANES {
                *column = Vec::with_capacity(expected + expected / 16);
            }
            column.clear();
            column.extend_from_slice(&earlier[..first]);
        }
        copy_front(&mut self.contacts, &earlier.contacts, first);
        if L::SPRING {
            copy_front(&mut self.spring, &earlier.spring, first);
        }
        if L::ROLLING {
            copy_front(&mut self.rolling, &earlier.rolling, first);
        }
        if L::TWISTING {
            copy_front(&mut self.twist, &earlier.twist, first);
        }
        if L::STIFFNESS {
            copy_front(&mut self.stiffness, &earlier.stiffness, first);
        }
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

    #[inline]
    pub(super) fn memory<L: LawRequirements>(&self, at: usize) -> Memory<V> {
        Memory {
            spring: if L::SPRING { self.spring[at] } else { V::ZERO },
            rolling: if L::ROLLING { self.rolling[at] } else { V::ZERO },
            twist: if L::TWISTING { self.twist[at] } else { 0.0 },
            stiffness: if L::STIFFNESS { self.stiffness[at] } else { 0.0 },
        }
    }

    /// Returns the memory at position `at`; components that are not stored are zero.
    fn any_memory(&self, at: usize) -> Memory<V> {
        Memory {
            spring: self.spring.get(at).copied().unwrap_or_default(),
            rolling: self.rolling.get(at).copied().unwrap_or_default(),
            twist: self.twist.get(at).copied().unwrap_or_default(),
            stiffness: self.stiffness.get(at).copied().unwrap_or_default(),
        }
    }

    /// Appends a contact, which must come after the last one in order.
    #[inline]
    pub fn push<L: LawRequirements>(&mut self, contact: Candidate, memory: &Memory<V>) {
        self.contacts.push(contact);
        if L::SPRING {
            self.spring.push(memory.spring);
        }
        if L::ROLLING {
            self.rolling.push(memory.rolling);
        }
        if L::TWISTING {
            self.twist.push(memory.twist);
        }
        if L::STIFFNESS {
            self.stiffness.push(memory.stiffness);
        }
    }

    /// Gives the memory of a contact to the contact of the same row with `other`, unless that has one that is not empty. The
    /// first `passed` contacts are left alone.
    pub(super) fn rename<L: LawRequirements>(&mut self, passed: usize, contact: Candidate, other: usize) {
        fn move_entry<T>(column: &mut [T], from: usize, to: usize) {
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
                if self.any_memory(to).is_empty() {
                    self.swap_memories(from, to);
                }
                return;
            }
            Err(to) => passed + to,
        };
        self.contacts[from] = renamed;
        move_entry(&mut self.contacts, from, to);
        if L::SPRING {
            move_entry(&mut self.spring, from, to);
        }
        if L::ROLLING {
            move_entry(&mut self.rolling, from, to);
        }
        if L::TWISTING {
            move_entry(&mut self.twist, from, to);
        }
        if L::STIFFNESS {
            move_entry(&mut self.stiffness, from, to);
        }
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
    pub(in crate::contact) fn copy<L: LawRequirements>(
        &mut self,
        others: &Self,
        is_wanted: impl Fn(Candidate) -> bool,
    ) {
        for (at, &contact) in others.contacts.iter().enumerate().filter(|&(_, &contact)| is_wanted(contact)) {
            self.push::<L>(contact, &others.memory::<L>(at));
        }
    }

    /// Appends the contacts of a batch with their memories.
    #[inline]
    pub(super) fn extend<L: LawRequirements>(&mut self, contacts: &[Candidate], memories: &MemoryLanes<V>) {
        self.contacts.extend_from_slice(contacts);
        let lanes = 0..contacts.len().min(LANES);
        if L::SPRING {
            self.spring.extend(lanes.clone().map(|lane| memories.get::<L>(lane).spring));
        }
        if L::ROLLING {
            self.rolling.extend(lanes.clone().map(|lane| memories.get::<L>(lane).rolling));
        }
        if L::TWISTING {
            self.twist.extend(lanes.clone().map(|lane| memories.get::<L>(lane).twist));
        }
        if L::STIFFNESS {
            self.stiffness.extend(lanes.map(|lane| memories.get::<L>(lane).stiffness));
        }
    }

    /// Loads the memories of the given contacts into lanes.
    #[inline]
    pub(super) fn read<L: LawRequirements>(&self, contacts: Range<usize>, memories: &mut MemoryLanes<V>) {
        for (lane, at) in contacts.enumerate().take(LANES) {
            memories.set::<L>(lane, &self.memory::<L>(at));
        }
    }

    /// Overwrites the memories of the given contacts from lanes.
    #[inline]
    pub(super) fn write<L: LawRequirements>(&mut self, contacts: Range<usize>, memories: &MemoryLanes<V>) {
        fn write<T>(column: &mut [T], memory: impl Fn(usize) -> T) {
            for (lane, place) in column.iter_mut().enumerate().take(LANES) {
                *place = memory(lane);
            }
        }
        if L::SPRING {
            write(&mut self.spring[contacts.clone()], |lane| memories.get::<L>(lane).spring);
        }
        if L::ROLLING {
            write(&mut self.rolling[contacts.clone()], |lane| memories.get::<L>(lane).rolling);
        }
        if L::TWISTING {
            write(&mut self.twist[contacts.clone()], |lane| memories.get::<L>(lane).twist);
        }
        if L::STIFFNESS {
            write(&mut self.stiffness[contacts], |lane| memories.get::<L>(lane).stiffness);
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
        Some(self.any_memory(self.contacts.binary_search(&contact).ok()?))
    }

    /// Returns the memory of a contact, for calls in ascending order of contacts. `from` is the position of the last
    /// look-up; start with 0.
    #[inline]
    #[must_use]
    pub fn look_up_next(&self, from: &mut usize, contact: Candidate) -> Option<Memory<V>> {
        while self.contacts.get(*from).is_some_and(|&before| before < contact) {
            *from += 1;
        }
        (self.contacts.get(*from) == Some(&contact)).then(|| self.any_memory(*from))
    }

    /// Returns every contact with its memory.
    pub(super) fn all(&self) -> impl Iterator<Item = (Candidate, Memory<V>)> {
        self.contacts.iter().enumerate().map(|(at, &contact)| (contact, self.any_memory(at)))
    }
}
