//! Neighbour list: candidate pairs in ascending order, and their division into tasks for threads.
//!
//! The list is flat and stores both members of each pair, so that iterating over it needs no lookups. A row is the set
//! of pairs with the same higher slot. Rows are grouped into blocks. A thread evaluates the pairs of the rows of a [`Task`].
//!
//! A pair is in the row of its higher slot. A particle therefore gets the forces of the partners in lower slots first, in its own row, and then
//! those of the partners in higher slots, row by row. If that is another task's row, the force comes last. So each particle sums its
//! partners in ascending order of slots on any number of threads, and each pair is evaluated once.

mod marks;

use std::ops::Range;

use self::marks::Marks;
use crate::nearly_sorted::sort_into;

/// Rows of a block. A force pass processes one block at a time, on any number of threads.
pub const BLOCK: usize = 128;

pub use self::marks::Chosen;
pub use crate::neighbours::candidate::{Candidate, are_same};

/// List of all candidate pairs.
#[derive(Debug, Default)]
pub struct PairList {
    pairs: Vec<Candidate>,
    /// Start of each row in `pairs`; scratch of the list's construction.
    starts: Vec<u32>,
    /// The row that is being written.
    row: u32,
    blocks: Vec<Block>,
    tasks: Vec<Task>,
    /// Number of changes of the list.
    version: u64,
    marks: Marks,
}

/// The pairs of a block of rows.
#[derive(Clone, Copy, Debug)]
struct Block {
    /// The end of the pairs in the list.
    pairs_end: usize,
    /// The lowest slot of the pairs; the largest number if there are none.
    lowest: usize,
}

/// Rows whose pairs one thread evaluates.
#[derive(Debug, Default, Clone)]
pub struct Task {
    /// Rows of the task.
    pub rows: Range<usize>,
    /// The lowest slot in pairs of these rows, if it is before `rows`; else the first row.
    pub lowest: usize,
    /// The end of the last block with a slot before `rows`; the first row if there is none.
    pub reaching_end: usize,
}

impl PairList {
    /// Returns all candidates.
    #[must_use]
    pub fn pairs(&self) -> &[Candidate] {
        &self.pairs
    }

    /// Returns the candidates of block `number`, and their lowest slot.
    #[must_use]
    pub fn block(&self, number: usize) -> (&[Candidate], usize) {
        let start = if number == 0 { 0 } else { self.blocks[number - 1].pairs_end };
        let Block { pairs_end, lowest } = self.blocks[number];
        (&self.pairs[start..pairs_end], lowest)
    }

    /// Returns the tasks of the threads.
    #[must_use]
    pub fn tasks(&self) -> &[Task] {
        &self.tasks
    }

    /// Empties the list.
    pub(super) fn clear(&mut self) {
        self.pairs.clear();
        self.row = 0;
    }

    /// Adds the partner in the lower slot `i` to the row that is being written.
    #[inline]
    pub(super) fn push(&mut self, i: u32) {
        self.pairs.push(Candidate::new(self.row, i));
    }

    /// Ends the row that is being written and sorts it.
    pub(super) fn end_row(&mut self) {
        let written = self.pairs.iter().rposition(|pair| pair.row() != self.row as usize).map_or(0, |last| last + 1);
        self.pairs[written..].sort_unstable();
        self.row += 1;
    }

    /// Replaces the list by `pairs` of `rows` particles, given in any order. The new list has no marks.
    pub(crate) fn fill(&mut self, pairs: impl Iterator<Item = Candidate> + Clone, rows: usize) {
        self.starts.clear();
        self.starts.resize(rows + 1, 0);
        pairs.clone().for_each(|pair| self.starts[pair.row() + 1] += 1);
        for row in 0..rows {
            self.starts[row + 1] += self.starts[row];
        }
        let count = self.starts[rows] as usize;
        self.make_room(count);
        self.pairs.resize(count, Candidate::default());
        // Filling moves each start to the start of the next row.
        pairs.for_each(|pair| {
            let place = &mut self.starts[pair.row()];
            self.pairs[*place as usize] = pair.unmarked();
            *place += 1;
        });
        let mut start = 0;
        for &end in &self.starts[..rows] {
            let row = &mut self.pairs[start..end as usize];
            // Most rows are sorted already.
            if !row.is_sorted() {
                row.sort_unstable();
            }
            start = end as usize;
        }
    }

    /// Replaces the list by the pairs of `parts`, nearly all of them in ascending order. The new list has no marks.
    pub(super) fn replace(&mut self, parts: &[Vec<Candidate>]) {
        self.make_room(parts.iter().map(Vec::len).sum());
        sort_into(&mut self.pairs, parts.iter().flatten().map(|pair| pair.unmarked()), |pair| *pair);
    }

    /// Empties the list and reserves memory for `count` pairs.
    fn make_room(&mut self, count: usize) {
        self.pairs.clear();
        if count > self.pairs.capacity() {
            // The number of candidates changes little. A vector that grows by itself would double, and keep its old memory meanwhile.
            self.pairs = Vec::new();
            self.pairs.reserve_exact(count + count / 16);
        }
    }

    /// Marks the pairs that contain a chosen particle, and no others.
    pub fn mark(&mut self, chosen: Chosen<'_>) {
        self.marks.mark(self.version, &mut self.pairs, chosen);
    }

    /// Assigns `rows` rows to at most `threads` tasks, in whole blocks of `size` rows. Tasks have about equal work: rows and pairs. The work of a
    /// row without pairs is taken for that of a pair.
    pub(crate) fn assign_tasks(&mut self, rows: usize, threads: usize, size: usize) {
        self.version += 1;
        let mut start = 0;
        self.blocks.clear();
        self.blocks.extend((1..=rows.div_ceil(size)).map(|number| {
            let pairs_end = start + self.pairs[start..].partition_point(|pair| pair.row() < number * size);
            let lowest = self.pairs[start..pairs_end].iter().map(|pair| pair.partner()).min().unwrap_or(usize::MAX);
            start = pairs_end;
            Block { pairs_end, lowest }
        }));
        let work: Vec<_> = (1..).zip(&self.blocks).map(|(number, block)| block.pairs_end + number * size).collect();
        self.tasks.clear();
        let mut begin = 0;
        for end in divide(&work, threads.min(work.len()).max(1), size) {
            let blocks = &self.blocks[begin / size..end / size];
            let lowest = blocks.iter().fold(begin, |lowest, block| lowest.min(block.lowest));
            let last = blocks.iter().rposition(|block| block.lowest < begin);
            let reaching_end = begin + last.map_or(0, |last| (last + 1) * size);
            self.tasks.push(Task { rows: begin..end.min(rows), lowest, reaching_end });
            begin = end;
        }
    }
}

/// Divides blocks of `size` rows among so many tasks by the ascending sums `work` of their rows and pairs. Returns the ends of the tasks in rows.
fn divide(work: &[usize], tasks: usize, size: usize) -> impl Iterator<Item = usize> {
    let all = work.last().copied().unwrap_or(0);
    let mut end = 0;
    (1..=tasks).map(move |number| {
        let border = nearest(work, number * all / tasks);
        // Each task has at least one block, and leaves one to each that follows.
        let most = work.len() - (tasks - number).min(work.len());
        end = border.clamp((end + 1).min(most), most);
        end * size
    })
}

/// Returns how many of the ascending sums `work` are before the border that is nearest to `target`.
fn nearest(work: &[usize], target: usize) -> usize {
    let below = work.partition_point(|&sum| sum <= target);
    let before = below.checked_sub(1).map_or(0, |last| work[last]);
    let is_next_nearer = work.get(below).is_some_and(|&next| next - target < target - before);
    below + usize::from(is_next_nearer)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all<const N: usize>(pairs: [[u32; 2]; N]) -> [Candidate; N] {
        pairs.map(Candidate::from)
    }

    #[test]
    fn a_list_that_grows_a_little_keeps_little_spare_memory() {
        let mut list = PairList::default();
        for count in [1000, 1100, 900, 1150] {
            list.fill((0..count).map(|i| Candidate::new(count, i)), count as usize + 1);
            assert_eq!(list.pairs().len(), count as usize);
        }
        assert!(list.pairs.capacity() <= 1250, "{}", list.pairs.capacity());
    }

    #[test]
    fn pairs_are_sorted_in_whichever_order_they_are_added() {
        let mut filled = PairList::default();
        filled.fill(all([[3, 0], [3, 2], [1, 0], [2, 1]]).into_iter(), 4);
        let mut written = PairList::default();
        for row in [&[][..], &[0], &[1], &[2, 0]] {
            for &i in row {
                written.push(i);
            }
            written.end_row();
        }
        for list in [filled, written] {
            assert_eq!(list.pairs(), all([[1, 0], [2, 1], [3, 0], [3, 2]]));
        }
    }

    #[test]
    fn tasks_cover_all_rows_and_know_how_far_down_they_reach() {
        let mut list = PairList::default();
        list.fill(all([[3, 1], [3, 2], [5, 0], [5, 3], [5, 4]]).into_iter(), 6);
        let tasks = |list: &PairList| -> Vec<_> {
            list.tasks().iter().map(|task| (task.rows.clone(), task.lowest, task.reaching_end)).collect()
        };
        list.assign_tasks(6, 3, 2);
        assert_eq!(tasks(&list), [(0..2, 0, 0), (2..4, 1, 4), (4..6, 0, 6)]);
        assert_eq!(list.block(1), (&all([[3, 1], [3, 2]])[..], 1));
        // With more threads than blocks there is one task per block.
        list.assign_tasks(6, 8, 4);
        assert_eq!(tasks(&list), [(0..4, 0, 0), (4..6, 0, 8)]);
        list.assign_tasks(6, 1, 4);
        assert_eq!(tasks(&list), [(0..6, 0, 0)]);
        list.assign_tasks(0, 3, 4);
        assert_eq!(tasks(&list), [(0..0, 0, 0)]);
        // A task without pairs, and one that reaches no other.
        list.fill(all([[4, 1], [5, 4]]).into_iter(), 6);
        list.assign_tasks(6, 3, 2);
        assert_eq!(tasks(&list), [(0..2, 0, 0), (2..4, 2, 2), (4..6, 1, 6)]);
    }

    #[test]
    fn tasks_share_work_and_none_is_empty() {
        let rows = |pairs: &[(u32, u32)], threads: usize| {
            let mut list = PairList::default();
            // So many pairs of a row, with any partner.
            let row = |&(row, count): &(u32, u32)| (0..count).map(move |_| Candidate::new(row, 0));
            list.fill(pairs.iter().flat_map(row), 12);
            list.assign_tasks(12, threads, 2);
            list.tasks().iter().map(|task| task.rows.clone()).collect::<Vec<_>>()
        };
        assert_eq!(rows(&[], 3), [0..4, 4..8, 8..12]);
        assert_eq!(rows(&[(1, 16), (7, 4)], 2), [0..2, 2..12]);
        assert_eq!(rows(&[(1, 16), (7, 16)], 2), [0..6, 6..12]);
        assert_eq!(rows(&[(10, 40)], 3), [0..8, 8..10, 10..12]);
        assert_eq!(rows(&[(1, 40)], 3), [0..2, 2..4, 4..12]);
    }

    #[test]
    fn tasks_have_equal_numbers_of_pairs() {
        // A strip: each row has pairs with the 20 before it. Blocks of 4 rows.
        let row = |j: u32| (j.saturating_sub(20)..j).map(move |i| Candidate::new(j, i));
        for threads in [2, 3, 5, 8] {
            let mut list = PairList::default();
            list.fill((0..400).flat_map(row), 400);
            list.assign_tasks(400, threads, 4);
            let own = |task: &Task| list.pairs().iter().filter(|pair| task.rows.contains(&pair.row())).count();
            let work: Vec<_> = list.tasks().iter().map(|task| task.rows.len() + own(task)).collect();
            // A border may be off by half a block.
            let [least, most] = [work.iter().min().unwrap(), work.iter().max().unwrap()];
            assert!(most - least <= 4 * 21, "{threads}: {work:?}");
        }
    }
}
