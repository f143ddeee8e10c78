//! A tally: what contacts add up to for each particle, and where books of energy are kept, beside it the part of it that dashpots
//! make.
//!
//! Both lie side by side, so that they are added to together; where no books are kept there is no room for the second, and
//! nobody reads past it. Hot loops take entries of a length known to the compiler: [`WHOLE`] numbers, or [`BOOKED`].

use crate::columns::Slot;
use crate::space::Linear;

/// Numbers of an entry: the whole.
pub(crate) const WHOLE: usize = 1;

/// Numbers of an entry where books are kept: the whole, and the part that dashpots make.
pub(crate) const BOOKED: usize = 2;

/// What the last kick of a step sums up of an entry and the motion that it leads to: the power of dashpots where books are kept, W,
/// else the motion itself ([`Columns::kick_sum`](crate::columns::Columns::kick_sum)).
#[inline(always)]
pub(crate) fn kick_term<T: Linear, const EACH: usize>(entry: &[T; EACH], motion: T) -> T {
    entry.get(1).map_or(motion, |of_dashpots| of_dashpots.times(motion))
}

/// The sums of all particles.
#[derive(Clone, Debug)]
pub struct Tally<T> {
    numbers: Vec<T>,
    /// Numbers of an entry.
    each: usize,
}

impl<T> Default for Tally<T> {
    fn default() -> Self {
        Self { numbers: Vec::new(), each: WHOLE }
    }
}

impl<T: Linear> Tally<T> {
    /// Makes room for so many particles, with sums of nothing.
    pub(crate) fn reset(&mut self, particles: usize, has_books: bool) {
        self.each = if has_books { BOOKED } else { WHOLE };
        self.numbers.clear();
        self.numbers.resize(particles * self.each, T::ZERO);
    }

    /// Makes room for so many particles, with the whole sums of the first ones, who had these slots.
    pub(crate) fn rearrange(&mut self, particles: usize, former: &[Slot], has_books: bool) {
        let before = std::mem::take(self);
        self.reset(particles, has_books);
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

    /// All entries, of `EACH` numbers; none if they have another number of them.
    #[inline]
    pub(crate) fn entries<const EACH: usize>(&self) -> &[[T; EACH]] {
        if EACH == self.each { self.numbers.as_chunks().0 } else { &[] }
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
        for (has_books, numbers) in [(false, vec![0.0, 5.0, 0.0]), (true, vec![0.0, 0.0, 5.0, 2.0, 0.0, 0.0])] {
            let mut tally = Tally::<f64>::default();
            tally.reset(3, has_books);
            tally.set(1, 4.0);
            let (numbers_of, each) = tally.numbers_mut();
            numbers_of[each] += 1.0;
            if has_books {
                numbers_of[each + 1] += 2.0;
            }
            assert_eq!((tally.len(), tally.of(1), tally.get(3)), (3, 5.0, None));
            assert_eq!(tally.numbers, numbers);
            assert_eq!(tally.entries::<BOOKED>().len(), if has_books { 3 } else { 0 });
        }
        assert_eq!([kick_term(&[4.0], 3.0), kick_term(&[4.0, 2.0], 3.0)], [3.0, 6.0]);
    }
}
