//! A tally: what contacts add up to for each particle, and where books of energy are kept, beside it the part of it that dashpots
//! make.
//!
//! Both lie side by side, so that they are added to together; where no books are kept there is no room for the second, and
//! nobody reads past it. Hot loops take entries of a length known to the compiler: [`TOTAL`] numbers, or [`TOTAL_AND_DISSIPATIVE`].

use crate::space::Linear;
use crate::store::Slot;

/// Numbers of an entry: the whole.
pub(crate) const TOTAL: usize = 1;

/// Numbers of an entry where books are kept: the whole, and the part that dashpots make.
pub(crate) const TOTAL_AND_DISSIPATIVE: usize = 2;

/// What the last kick of a step sums up of an entry and the motion that it leads to: the power of dashpots where books are kept, W,
/// else the motion itself ([`ParticleStore::kick_sum`](crate::store::Columns::kick_sum)).
#[inline(always)]
pub(crate) fn kick_term<T: Linear, const NUMBERS: usize>(entry: &[T; NUMBERS], motion: T) -> T {
    entry.get(1).map_or(motion, |of_dashpots| of_dashpots.times(motion))
}

/// The sums of all particles.
#[derive(Clone, Debug)]
pub struct Accumulator<T> {
    numbers: Vec<T>,
    /// Numbers of an entry.
    each: usize,
}

impl<T> Default for Accumulator<T> {
    fn default() -> Self {
        Self { numbers: Vec::new(), each: TOTAL }
    }
}

impl<T: Linear> Accumulator<T> {
    /// Makes room for so many particles, with sums of nothing.
    pub(crate) fn reset(&mut self, particles: usize, tracks_energy: bool) {
        self.each = if tracks_energy { TOTAL_AND_DISSIPATIVE } else { TOTAL };
        self.numbers.clear();
        self.numbers.resize(particles * self.each, T::ZERO);
    }

    /// Makes room for so many particles, with the whole sums of the first ones, who had these slots.
    pub(crate) fn rearrange(&mut self, particles: usize, former: &[Slot], tracks_energy: bool) {
        let before = std::mem::take(self);
        self.reset(particles, tracks_energy);
        for (i, slot) in former.iter().enumerate() {
            self.set(i, before.get(slot.index()).unwrap_or(T::ZERO));
        }
    }

    /// How many particles there is room for.
    #[must_use]
    pub fn len(&self) -> usize {
        self.numbers.len() / self.each
    }

    /// Whether there is room for none: nobody asked for these sums.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }

    /// The whole sum of entry `i`, if there is one.
    #[inline]
    #[must_use]
    pub fn get(&self, i: usize) -> Option<T> {
        self.numbers.get(i * self.each).copied()
    }

    /// The whole sum of entry `i`.
    ///
    /// # Panics
    /// If there is none.
    #[inline]
    #[must_use]
    pub fn of(&self, i: usize) -> T {
        self.numbers[i * self.each]
    }

    /// Sets the whole sum of entry `i`, if there is one.
    #[inline]
    pub(crate) fn set(&mut self, i: usize, whole: T) {
        if let Some(sum) = self.numbers.get_mut(i * self.each) {
            *sum = whole;
        }
    }

    /// All entries, of `NUMBERS` numbers; none if they have another number of them.
    #[inline]
    pub(crate) fn entries<const NUMBERS: usize>(&self) -> &[[T; NUMBERS]] {
        if NUMBERS == self.each { self.numbers.as_chunks().0 } else { &[] }
    }

    /// All numbers, entry by entry, and how many an entry has.
    #[inline]
    pub(crate) fn numbers_mut(&mut self) -> (&mut [T], usize) {
        (&mut self.numbers, self.each)
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use super::*;

    #[test]
    fn the_part_of_dashpots_is_kept_where_books_are() {
        for (tracks_energy, numbers) in [(false, vec![0.0, 5.0, 0.0]), (true, vec![0.0, 0.0, 5.0, 2.0, 0.0, 0.0])] {
            let mut tally = Accumulator::<f64>::default();
            tally.reset(3, tracks_energy);
            tally.set(1, 4.0);
            let (numbers_of, each) = tally.numbers_mut();
            numbers_of[each] += 1.0;
            if tracks_energy {
                numbers_of[each + 1] += 2.0;
            }
            assert_eq!((tally.len(), tally.of(1), tally.get(3)), (3, 5.0, None));
            assert_eq!(tally.numbers, numbers);
            assert_eq!(tally.entries::<TOTAL_AND_DISSIPATIVE>().len(), if tracks_energy { 3 } else { 0 });
        }
        assert_eq!([kick_term(&[4.0], 3.0), kick_term(&[4.0, 2.0], 3.0)], [3.0, 6.0]);
    }
}
