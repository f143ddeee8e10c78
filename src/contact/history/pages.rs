//! Pages: memories of the contacts of consecutive rows, in the order in which the kernel comes by, and the walk along them.

use crate::contact::batch::MemoryLanes;
use crate::contact::lanes::LANES;
use crate::contact::{Demands, Memory};
use crate::neighbours::list::Candidate;
use crate::space::Space;

/// Row and partner of a contact, in one number that orders contacts by row, then by partner.
type Key = u64;

#[inline(always)]
fn key(row: usize, partner: u32) -> Key {
    (row as u64) << 32 | u64::from(partner)
}

fn row_of(key: Key) -> usize {
    (key >> 32) as usize
}

#[expect(clippy::cast_possible_truncation, reason = "the lower half of the key")]
fn partner_of(key: Key) -> u32 {
    key as u32
}

/// Memories of the contacts of consecutive rows.
#[derive(Clone, Debug)]
pub struct Pages<V: Space> {
    /// Row and partner of each contact, ascending.
    keys: Vec<Key>,
    spring: Vec<V>,
    rolling: Vec<V>,
    stiffness: Vec<f64>,
    /// What sliding and rolling took in these rows, J.
    pub lost: [f64; 2],
}

impl<V: Space> Default for Pages<V> {
    fn default() -> Self {
        Self { keys: Vec::new(), spring: Vec::new(), rolling: Vec::new(), stiffness: Vec::new(), lost: [0.0; 2] }
    }
}

impl<V: Space> Pages<V> {
    /// Makes them empty, with room for about as many contacts as those had: vectors that double would hold twice as much.
    pub(in crate::contact) fn begin<L: Demands>(&mut self, earlier: &Self) {
        fn make_room<T>(column: &mut Vec<T>, expected: usize) {
            if column.capacity() < expected || column.capacity() > 2 * expected + LANES {
                *column = Vec::with_capacity(expected + expected / 16);
            }
        }
        self.clear();
        let expected = earlier.keys.len();
        make_room(&mut self.keys, expected);
        if L::SPRING {
            make_room(&mut self.spring, expected);
        }
        if L::ROLLING {
            make_room(&mut self.rolling, expected);
        }
        if L::STIFFNESS {
            make_room(&mut self.stiffness, expected);
        }
    }

    /// Makes them empty.
    pub fn clear(&mut self) {
        self.keys.clear();
        self.spring.clear();
        self.rolling.clear();
        self.stiffness.clear();
        self.lost = [0.0; 2];
    }

    #[inline]
    fn memory<L: Demands>(&self, at: usize) -> Memory<V> {
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

    /// Adds a contact of `row`, which comes after the last one.
    #[inline]
    pub fn push<L: Demands>(&mut self, row: usize, partner: u32, memory: &Memory<V>) {
        self.keys.push(key(row, partner));
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

    /// Adds the first of these contacts that were asked about together, as many as there are `pairs`; the rows of these
    /// pages begin with `first`.
    #[inline]
    pub(in crate::contact) fn extend<L: Demands>(
        &mut self,
        first: usize,
        pairs: &[Candidate],
        memories: &MemoryLanes<V>,
    ) {
        self.keys.extend(pairs.iter().map(|&[i, j]| key(i as usize - first, j)));
        let lanes = 0..pairs.len().min(LANES);
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

    /// How many contacts they hold.
    #[must_use]
    pub fn len(&self) -> usize {
        self.keys.len()
    }

    /// Whether they hold none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }

    /// The memory of the contact of `row` with `partner`.
    #[must_use]
    pub fn look_up(&self, row: usize, partner: u32) -> Option<Memory<V>> {
        Some(self.any_memory(self.keys.binary_search(&key(row, partner)).ok()?))
    }

    /// Every contact: row, partner, memory.
    pub(super) fn contacts(&self) -> impl Iterator<Item = (usize, u32, Memory<V>)> {
        self.keys.iter().enumerate().map(|(at, &key)| (row_of(key), partner_of(key), self.any_memory(at)))
    }
}

/// Walks along earlier pages while the kernel comes by in ascending order of rows and partners.
#[derive(Clone, Copy)]
pub struct Recall<'a, V: Space> {
    pages: &'a Pages<V>,
    /// Of the contacts that are still to come.
    keys: &'a [Key],
}

impl<'a, V: Space> Recall<'a, V> {
    /// At the start.
    #[must_use]
    pub fn new(pages: &'a Pages<V>) -> Self {
        Self { pages, keys: &pages.keys }
    }

    /// What these contacts remember, if they are the next ones, all of them, and no other is among them: in a bed at rest. The
    /// rows of the pages begin with `first`.
    #[inline]
    pub(in crate::contact) fn of_all<L: Demands>(
        &mut self,
        first: usize,
        pairs: &[Candidate],
    ) -> Option<impl Iterator<Item = Memory<V>> + use<'a, V, L>> {
        let (next, rest) = self.keys.split_at_checked(pairs.len())?;
        let is_next = |(&next, &[i, j]): (&Key, &Candidate)| next == key(i as usize - first, j);
        // Without a branch, several at a time.
        if !next.iter().zip(pairs).fold(true, |all, contact| all & is_next(contact)) {
            return None;
        }
        let start = self.pages.keys.len() - self.keys.len();
        self.keys = rest;
        let pages = self.pages;
        Some((start..start + next.len()).map(move |at| pages.memory::<L>(at)))
    }

    /// What the contact of `row` with `partner` remembers, if it is not new. Contacts that are passed over have ended:
    /// `forgotten` gets their rows, partners and memories.
    #[inline]
    pub fn of<L: Demands>(
        &mut self,
        row: usize,
        partner: u32,
        mut forgotten: impl FnMut(usize, u32, &Memory<V>),
    ) -> Option<Memory<V>> {
        let wanted = key(row, partner);
        while let Some((&next, rest)) = self.keys.split_first()
            && next <= wanted
        {
            let memory = self.pages.memory::<L>(self.pages.keys.len() - self.keys.len());
            self.keys = rest;
            if next == wanted {
                return Some(memory);
            }
            forgotten(row_of(next), partner_of(next), &memory);
        }
        None
    }

    /// Passes over what is left.
    #[inline]
    pub fn finish<L: Demands>(&mut self, forgotten: impl FnMut(usize, u32, &Memory<V>)) {
        let nobody = self.of::<L>(u32::MAX as usize, u32::MAX, forgotten);
        debug_assert!(nobody.is_none(), "no particle has the largest index");
    }
}
