//! Candidate pairs: pairs that may touch, as neighbour lists and contact histories key them.

use serde::{Deserialize, Serialize};

use std::fmt;

/// Candidate pair: a row and its partner. A pair of particles has the higher slot as its row. A pair of a particle and a wall surface has the
/// slot of the particle as its row, and the index of the surface as the partner.
///
/// Both indices are packed into one `u64`, so that a pair is read, written and compared as one number. Pairs are
/// ordered by rows, then by partners. A neighbour list can mark a pair. The mark takes one bit of the number, so it costs
/// the loop over candidates nothing; marked pairs are not compared.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
#[serde(try_from = "Indices", into = "[u32; 2]")]
pub struct Candidate(u64);

/// Both indices of a pair, as a file holds them.
#[derive(Deserialize)]
struct Indices([u32; 2]);

/// Place of the row: above the partner and the mark.
const ROW: u32 = 33;

/// The bit of the mark, above the partner.
const MARK: u32 = 32;

impl Candidate {
    /// Packs a row and its partner, without a mark. The row must be less than 2^31.
    #[inline(always)]
    #[must_use]
    pub fn new(row: u32, partner: u32) -> Self {
        debug_assert!(row < 1 << 31, "a row of at most 31 bits");
        Self(u64::from(row) << ROW | u64::from(partner))
    }

    /// Returns the pair of two particles, given their slots in either order.
    #[inline(always)]
    #[must_use]
    pub fn of_slots(one: u32, other: u32) -> Self {
        Self::new(one.max(other), one.min(other))
    }

    /// Returns the row.
    #[inline(always)]
    #[must_use]
    pub fn row(self) -> usize {
        (self.0 >> ROW) as usize
    }

    /// Returns the partner.
    #[expect(clippy::cast_possible_truncation, reason = "keeps the lower 32 bits")]
    #[inline(always)]
    #[must_use]
    pub fn partner(self) -> usize {
        self.0 as u32 as usize
    }

    /// Returns the slots of a pair of particles, the lower one first. Geometry, memories and forces of the pair are seen from the lower one.
    #[inline(always)]
    #[must_use]
    pub fn slots(self) -> [usize; 2] {
        [self.partner(), self.row()]
    }

    /// Returns the pair of the same row with another partner.
    ///
    /// # Panics
    /// If the partner does not fit into 32 bits.
    #[must_use]
    pub(crate) fn with_partner(self, partner: usize) -> Self {
        let partner = u32::try_from(partner).expect("fewer than 2^32 partners");
        Self(self.0 >> ROW << ROW | u64::from(partner))
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

    /// Returns the row and the partner.
    #[inline(always)]
    #[must_use]
    pub fn row_and_partner(self) -> [usize; 2] {
        [self.row(), self.partner()]
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
    fn from([row, partner]: [u32; 2]) -> Self {
        Self::new(row, partner)
    }
}

impl TryFrom<Indices> for Candidate {
    type Error = &'static str;

    fn try_from(Indices(indices): Indices) -> Result<Self, Self::Error> {
        if indices[0] < 1 << 31 { Ok(indices.into()) } else { Err("the row of a pair has more than 31 bits") }
    }
}

impl From<Candidate> for [u32; 2] {
    #[expect(clippy::cast_possible_truncation, reason = "both indices have at most 32 bits")]
    fn from(candidate: Candidate) -> Self {
        candidate.row_and_partner().map(|index| index as u32)
    }
}

impl fmt::Debug for Candidate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.row_and_partner().fmt(f)
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
    fn order_and_text_follow_row_and_partner() {
        let pairs = [[0, 7], [1, 0], [1, u32::MAX], [i32::MAX.unsigned_abs(), 0]];
        let candidates = pairs.map(Candidate::from);
        assert!(candidates.is_sorted());
        assert_eq!(candidates.map(<[u32; 2]>::from), pairs);
        assert_eq!(format!("{:?}", candidates[2]), "[1, 4294967295]");
    }

    #[test]
    fn a_pair_from_a_file_has_a_row_of_31_bits() {
        assert_eq!(Candidate::try_from(Indices([3, u32::MAX])), Ok(Candidate::new(3, u32::MAX)));
        assert!(Candidate::try_from(Indices([1 << 31, 0])).is_err());
    }

    #[test]
    fn a_pair_of_particles_has_its_higher_slot_as_its_row() {
        for pair in [Candidate::of_slots(3, 8), Candidate::of_slots(8, 3)] {
            assert_eq!((pair.row_and_partner(), pair.slots()), ([8, 3], [3, 8]));
        }
    }

    #[test]
    fn a_mark_changes_neither_index() {
        for pair in [[0, 0], [3, 7], [i32::MAX.unsigned_abs(), u32::MAX]].map(Candidate::from) {
            let marked = pair.with_mark(1);
            assert_eq!((marked.mark(), marked.row_and_partner(), marked.unmarked()), (1, pair.row_and_partner(), pair));
            assert_eq!((pair.mark(), marked.with_mark(1), marked.with_mark(0)), (0, marked, pair));
            assert_eq!(marked.with_partner(5), Candidate::new(u32::try_from(pair.row()).unwrap(), 5));
        }
    }
}
