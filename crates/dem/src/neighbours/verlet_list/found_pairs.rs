//! Pairs that a search found, as the partners of each searching particle, and the division of a search among threads.
//!
//! A renewal holds all pairs that it finds beside the former list, and the peak of a run's memory falls into it. A pair takes 4 bytes here
//! and 8 in the list.

use std::ops::Range;

use crate::neighbours::list::Candidate;
use crate::threads::Threads;

/// Number of particles per thread job.
const JOB_ROWS: u32 = 256;

/// The partners that the particles of consecutive rows found.
pub(super) struct FoundPairs {
    rows: Range<u32>,
    /// For each row: the end of its partners.
    ends: Vec<u32>,
    partners: Vec<u32>,
}

impl FoundPairs {
    /// Searches all pairs of `particles` particles, in one part per job. `find` adds the partners of a particle. `expected` is an
    /// estimate of the number of pairs.
    pub(super) fn search(
        particles: usize,
        expected: usize,
        threads: &Threads,
        find: impl Fn(u32, &mut Vec<u32>) + Sync,
    ) -> Vec<Self> {
        let of_each = expected.div_ceil(particles.max(1));
        let particles = u32::try_from(particles).expect("fewer than 2^32 particles");
        let jobs =
            (0..particles).step_by(JOB_ROWS as usize).map(|first| first..particles.min(first.saturating_add(JOB_ROWS)));
        let find = &find;
        threads.share(jobs.map(|rows| move || Self::of_rows(rows, of_each, find)))
    }

    /// Returns the partners of the particles of `rows`, with space reserved for `of_each` per particle.
    #[inline]
    fn of_rows(rows: Range<u32>, of_each: usize, find: impl Fn(u32, &mut Vec<u32>)) -> Self {
        let mut ends = Vec::with_capacity(rows.len());
        let mut partners = Vec::with_capacity(of_each * rows.len());
        for i in rows.clone() {
            find(i, &mut partners);
            ends.push(u32::try_from(partners.len()).expect("fewer than 2^32 pairs"));
        }
        partners.shrink_to_fit();
        Self { rows, ends, partners }
    }

    /// Returns the pairs, row by row.
    pub(super) fn pairs(&self) -> impl Iterator<Item = Candidate> + Clone {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        self.rows.clone().zip(starts.zip(&self.ends)).flat_map(|(i, (start, &end))| {
            self.partners[start as usize..end as usize].iter().map(move |&j| Candidate::of_slots(i, j))
        })
    }
}
