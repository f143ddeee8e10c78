//! Averages over time: when a sample is due, and when the samples cover the averaging time.
//!
//! Sample n is due at `from` + n `sample`. An average is complete once its samples cover the time `average`, or at the end of the
//! run if there is no such time.

use serde::{Deserialize, Serialize};

use siloflow_dem::step::Clock;
use siloflow_dem::values::{NonNegative, Positive};

/// Samples at intervals, averaged over windows of time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Averaging {
    /// Time between samples, s.
    sample: f64,
    /// Time of the first sample, s.
    from: f64,
    /// Time that an average covers, s; `None` for the whole run.
    average: Option<f64>,
    progress: Progress,
}

/// The part of [`Averaging`] that changes in a run.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub(crate) struct Progress {
    /// Number of samples since the start of the run.
    taken: u64,
    /// Number of samples in the present average.
    pub(crate) samples: u64,
    /// Times of the first and last sample of the present average, s.
    pub(crate) window: [f64; 2],
}

impl Averaging {
    /// Makes the average without samples.
    pub(crate) fn new(sample: Positive, from: Option<NonNegative>, average: Option<Positive>) -> Self {
        Self {
            sample: sample.get(),
            from: from.map_or(0.0, NonNegative::get),
            average: average.map(Positive::get),
            progress: Progress::default(),
        }
    }

    /// Whether a sample is due.
    #[expect(clippy::cast_precision_loss, reason = "2^53 samples are out of reach")]
    pub(crate) fn is_due(&self, clock: &Clock) -> bool {
        clock.has_reached(self.from + self.progress.taken as f64 * self.sample)
    }

    /// Whether the samples cover the averaging time.
    fn is_full(&self, clock: &Clock) -> bool {
        let is_over = |average| clock.has_reached(self.progress.window[0] + average - self.sample);
        self.progress.samples > 0 && self.average.is_some_and(is_over)
    }

    /// Whether a sample is due or the average is complete before the end of the run.
    pub(crate) fn has_work(&self, clock: &Clock) -> bool {
        self.is_due(clock) || self.is_full(clock)
    }

    /// Counts a sample at this moment.
    pub(crate) fn count(&mut self, clock: &Clock) {
        let Progress { taken, samples, window } = &mut self.progress;
        if *samples == 0 {
            window[0] = clock.time();
        }
        window[1] = clock.time();
        *taken += 1;
        *samples += 1;
    }

    /// If the average is complete, or the run ends with samples in it, returns its progress and begins a new average.
    pub(crate) fn complete(&mut self, clock: &Clock, run_ends: bool) -> Option<Progress> {
        let is_complete = self.progress.samples > 0 && (run_ends || self.is_full(clock));
        let complete = self.progress;
        is_complete.then(|| {
            self.progress.samples = 0;
            complete
        })
    }

    /// Returns the progress, for a checkpoint.
    pub(crate) fn saved(&self) -> Progress {
        self.progress
    }

    /// Continues from a saved progress.
    pub(crate) fn restore(&mut self, saved: Progress) {
        self.progress = saved;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_and_averages_come_at_their_times() {
        let value = |x: f64| Positive::try_from(x).unwrap();
        let mut averaging = Averaging::new(value(0.2), Some(0.3.try_into().unwrap()), Some(value(0.6)));
        let mut clock = Clock::new(0.1);
        let mut samples = Vec::new();
        let mut windows = Vec::new();
        for step in 0..=14 {
            clock.steps = step;
            if averaging.is_due(&clock) {
                averaging.count(&clock);
                samples.push(step);
            }
            windows.extend(averaging.complete(&clock, step == 14).map(|done| (step, done.samples)));
        }
        assert_eq!(samples, [3, 5, 7, 9, 11, 13]);
        assert_eq!(windows, [(7, 3), (13, 3)]);
    }
}
