//! Candidate pairs: pairs that may touch, as neighbour lists and contact histories key them.

use serde::{Deserialize, Serialize};

use std::fmt;

/// Candidate pair: two slots with the lower one first, or a slot and the index of a wall surface.
///
/// Both indices are packed into one `u64`, so that a pair is read, written and compared as one number. Pairs are
/// ordered by the first index, then by the second. A neighbour list can mark a pair. The mark takes one bit of the number, so it costs
/// the loop over candidates nothing; marked pairs are not compared.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
#[serde(try_from = "Indices", into = "[u32; 2]")]
pub struct Candidate(u64);

/// Both indices of a pair, as a file holds them.
#[derive(Deserialize)]
struct Indices([u32; 2]);

/// Place of the first index: above the second index and the mark.
const FIRST: u32 = 33;

/// The bit of the mark, above the second index.
const MARK: u32 = 32;

impl Candidate {
    /// Packs the indices of a pair, without a mark. The first must be less than 2^31.
    #[inline(always)]
    #[must_use]
    pub fn new(first: u32, second: u32) -> Self {
        debug_assert!(first < 1 << 31, "a first index of at most 31 bits");
        Self(u64::from(first) << FIRST | u64::from(second))
    }

    /// Returns the first index.
    #[inline(always)]
    #[must_use]
    pub fn first(self) -> usize {
        (self.0 >> FIRST) as usize
    }

    /// Returns the second index.
    #[expect(clippy::cast_possible_truncation, reason = "keeps the lower 32 bits")]
    #[inline(always)]
    #[must_use]
    pub fn second(self) -> usize {
        self.0 as u32 as usize
    }

    /// Returns the pair of the same first index with another partner.
    ///
    /// # Panics
    /// If the partner does not fit into 32 bits.
    #[must_use]
    pub(crate) fn with_partner(self, partner: usize) -> Self {
        let partner = u32::try_from(partner).expect("fewer than 2^32 partners");
        Self(self.0 >> FIRST << FIRST | u64::from(partner))
    }

    /// Returns the pair with a mark if `mark` is 1, without a mark if it is 0.
    #[inline(always)]
    #[must_use]
    pub(crate) fn with_mark(self, mark: u8) -> Self {
        Self(self.unmarked().0 | u64::from(mark) << MARK)
    }

    /// Returns the pair without a mark.
    #[inline(always)]
    #[must_use]
    pub(crate) fn unmarked(self) -> Self {
        Self(self.0 & !(1 << MARK))
    }

    /// Returns 1 if the pair has a mark, else 0.
    #[inline(always)]
    #[must_use]
    pub(crate) fn mark(self) -> u64 {
        self.0 >> MARK & 1
    }

    /// Returns both indices.
    #[inline(always)]
    #[must_use]
    pub fn both(self) -> [usize; 2] {
        [self.first(), self.second()]
    }
}

/// Returns whether two slices hold equal candidates. It compares all of them without a branch, because they usually are
/// equal.
#[inline]
#[must_use]
pub fn are_same(some: &[Candidate], others: &[Candidate]) -> bool {
    let differing_bits = some.iter().zip(others).fold(0, |bits, (one, other)| bits | (one.0 ^ other.0));
    some.len() == others.len() && differing_bits == 0
}

impl From<[u32; 2]> for Candidate {
    fn from([first, second]: [u32; 2]) -> Self {
        Self::new(first, second)
    }
}

impl TryFrom<Indices> for Candidate {
    type Error = &'static str;

    fn try_from(Indices(indices): Indices) -> Result<Self, Self::Error> {
        if indices[0] < 1 << 31 { Ok(indices.into()) } else { Err("the first index of a pair has more than 31 bits") }
    }
}

impl From<Candidate> for [u32; 2] {
    #[expect(clippy::cast_possible_truncation, reason = "both indices have at most 32 bits")]
    fn from(candidate: Candidate) -> Self {
        candidate.both().map(|index| index as u32)
    }
}

impl fmt::Debug for Candidate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.both().fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn different_lists_are_not_equal() {
        let some = [[0, 7], [1, 0], [1, 2]].map(Candidate::from);
        assert!(are_same(&some, &some) && are_same(&[], &[]));
        assert!(!are_same(&some, &some[..2]) && !are_same(&some[1..], &some[..2]));
        assert!(!are_same(&some, &[some[0], some[1], Candidate::new(1, 3)]));
    }

    #[test]
    fn order_and_text_follow_both_indices() {
        let pairs = [[0, 7], [1, 0], [1, u32::MAX], [i32::MAX.unsigned_abs(), 0]];
        let candidates = pairs.map(Candidate::from);
        assert!(candidates.is_sorted());
        assert_eq!(candidates.map(<[u32; 2]>::from), pairs);
        assert_eq!(format!("{:?}", candidates[2]), "[1, 4294967295]");
    }

    #[test]
    fn a_pair_from_a_file_has_a_first_index_of_31_bits() {
        assert_eq!(Candidate::try_from(Indices([3, u32::MAX])), Ok(Candidate::new(3, u32::MAX)));
        assert!(Candidate::try_from(Indices([1 << 31, 0])).is_err());
    }

    #[test]
    fn a_mark_changes_neither_index() {
        for pair in [[0, 0], [3, 7], [i32::MAX.unsigned_abs(), u32::MAX]].map(Candidate::from) {
            let marked = pair.with_mark(1);
            assert_eq!((marked.mark(), marked.both(), marked.unmarked()), (1, pair.both(), pair));
            assert_eq!((pair.mark(), marked.with_mark(1), marked.with_mark(0)), (0, marked, pair));
            assert_eq!(marked.with_partner(5), Candidate::new(u32::try_from(pair.first()).unwrap(), 5));
        }
    }
}
