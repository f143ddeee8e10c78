//! Numbers of a run as levels of 8 bits, on a scale for the whole run.
//!
//! The scale reaches from the smallest to the largest number. Few numbers far away, such as the forces of one impact, would leave a
//! single colour to all others: if the largest is more than 1.25 times the number below which [`BULK`] of all numbers are, the scale
//! ends there, and larger numbers have the highest level. The same holds for the smallest. Zeros do not count as numbers for that.
//! A scale of numbers that are not negative begins at 0 if the smallest is below a third of its end.

use rustc_hash::FxHashMap;

/// Share of the numbers below the end of a scale that does not reach the largest.
const BULK: f64 = 0.995;

/// Highest level; the number 255 means that there is no number.
pub(super) const TOP: f64 = 254.0;

/// Level of a row without a number.
pub(super) const NO_LEVEL: u8 = 255;

/// Numbers of a run, counted by their sign, exponent and first seven bits.
#[derive(Clone, Debug)]
pub(super) struct Spread {
    pub low: f64,
    pub high: f64,
    counts: FxHashMap<u32, u64>,
}

impl Default for Spread {
    fn default() -> Self {
        Self { low: f64::INFINITY, high: f64::NEG_INFINITY, counts: FxHashMap::default() }
    }
}

/// Bits of a float that are not counted apart.
const SHIFT: u32 = 45;

/// Returns the bin of a number; bins are in the order of numbers.
fn bin(number: f64) -> u32 {
    let bits = number.to_bits();
    let ordered = if number.is_sign_negative() { !bits } else { bits | 1 << 63 };
    // 19 bits are left.
    u32::try_from(ordered >> SHIFT).unwrap_or(u32::MAX)
}

/// Returns the number in a bin that is nearest to zero.
fn inner_edge(bin: u32) -> f64 {
    let ordered = u64::from(bin) << SHIFT;
    if ordered >> 63 == 1 {
        f64::from_bits(ordered & !(1 << 63))
    } else {
        f64::from_bits(!(ordered | ((1 << SHIFT) - 1)))
    }
}

impl Spread {
    /// Adds a number. Only finite numbers count.
    pub fn add(&mut self, number: f64) {
        if number.is_finite() {
            self.low = self.low.min(number);
            self.high = self.high.max(number);
            if number != 0.0 {
                *self.counts.entry(bin(number)).or_default() += 1;
            }
        }
    }

    /// Adds the numbers of another spread.
    pub fn merge(&mut self, other: &Self) {
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
        for (bin, count) in &other.counts {
            *self.counts.entry(*bin).or_default() += count;
        }
    }

    /// Whether all numbers are equal, or there is none.
    pub fn is_constant(&self) -> bool {
        self.low >= self.high
    }

    /// Returns the numbers between which [`BULK`] of all numbers are on each side, to 1 %.
    fn bulk(&self) -> (f64, f64) {
        let mut bins: Vec<(u32, u64)> = self.counts.iter().map(|(&bin, &count)| (bin, count)).collect();
        bins.sort_unstable();
        let total: u64 = bins.iter().map(|(_, count)| count).sum();
        #[expect(
            clippy::cast_precision_loss,
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a share of a count"
        )]
        let outside = ((1.0 - BULK) * total as f64) as u64;
        let edge = |mut of: Box<dyn Iterator<Item = &(u32, u64)> + '_>| {
            let mut passed = 0;
            let found = of.find(|(_, count)| {
                passed += count;
                passed > outside
            });
            found.map_or(0.0, |(bin, _)| inner_edge(*bin))
        };
        (edge(Box::new(bins.iter())), edge(Box::new(bins.iter().rev())))
    }

    /// Returns the scale of these numbers. `is_whole` numbers have a level each, if they are not too many.
    pub fn scale(&self, is_whole: bool) -> Scale {
        let (mut low, mut high) = if self.counts.is_empty() { (0.0, 0.0) } else { (self.low, self.high) };
        if !is_whole {
            let (first, last) = self.bulk();
            if last > 0.0 && high > 1.25 * last {
                high = last;
            }
            if first < 0.0 && low < 1.25 * first {
                low = first;
            }
            if low > 0.0 && low < high / 3.0 {
                low = 0.0;
            }
        }
        Scale { low, high, is_root: false }
    }
}

/// The numbers of the lowest and the highest level.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    pub low: f64,
    pub high: f64,
    /// Whether levels are in proportion to the root of the distance from the lowest number. Speeds need it: few grains fall freely, and the
    /// differences among the slow ones in the bed tell how a silo flows.
    pub is_root: bool,
}

impl Scale {
    /// Returns the level of a number, at most `top`; [`NO_LEVEL`] if it is none.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to a byte")]
    pub fn level(&self, number: f64, top: f64) -> u8 {
        if number.is_nan() {
            return NO_LEVEL;
        }
        let share = (number - self.low) / (self.high - self.low);
        let share = if self.is_root { share.max(0.0).sqrt() } else { share };
        // All numbers are equal: 0 / 0.
        if share.is_nan() { 0 } else { (share * top).round().clamp(0.0, top) as u8 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(numbers: impl IntoIterator<Item = f64>) -> Spread {
        let mut spread = Spread::default();
        numbers.into_iter().for_each(|number| spread.add(number));
        spread
    }

    #[test]
    fn few_large_numbers_do_not_stretch_the_scale() {
        let even = of((0..1000).map(f64::from)).scale(false);
        assert_eq!((even.low, even.high), (0.0, 999.0));
        let peaks = of((1..1000).map(f64::from).chain([1e9, 1e12])).scale(false);
        assert!(peaks.high > 980.0 && peaks.high < 1000.0, "{peaks:?}");
        let both = of((-999..1000).map(f64::from).chain([1e9, -1e9])).scale(false);
        assert!(both.high > 970.0 && both.low < -970.0, "{both:?}");
        assert_eq!(both.level(f64::INFINITY, TOP), 254);
        assert_eq!(both.level(f64::NEG_INFINITY, TOP), 0);
        assert_eq!(both.level(f64::NAN, TOP), NO_LEVEL);
        // The numbers of a small share of the rows are not cut if all others are zero.
        let rare = of((0..100_000).map(|row| if row < 50 { 3.0 } else { 0.0 })).scale(false);
        assert_eq!((rare.low, rare.high), (0.0, 3.0));
    }

    #[test]
    fn slow_grains_have_more_levels_on_a_scale_of_roots() {
        let even = of((0..=1000).map(f64::from)).scale(false);
        let root = Scale { is_root: true, ..even };
        assert_eq!((root.level(0.0, TOP), root.level(1000.0, TOP), root.level(-1.0, TOP)), (0, 254, 0));
        assert_eq!((root.level(10.0, TOP), even.level(10.0, TOP)), (25, 3));
        assert_eq!(root.level(f64::NAN, TOP), NO_LEVEL);
    }

    #[test]
    fn a_temperature_does_not_begin_at_zero() {
        let scale = of((293..350).map(f64::from)).scale(false);
        assert_eq!((scale.low, scale.high), (293.0, 349.0));
    }

    #[test]
    fn whole_numbers_are_read_back() {
        let scale = of((2..200).map(f64::from)).scale(true);
        for number in (2..200).map(f64::from) {
            let level = f64::from(scale.level(number, TOP));
            let read = (scale.low + level / TOP * (scale.high - scale.low)).round();
            assert!((read - number).abs() < 1e-9, "{read} {number}");
        }
    }

    #[test]
    fn bins_are_in_the_order_of_numbers() {
        let numbers = [-1e300, -2.0, -1.0, -1e-300, 1e-300, 1.0, 1.5, 2.0, 1e300];
        for pair in numbers.windows(2) {
            assert!(bin(pair[0]) < bin(pair[1]), "{pair:?}");
        }
        for number in numbers {
            let edge = inner_edge(bin(number));
            assert!((number / edge - 1.0).abs() < 0.01 && edge.abs() <= number.abs(), "{number} {edge}");
        }
        assert!(of([]).is_constant() && of([2.0, 2.0]).is_constant() && !of([1.0, 2.0]).is_constant());
        assert_eq!(of([5.0]).scale(false).level(5.0, TOP), 0);
    }
}
