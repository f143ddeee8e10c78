//! The times of an observer: multiples of an interval, which may grow with the time of the run.
//!
//! A run whose end nobody knows wants enough moments however early it ends, and not too many if it lasts. [`Times::growing`] has the finest interval
//! f up to the time 2 n f, 2 f up to the time 4 n f, 4 f up to 8 n f, and so on up to a largest interval. So a run has between n and 2 n moments
//! after each doubling of its time: 2 n, then n more with each doubling. All times are multiples of f, so those of a coarser interval are among
//! those of a finer one.

/// The times of an observer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Times {
    /// The interval at the start, s.
    pub finest: f64,
    growth: Option<Growth>,
}

/// The growth of an interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Growth {
    /// Number of finest intervals before the first doubling.
    first: u64,
    /// The largest interval, in finest ones: a power of two.
    most: u64,
}

impl Times {
    /// A number of times that is more than any run should have; more are not counted.
    pub const MOST_COUNTED: u64 = 1_000_000;

    /// An interval that stays, s.
    #[must_use]
    pub fn every(interval: f64) -> Self {
        Self { finest: interval, growth: None }
    }

    /// An interval that begins with `finest` (s), doubles after `2 n` of them and then with the time, as long as it is at most `coarsest`, s.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    pub fn growing(finest: f64, n: u32, coarsest: f64) -> Self {
        let most = (coarsest / finest * (1.0 + 1e-9)).clamp(1.0, 1e9) as u64;
        Self { finest, growth: Some(Growth { first: 2 * u64::from(n.max(1)), most: 1 << most.ilog2() }) }
    }

    /// Returns the interval after `finest` intervals, in these.
    fn stride(&self, finest: u64) -> u64 {
        match self.growth {
            Some(Growth { first, most }) if finest >= first => (1 << ((finest / first).ilog2() + 1).min(62)).min(most),
            _ => 1,
        }
    }

    /// Returns the next time after `finest` intervals, in these.
    #[must_use]
    pub fn next(&self, finest: u64) -> u64 {
        let stride = self.stride(finest);
        (finest / stride).saturating_add(1).saturating_mul(stride)
    }

    /// Returns the number of times from 0 to `until`, s; at most `most`.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "a number of times")]
    pub fn count(&self, until: f64, most: u64) -> f64 {
        if self.growth.is_none() {
            return (until / self.finest).floor().min(most as f64) + 1.0;
        }
        let mut at = 0;
        let mut count = 0;
        while at as f64 * self.finest <= until * (1.0 + 1e-9) && count < most {
            at = self.next(at);
            count += 1;
        }
        count as f64
    }

    /// Returns the mean interval up to `until`, s.
    #[must_use]
    pub fn mean_interval(&self, until: f64) -> f64 {
        if self.growth.is_none() { self.finest } else { until / self.count(until, Self::MOST_COUNTED) }
    }

    /// The interval in words: `0.1 s`, or `0.1 s at first`.
    #[must_use]
    pub fn words(&self) -> String {
        let grows = self.growth.is_some_and(|growth| growth.most > 1);
        format!("{} s{}", self.finest, if grows { " at first" } else { "" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(times: &Times, until: u64) -> Vec<u64> {
        std::iter::successors(Some(0), |at| Some(times.next(*at))).take_while(|at| *at <= until).collect()
    }

    #[test]
    fn an_interval_that_stays_has_all_multiples() {
        let times = Times::every(0.5);
        assert_eq!(numbers(&times, 5), [0, 1, 2, 3, 4, 5]);
        assert!((times.count(2.6, 1000) - 6.0).abs() < 1e-12);
    }

    #[test]
    fn an_interval_doubles_with_the_time_up_to_the_coarsest() {
        // Two finest intervals: then 2, 4, 8, and no more than 0.45/0.05, of which 8 is the largest power of two.
        let times = Times::growing(0.05, 1, 0.45);
        assert_eq!(numbers(&times, 40), [0, 1, 2, 4, 8, 16, 24, 32, 40]);
        assert!((times.count(1.6, 1000) - 8.0).abs() < 1e-12);
        assert!((times.count(1.6, 3) - 3.0).abs() < 1e-12);
        // A time between two multiples of a coarse interval leads to the next multiple.
        assert_eq!((times.next(5), times.next(17)), (8, 24));
        let times = Times::growing(1.0, 100, 1e9);
        // 200 to the time 200, and a hundred more with each doubling.
        assert_eq!([200, 400, 800, 1600].map(|until| numbers(&times, until).len()), [201, 301, 401, 501]);
    }
}
