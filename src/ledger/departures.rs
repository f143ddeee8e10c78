//! Times at which grains crossed the orifice, in bounded memory.
//!
//! The first [`CAPACITY`] times are kept. Beyond that, every second time is kept, then every fourth, and so on. A time that is
//! kept is exact, and its number among all departures is known. A quantile is taken at the nearest kept time, so its number is
//! off by at most 2/[`CAPACITY`] of all departures.

use serde::{Deserialize, Serialize};

/// Largest number of times that are kept.
const CAPACITY: usize = 1 << 16;

/// Times of departure, ascending.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Departures {
    count: u32,
    /// The times of the departures number 0, `stride`, 2 `stride`, ..., s.
    kept: Vec<f64>,
    stride: u32,
    /// The time of the last departure, s.
    last: f64,
}

impl Default for Departures {
    fn default() -> Self {
        Self { count: 0, kept: Vec::new(), stride: 1, last: 0.0 }
    }
}

impl Departures {
    /// Records a departure at `time`, s.
    pub(super) fn add(&mut self, time: f64) {
        if self.count.is_multiple_of(self.stride) {
            if self.kept.len() == CAPACITY {
                let mut number = 0usize;
                self.kept.retain(|_| {
                    number += 1;
                    !number.is_multiple_of(2)
                });
                self.stride *= 2;
            }
            // After the thinning this departure is still a multiple of the stride, because the capacity is even.
            self.kept.push(time);
        }
        self.last = time;
        self.count += 1;
    }

    /// Number of departures.
    #[must_use]
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Times of the first and last departure, s; `None` without a departure.
    #[must_use]
    pub fn ends(&self) -> Option<(f64, f64)> {
        Some((*self.kept.first()?, self.last))
    }

    /// The kept departure nearest to the departure `number`, counted from 0: its number and its time, s. `None` without a
    /// departure.
    #[must_use]
    pub fn nearest(&self, number: u32) -> Option<(u32, f64)> {
        let index = (number + self.stride / 2) / self.stride;
        let index = index.min(u32::try_from(self.kept.len()).ok()?.checked_sub(1)?);
        Some((index * self.stride, self.kept[index as usize]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_departures_are_all_kept() {
        let mut departures = Departures::default();
        assert_eq!((departures.ends(), departures.nearest(0)), (None, None));
        (0..100u32).for_each(|number| departures.add(f64::from(number) + 0.5));
        assert_eq!((departures.count(), departures.ends()), (100, Some((0.5, 99.5))));
        assert!((0..100).all(|number| departures.nearest(number) == Some((number, f64::from(number) + 0.5))));
    }

    #[test]
    fn memory_is_bounded_and_kept_times_are_exact() {
        let mut departures = Departures::default();
        let count = 1_000_000u32;
        (0..count).for_each(|number| departures.add(f64::from(number)));
        assert!(departures.kept.len() <= CAPACITY && departures.kept.capacity() <= CAPACITY);
        assert_eq!(departures.ends(), Some((0.0, f64::from(count - 1))));
        for number in [0, 1, 99_999, 100_000, 899_999, count - 1] {
            let (kept, time) = departures.nearest(number).unwrap();
            assert!(
                (time - f64::from(kept)).abs() < 1e-9 && kept.abs_diff(number) <= count / 32768 + 1,
                "{kept} for {number}"
            );
        }
    }
}
