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
    fn it_is_two_numbers_in_one() {
        let candidates = [[0, 7], [1, 0], [1, u32::MAX], [u32::MAX, 0]].map(Candidate::from);
        assert!(candidates.is_sorted());
        assert_eq!(format!("{:?}", candidates[2]), "[1, 4294967295]");
    }
}
