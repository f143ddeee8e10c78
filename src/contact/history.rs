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
use crate::contact::{Demands, Memory};
use crate::particle::GrainId;
use crate::space::{Plane, Space};

/// Rows of a page: what a force pass does at a time, on however many threads.
pub const BLOCK: usize = 1024;

/// Memories of the contacts of consecutive rows.
#[derive(Clone, Debug)]
pub struct Pages<V: Space> {
    ends: Vec<u32>,
    partner: Vec<u32>,
    spring: Vec<V>,
    rolling: Vec<V>,
    stiffness: Vec<f64>,
    /// What sliding and rolling took in these rows, J.
    pub lost: [f64; 2],
}

impl<V: Space> Default for Pages<V> {
    fn default() -> Self {
        Self {
            ends: Vec::new(),
            partner: Vec::new(),
            spring: Vec::new(),
            rolling: Vec::new(),
            stiffness: Vec::new(),
            lost: [0.0; 2],
        }
    }
}

impl<V: Space> Pages<V> {
    /// Makes them empty.
    pub fn clear(&mut self) {
        self.ends.clear();
        self.partner.clear();
        self.spring.clear();
        self.rolling.clear();
        self.stiffness.clear();
        self.lost = [0.0; 2];
    }

    fn row(&self, row: usize) -> std::ops::Range<usize> {
        let end = |row: usize| self.ends.get(row).map_or(self.partner.len(), |&end| end as usize);
        (if row == 0 { 0 } else { end(row - 1) })..end(row)
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

    /// Adds a contact of `row`, which is not before the last one's; rows between the two have none.
    #[inline]
    pub fn push<L: Demands>(&mut self, row: usize, partner: u32, memory: &Memory<V>) {
        self.end_rows(row);
        self.partner.push(partner);
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

    /// Ends all rows before `row`.
    #[inline]
    #[expect(clippy::cast_possible_truncation, reason = "fewer than 2^32 contacts")]
    pub fn end_rows(&mut self, row: usize) {
        while self.ends.len() < row {
            self.ends.push(self.partner.len() as u32);
        }
    }

    /// The memory of the contact of `row` with `partner`.
    #[must_use]
    pub fn look_up(&self, row: usize, partner: u32) -> Option<Memory<V>> {
        let row = self.row(row);
        let at = self.partner[row.clone()].binary_search(&partner).ok()?;
        Some(self.any_memory(row.start + at))
    }

    /// Every contact: row, partner, memory.
    fn contacts(&self) -> impl Iterator<Item = (usize, u32, Memory<V>)> {
        (0..self.ends.len())
            .flat_map(move |row| self.row(row).map(move |at| (row, self.partner[at], self.any_memory(at))))
    }
}

/// Walks along earlier pages while the kernel comes by in ascending order of rows and partners.
#[derive(Clone, Copy)]
pub struct Recall<'a, V: Space> {
    pages: &'a Pages<V>,
    row: usize,
    at: usize,
}

impl<'a, V: Space> Recall<'a, V> {
    /// At the start.
    #[must_use]
    pub fn new(pages: &'a Pages<V>) -> Self {
        Self { pages, row: 0, at: 0 }
    }

    /// The contact that comes next, unless it is beyond this one.
    #[inline]
    fn next_up_to(&mut self, row: usize, partner: u32) -> Option<(usize, u32)> {
        let next = *self.pages.partner.get(self.at)?;
        while self.pages.ends[self.row] as usize <= self.at {
            self.row += 1;
        }
        (self.row < row || (self.row == row && next <= partner)).then_some((self.row, next))
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
        while let Some(next) = self.next_up_to(row, partner) {
            let memory = self.pages.memory::<L>(self.at);
            self.at += 1;
            if next == (row, partner) {
                return Some(memory);
            }
            forgotten(next.0, next.1, &memory);
        }
        None
    }

    /// Passes over what is left up to the end of `row`.
    #[inline]
    pub fn finish<L: Demands>(&mut self, row: usize, forgotten: impl FnMut(usize, u32, &Memory<V>)) {
        let nobody = self.of::<L>(row, u32::MAX, forgotten);
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
        self.now.iter_mut().for_each(|pages| pages.end_rows(BLOCK));
        self.walls[0].clear();
        for (i, wall, memory) in &walls {
            self.walls[0].push::<L>(*i as usize, *wall, memory);
        }
        self.walls[0].end_rows(columns.len());
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
        for pages in pages {
            pages.end_rows(BLOCK);
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
        recall.finish::<Springs>(BLOCK, |_, _, _| panic!("they are at their end"));
        assert_eq!(forgotten, [(0, 3), (1, 2)]);
        Recall::new(&before[0]).finish::<Springs>(0, |row, partner, _| forgotten.push((row, partner)));
        assert_eq!(forgotten[2..], [(0, 1), (0, 3)]);
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
        let kept: usize = history.now.iter().map(|pages| pages.partner.len()).sum();
        assert_eq!(kept, 3);
    }
}
