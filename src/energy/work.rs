//! Work in a step: of dashpots, of moving walls and of forces that behaviours add, J.
//!
//! Sums run in ascending order of slots, separately for each component. Sums of drag power run chunk by chunk. Some
//! steps do not sum dissipation ([`sampling`](super::sampling)).

use std::array;
use std::ops::Add;

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::contact::history::{ContactLosses, History};
use crate::energy::{Channels, EnergyFlows};
use crate::space::{Linear, Space};
use crate::step::Clock;
use crate::store::{CHUNK, ParticleStore, TOTAL_AND_DISSIPATIVE};
use crate::walls::surfaces::Surfaces;

/// The time integral of a power, or the sum of the losses of single steps, with samples in some steps only. A step
/// without a sample counts like the last sample, until the next sample corrects the sum.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
struct SampledSum {
    /// The last sample.
    last: f64,
    /// Number of steps without a sample since then.
    skipped: u32,
}

impl SampledSum {
    /// Returns what a step of `dt` (s) adds to the integral of a power (W), by the trapezoidal rule, J.
    fn integrate(&mut self, power: Option<f64>, dt: f64) -> f64 {
        self.add(power, |last, power| 0.5 * (last + power), dt)
    }

    /// Returns what a step adds to a sum of losses, J.
    fn sum(&mut self, loss: Option<f64>) -> f64 {
        self.add(loss, |_, loss| loss, 1.0)
    }

    /// `mean` returns the mean over the steps since the last sample, from that sample and the new one.
    fn add(&mut self, value: Option<f64>, mean: impl Fn(f64, f64) -> f64, dt: f64) -> f64 {
        let Some(value) = value else {
            self.skipped += 1;
            return dt * self.last;
        };
        let skipped = f64::from(std::mem::take(&mut self.skipped));
        let last = std::mem::replace(&mut self.last, value);
        let mean = mean(last, value);
        dt * mean + skipped * dt * (mean - last)
    }
}

/// Powers at the end of the last step, W.
#[derive(Resource, Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub(super) struct Powers {
    wall: f64,
    added: f64,
    dissipation: SampledSum,
}

/// Powers of the torques of tangential and rolling dashpots, W, and losses of contacts, J: by sliding, by rolling, by
/// tangential dashpots, and where contacts break.
#[derive(Resource, Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub(super) struct TurningPowers {
    turning: SampledSum,
    rolling: SampledSum,
    losses: [SampledSum; 4],
}

/// Returns the sum of scalar products, given by component. It runs in ascending order of slots, separately for each
/// component.
fn sum<T: Linear>(products: impl Iterator<Item = T>) -> f64 {
    products.fold(T::ZERO, Add::add).sum_of_components()
}

/// Returns the power of the dissipative accumulators, by component, W. `motion` returns the velocity or spin of a
/// particle.
fn power<T: Linear, M>(sums: &[[T; TOTAL_AND_DISSIPATIVE]], movers: &[M], motion: impl Fn(&M) -> T) -> T {
    sums.iter().zip(movers).map(|([_, drag], mover)| drag.times(motion(mover))).fold(T::ZERO, Add::add)
}

/// Like [`power`], but summed chunk by chunk.
fn power_by_chunks<T: Linear, M>(sums: &[[T; TOTAL_AND_DISSIPATIVE]], movers: &[M], motion: impl Fn(&M) -> T) -> T {
    let chunks = sums.chunks(CHUNK).zip(movers.chunks(CHUNK));
    chunks.map(|(sums, movers)| power(sums, movers, &motion)).fold(T::ZERO, Add::add)
}

/// Returns the power of normal and tangential dashpots, W, if the last force pass has summed dissipation.
fn dissipation<V: Space>(store: &ParticleStore<V>, walls: &Surfaces<V>) -> Option<f64> {
    if !store.tracks_energy {
        return None;
    }
    let (force, on_fixed) = store.loads.force.entries().split_at(store.movable_end);
    let (body, fixed) = store.body.split_at(store.movable_end);
    // The kick's sum is reused if there is one; otherwise the sum runs in the same order.
    let of_grains = store.kick_sum.unwrap_or_else(|| power_by_chunks(force, body, |body| body.velocity));
    let mut dissipation = -of_grains.sum_of_components();
    // Most fixed particles do not move.
    for ([_, drag], body) in on_fixed.iter().zip(fixed).filter(|(_, body)| body.velocity != V::ZERO) {
        dissipation -= drag.dot(body.velocity);
    }
    for (moving, load) in walls.with_loads() {
        dissipation -= load.drag.dot(moving.velocity) + load.drag_torque.dot(moving.spin);
    }
    Some(dissipation)
}

/// Adds the work of normal and tangential dashpots and of moving walls.
pub(super) fn add_contact_work<V: Space>(
    clock: Res<Clock>,
    store: Res<ParticleStore<V>>,
    walls: Res<Surfaces<V>>,
    mut flows: ResMut<EnergyFlows>,
    mut last: ResMut<Powers>,
) {
    let mut wall = 0.0;
    for (i, body) in store.body.iter().enumerate().skip(store.movable_end).filter(|(_, body)| body.velocity != V::ZERO)
    {
        let added = store.added.get(i).copied().unwrap_or(V::ZERO);
        wall -= (store.loads.force.of(i) - added).dot(body.velocity);
    }
    for (moving, load) in walls.with_loads() {
        wall -= load.force.dot(moving.velocity) + load.torque.dot(moving.spin);
    }
    let dissipated = last.dissipation.integrate(dissipation(&store, &walls), clock.dt);
    if !clock.is_step_zero() {
        flows.dissipated += dissipated;
        flows.wall_work += 0.5 * clock.dt * (last.wall + wall);
    }
    last.wall = wall;
}

/// Returns the powers of the torques of tangential dashpots and of rolling dashpots, W, if the last force pass has
/// summed dissipation.
fn turning_powers<V: Space>(store: &ParticleStore<V>) -> Option<[f64; 2]> {
    if !store.tracks_energy {
        return None;
    }
    let (torque, on_fixed) = store.loads.torque.entries().split_at(store.movable_end);
    let (rotation, fixed) = store.rotation.split_at(store.movable_end);
    // The kick's sum is reused if there is one; otherwise the sum runs in the same order.
    let of_grains = store.spin_kick_sum.unwrap_or_else(|| power_by_chunks(torque, rotation, |rotation| rotation.spin));
    let turning = -(of_grains + power(on_fixed, fixed, |rotation| rotation.spin)).sum_of_components();
    let rolling = store.loads.rolling_drag.iter().zip(&store.rotation);
    Some([turning, -sum(rolling.map(|(drag, rotation)| drag.times(rotation.spin)))])
}

/// Adds the losses of friction and rolling resistance.
pub(super) fn add_friction_loss<V: Space>(
    clock: Res<Clock>,
    store: Res<ParticleStore<V>>,
    history: Res<History<V>>,
    mut flows: ResMut<EnergyFlows>,
    mut channels: ResMut<Channels>,
    mut last: ResMut<TurningPowers>,
) {
    let powers = turning_powers(&store);
    let losses = powers.map(|_| {
        let ContactLosses { sliding, rolling, dashpots, breaking } = history.lost();
        [sliding, rolling, dashpots, breaking]
    });
    let [sliding, rolled, dashpots, breaking] =
        array::from_fn(|channel| last.losses[channel].sum(losses.map(|losses| losses[channel])));
    // Step zero counts too: a dashpot beyond the cap loads its spring there, and this energy must have a source.
    channels.tangential += sliding + dashpots;
    channels.rolling += rolled;
    flows.dissipated += sliding + rolled + breaking;
    let turning = last.turning.integrate(powers.map(|[turning, _]| turning), clock.dt);
    let rolling = last.rolling.integrate(powers.map(|[_, rolling]| rolling), clock.dt);
    if !clock.is_step_zero() {
        channels.rolling += rolling;
        flows.dissipated += turning + rolling;
    }
}

/// Adds the work of forces that behaviours add. The store has summed their power when they were written.
pub(super) fn add_behaviour_work<V: Space>(
    clock: Res<Clock>,
    store: Res<ParticleStore<V>>,
    mut flows: ResMut<EnergyFlows>,
    mut last: ResMut<Powers>,
) {
    let added = store.added_power.unwrap_or_default();
    if !clock.is_step_zero() {
        flows.added_work += 0.5 * clock.dt * (last.added + added);
    }
    last.added = added;
}

/// Adds the potential energy of grains wrapped at periodic sides in this step.
pub(super) fn add_lifted_energy<V: Space>(store: Res<ParticleStore<V>>, mut flows: ResMut<EnergyFlows>) {
    flows.lifted += store.lifted;
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
