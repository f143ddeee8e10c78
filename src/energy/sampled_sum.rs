//! Time integrals of powers and sums of losses that are measured in some steps only ([`sampling`](super::sampling)).

use serde::{Deserialize, Serialize};

/// The time integral of a power, or the sum of the losses of single steps, with samples in some steps only. A step
/// without a sample counts like the last sample, until the next sample corrects the sum.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub(super) struct SampledSum {
    /// The last sample.
    last: f64,
    /// Number of steps without a sample since then.
    skipped: u32,
}

impl SampledSum {
    /// Returns what a step of `dt` (s) adds to the integral of a power (W), by the trapezoidal rule, J.
    pub(super) fn integrate(&mut self, power: Option<f64>, dt: f64) -> f64 {
        self.add(power, |last, power| 0.5 * (last + power), dt)
    }

    /// Returns what a step adds to a sum of losses, J.
    pub(super) fn sum(&mut self, loss: Option<f64>) -> f64 {
        self.add(loss, |_, loss| loss, 1.0)
    }

    /// `mean` returns the mean over the steps since the last sample, from that sample and the new one.
    fn add(&mut self, value: Option<f64>, mean: impl Fn(f64, f64) -> f64, dt: f64) -> f64 {
        let Some(value) = value else {
            self.skipped = self.skipped.saturating_add(1);
            return dt * self.last;
        };
        let skipped = f64::from(std::mem::take(&mut self.skipped));
        let last = std::mem::replace(&mut self.last, value);
        let mean = mean(last, value);
        dt * mean + skipped * dt * (mean - last)
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::random::Stream;

    /// Duration of an impact, steps.
    const DURATION: u32 = 20;
    /// Steps between two impacts: a multiple of every block here.
    const PERIOD: u32 = 64;

    /// Integrates the power cos^2(pi t/20) of `impacts` impacts, which begin a time `onset(number)` after the start of
    /// their period. Samples lie in one of `block` steps.
    fn integral(impacts: u32, block: u32, onset: impl Fn(u32) -> f64) -> f64 {
        let draws = Stream::new(1, "samples");
        let mut sum = SampledSum::default();
        let mut total = 0.0;
        for step in 0..PERIOD * impacts {
            let time = f64::from(step % PERIOD) - onset(step / PERIOD);
            let is_on = (0.0..f64::from(DURATION)).contains(&time);
            let power = if is_on { (PI * time / f64::from(DURATION)).cos().powi(2) } else { 0.0 };
            let [uniform] = draws.uniform(u64::from(step / block));
            let is_due = f64::from(step % block) == (uniform * f64::from(block)).floor();
            total += sum.integrate(is_due.then_some(power), 1.0);
        }
        total
    }

    #[test]
    fn samples_give_the_integral_on_average() {
        let (impacts, onsets) = (2000, Stream::new(1, "onsets"));
        let exact = 0.5 * f64::from(DURATION * impacts);
        for block in [1, 2, 4, 8] {
            // The power jumps by 1 at both ends of an impact. A jump within an interval g between two samples makes an error
            // that is uniform between -g/2 and g/2. Jumps meet intervals of mean square <g^3>/<g>, and g = b + u - u' with two
            // uniform numbers, each of variance (b^2 - 1)/12. Five standard deviations of all jumps:
            let b = f64::from(block);
            let square = b * b + 0.5 * (b * b - 1.0);
            let bound = 5.0 * (2.0 * f64::from(impacts) * square / 12.0).sqrt();
            let at_random = integral(impacts, block, |number| 40.0 * onsets.uniform::<1>(u64::from(number))[0]);
            assert!((at_random - exact).abs() < bound, "block {block}: {at_random}, not {exact}");
            // With the period of the blocks, where samples at fixed places would meet all impacts at the same phase.
            let in_phase = integral(impacts, block, |_| 3.3);
            let all = integral(impacts, 1, |_| 3.3);
            assert!((in_phase - all).abs() < bound, "block {block}, in phase: {in_phase}, not {all}");
        }
    }

    #[test]
    fn a_skipped_step_counts_like_the_last_one_until_the_next_sample() {
        let mut power = SampledSum::default();
        power.integrate(Some(2.0), 0.5);
        let steps = [None, None, Some(4.0), Some(4.0)].map(|sample| power.integrate(sample, 0.5));
        // Three steps with the mean power 3 W, of which two were counted with 2 W.
        assert_eq!(steps, [1.0, 1.0, 2.5, 2.0]);
        let mut losses = SampledSum::default();
        assert_eq!([Some(1.0), None, Some(3.0)].map(|loss| losses.sum(loss)), [1.0, 1.0, 5.0]);
    }
}
