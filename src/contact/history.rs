//! What contacts remember, from step to step.
//!
//! Each force pass writes the memories of the contacts that it finds into new pages, reading those of the pass
//! before. So a memory lives exactly as long as its contact, whatever the neighbour search does; and a contact that
//! ends is forgotten. Rows are particles in the order of the columns, each with its partners in ascending order: the
//! order in which the kernel comes by, so that looking up is walking along. When slots are dealt out anew, pages are
//! rewritten by the names of the particles, which do not change.
//!
//! On one thread a contact stands once, in the row of its lower member and as seen from it; on several threads, in
//! both rows, each from its own side, so that no thread writes what another one reads. Pages are split into books of
//! [`CHUNK`] rows then. Columns that the law does not demand stay empty.

use bevy_ecs::prelude::*;

use crate::contact::{Demands, Memory};
use crate::particle::GrainId;
use crate::space::{Plane, Space};

/// Rows of a book, where there are several.
pub const CHUNK: usize = 256;

/// Memories of the contacts of consecutive rows.
#[derive(Clone, Debug)]
pub struct Pages<V: Space> {
    ends: Vec<u32>,
    partner: Vec<u32>,
    spring: Vec<V>,
    rolling: Vec<V>,
    stiffness: Vec<f64>,
}

impl<V: Space> Default for Pages<V> {
    fn default() -> Self {
        Self { ends: Vec::new(), partner: Vec::new(), spring: Vec::new(), rolling: Vec::new(), stiffness: Vec::new() }
    }
}

impl<V: Space> Pages<V> {
    fn clear(&mut self) {
        self.ends.clear();
        self.partner.clear();
        self.spring.clear();
        self.rolling.clear();
        self.stiffness.clear();
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

    /// Adds the contact with `partner` to the row that is being written.
    #[inline]
    pub fn push<L: Demands>(&mut self, partner: u32, memory: &Memory<V>) {
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

    fn push_from(&mut self, other: &Self, at: usize, partner: u32) {
        self.partner.push(partner);
        self.spring.extend(other.spring.get(at));
        self.rolling.extend(other.rolling.get(at));
        self.stiffness.extend(other.stiffness.get(at));
    }

    /// Ends the row that is being written.
    #[inline]
    #[expect(clippy::cast_possible_truncation, reason = "fewer than 2^32 contacts")]
    pub fn end_row(&mut self) {
        self.ends.push(self.partner.len() as u32);
    }
}

/// The pages of now and of the pass before.
#[derive(Clone, Debug)]
pub struct Book<V: Space> {
    now: Pages<V>,
    before: Pages<V>,
}

impl<V: Space> Default for Book<V> {
    fn default() -> Self {
        Self { now: Pages::default(), before: Pages::default() }
    }
}

impl<V: Space> Book<V> {
    /// Opens new pages: those to read, and those to write.
    pub fn turn(&mut self) -> (&Pages<V>, &mut Pages<V>) {
        std::mem::swap(&mut self.now, &mut self.before);
        self.now.clear();
        (&self.before, &mut self.now)
    }

    /// The memory of the contact of `row` with `partner`.
    #[must_use]
    pub fn look_up(&self, row: usize, partner: u32) -> Option<Memory<V>> {
        let row = self.now.row(row);
        let at = self.now.partner[row.clone()].binary_search(&partner).ok()?;
        Some(self.now.any_memory(row.start + at))
    }
}

/// Walks along a row of earlier pages while the kernel asks for partners in ascending order.
pub struct Recall<'a, V: Space> {
    pages: &'a Pages<V>,
    at: usize,
    end: usize,
}

impl<'a, V: Space> Recall<'a, V> {
    /// At the start of a row.
    #[must_use]
    pub fn new(pages: &'a Pages<V>, row: usize) -> Self {
        let range = pages.row(row);
        Self { pages, at: range.start, end: range.end }
    }

    /// What the contact with `partner` remembers; nothing, if it is new. Contacts that are passed over have ended:
    /// `forgotten` gets their partners and memories.
    #[inline]
    #[must_use]
    pub fn of<L: Demands>(&mut self, partner: u32, mut forgotten: impl FnMut(u32, &Memory<V>)) -> Memory<V> {
        while self.at < self.end && self.pages.partner[self.at] < partner {
            forgotten(self.pages.partner[self.at], &self.pages.memory::<L>(self.at));
            self.at += 1;
        }
        if self.at < self.end && self.pages.partner[self.at] == partner {
            self.at += 1;
            self.pages.memory::<L>(self.at - 1)
        } else {
            Memory::default()
        }
    }

    /// Passes over what is left of the row.
    #[inline]
    pub fn finish<L: Demands>(&mut self, mut forgotten: impl FnMut(u32, &Memory<V>)) {
        for at in self.at..self.end {
            forgotten(self.pages.partner[at], &self.pages.memory::<L>(at));
        }
        self.at = self.end;
    }
}

/// The memories of all contacts between particles, and of those with flat walls.
#[derive(Resource, Clone, Debug)]
pub struct History<V: Space = Plane> {
    /// Between particles; empty for a law without memory.
    pub(super) pairs: Vec<Book<V>>,
    /// With flat walls, the partner being the wall's index; one book for all rows.
    pub(crate) walls: Book<V>,
    names: Vec<GrainId>,
    generation: u64,
}

impl<V: Space> Default for History<V> {
    fn default() -> Self {
        Self { pairs: vec![Book::default()], walls: Book::default(), names: Vec::new(), generation: 0 }
    }
}

impl<V: Space> History<V> {
    /// The memory of a contact between entries i and j of the columns, as seen from the lower one.
    #[must_use]
    pub fn of_pair(&self, i: usize, j: usize) -> Option<Memory<V>> {
        let (low, high) = (i.min(j), i.max(j));
        let (book, row) =
            if self.pairs.len() > 1 { (self.pairs.get(low / CHUNK)?, low % CHUNK) } else { (&self.pairs[0], low) };
        book.look_up(row, u32::try_from(high).ok()?)
    }

    /// The memory of the contact of entry i with a flat wall.
    #[must_use]
    pub fn of_wall(&self, i: usize, wall: usize) -> Option<Memory<V>> {
        self.walls.look_up(i, u32::try_from(wall).ok()?)
    }

    /// Follows the particles to the slots that they have in `names`, and provides `books` books.
    pub(super) fn follow(&mut self, names: &[GrainId], generation: u64, books: usize) {
        if generation == self.generation {
            return;
        }
        self.generation = generation;
        // Both lists ascend: the new place of each old row, if it still has one.
        let mut places = Vec::with_capacity(self.names.len());
        let mut next = 0;
        for name in &self.names {
            while names.get(next).is_some_and(|other| other < name) {
                next += 1;
            }
            places.push((names.get(next) == Some(name)).then(|| u32::try_from(next).expect("fewer than 2^32")));
        }
        let size = if self.pairs.len() > 1 { CHUNK } else { usize::MAX };
        let old = self.pairs.iter().enumerate().map(|(number, book)| (number.saturating_mul(size), &book.now));
        let sizes = if books > 1 { CHUNK } else { names.len().max(1) };
        self.pairs = moved(old, &places, names.len(), sizes, |partner| places[partner as usize]);
        self.pairs.resize_with(books.max(1), Book::default);
        let walls = moved([(0, &self.walls.now)].into_iter(), &places, names.len(), names.len().max(1), Some);
        self.walls = walls.into_iter().next().unwrap_or_default();
        self.names = names.to_vec();
    }
}

/// Pages with rows and partners in new places, cut into books of `size` rows.
fn moved<'a, V: Space>(
    old: impl Iterator<Item = (usize, &'a Pages<V>)>,
    places: &[Option<u32>],
    rows: usize,
    size: usize,
    partner: impl Fn(u32) -> Option<u32>,
) -> Vec<Book<V>> {
    let mut books: Vec<Book<V>> = Vec::new();
    let mut written = 0;
    let mut write_up_to = |row: usize, books: &mut Vec<Book<V>>| {
        for row in written..=row {
            if books.len() <= row / size {
                books.push(Book::default());
            }
            if row > written {
                books[(row - 1) / size].now.end_row();
            }
        }
        written = row;
    };
    for (first, pages) in old {
        for row in 0..pages.ends.len() {
            let Some(place) = places.get(first + row).copied().flatten() else { continue };
            write_up_to(place as usize, &mut books);
            let target = &mut books[place as usize / size].now;
            for at in pages.row(row) {
                if let Some(partner) = partner(pages.partner[at]) {
                    target.push_from(pages, at, partner);
                }
            }
        }
    }
    write_up_to(rows, &mut books);
    books
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Springs;
    impl Demands for Springs {
        const SPIN: bool = true;
        const SPRING: bool = true;
    }

    fn names(numbers: &[u32]) -> Vec<GrainId> {
        numbers.iter().map(|&number| GrainId::grain(number).unwrap()).collect()
    }

    fn memory(x: f64) -> Memory {
        Memory { spring: Plane::new(x, 0.0), ..Memory::default() }
    }

    /// Writes contacts (row, partner, spring) into the books.
    fn write(history: &mut History, rows: usize, contacts: &[(usize, u32, f64)]) {
        let size = if history.pairs.len() > 1 { CHUNK } else { rows };
        for (number, book) in history.pairs.iter_mut().enumerate() {
            let (_, pages) = book.turn();
            for row in number * size..((number + 1) * size).min(rows) {
                for &(_, partner, x) in contacts.iter().filter(|contact| contact.0 == row) {
                    pages.push::<Springs>(partner, &memory(x));
                }
                pages.end_row();
            }
        }
    }

    #[test]
    fn a_row_is_recalled_in_passing() {
        let mut history = History::default();
        history.follow(&names(&[1, 2, 3, 4]), 1, 1);
        write(&mut history, 4, &[(0, 1, 0.1), (0, 3, 0.3), (2, 3, 2.3)]);
        let (before, _) = history.pairs[0].turn();
        let mut forgotten = Vec::new();
        let mut recall = Recall::new(before, 0);
        assert_eq!(recall.of::<Springs>(1, |_, _| panic!("nothing ended")), memory(0.1));
        assert_eq!(recall.of::<Springs>(2, |_, _| panic!("nothing ended")), Memory::default());
        assert_eq!(recall.of::<Springs>(4, |partner, _| forgotten.push(partner)), Memory::default());
        recall.finish::<Springs>(|_, _| panic!("the row is at its end"));
        Recall::new(before, 2).finish::<Springs>(|partner, _| forgotten.push(partner + 10));
        assert_eq!(forgotten, [3, 13]);
    }

    #[test]
    fn memories_follow_their_particles() {
        for books in [1, 3] {
            let mut history = History::default();
            let old: Vec<u32> = (0..600).map(|n| 10 * n).collect();
            history.follow(&names(&old), 1, books);
            write(&mut history, 600, &[(0, 1, 0.1), (1, 599, 1.5), (255, 256, 2.5), (599, 2, 5.2)]);
            // Grain 0 goes, grain 5 comes between the first two, 20 stays: all slots but the first are the same again,
            // then 7 grains come at the start of the second book.
            let mut new: Vec<u32> = old[1..].iter().copied().chain([5, 2551, 2552]).collect();
            new.sort_unstable();
            history.follow(&names(&new), 2, books);
            let slot = |name: u32| new.binary_search(&name).unwrap();
            let spring = |a: u32, b: u32| {
                let (i, j) = (slot(a), u32::try_from(slot(b)).unwrap());
                let (book, row) = if books > 1 { (i / CHUNK, i % CHUNK) } else { (0, i) };
                history.pairs[book].look_up(row, j).map(|memory| memory.spring.x)
            };
            assert_eq!(spring(10, 5990), Some(1.5), "{books} books");
            assert_eq!(spring(2550, 2560), Some(2.5), "{books} books");
            assert_eq!(spring(5990, 20), Some(5.2), "{books} books");
            assert_eq!(spring(5, 10), None, "{books} books");
            assert_eq!(history.pairs.len(), books);
        }
    }
}
