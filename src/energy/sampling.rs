//! Steps that sum dissipation.
//!
//! The power of dashpots and the losses by friction are sums over all contacts, and make a step up to a fifth longer.
//! Scenes with many grains ([`block`]) therefore sum them in one step of each block of 4 or 8 steps, drawn at random. The powers in between
//! are interpolated (`sampled_sum.rs`). On average over the draws that is the sum over all steps, also for motions with the
//! period of the blocks.
//!
//! Error: where the power of a contact jumps by P, at the beginning and end of an impact, a block of b steps of dt makes
//! an error with the standard deviation b P dt/sqrt(12) or slightly more. An impact of n steps so has an error of about
//! 0.8 b/n of its dissipation if the drag is weak. These errors are independent if the impacts are, so that m impacts have 1/sqrt(m) of
//! it. Where they are not, further steps are summed on demand:
//!
//! * the next steps, if many more contacts than usual have begun or ended in a step, as where a layer meets a floor, or a door opens
//!   (`activity.rs`). The jump of the power is placed in that step;
//! * every step, while there are few contacts: less than one for four grains;
//! * a step in which a wall changes its velocity at once. Its contacts all change with it;
//! * every step, while an interval of a block would add more than [`SHARE`] of the dissipated energy to the standard error, as in the
//!   first impacts of a run and during an impact of many grains together.
//!
//! A step on demand is decided by earlier steps, so it makes no error on average. `DissipationError` has the standard error of the sum.
//!
//! `energy_balance_every` bounds b: with 1, every step sums dissipation. It cannot raise b.
//!
//! Limit: what many contacts lose in the one step in which they break together, such as an adhesive layer that comes off, is known only if that
//! step is summed. The sum stays right on average, and its standard error has it.

use std::num::NonZeroU32;

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use super::EnergyFlows;
use super::activity::Activity;
use super::sampled_sum::SampledSum;
use super::work::{Powers, TurningPowers};
use crate::random::Stream;
use siloflow_dem::contact::history::History;
use siloflow_dem::space::Space;
use siloflow_dem::step::Clock;
use siloflow_dem::store::ParticleStore;
use siloflow_dem::walls::surfaces::Surfaces;

/// Share of the dissipated energy that one interval between samples may add to the standard error.
pub const SHARE: f64 = 2e-3;

/// Returns the number of steps of which one sums dissipation, for a number of grains.
#[must_use]
pub const fn block(grains: usize) -> u32 {
    match grains {
        ..1000 => 1,
        1000..10_000 => 4,
        10_000.. => 8,
    }
}

/// Decides which steps sum dissipation.
#[derive(Resource)]
pub(super) struct Sampling {
    /// Largest block.
    most: u32,
    draws: Stream,
}

impl Sampling {
    /// Sampling in blocks of at most `every` steps.
    pub(super) fn new(every: Option<NonZeroU32>) -> Self {
        Self { most: every.map_or(u32::MAX, NonZeroU32::get), draws: Stream::new(0, "dissipation") }
    }

    /// Returns the block for a number of grains.
    fn block(&self, grains: usize) -> u32 {
        block(grains).min(self.most)
    }

    /// Whether the step `step` sums dissipation, in a scene that now has `grains` grains.
    fn is_due(&self, step: u64, grains: usize) -> bool {
        let block = u64::from(self.block(grains));
        if block == 1 {
            return true;
        }
        let [uniform] = self.draws.uniform(step / block);
        #[expect(clippy::cast_precision_loss, reason = "a block is short")]
        let place = uniform * block as f64;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "rounds down, below `block`")]
        let place = place as u64;
        step % block == place
    }
}

/// The error of the energy dissipated so far.
#[derive(SystemParam)]
pub(crate) struct DissipationError<'w> {
    powers: Option<Res<'w, Powers>>,
    turning: Option<Res<'w, TurningPowers>>,
}

impl DissipationError<'_> {
    /// Returns the standard error of [`EnergyFlows::dissipated`], J, as if the errors of its parts had one cause.
    pub(crate) fn standard(&self) -> f64 {
        self.sums().map(SampledSum::standard_error).sum()
    }

    /// Returns what steps without a sample have added since the last sample, J.
    pub(crate) fn pending(&self) -> f64 {
        self.sums().map(SampledSum::pending).sum()
    }

    /// Returns the standard error that an interval of `steps` steps is likely to add, J.
    fn ahead(&self, steps: f64) -> f64 {
        self.sums().map(|sum| sum.error_ahead(steps)).sum()
    }

    fn sums(&self) -> impl Iterator<Item = &SampledSum> {
        let powers = self.powers.iter().flat_map(|powers| powers.sampled());
        powers.chain(self.turning.iter().flat_map(|powers| powers.sampled()))
    }
}

/// Sets whether the force pass of this step sums dissipation. The first pass of a run does.
pub(super) fn choose<V: Space>(
    clock: Res<Clock>,
    sampling: Res<Sampling>,
    flows: Res<EnergyFlows>,
    walls: Res<Surfaces<V>>,
    error: DissipationError,
    mut activity: ResMut<Activity>,
    mut store: ResMut<ParticleStore<V>>,
) {
    let grains = store.integrated_rows().len();
    let block = sampling.block(grains);
    let mut is_due = clock.is_step_zero() || sampling.is_due(clock.steps, grains);
    if block > 1 {
        let is_demanded = activity.take_demand();
        is_due |= activity.compare(&walls) || is_demanded || activity.is_dilute(grains);
        is_due |= error.ahead(f64::from(block)) > SHARE * flows.dissipated;
    }
    store.track_energy(is_due);
}

/// Notes how much contacts have changed in this step.
pub(super) fn note_contacts<V: Space>(
    sampling: Res<Sampling>,
    store: Res<ParticleStore<V>>,
    history: Option<Res<History>>,
    mut activity: ResMut<Activity>,
) {
    if sampling.block(store.integrated_rows().len()) == 1 {
        if !activity.is_empty() {
            *activity = Activity::default();
        }
    } else if let Some(history) = history {
        activity.note(history.touching(), store.generation, store.predicts());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_block_has_one_sample_at_any_place() {
        let sampling = Sampling::new(None);
        assert!((0..100).all(|step| sampling.is_due(step, 999)));
        for (grains, length) in [(1000, 4), (10_000, 8)] {
            let samples: Vec<u64> = (0..1000 * length).filter(|&step| sampling.is_due(step, grains)).collect();
            let blocks: Vec<_> = samples.iter().map(|step| step / length).collect();
            assert_eq!(blocks, (0..1000).collect::<Vec<_>>());
            for place in 0..length {
                let count = samples.iter().filter(|&&step| step % length == place).count();
                // 1000 draws with probability 1/length; the standard deviation is at most 13.7, here five of them.
                assert!(count.abs_diff(usize::try_from(1000 / length).unwrap()) < 69, "place {place}: {count}");
            }
        }
        // A scene may bound the length of the blocks.
        let sampling = Sampling::new(NonZeroU32::new(3));
        assert_eq!((0..300).filter(|&step| sampling.is_due(step, 1000)).count(), 100);
        assert!((0..300).all(|step| sampling.is_due(step, 999)));
    }
}
