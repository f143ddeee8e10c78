//! Times at which grains crossed the orifice, and the mass that was out by then, in bounded memory.
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
    /// The departures number 0, `stride`, 2 `stride`, ...
    kept: Vec<KeptDeparture>,
    stride: u32,
    /// The time of the last departure, s.
    last: f64,
    /// Mass of all grains that have departed, kg.
    mass: f64,
}

/// A departure whose time is kept.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
struct KeptDeparture {
    /// Its time, s.
    time: f64,
    /// Mass of the grains that are out, this one included, kg.
    mass_out: f64,
}

/// One departure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Departure {
    /// Its number, counted from 0.
    pub number: u32,
    /// Its time, s.
    pub time: f64,
    /// Mass of the grains that are out, this one included, kg.
    pub mass_out: f64,
}

impl Default for Departures {
    fn default() -> Self {
        Self { count: 0, kept: Vec::new(), stride: 1, last: 0.0, mass: 0.0 }
    }
}

impl Departures {
    /// Records the departure of a grain of this mass, kg, at `time`, s.
    pub(super) fn add(&mut self, time: f64, mass: f64) {
        self.mass += mass;
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
            self.kept.push(KeptDeparture { time, mass_out: self.mass });
        }
        self.last = time;
        self.count += 1;
    }

    /// Whether restored times are as many as the count says.
    pub(super) fn is_sound(&self) -> bool {
        let kept = if self.stride.is_power_of_two() { self.count.div_ceil(self.stride) as usize } else { usize::MAX };
        kept == self.kept.len() && kept <= CAPACITY
    }

    /// Number of departures.
    #[must_use]
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Mass of all grains that have departed, kg.
    #[must_use]
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// Time of the first departure, s; `None` without a departure.
    #[must_use]
    pub fn first(&self) -> Option<f64> {
        self.kept.first().map(|departure| departure.time)
    }

    /// Time of the last departure, s; `None` without a departure.
    #[must_use]
    pub fn last(&self) -> Option<f64> {
        (!self.kept.is_empty()).then_some(self.last)
    }

    /// The kept departure nearest to the departure `number`, counted from 0; `None` without a departure.
    #[must_use]
    pub fn nearest(&self, number: u32) -> Option<Departure> {
        let index = (number + self.stride / 2) / self.stride;
        let index = index.min(u32::try_from(self.kept.len()).ok()?.checked_sub(1)?);
        let KeptDeparture { time, mass_out } = self.kept[index as usize];
        Some(Departure { number: index * self.stride, time, mass_out })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_departures_are_all_kept() {
        let mut departures = Departures::default();
        assert_eq!((departures.first(), departures.last(), departures.nearest(0)), (None, None, None));
        (0..100u32).for_each(|number| departures.add(f64::from(number) + 0.5, 2.0));
        assert_eq!((departures.count(), departures.first(), departures.last()), (100, Some(0.5), Some(99.5)));
        for number in 0..100u32 {
            let time = f64::from(number) + 0.5;
            let mass_out = 2.0 * f64::from(number + 1);
            assert_eq!(departures.nearest(number), Some(Departure { number, time, mass_out }));
        }
    }

    #[test]
    fn memory_is_bounded_and_kept_times_are_exact() {
        let mut departures = Departures::default();
        let count = 1_000_000u32;
        (0..count).for_each(|number| departures.add(f64::from(number), 1.0));
        assert!(departures.kept.len() <= CAPACITY && departures.kept.capacity() <= CAPACITY);
        assert_eq!((departures.first(), departures.last()), (Some(0.0), Some(f64::from(count - 1))));
        for number in [0, 1, 99_999, 100_000, 899_999, count - 1] {
            let Departure { number: kept, time, mass_out } = departures.nearest(number).unwrap();
            assert!(
                (time - f64::from(kept)).abs() < 1e-9
                    && (mass_out - time - 1.0).abs() < 1e-9
                    && kept.abs_diff(number) <= count / 32768 + 1,
                "{kept} for {number}"
            );
        }
    }
}
