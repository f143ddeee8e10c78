//! Candidate pairs: pairs that may touch, as neighbour lists and contact histories key them.

use serde::{Deserialize, Serialize};

use std::fmt;

/// Candidate pair: two slots with the lower one first, or a slot and the index of a wall surface.
///
/// Both indices are packed into one `u64`, so that a pair is read, written and compared as one number. Pairs are
/// ordered by the first index, then by the second.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
pub struct Candidate(u64);

impl Candidate {
    /// Packs the indices of a pair.
    #[inline(always)]
    #[must_use]
    pub fn new(first: u32, second: u32) -> Self {
        Self(u64::from(first) << 32 | u64::from(second))
    }

    /// Returns the first index.
    #[inline(always)]
    #[must_use]
    pub fn first(self) -> usize {
        (self.0 >> 32) as usize
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
        Self(self.0 >> 32 << 32 | u64::from(partner))
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
        let candidates = [[0, 7], [1, 0], [1, u32::MAX], [u32::MAX, 0]].map(Candidate::from);
        assert!(candidates.is_sorted());
        assert_eq!(format!("{:?}", candidates[2]), "[1, 4294967295]");
    }
}
