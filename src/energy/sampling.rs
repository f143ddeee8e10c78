//! Steps that sum dissipation.
//!
//! The power of dashpots and the losses by friction are sums over all contacts, and make a step up to a fifth longer.
//! Scenes with many grains ([`block`]) therefore sum them in one step of each block of 4 or 8 steps, drawn at random. The powers in between follow from the trapezoidal rule, as between all steps. On average over the draws that
//! is the sum over all steps, also for motions with the period of the blocks.
//!
//! Error: where the power of a contact jumps by P, at the beginning and end of an impact, a block of b steps of dt makes
//! an error with the standard deviation b P dt/sqrt(12) or slightly more. An impact of n steps so has an error of about
//! 0.8 b/n of its dissipation if the drag is weak. These errors are independent, so that m impacts have 1/sqrt(m) of it.
//! `energy_balance_every` bounds b: with 1, every step sums dissipation. It cannot raise b, because the watchdog takes the
//! error of few impacts for energy without a source.

use std::num::NonZeroU32;

use bevy_ecs::prelude::*;

use crate::random::Stream;
use crate::space::Space;
use crate::step::Clock;
use crate::store::ParticleStore;

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

    /// Whether the step `step` sums dissipation, in a scene that now has `grains` grains.
    fn is_due(&self, step: u64, grains: usize) -> bool {
        let block = u64::from(block(grains).min(self.most));
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

/// Sets whether the force pass of this step sums dissipation. The first pass of a run does.
pub(super) fn choose<V: Space>(clock: Res<Clock>, sampling: Res<Sampling>, mut store: ResMut<ParticleStore<V>>) {
    let is_due = clock.is_step_zero() || sampling.is_due(clock.steps, store.movable_end);
    store.track_energy(is_due);
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
