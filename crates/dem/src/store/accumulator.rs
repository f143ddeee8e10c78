//! Accumulators: sums over the contacts of each particle and, in steps that sum dissipation for the energy balance, the
//! dissipative part of each sum, made by dashpots.
//!
//! Total and dissipative part lie side by side, so that both are updated together. In other steps there is no
//! dissipative part, and no code reads it. Hot loops use entries of a length known at compile time:
//! [`TOTAL`] or [`TOTAL_AND_DISSIPATIVE`] numbers.
//!
//! Memory that longer entries have taken is kept. Filling it anew in each step that sums dissipation would cost a pass by one thread over
//! memory that the other threads have in their caches.

use serde::{Deserialize, Serialize, Serializer};

use crate::space::Linear;
use crate::store::Slot;

/// Numbers per entry in a step that does not sum dissipation: the total.
pub(crate) const TOTAL: usize = 1;

/// Numbers per entry in a step that sums dissipation: the total, and the part that dashpots make.
pub const TOTAL_AND_DISSIPATIVE: usize = 2;

/// The term of one particle in the sum that the last kick of a step forms,
/// [`ParticleStore::kick_sum`](crate::store::ParticleStore). In a step that sums dissipation it is the power of dashpots,
/// W. Otherwise it is `motion`: the velocity or spin after the kick.
#[inline(always)]
pub(crate) fn kick_term<T: Linear, const NUMBERS: usize>(entry: &[T; NUMBERS], motion: T) -> T {
    entry.get(1).map_or(motion, |dissipative| dissipative.times(motion))
}

/// One accumulator entry per particle.
#[derive(Clone, Debug, Deserialize)]
#[serde(from = "SavedAccumulator<Vec<T>>")]
pub struct Accumulator<T> {
    /// The numbers of all entries. Numbers beyond them are unused.
    numbers: Vec<T>,
    particles: usize,
    /// Numbers per entry.
    per_entry: usize,
}

/// An accumulator as it is saved, without unused numbers.
#[derive(Deserialize, Serialize)]
struct SavedAccumulator<N> {
    numbers: N,
    per_entry: usize,
}

impl<T> From<SavedAccumulator<Vec<T>>> for Accumulator<T> {
    fn from(SavedAccumulator { numbers, per_entry }: SavedAccumulator<Vec<T>>) -> Self {
        Self { particles: numbers.len().checked_div(per_entry).unwrap_or(0), numbers, per_entry }
    }
}

impl<T: Serialize> Serialize for Accumulator<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        SavedAccumulator { numbers: self.used(), per_entry: self.per_entry }.serialize(serializer)
    }
}

impl<T> Default for Accumulator<T> {
    fn default() -> Self {
        Self { numbers: Vec::new(), particles: 0, per_entry: TOTAL }
    }
}

impl<T> Accumulator<T> {
    /// The numbers of all entries.
    #[inline]
    fn used(&self) -> &[T] {
        &self.numbers[..self.particles * self.per_entry]
    }

    /// The numbers of all entries, to write.
    #[inline]
    fn used_mut(&mut self) -> &mut [T] {
        &mut self.numbers[..self.particles * self.per_entry]
    }
}

impl<T: Linear> Accumulator<T> {
    /// Sets the size to `particles` entries, all zero.
    pub(crate) fn reset(&mut self, particles: usize, tracks_energy: bool) {
        self.per_entry = if tracks_energy { TOTAL_AND_DISSIPATIVE } else { TOTAL };
        self.particles = particles;
        self.numbers.clear();
        self.numbers.resize(particles * self.per_entry, T::ZERO);
    }

    /// Sets the size to `particles` entries. The first entries take the totals of the slots in `former`; the others are
    /// zero.
    pub(crate) fn rearrange(&mut self, particles: usize, former: &[Slot], tracks_energy: bool) {
        let before = std::mem::take(self);
        self.reset(particles, tracks_energy);
        for (i, slot) in former.iter().enumerate() {
            self.set(i, before.get(slot.index()).unwrap_or(T::ZERO));
        }
    }

    /// Changes the numbers per entry. All numbers are meaningless until a force pass has set them.
    pub(crate) fn change_layout(&mut self, tracks_energy: bool) {
        self.per_entry = if tracks_energy { TOTAL_AND_DISSIPATIVE } else { TOTAL };
        let used = self.particles * self.per_entry;
        self.numbers.resize(used.max(self.numbers.len()), T::ZERO);
    }

    /// Whether entries have a dissipative part.
    pub(crate) fn tracks_energy(&self) -> bool {
        self.per_entry == TOTAL_AND_DISSIPATIVE
    }

    /// Number of particles.
    #[must_use]
    pub fn len(&self) -> usize {
        self.particles
    }

    /// Whether a restored accumulator has an entry for each of `particles`, of a length that force passes know.
    pub(super) fn fits(&self, particles: usize) -> bool {
        [TOTAL, TOTAL_AND_DISSIPATIVE].contains(&self.per_entry) && self.numbers.len() == particles * self.per_entry
    }

    /// Whether there are no entries: the scene does not need these sums.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.particles == 0
    }

    /// Returns the total of entry `i`, or `None` if the accumulator has no such entry.
    #[inline]
    #[must_use]
    pub fn get(&self, i: usize) -> Option<T> {
        self.used().get(i * self.per_entry).copied()
    }

    /// Returns the total of entry `i`.
    ///
    /// # Panics
    /// If there is no such entry.
    #[inline]
    #[must_use]
    pub fn of(&self, i: usize) -> T {
        self.used()[i * self.per_entry]
    }

    /// Sets the total of entry `i`, if the entry exists.
    #[inline]
    pub(crate) fn set(&mut self, i: usize, total: T) {
        let at = i * self.per_entry;
        if let Some(sum) = self.used_mut().get_mut(at) {
            *sum = total;
        }
    }

    /// Returns all entries as arrays of `NUMBERS` numbers, to write. Empty if the entries have another length.
    #[inline]
    pub(crate) fn entries_mut<const NUMBERS: usize>(&mut self) -> &mut [[T; NUMBERS]] {
        if NUMBERS == self.per_entry { self.used_mut().as_chunks_mut().0 } else { &mut [] }
    }

    /// Returns all entries as arrays of `NUMBERS` numbers. Empty if the entries have another length.
    #[inline]
    #[must_use]
    pub fn entries<const NUMBERS: usize>(&self) -> &[[T; NUMBERS]] {
        if NUMBERS == self.per_entry { self.used().as_chunks().0 } else { &[] }
    }

    /// Returns all numbers, entry by entry, and the numbers per entry.
    #[inline]
    pub(crate) fn numbers_mut(&mut self) -> (&mut [T], usize) {
        let per_entry = self.per_entry;
        (self.used_mut(), per_entry)
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use super::*;

    #[test]
    fn the_dissipative_part_is_kept_with_the_energy_balance() {
        for (tracks_energy, numbers) in [(false, vec![0.0, 5.0, 0.0]), (true, vec![0.0, 0.0, 5.0, 2.0, 0.0, 0.0])] {
            let mut accumulator = Accumulator::<f64>::default();
            accumulator.reset(3, tracks_energy);
            accumulator.set(1, 4.0);
            let (values, per_entry) = accumulator.numbers_mut();
            values[per_entry] += 1.0;
            if tracks_energy {
                values[per_entry + 1] += 2.0;
            }
            assert_eq!((accumulator.len(), accumulator.of(1), accumulator.get(3)), (3, 5.0, None));
            assert_eq!(accumulator.numbers, numbers);
            assert_eq!(accumulator.entries::<TOTAL_AND_DISSIPATIVE>().len(), if tracks_energy { 3 } else { 0 });
        }
        assert_eq!([kick_term(&[4.0], 3.0), kick_term(&[4.0, 2.0], 3.0)], [3.0, 6.0]);
    }

    #[test]
    fn shorter_entries_keep_the_memory_of_longer_ones_and_are_saved_without_it() {
        let mut accumulator = Accumulator::<f64>::default();
        accumulator.reset(3, true);
        accumulator.change_layout(false);
        accumulator.set(2, 7.0);
        assert_eq!(
            (accumulator.numbers.len(), accumulator.len(), accumulator.of(2), accumulator.get(3)),
            (6, 3, 7.0, None)
        );
        assert_eq!((accumulator.entries::<TOTAL>().len(), accumulator.numbers_mut().0.len()), (3, 3));
        let restored: Accumulator<f64> = postcard::from_bytes(&postcard::to_allocvec(&accumulator).unwrap()).unwrap();
        assert!(restored.fits(3) && !restored.fits(2));
        assert_eq!(restored.numbers, [0.0, 0.0, 7.0]);
        accumulator.change_layout(true);
        assert_eq!((accumulator.numbers.len(), accumulator.entries::<TOTAL_AND_DISSIPATIVE>().len()), (6, 3));
    }
}
