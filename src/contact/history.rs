//! What contacts remember, from step to step.
//!
//! Each force pass writes the memories of the contacts that it finds into new pages, reading those of the pass
//! before. So a memory lives exactly as long as its contact, whatever the neighbour search does; and a contact that
//! ends is forgotten. A contact stands once, in the row of its lower member and as seen from it. Rows are particles in the
//! order of the columns, each with its partners in ascending order: the order in which the kernel comes by, so that looking
//! up is walking along. Pages have [`BLOCK`] rows each, so that threads write pages of their own while all read those of
//! the pass before. When slots are dealt out anew, pages are rewritten by the names of the particles, which do not change.
//! Columns that the law does not demand stay empty.

use std::collections::HashMap;

use bevy_ecs::prelude::*;

use crate::columns::Columns;
use crate::contact::batch::MemoryLanes;
use crate::contact::lanes::LANES;
use crate::contact::{Demands, Memory};
use crate::neighbours::list::Candidate;
use crate::particle::GrainId;
use crate::space::{Plane, Space};

/// Rows of a page: what a force pass does at a time, on however many threads.
pub const BLOCK: usize = 1024;

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
    pub(super) fn begin<L: Demands>(&mut self, earlier: &Self) {
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
    pub(super) fn extend<L: Demands>(&mut self, first: usize, pairs: &[Candidate], memories: &MemoryLanes<V>) {
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

    /// The memory of the contact of `row` with `partner`.
    #[must_use]
    pub fn look_up(&self, row: usize, partner: u32) -> Option<Memory<V>> {
        Some(self.any_memory(self.keys.binary_search(&key(row, partner)).ok()?))
    }

    /// Every contact: row, partner, memory.
    fn contacts(&self) -> impl Iterator<Item = (usize, u32, Memory<V>)> {
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
    pub(super) fn of_all<L: Demands>(
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

/// The memories of all contacts between particles, and of those with flat walls.
#[derive(Resource, Clone, Debug)]
pub struct History<V: Space = Plane> {
    /// Between particles, page by page.
    now: Vec<Pages<V>>,
    before: Vec<Pages<V>>,
    /// With flat walls, the partner being the wall's index; all rows together.
    walls: [Pages<V>; 2],
    names: Vec<GrainId>,
    generation: u64,
}

impl<V: Space> Default for History<V> {
    fn default() -> Self {
        Self { now: Vec::new(), before: Vec::new(), walls: Default::default(), names: Vec::new(), generation: 0 }
    }
}

impl<V: Space> History<V> {
    /// The memory of a contact between entries i and j of the columns, as seen from the lower one.
    #[must_use]
    pub fn of_pair(&self, i: usize, j: usize) -> Option<Memory<V>> {
        let (low, high) = (i.min(j), i.max(j));
        self.now.get(low / BLOCK)?.look_up(low % BLOCK, u32::try_from(high).ok()?)
    }

    /// The memory of the contact of entry i with a flat wall.
    #[must_use]
    pub fn of_wall(&self, i: usize, wall: usize) -> Option<Memory<V>> {
        self.walls[0].look_up(i, u32::try_from(wall).ok()?)
    }

    /// What sliding and rolling beyond their caps took in the last step, J.
    #[must_use]
    pub fn lost(&self) -> [f64; 2] {
        let pages = self.now.iter().chain([&self.walls[0]]);
        pages.fold([0.0; 2], |[sliding, rolling], pages| [sliding + pages.lost[0], rolling + pages.lost[1]])
    }

    /// Opens new pages for the particles of `columns`: those to read, and those to write.
    pub fn turn(&mut self, columns: &Columns<V>) -> (&[Pages<V>], &mut [Pages<V>]) {
        let blocks = columns.len().div_ceil(BLOCK);
        std::mem::swap(&mut self.now, &mut self.before);
        self.now.resize_with(blocks, Pages::default);
        self.before.resize_with(blocks, Pages::default);
        (&self.before, &mut self.now)
    }

    /// The same for flat walls.
    pub(crate) fn turn_walls(&mut self) -> (&Pages<V>, &mut Pages<V>) {
        self.walls.swap(0, 1);
        let [now, before] = &mut self.walls;
        now.clear();
        (before, now)
    }

    /// Follows the particles to the slots that they have in `columns`.
    pub(super) fn follow<L: Demands>(&mut self, columns: &Columns<V>) {
        if columns.generation == self.generation {
            return;
        }
        self.generation = columns.generation;
        if self.now.iter().chain(&self.walls[..1]).all(|pages| pages.keys.is_empty()) {
            self.names.clone_from(&columns.id);
            return;
        }
        let slots: HashMap<GrainId, u32> = columns.id.iter().copied().zip(0..).collect();
        let place = |old: usize| self.names.get(old).and_then(|name| slots.get(name)).copied();
        let mut pairs = Vec::new();
        for (block, pages) in self.now.iter().enumerate() {
            for (row, partner, mut memory) in pages.contacts() {
                if let (Some(i), Some(j)) = (place(block * BLOCK + row), place(partner as usize)) {
                    if i > j {
                        memory = memory.turned();
                    }
                    pairs.push((i.min(j), i.max(j), memory));
                }
            }
        }
        let on_walls = self.walls[0].contacts();
        let mut walls: Vec<_> = on_walls.filter_map(|(row, wall, memory)| Some((place(row)?, wall, memory))).collect();
        pairs.sort_unstable_by_key(|&(i, j, _)| (i, j));
        walls.sort_unstable_by_key(|&(i, wall, _)| (i, wall));
        self.now.clear();
        self.now.resize_with(columns.len().div_ceil(BLOCK), Pages::default);
        for (i, j, memory) in &pairs {
            self.now[*i as usize / BLOCK].push::<L>(*i as usize % BLOCK, *j, memory);
        }
        self.walls[0].clear();
        for (i, wall, memory) in &walls {
            self.walls[0].push::<L>(*i as usize, *wall, memory);
        }
        self.names.clone_from(&columns.id);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Springs;
    impl Demands for Springs {
        const SPIN: bool = true;
        const SPRING: bool = true;
    }

    fn columns(numbers: &[u32], generation: u64) -> Columns {
        let id = numbers.iter().map(|&number| GrainId::grain(number).unwrap()).collect();
        Columns { id, generation, ..Columns::default() }
    }

    fn memory(x: f64) -> Memory {
        Memory { spring: Plane::new(x, 0.0), ..Memory::default() }
    }

    /// Writes contacts (row, partner, spring), in ascending order.
    fn write(history: &mut History, columns: &Columns, contacts: &[(usize, u32, f64)]) {
        let (_, pages) = history.turn(columns);
        pages.iter_mut().for_each(Pages::clear);
        for &(row, partner, x) in contacts {
            pages[row / BLOCK].push::<Springs>(row % BLOCK, partner, &memory(x));
        }
    }

    #[test]
    fn pages_are_recalled_in_passing() {
        let mut history = History::default();
        let four = columns(&[1, 2, 3, 4], 1);
        history.follow::<Springs>(&four);
        write(&mut history, &four, &[(0, 1, 0.1), (0, 3, 0.3), (1, 2, 1.2), (2, 3, 2.3)]);
        let (before, _) = history.turn(&four);
        let mut forgotten = Vec::new();
        let mut recall = Recall::new(&before[0]);
        assert_eq!(recall.of::<Springs>(0, 1, |_, _, _| panic!("nothing ended")), Some(memory(0.1)));
        assert_eq!(recall.of::<Springs>(0, 2, |_, _, _| panic!("nothing ended")), None);
        // Row 1 is passed over as a whole.
        assert_eq!(recall.of::<Springs>(2, 3, |row, partner, _| forgotten.push((row, partner))), Some(memory(2.3)));
        recall.finish::<Springs>(|_, _, _| panic!("they are at their end"));
        assert_eq!(forgotten, [(0, 3), (1, 2)]);
        let mut recall = Recall::new(&before[0]);
        assert_eq!(recall.of::<Springs>(0, 3, |row, partner, _| forgotten.push((row, partner))), Some(memory(0.3)));
        recall.finish::<Springs>(|row, partner, _| forgotten.push((row, partner)));
        assert_eq!(forgotten[2..], [(0, 1), (1, 2), (2, 3)]);
    }

    #[test]
    fn memories_follow_their_particles() {
        let old: Vec<u32> = (0..3000).map(|n| 10 * n).collect();
        let before = columns(&old, 1);
        let mut history = History::default();
        history.follow::<Springs>(&before);
        write(&mut history, &before, &[(0, 1, 0.1), (1, 2999, 1.5), (1023, 1024, 2.5), (1500, 1501, 5.2)]);
        // Grain 0 goes, two come, and the order is turned round: who was the lower one is the upper one.
        let new: Vec<u32> = [5, 7].into_iter().chain(old[1..].iter().rev().copied()).collect();
        let after = columns(&new, 2);
        history.follow::<Springs>(&after);
        let slot = |name: u32| new.iter().position(|&other| other == name).unwrap();
        let spring = |a: u32, b: u32| history.of_pair(slot(a), slot(b)).map(|memory| memory.spring.x);
        assert_eq!(spring(10, 29990), Some(-1.5));
        assert_eq!(spring(10230, 10240), Some(-2.5));
        assert_eq!(spring(15000, 15010), Some(-5.2));
        assert_eq!(spring(5, 10), None);
        let kept: usize = history.now.iter().map(|pages| pages.keys.len()).sum();
        assert_eq!(kept, 3);
    }
}
