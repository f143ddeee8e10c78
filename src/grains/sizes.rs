//! The sizes of the grains of a source: one radius, a mixture with exact shares, or a range.

use serde::{Deserialize, Serialize};

use siloflow_dem::particle::Species;
use siloflow_dem::values::{Positive, Share};

/// The keys `radius` and `scale` of `fill`, `spawner` and `feed`. A `scale` has ratios in place of radii.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub enum RadiusLaw {
    /// One radius, m.
    Fixed(Positive),
    /// Radii, m, with their shares. Their order is random, but the number of each size is exactly its share of the
    /// count, rounded to whole grains. The shares sum to 1. The index of a size is its species.
    Mixture(Vec<(Positive, Share)>),
    /// Uniform between two radii, m.
    Uniform(Positive, Positive),
}

impl Default for RadiusLaw {
    /// One: the scale of a shaped grain. Sources of spheres must give radii.
    fn default() -> Self {
        Self::Fixed(Positive::try_from(1.0).expect("1 is positive"))
    }
}

impl RadiusLaw {
    /// Returns the smallest and the largest radius, m.
    #[must_use]
    pub fn range(&self) -> (f64, f64) {
        match self {
            Self::Fixed(radius) => (radius.get(), radius.get()),
            Self::Uniform(a, b) => (a.get().min(b.get()), a.get().max(b.get())),
            Self::Mixture(sizes) => {
                let radii = || sizes.iter().map(|(radius, _)| radius.get());
                (radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max))
            }
        }
    }

    /// Returns how many of `count` grains each size of a mixture gets. Shares are rounded; the last size gets the rest.
    pub(crate) fn quotas(&self, count: u32) -> Vec<u32> {
        let Self::Mixture(sizes) = self else { return Vec::new() };
        let mut left = count;
        let mut quotas: Vec<u32> = sizes
            .iter()
            .map(|(_, share)| {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a share of a count does not exceed the count"
                )]
                let quota = ((share.get() * f64::from(count)).round() as u32).min(left);
                left -= quota;
                quota
            })
            .collect();
        if let Some(last) = quotas.last_mut() {
            *last += left;
        }
        quotas
    }

    /// Returns the size of a grain for a uniform random number `u`. `quotas` holds the remaining number of grains of each size.
    pub(crate) fn choose(&self, u: f64, quotas: &mut [u32]) -> GrainSize {
        match self {
            Self::Fixed(radius) => GrainSize { radius: radius.get(), species: Species(0) },
            Self::Uniform(a, b) => GrainSize { radius: a.get() + u * (b.get() - a.get()), species: Species(0) },
            Self::Mixture(sizes) => {
                let mut remainder = u * f64::from(quotas.iter().sum::<u32>());
                let mut chosen = quotas.iter().rposition(|&quota| quota > 0).unwrap_or(0);
                for (size, &quota) in quotas.iter().enumerate() {
                    if remainder < f64::from(quota) {
                        chosen = size;
                        break;
                    }
                    remainder -= f64::from(quota);
                }
                quotas[chosen] = quotas[chosen].saturating_sub(1);
                let species = Species(u8::try_from(chosen).unwrap_or(u8::MAX));
                GrainSize { radius: sizes[chosen].0.get(), species }
            }
        }
    }
}

/// The size of a grain that a radius law gives.
#[derive(Clone, Copy)]
pub(crate) struct GrainSize {
    /// Radius, m.
    pub(crate) radius: f64,
    /// The number of its size in a mixture, else 0.
    pub(crate) species: Species,
}

/// Whether restored numbers of grains that are left, by size, are such of a source with the quotas `of_scene` and at most `most` grains.
pub(super) fn are_quotas(restored: &[u32], of_scene: &[u32], most: u32) -> bool {
    restored.len() == of_scene.len() && restored.iter().map(|&quota| u64::from(quota)).sum::<u64>() <= u64::from(most)
}
