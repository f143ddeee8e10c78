//! Pairs that a search found, as the partners of each searching particle.
//!
//! A renewal holds all pairs that it finds beside the former list, and the peak of a run's memory falls into it. A pair takes 4 bytes here
//! and 8 in the list.

use std::ops::Range;

use crate::neighbours::list::Candidate;

/// The partners that the particles of consecutive rows found.
pub(super) struct FoundPairs {
    rows: Range<u32>,
    /// For each finished row: the end of its partners.
    ends: Vec<u32>,
    partners: Vec<u32>,
}

impl FoundPairs {
    /// Makes an empty set for `rows`, with space reserved for `of_each` partners per particle.
    pub(super) fn new(rows: Range<u32>, of_each: usize) -> Self {
        let partners = Vec::with_capacity(of_each * rows.len());
        Self { ends: Vec::with_capacity(rows.len()), partners, rows }
    }

    /// Adds a partner of the particle whose row is being written.
    #[inline(always)]
    pub(super) fn push(&mut self, partner: u32) {
        self.partners.push(partner);
    }

    /// Ends the row that is being written.
    #[inline(always)]
    pub(super) fn end_row(&mut self) {
        self.ends.push(u32::try_from(self.partners.len()).expect("fewer than 2^32 pairs"));
    }

    /// Returns the set without the space that it does not need.
    pub(super) fn shrunk(mut self) -> Self {
        self.partners.shrink_to_fit();
        self
    }

    /// Returns the pairs, row by row.
    pub(super) fn pairs(&self) -> impl Iterator<Item = Candidate> + Clone {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        self.rows.clone().zip(starts.zip(&self.ends)).flat_map(|(i, (start, &end))| {
            self.partners[start as usize..end as usize].iter().map(move |&j| Candidate::new(i.min(j), i.max(j)))
        })
    }
}
