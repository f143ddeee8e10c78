//! Pages: memories of the contacts of consecutive rows, in the order in which the kernel comes by.

use std::ops::Range;

use crate::contact::batch::MemoryLanes;
use crate::contact::history::ContactLosses;
use crate::contact::lanes::LANES;
use crate::contact::{LawRequirements, Memory};
use crate::neighbours::list::Candidate;
use crate::space::Space;

/// Memories of the contacts of consecutive rows. Columns that the law does not demand stay empty.
#[derive(Clone, Debug)]
pub struct HistoryBlock<V: Space> {
    /// Ascending.
    pub(super) contacts: Vec<Candidate>,
    spring: Vec<V>,
    rolling: Vec<V>,
    stiffness: Vec<f64>,
    /// What contacts in these rows took.
    pub lost: ContactLosses,
}

impl<V: Space> Default for HistoryBlock<V> {
    fn default() -> Self {
        Self {
            contacts: Vec::new(),
            spring: Vec::new(),
            rolling: Vec::new(),
            stiffness: Vec::new(),
            lost: ContactLosses::default(),
        }
    }
}

impl<V: Space> HistoryBlock<V> {
    /// Makes them a copy of the first contacts of `earlier`, with room for about as many as there are in all: vectors that
    /// double would hold twice as much.
    pub(super) fn begin<L: LawRequirements>(&mut self, earlier: &Self, first: usize) {
        fn begin<T: Copy>(column: &mut Vec<T>, earlier: &[T], first: usize) {
            let expected = earlier.len();
            if column.capacity() < expected || column.capacity() > 2 * expected + LANES {
                *column = Vec::with_capacity(expected + expected / 16);
            }
            column.clear();
            column.extend_from_slice(&earlier[..first]);
        }
        begin(&mut self.contacts, &earlier.contacts, first);
        if L::SPRING {
            begin(&mut self.spring, &earlier.spring, first);
        }
        if L::ROLLING {
            begin(&mut self.rolling, &earlier.rolling, first);
        }
        if L::STIFFNESS {
            begin(&mut self.stiffness, &earlier.stiffness, first);
        }
    }

    /// Makes them empty.
    pub fn clear(&mut self) {
        self.truncate(0);
        self.lost = ContactLosses::default();
    }

    /// Forgets all but the first contacts.
    pub(super) fn truncate(&mut self, first: usize) {
        self.contacts.truncate(first);
        self.spring.truncate(first);
        self.rolling.truncate(first);
        self.stiffness.truncate(first);
    }

    #[inline]
    pub(super) fn memory<L: LawRequirements>(&self, at: usize) -> Memory<V> {
        Memory {
            spring: if L::SPRING { self.spring[at] } else { V::ZERO },
            rolling: if L::ROLLING { self.rolling[at] } else { V::ZERO },
            stiffness: if L::STIFFNESS { self.stiffness[at] } else { 0.0 },
        }
    }

    /// The memory at a place, of whatever the pages hold.
    fn any_memory(&self, at: usize) -> Memory<V> {
        Memory {
            spring: self.spring.get(at).copied().unwrap_or_default(),
            rolling: self.rolling.get(at).copied().unwrap_or_default(),
            stiffness: self.stiffness.get(at).copied().unwrap_or_default(),
        }
    }

    /// Adds a contact, which comes after the last one.
    #[inline]
    pub fn push<L: LawRequirements>(&mut self, contact: Candidate, memory: &Memory<V>) {
        self.contacts.push(contact);
        if L::SPRING {
            self.spring.push(memory.spring);
        }
        if L::ROLLING {
            self.rolling.push(memory.rolling);
        }
        if L::STIFFNESS {
            self.stiffness.push(memory.stiffness);
        }
    }

    /// Adds those contacts of others that are wanted, and that come after the last one.
    pub(in crate::contact) fn copy<L: LawRequirements>(
        &mut self,
        others: &Self,
        is_wanted: impl Fn(Candidate) -> bool,
    ) {
        for (at, &contact) in others.contacts.iter().enumerate().filter(|&(_, &contact)| is_wanted(contact)) {
            self.push::<L>(contact, &others.memory::<L>(at));
        }
    }

    /// Adds these contacts, which were asked about together.
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
        if L::STIFFNESS {
            self.stiffness.extend(lanes.map(|lane| memories.get::<L>(lane).stiffness));
        }
    }

    /// Fetches what these contacts remember.
    #[inline]
    pub(super) fn read<L: LawRequirements>(&self, contacts: Range<usize>, memories: &mut MemoryLanes<V>) {
        for (lane, at) in contacts.enumerate().take(LANES) {
            memories.set::<L>(lane, &self.memory::<L>(at));
        }
    }

    /// Writes down what these contacts remember.
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
        if L::STIFFNESS {
            write(&mut self.stiffness[contacts], |lane| memories.get::<L>(lane).stiffness);
        }
    }

    /// How many contacts they hold.
    #[must_use]
    pub fn len(&self) -> usize {
        self.contacts.len()
    }

    /// Whether they hold none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.contacts.is_empty()
    }

    /// The memory of a contact.
    #[must_use]
    pub fn look_up(&self, contact: Candidate) -> Option<Memory<V>> {
        Some(self.any_memory(self.contacts.binary_search(&contact).ok()?))
    }

    /// The same, if contacts are asked for in ascending order: `from` is where the last one was, at first 0.
    #[must_use]
    pub fn look_up_next(&self, from: &mut usize, contact: Candidate) -> Option<Memory<V>> {
        while self.contacts.get(*from).is_some_and(|&before| before < contact) {
            *from += 1;
        }
        (self.contacts.get(*from) == Some(&contact)).then(|| self.any_memory(*from))
    }

    /// Every contact and its memory.
    pub(super) fn all(&self) -> impl Iterator<Item = (Candidate, Memory<V>)> {
        self.contacts.iter().enumerate().map(|(at, &contact)| (contact, self.any_memory(at)))
    }
}
