//! A pair that may touch, as lists and histories name it.

use std::fmt;

/// Two entries of the columns, the lower one first; or an entry and a flat wall. One number, so that it is read, written and
/// compared at once; in ascending order of the first, then of the second.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Candidate(u64);

impl Candidate {
    /// These two.
    #[inline(always)]
    #[must_use]
    pub fn new(first: u32, second: u32) -> Self {
        Self(u64::from(first) << 32 | u64::from(second))
    }

    /// The first.
    #[inline(always)]
    #[must_use]
    pub fn first(self) -> usize {
        (self.0 >> 32) as usize
    }

    /// The second.
    #[expect(clippy::cast_possible_truncation, reason = "the lower half")]
    #[inline(always)]
    #[must_use]
    pub fn second(self) -> usize {
        self.0 as u32 as usize
    }

    /// Both.
    #[inline(always)]
    #[must_use]
    pub fn both(self) -> [usize; 2] {
        [self.first(), self.second()]
    }
}

/// Whether these are the same. All are compared, without a branch: they mostly are.
#[inline]
#[must_use]
pub fn are_same(some: &[Candidate], others: &[Candidate]) -> bool {
    let differences = some.iter().zip(others).fold(0, |found, (one, other)| found | (one.0 ^ other.0));
    some.len() == others.len() && differences == 0
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
    fn others_are_told_apart() {
        let some = [[0, 7], [1, 0], [1, 2]].map(Candidate::from);
        assert!(are_same(&some, &some) && are_same(&[], &[]));
        assert!(!are_same(&some, &some[..2]) && !are_same(&some[1..], &some[..2]));
        assert!(!are_same(&some, &[some[0], some[1], Candidate::new(1, 3)]));
    }

    #[test]
    fn it_is_two_numbers_in_one() {
        let candidates = [[0, 7], [1, 0], [1, u32::MAX], [u32::MAX, 0]].map(Candidate::from);
        assert!(candidates.is_sorted());
        assert_eq!(format!("{:?}", candidates[2]), "[1, 4294967295]");
    }
}
