//! The candidates: pairs of particles that may touch, the first of lower slot than the second, ascending; and how they are
//! shared among threads.
//!
//! A flat list, with both members of a pair, so that walking it has nothing to foresee. It is cut into blocks of rows; a
//! row is the pairs of one first member. A thread sums the rows of a [`Task`] and adds each pair to both members, as one
//! thread does for all rows. What a row of another task does to its own particles it evaluates itself, before its own
//! rows: those pairs are `incoming`. So each particle receives its partners in ascending order of slots on any number of
//! threads, and only pairs across the border of two tasks are evaluated twice.

use std::ops::Range;

/// Rows of a block: what a force pass does at a time, on however many threads.
pub const BLOCK: usize = 1024;

pub use crate::neighbours::candidate::{Candidate, are_same};

/// The candidates.
#[derive(Debug, Default)]
pub struct PairList {
    pairs: Vec<Candidate>,
    /// Of rows: where each begins; made with the list.
    starts: Vec<u32>,
    /// Of the row that is being written.
    row: u32,
    /// Of each block of rows: where its pairs end, and [where their entries do](end_of).
    blocks: Vec<[usize; 2]>,
    tasks: Vec<Task>,
}

/// What one thread sums.
#[derive(Debug, Default, Clone)]
pub struct Task {
    /// Its rows.
    pub rows: Range<usize>,
    /// Pairs (i, j) with i before these rows and j among them, ascending.
    pub incoming: Vec<Candidate>,
}

/// Before this entry are all of which these pairs are.
#[must_use]
pub fn end_of(pairs: &[Candidate]) -> usize {
    pairs.iter().map(|pair| pair.second() + 1).max().unwrap_or(0)
}

impl PairList {
    /// All candidates.
    #[must_use]
    pub fn pairs(&self) -> &[Candidate] {
        &self.pairs
    }

    /// The candidates of a block of rows, and the [end](end_of) of their entries.
    #[must_use]
    pub fn block(&self, number: usize) -> (&[Candidate], usize) {
        let start = if number == 0 { 0 } else { self.blocks[number - 1][0] };
        let [end, entries] = self.blocks[number];
        (&self.pairs[start..end], entries)
    }

    /// The shares of the threads.
    #[must_use]
    pub fn tasks(&self) -> &[Task] {
        &self.tasks
    }

    /// Starts anew.
    pub(super) fn clear(&mut self) {
        self.pairs.clear();
        self.row = 0;
    }

    /// Adds a candidate to the row that is being written.
    #[inline]
    pub(super) fn push(&mut self, j: u32) {
        self.pairs.push(Candidate::new(self.row, j));
    }

    /// Ends that row, whose candidates came in any order.
    pub(super) fn end_row(&mut self) {
        let written = self.pairs.iter().rposition(|pair| pair.first() != self.row as usize).map_or(0, |last| last + 1);
        self.pairs[written..].sort_unstable();
        self.row += 1;
    }

    /// Takes pairs of `rows` particles, in any order, and in parts.
    pub(super) fn take(&mut self, parts: &[Vec<Candidate>], rows: usize) {
        self.starts.clear();
        self.starts.resize(rows + 1, 0);
        for pair in parts.iter().flatten() {
            self.starts[pair.first() + 1] += 1;
        }
        for row in 0..rows {
            self.starts[row + 1] += self.starts[row];
        }
        self.pairs.clear();
        self.pairs.resize(parts.iter().map(Vec::len).sum(), Candidate::default());
        // Filling moves each start to the next one's place.
        for &pair in parts.iter().flatten() {
            let place = &mut self.starts[pair.first()];
            self.pairs[*place as usize] = pair;
            *place += 1;
        }
        let mut start = 0;
        for &end in &self.starts[..rows] {
            let row = &mut self.pairs[start..end as usize];
            // Most are.
            if !row.is_sorted() {
                row.sort_unstable();
            }
            start = end as usize;
        }
    }

    /// Shares `rows` rows among `threads`, in whole blocks of `size` rows.
    pub(super) fn share_out(&mut self, rows: usize, threads: usize, size: usize) {
        let pairs = &self.pairs;
        let row_of = |border: usize| pairs.partition_point(|pair| pair.first() < border);
        self.blocks.clear();
        let mut start = 0;
        self.blocks.extend((1..=rows.div_ceil(size)).map(|number| {
            let end = row_of(number * size);
            let block = &pairs[start..end];
            start = end;
            [end, end_of(block)]
        }));
        let (blocks, shares) = (self.blocks.len(), threads.min(self.blocks.len()).max(1));
        self.tasks.resize_with(shares, Task::default);
        for (number, task) in self.tasks.iter_mut().enumerate() {
            let border = |number: usize| (number * blocks / shares * size).min(rows);
            task.rows = border(number)..border(number + 1);
            task.incoming.clear();
        }
        let mut own = 0;
        for &pair in if shares > 1 { &self.pairs[..] } else { &[] } {
            let [i, j] = pair.both();
            while i >= self.tasks[own].rows.end {
                own += 1;
            }
            if j >= self.tasks[own].rows.end {
                let theirs = self.tasks.partition_point(|task| task.rows.end <= j);
                self.tasks[theirs].incoming.push(pair);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all<const N: usize>(pairs: [[u32; 2]; N]) -> [Candidate; N] {
        pairs.map(Candidate::from)
    }

    #[test]
    fn pairs_come_out_in_order_whichever_way_they_go_in() {
        let mut taken = PairList::default();
        taken.take(&[all([[0, 3], [2, 3]]).to_vec(), all([[0, 1], [1, 2]]).to_vec()], 4);
        let mut written = PairList::default();
        for row in [&[3, 1][..], &[2], &[3], &[]] {
            for &j in row {
                written.push(j);
            }
            written.end_row();
        }
        for list in [taken, written] {
            assert_eq!(list.pairs(), all([[0, 1], [0, 3], [1, 2], [2, 3]]));
        }
    }

    #[test]
    fn tasks_cover_all_rows_and_know_who_comes_in() {
        let mut list = PairList::default();
        list.take(&[all([[0, 5], [1, 3], [2, 3], [3, 5], [4, 5]]).to_vec()], 6);
        list.share_out(6, 3, 2);
        let tasks: Vec<_> = list.tasks().iter().map(|task| (task.rows.clone(), task.incoming.clone())).collect();
        assert_eq!(tasks, [(0..2, vec![]), (2..4, all([[1, 3]]).to_vec()), (4..6, all([[0, 5], [3, 5]]).to_vec())]);
        assert_eq!(list.block(1), (&all([[2, 3], [3, 5]])[..], 6));
        // More threads than blocks: as many tasks as blocks.
        list.share_out(6, 8, 4);
        assert_eq!(list.tasks().len(), 2);
        list.share_out(6, 1, 4);
        assert_eq!((list.tasks().len(), list.tasks()[0].rows.clone()), (1, 0..6));
    }
}
