//! What contacts remember, from step to step.
//!
//! Each force pass writes the memories of the contacts that it finds into new pages, reading those of the pass
//! before. So a memory lives exactly as long as its contact, whatever the neighbour search does; and a contact that
//! ends is forgotten. A contact stands once, in the row of its lower member and as seen from it. Rows are particles in the
//! order of the columns, each with its partners in ascending order: the order in which the kernel comes by, so that looking
//! up is walking along. Pages have [`BLOCK`] rows each, so that threads write pages of their own while all read those of
//! the pass before. When slots are dealt out anew, pages are rewritten by the names of the particles, which do not change.
//! Columns that the law does not demand stay empty.

mod pages;

use std::collections::HashMap;

use bevy_ecs::prelude::*;

pub use self::pages::{Pages, Recall};
use crate::columns::Columns;
use crate::contact::{Demands, Memory};
use crate::particle::GrainId;
use crate::space::{Plane, Space};

/// Rows of a page: what a force pass does at a time, on however many threads.
pub const BLOCK: usize = 1024;

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
        if self.now.iter().chain(&self.walls[..1]).all(Pages::is_empty) {
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
    use crate::neighbours::list::Candidate;

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

    /// The first page of four particles with four contacts.
    fn page() -> Pages<Plane> {
        let mut history = History::default();
        let four = columns(&[1, 2, 3, 4], 1);
        history.follow::<Springs>(&four);
        write(&mut history, &four, &[(0, 1, 0.1), (0, 3, 0.3), (1, 2, 1.2), (2, 3, 2.3)]);
        history.turn(&four).0[0].clone()
    }

    #[test]
    fn pages_are_recalled_in_passing() {
        let page = page();
        let mut forgotten = Vec::new();
        let mut recall = Recall::new(&page);
        assert_eq!(recall.of::<Springs>(0, 1, |_, _, _| panic!("nothing ended")), Some(memory(0.1)));
        assert_eq!(recall.of::<Springs>(0, 2, |_, _, _| panic!("nothing ended")), None);
        // Row 1 is passed over as a whole.
        assert_eq!(recall.of::<Springs>(2, 3, |row, partner, _| forgotten.push((row, partner))), Some(memory(2.3)));
        recall.finish::<Springs>(|_, _, _| panic!("they are at their end"));
        assert_eq!(forgotten, [(0, 3), (1, 2)]);
        let mut recall = Recall::new(&page);
        assert_eq!(recall.of::<Springs>(0, 3, |row, partner, _| forgotten.push((row, partner))), Some(memory(0.3)));
        recall.finish::<Springs>(|row, partner, _| forgotten.push((row, partner)));
        assert_eq!(forgotten[2..], [(0, 1), (1, 2), (2, 3)]);
    }

    #[test]
    fn contacts_that_all_last_are_recalled_together() {
        let page = page();
        let mut recall = Recall::new(&page);
        let mut springs = |pairs: &[Candidate]| {
            recall
                .of_all::<Springs>(0, pairs)
                .map(|memories| memories.map(|memory| memory.spring.x).collect::<Vec<_>>())
        };
        // A new one among them, one that has ended, more than there are: then one by one.
        assert_eq!(springs(&[[0, 1], [0, 2]]), None);
        assert_eq!(springs(&[[0, 3]]), None);
        assert_eq!(springs(&[[0, 1], [0, 3], [1, 2], [2, 3], [3, 4]]), None);
        assert_eq!(springs(&[[0, 1], [0, 3]]), Some(vec![0.1, 0.3]));
        assert_eq!(springs(&[[1, 2]]), Some(vec![1.2]));
        assert_eq!(recall.of::<Springs>(2, 3, |_, _, _| panic!("nothing ended")), Some(memory(2.3)));
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
        let kept: usize = history.now.iter().map(Pages::len).sum();
        assert_eq!(kept, 3);
    }
}
