//! Neighbour list: candidate pairs in ascending order, the lower slot first; and their division into tasks for threads.
//!
//! The list is flat and stores both members of each pair, so that iterating over it needs no lookups. A row is the set
//! of pairs with one first member. Rows are grouped into blocks. A thread sums the rows of a [`Task`] and adds the
//! force of each pair to both members.
//!
//! A pair whose members belong to two tasks is evaluated twice. The task of the second member evaluates it too, before
//! its own rows, as an `incoming` pair. So each particle sums its partners in ascending order of slots on any
//! number of threads.

mod marks;

use std::ops::Range;

use self::marks::Marks;

/// How often a division among threads is corrected for the pairs that two threads evaluate.
const CORRECTIONS: usize = 2;

/// Rows of a block. A force pass processes one block at a time, on any number of threads.
pub const BLOCK: usize = 256;

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
    /// The [end of their slots](end_of).
    slots_end: usize,
}

/// Rows and pairs that one thread sums.
#[derive(Debug, Default, Clone)]
pub struct Task {
    /// Rows of the task.
    pub rows: Range<usize>,
    /// Pairs (i, j) with i before `rows` and j in `rows`, ascending.
    pub incoming: Vec<Candidate>,
}

/// Returns one more than the largest slot in `pairs`; 0 if there are none.
#[must_use]
pub fn end_of(pairs: &[Candidate]) -> usize {
    pairs.iter().map(|pair| pair.second() + 1).max().unwrap_or(0)
}

impl PairList {
    /// Returns all candidates.
    #[must_use]
    pub fn pairs(&self) -> &[Candidate] {
        &self.pairs
    }

    /// Returns the candidates of block `number`, and the [end](end_of) of their slots.
    #[must_use]
    pub fn block(&self, number: usize) -> (&[Candidate], usize) {
        let start = if number == 0 { 0 } else { self.blocks[number - 1].pairs_end };
        let Block { pairs_end, slots_end } = self.blocks[number];
        (&self.pairs[start..pairs_end], slots_end)
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

    /// Adds a candidate with second member `j` to the row that is being written.
    #[inline]
    pub(super) fn push(&mut self, j: u32) {
        self.pairs.push(Candidate::new(self.row, j));
    }

    /// Ends the row that is being written and sorts it.
    pub(super) fn end_row(&mut self) {
        let written = self.pairs.iter().rposition(|pair| pair.first() != self.row as usize).map_or(0, |last| last + 1);
        self.pairs[written..].sort_unstable();
        self.row += 1;
    }

    /// Replaces the list by `pairs` of `rows` particles, given in any order. The new list has no marks.
    pub(crate) fn fill(&mut self, pairs: impl Iterator<Item = Candidate> + Clone, rows: usize) {
        self.starts.clear();
        self.starts.resize(rows + 1, 0);
        pairs.clone().for_each(|pair| self.starts[pair.first() + 1] += 1);
        for row in 0..rows {
            self.starts[row + 1] += self.starts[row];
        }
        let count = self.starts[rows] as usize;
        self.pairs.clear();
        if count > self.pairs.capacity() {
            // The number of candidates changes little. A vector that grows by itself would double, and keep its old memory meanwhile.
            self.pairs = Vec::new();
            self.pairs.reserve_exact(count + count / 16);
        }
        self.pairs.resize(count, Candidate::default());
        // Filling moves each start to the start of the next row.
        pairs.for_each(|pair| {
            let place = &mut self.starts[pair.first()];
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

    /// Marks the pairs that contain a chosen particle, and no others.
    pub fn mark(&mut self, chosen: Chosen<'_>) {
        let copies = self.tasks.iter_mut().map(|task| &mut task.incoming[..]);
        self.marks.mark(self.version, &mut self.pairs, copies, chosen);
    }

    /// Assigns `rows` rows to at most `threads` tasks, in whole blocks of `size` rows. Tasks have about equal work: rows, own pairs and incoming
    /// pairs. The work of a row without pairs is taken for that of a pair.
    pub(crate) fn assign_tasks(&mut self, rows: usize, threads: usize, size: usize) {
        self.version += 1;
        let pairs = &self.pairs;
        let row_of = |border: usize| pairs.partition_point(|pair| pair.first() < border);
        self.blocks.clear();
        let mut start = 0;
        self.blocks.extend((1..=rows.div_ceil(size)).map(|number| {
            let end = row_of(number * size);
            let block = &pairs[start..end];
            start = end;
            Block { pairs_end: end, slots_end: end_of(block) }
        }));
        let shares = threads.min(self.blocks.len()).max(1);
        let work: Vec<_> = (1..).zip(&self.blocks).map(|(number, block)| block.pairs_end + number * size).collect();
        // The division decides which pairs are incoming, so it is corrected by the numbers that it gave.
        let mut incoming = vec![0; shares];
        let mut ends = divide(&work, &incoming, size);
        for _ in 0..if shares > 1 { CORRECTIONS } else { 0 } {
            incoming.fill(0);
            for_each_incoming(&self.pairs, &ends, |task, _| incoming[task] += 1);
            ends = divide(&work, &incoming, size);
        }
        self.tasks.resize_with(shares, Task::default);
        let mut begin = 0;
        for (task, &end) in self.tasks.iter_mut().zip(&ends) {
            task.rows = begin..end.min(rows);
            task.incoming.clear();
            begin = end;
        }
        for_each_incoming(&self.pairs, &ends, |task, pair| self.tasks[task].incoming.push(pair));
    }
}

/// Divides blocks of `size` rows among tasks by the ascending sums `work` of their rows and pairs, and by the number of incoming pairs of each task.
/// Returns the ends of the tasks in rows.
fn divide(work: &[usize], incoming: &[usize], size: usize) -> Vec<usize> {
    let shares = incoming.len();
    let all = work.last().copied().unwrap_or(0) + incoming.iter().sum::<usize>();
    let mut end = 0;
    let mut before = 0;
    let ends = (1..).zip(incoming).map(|(number, incoming)| {
        before += incoming;
        let border = nearest(work, (number * all / shares).saturating_sub(before));
        // Each task has at least one block, and leaves one to each that follows.
        let most = work.len() - (shares - number);
        end = border.clamp((end + 1).min(most), most);
        end * size
    });
    ends.collect()
}

/// Calls `each` for all pairs whose second member is in a later task than the first, with the number of the later task.
fn for_each_incoming(pairs: &[Candidate], ends: &[usize], mut each: impl FnMut(usize, Candidate)) {
    if ends.len() == 1 {
        return;
    }
    let mut own = 0;
    for &pair in pairs {
        let [i, j] = pair.both();
        while i >= ends[own] {
            own += 1;
        }
        if j >= ends[own] {
            each(ends.partition_point(|&end| end <= j), pair);
        }
    }
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
            list.fill((1..=count).map(|j| Candidate::new(0, j)), 1);
            assert_eq!(list.pairs().len(), count as usize);
        }
        assert!(list.pairs.capacity() <= 1250, "{}", list.pairs.capacity());
    }

    #[test]
    fn pairs_are_sorted_in_whichever_order_they_are_added() {
        let mut filled = PairList::default();
        filled.fill(all([[0, 3], [2, 3], [0, 1], [1, 2]]).into_iter(), 4);
        let mut written = PairList::default();
        for row in [&[3, 1][..], &[2], &[3], &[]] {
            for &j in row {
                written.push(j);
            }
            written.end_row();
        }
        for list in [filled, written] {
            assert_eq!(list.pairs(), all([[0, 1], [0, 3], [1, 2], [2, 3]]));
        }
    }

    #[test]
    fn tasks_cover_all_rows_and_hold_incoming_pairs() {
        let mut list = PairList::default();
        list.fill(all([[0, 5], [1, 3], [2, 3], [3, 5], [4, 5]]).into_iter(), 6);
        list.assign_tasks(6, 3, 2);
        let tasks: Vec<_> = list.tasks().iter().map(|task| (task.rows.clone(), task.incoming.clone())).collect();
        assert_eq!(tasks, [(0..2, vec![]), (2..4, all([[1, 3]]).to_vec()), (4..6, all([[0, 5], [3, 5]]).to_vec())]);
        assert_eq!(list.block(1), (&all([[2, 3], [3, 5]])[..], 6));
        // With more threads than blocks there is one task per block.
        list.assign_tasks(6, 8, 4);
        assert_eq!(list.tasks().len(), 2);
        list.assign_tasks(6, 1, 4);
        assert_eq!((list.tasks().len(), list.tasks()[0].rows.clone()), (1, 0..6));
        list.assign_tasks(0, 3, 4);
        assert_eq!((list.tasks().len(), list.tasks()[0].rows.clone()), (1, 0..0));
    }

    #[test]
    fn tasks_share_work_and_none_is_empty() {
        let rows = |pairs: &[(u32, u32)], threads: usize| {
            let mut list = PairList::default();
            // So many pairs of a row, with any partner.
            let row = |&(row, count): &(u32, u32)| (0..count).map(move |_| Candidate::new(row, 11));
            list.fill(pairs.iter().flat_map(row), 12);
            list.assign_tasks(12, threads, 2);
            list.tasks().iter().map(|task| task.rows.clone()).collect::<Vec<_>>()
        };
        assert_eq!(rows(&[], 3), [0..4, 4..8, 8..12]);
        // The second thread evaluates the pairs of row 0 too.
        assert_eq!(rows(&[(0, 16), (7, 4)], 2), [0..6, 6..12]);
        assert_eq!(rows(&[(0, 16), (7, 16)], 2), [0..6, 6..12]);
        assert_eq!(rows(&[(10, 40)], 3), [0..8, 8..10, 10..12]);
        assert_eq!(rows(&[(0, 40)], 3), [0..2, 2..10, 10..12]);
    }

    #[test]
    fn pairs_that_two_threads_evaluate_count_twice() {
        // A strip: each row has pairs with the next 20. Blocks of 4 rows.
        let rows = 400;
        let row = |i: u32| (i + 1..=i + 20).filter(|&j| j < rows).map(move |j| Candidate::new(i, j));
        for threads in [2, 3, 5, 8] {
            let mut list = PairList::default();
            list.fill((0..rows).flat_map(row), 400);
            list.assign_tasks(400, threads, 4);
            let own = |task: &Task| list.pairs().iter().filter(|pair| task.rows.contains(&pair.first())).count();
            let work: Vec<_> =
                list.tasks().iter().map(|task| task.rows.len() + own(task) + task.incoming.len()).collect();
            // A border may be off by half a block.
            let [least, most] = [work.iter().min().unwrap(), work.iter().max().unwrap()];
            assert!(most - least <= 2 * 4 * 21, "{threads}: {work:?}");
        }
    }
}
