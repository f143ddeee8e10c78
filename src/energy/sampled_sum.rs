//! Time integrals of powers and sums of losses that are measured in some steps only ([`sampling`](super::sampling)), with their errors.
//!
//! Between two samples P_l and P_r, g steps apart, the power is interpolated along the *activity*: P_k = P_l + (P_r - P_l) w_k, where w_k is
//! the share of the activity from l to r that has passed at step k. The activity of a step grows with the number of contacts
//! that begin or end in it. So a jump that many contacts make together is placed in its step, and without activity the
//! interpolation is linear in time. Where activity and sign of a change are independent, the sum is right on average. Behind a jump that is
//! placed within a step or so the power is not constant either. If the step after the sample is a sample too, their difference tells the slope,
//! and the steps from the jump to the first sample are corrected by it. A centred contact acts in a part of its first step, anything from
//! nothing to all: the half is taken, and the standard deviation of the rest, 1/sqrt(12), added to the error.
//!
//! Error: a jump P_r - P_l that lies in step k with a probability proportional to its activity misplaces the integral by (P_r - P_l) times
//! the time from step k to the mean place. The variance of an interval is therefore (P_r - P_l)^2 times the variance of the place, in the mean
//! also where many independent jumps make up the difference. A sum of losses of single steps takes the loss of a sample for the
//! steps around it; with the variance s^2 of single losses, of which (L_r - L_l)^2/2 is an estimate, its variance is g (g - 1) s^2.

use serde::{Deserialize, Serialize};

/// The time integral of a power, or the sum of the losses of single steps, with samples in some steps only. A step
/// without a sample counts like the last sample, until the next sample corrects the sum.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub(super) struct SampledSum {
    /// The last sample.
    last: f64,
    /// Steps without a sample since then.
    since: Passed,
    /// Sum of the variances of all intervals, J^2.
    variance: f64,
    /// Energy that a step without a sample adds, J.
    pending: f64,
    /// The jump before the last sample, if its place is known.
    jump: Option<Jump>,
    /// Change of a step's energy between the last samples over the root of their distance in steps, J. It decays over some ten samples, so
    /// that it tells of a jump also where the power is flat behind it.
    change: f64,
}

/// A jump whose place is known.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
struct Jump {
    /// Its size, J in a step.
    size: f64,
    /// Steps from it to the sample behind it.
    age: f64,
    /// The share of its first step in which it does not act, on average.
    missing: f64,
}

/// The activity of contacts in a step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Weight {
    /// Contacts that have begun or ended, and a share of all others.
    pub activity: f64,
    /// The share of its first step in which a contact does not act, on average.
    pub missing: f64,
}

/// The part of a change that the next sample remembers.
const KEPT: f64 = 0.9;

/// Variance of the place of a jump, in squares of a step, below which the place is known.
const SHARP: f64 = 0.1;

/// Steps since a sample, and the activity of them: its sum, and the sums of its products with the age of the steps and with the
/// square of the age.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
struct Passed {
    steps: u32,
    moments: [f64; 3],
}

/// The age of the activity that has passed since a sample.
struct Age {
    /// Its mean, steps.
    mean: f64,
    /// Its variance, squares of a step.
    variance: f64,
}

impl Passed {
    /// Adds a step with this activity.
    fn add(&mut self, activity: f64) {
        let [sum, first, second] = self.moments;
        self.steps = self.steps.saturating_add(1);
        self.moments = [sum + activity, first + sum, second + 2.0 * first + sum];
    }

    /// Returns the age of the activity since the sample. Without activity each step since the sample counts alike.
    fn age(&self) -> Age {
        let [sum, first, second] = self.moments;
        let steps = f64::from(self.steps);
        if sum > 0.0 {
            let mean = first / sum;
            Age { mean, variance: (second / sum - mean * mean).max(0.0) }
        } else {
            Age { mean: 0.5 * (steps - 1.0), variance: (steps * steps - 1.0) / 12.0 }
        }
    }
}

impl SampledSum {
    /// Returns what a step of `dt` (s) with this activity adds to the integral of a power (W), by the trapezoidal rule, J.
    pub(super) fn integrate(&mut self, power: Option<f64>, dt: f64, weight: Weight) -> f64 {
        self.add(power, dt, weight, 0.5, |_, place| place)
    }

    /// Returns what a step with this activity adds to a sum of losses, J.
    pub(super) fn sum(&mut self, loss: Option<f64>, weight: Weight) -> f64 {
        self.add(loss, 1.0, weight, 1.0, |steps, _| 0.5 * steps * (steps - 1.0))
    }

    /// `share` is the part of a change that counts in the step of the sample. `variance` returns the variance of an interval over the square
    /// of its change, from its steps and the variance of the place of the change.
    fn add(
        &mut self,
        value: Option<f64>,
        dt: f64,
        Weight { activity, missing }: Weight,
        share: f64,
        variance: impl Fn(f64, f64) -> f64,
    ) -> f64 {
        self.since.add(activity);
        let Some(value) = value else {
            self.pending = dt * self.last;
            return dt * self.last;
        };
        let passed = std::mem::take(&mut self.since);
        let last = std::mem::replace(&mut self.last, value);
        let steps = f64::from(passed.steps);
        let change = dt * (value - last);
        let Age { mean: age, variance: spread } = passed.age();
        let mut correction = 0.0;
        if passed.steps > 1 {
            self.variance += change * change * variance(steps, spread);
            // A jump in the step of the sample is summed as it is.
            let is_known = spread < SHARP && age > 0.5;
            self.jump = is_known.then_some(Jump { size: change, age, missing });
        } else if let Some(Jump { size, age, missing }) = self.jump.take() {
            let at_first = missing * (size - change * age);
            correction = -0.5 * change * age * (age + 1.0) - at_first;
            self.variance += at_first * at_first / 3.0;
        }
        self.change = (KEPT * self.change).max(change.abs() / steps.sqrt());
        dt * last + change * (age + share) + correction
    }

    /// Returns the standard error of the sum, J, without the steps since the last sample.
    pub(super) fn standard_error(&self) -> f64 {
        self.variance.sqrt()
    }

    /// Returns what the steps since the last sample have added, J: the next sample may take it back.
    pub(super) fn pending(&self) -> f64 {
        f64::from(self.since.steps) * self.pending.abs()
    }

    /// Returns the standard error that an interval of `steps` steps would add if the sum went on to change as in the last samples, J. Changes of
    /// independent contacts grow with the root of the time.
    pub(super) fn error_ahead(&self, steps: f64) -> f64 {
        self.change * steps * (steps / 12.0).sqrt()
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::random::Stream;

    /// The weight of a step in which so many contacts begin or end.
    fn weight(activity: f64) -> Weight {
        Weight { activity, missing: 0.0 }
    }

    /// Duration of an impact, steps.
    const DURATION: u32 = 20;
    /// Steps between two impacts: a multiple of every block here.
    const PERIOD: u32 = 64;

    /// Integrates the power cos^2(pi t/20) of `impacts` impacts, which begin a time `onset(number)` after the start of
    /// their period. Samples lie in one of `block` steps.
    fn integral(impacts: u32, block: u32, onset: impl Fn(u32) -> f64) -> (f64, SampledSum) {
        let draws = Stream::new(1, "samples");
        let mut sum = SampledSum::default();
        let mut total = 0.0;
        for step in 0..PERIOD * impacts {
            let time = f64::from(step % PERIOD) - onset(step / PERIOD);
            let is_on = (0.0..f64::from(DURATION)).contains(&time);
            let power = if is_on { (PI * time / f64::from(DURATION)).cos().powi(2) } else { 0.0 };
            let [uniform] = draws.uniform(u64::from(step / block));
            let is_due = f64::from(step % block) == (uniform * f64::from(block)).floor();
            total += sum.integrate(is_due.then_some(power), 1.0, weight(0.0));
        }
        (total, sum)
    }

    #[test]
    fn samples_give_the_integral_on_average() {
        let impacts = 2000;
        let onsets = Stream::new(1, "onsets");
        let exact = 0.5 * f64::from(DURATION * impacts);
        for block in [1, 2, 4, 8] {
            // The power jumps by 1 at both ends of an impact. A jump within an interval g between two samples makes an error
            // that is uniform between -g/2 and g/2. Jumps meet intervals of mean square <g^3>/<g>, and g = b + u - u' with two
            // uniform numbers, each of variance (b^2 - 1)/12. Five standard deviations of all jumps:
            let b = f64::from(block);
            let square = b * b + 0.5 * (b * b - 1.0);
            let deviation = (2.0 * f64::from(impacts) * square / 12.0).sqrt();
            let (at_random, sum) = integral(impacts, block, |number| 40.0 * onsets.uniform::<1>(u64::from(number))[0]);
            assert!((at_random - exact).abs() < 5.0 * deviation, "block {block}: {at_random}, not {exact}");
            // The sum knows this error, without the part within a step. The smooth fall between the jumps adds to it, and of an impact within
            // one interval it sees nothing.
            let known = sum.standard_error();
            let jumps = (2.0 * f64::from(impacts) * (square - 1.0) / 12.0).sqrt();
            assert!((0.6 * jumps..=1.3 * jumps).contains(&known), "block {block}: {known}, not {jumps}");
            // With the period of the blocks, where samples at fixed places would meet all impacts at the same phase.
            let (in_phase, _) = integral(impacts, block, |_| 3.3);
            let (all, _) = integral(impacts, 1, |_| 3.3);
            assert!((in_phase - all).abs() < 5.0 * deviation, "block {block}, in phase: {in_phase}, not {all}");
        }
    }

    #[test]
    fn a_skipped_step_counts_like_the_last_one_until_the_next_sample() {
        let mut power = SampledSum::default();
        power.integrate(Some(2.0), 0.5, weight(0.0));
        let steps = [None, None, Some(4.0), Some(4.0)].map(|sample| power.integrate(sample, 0.5, weight(0.0)));
        // Three steps with the mean power 3 W, of which two were counted with 2 W.
        assert_eq!(steps, [1.0, 1.0, 2.5, 2.0]);
        let mut losses = SampledSum::default();
        // Losses of 1 J, 2 J and 3 J, of which two were counted with 1 J.
        assert_eq!([Some(1.0), None, Some(3.0)].map(|loss| losses.sum(loss, weight(0.0))), [1.0, 1.0, 4.0]);
    }

    #[test]
    fn a_jump_is_placed_where_the_contacts_change() {
        for place in 0..7 {
            let mut power = SampledSum::default();
            power.integrate(Some(0.0), 1.0, weight(0.0));
            // The power jumps to 1 W in this step, and the next sample is the eighth.
            let total: f64 = (0..8)
                .map(|step| {
                    let activity = if step == place { 1600.0 } else { 0.0 };
                    power.integrate((step == 7).then_some(1.0), 1.0, weight(activity))
                })
                .sum();
            assert_eq!((total, power.standard_error()), (f64::from(7 - place) + 0.5, 0.0), "place {place}");
            let mut losses = SampledSum::default();
            losses.sum(Some(0.0), weight(0.0));
            let total: f64 = (0..8)
                .map(|step| losses.sum((step == 7).then_some(1.0), weight(if step == place { 1.0 } else { 0.0 })))
                .sum();
            assert_eq!(total, f64::from(8 - place), "place {place}");
        }
    }

    #[test]
    fn the_slope_behind_a_jump_is_taken_back_to_it() {
        // The power jumps to 10 W in step 3 and falls by 1 W in each step. Samples are in steps 0, 5 and 6.
        let power = |step: u32| if step < 3 { 0.0 } else { 13.0 - f64::from(step) };
        let at = |step: u32| weight(if step == 3 { 1600.0 } else { 0.0 });
        let mut sum = SampledSum::default();
        sum.integrate(Some(power(0)), 1.0, weight(0.0));
        let total: f64 = (1..=6).map(|step| sum.integrate((step > 4).then(|| power(step)), 1.0, at(step))).sum();
        let exact: f64 = (1..=6).map(|step| 0.5 * (power(step - 1) + power(step))).sum();
        assert_eq!(total, exact);
        // A centred contact: in step 3 it acts for a quarter of the step, and a half is taken.
        let power = |step: u32| if step == 3 { 2.5 } else { power(step) };
        let mut sum = SampledSum::default();
        sum.integrate(Some(power(0)), 1.0, at(0));
        let centred = |step: u32| Weight { missing: 0.5, ..at(step) };
        let total: f64 = (1..=6).map(|step| sum.integrate((step > 4).then(|| power(step)), 1.0, centred(step))).sum();
        let exact: f64 = (1..=6).map(|step| 0.5 * (power(step - 1) + power(step))).sum();
        assert_eq!((total - exact, sum.standard_error()), (2.5, (25.0f64 / 3.0).sqrt()));
    }

    #[test]
    fn steps_since_the_last_sample_are_pending_and_a_jump_is_remembered() {
        let mut power = SampledSum::default();
        power.integrate(Some(0.0), 0.5, weight(0.0));
        power.integrate(Some(4.0), 0.5, weight(0.0));
        (0..3).for_each(|_| assert_eq!(power.integrate(None, 0.5, weight(0.0)), 2.0));
        assert_eq!(power.pending(), 6.0);
        assert_eq!(power.error_ahead(12.0), 2.0 * 12.0);
        power.integrate(Some(4.0), 0.5, weight(0.0));
        assert_eq!((power.pending(), power.error_ahead(12.0)), (0.0, KEPT * 2.0 * 12.0));
    }
}
