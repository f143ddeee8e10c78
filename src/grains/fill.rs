//! Lattice fill: places the initial grains on a lattice. Examples are a block that falls, a gas, or the rough wall of a
//! chute or a shear cell.
//!
//! A square lattice of side `spacing` (in solid space a cubic one) fills the box from `low` to `high`. Its x index runs
//! fastest, then y, then z. Space that does not hold a whole cell stays free at the upper ends. Each grain is displaced
//! by a uniform `jitter`, and starts with `velocity` plus a uniform `agitation`. Both are half-widths. The random
//! numbers depend only on the seed and the number of the grain.

use serde::{Deserialize, Serialize};

use crate::grains::MOST_GRAINS;
use crate::grains::file::GrainRow;
use crate::grains::mass::MassLaw;
use crate::grains::spawner::RadiusLaw;
use crate::particle::{GrainId, Species};
use crate::random::Stream;
use crate::space::{Dimension, Solid};
use crate::values::{FiniteVector, NonNegative, Positive};

/// One entry of the scene key `fill`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Fill {
    /// Lower corner of the box, m.
    pub low: FiniteVector,
    /// Upper corner of the box, m.
    pub high: FiniteVector,
    /// Side of the lattice, m.
    pub spacing: Positive,
    /// Radii, m.
    pub radius: RadiusLaw,
    /// Number of grains. Default: as many as fit.
    pub count: Option<u32>,
    /// Half-width of the displacement of each coordinate, m. Default 0.
    #[serde(default)]
    pub jitter: Option<NonNegative>,
    /// Velocity, m/s. Default 0. Fixed grains keep it.
    pub velocity: Option<FiniteVector>,
    /// Half-widths of a uniform random velocity, m/s. Default 0.
    pub agitation: Option<FiniteVector>,
    /// Whether the grains are fixed wall grains.
    #[serde(default)]
    pub fixed: bool,
    /// Species of the first size of `radius`. Default 0.
    #[serde(default)]
    pub species: u8,
}

/// A wall grain of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedGrain {
    /// Centre, m.
    pub position: Solid,
    /// Radius, m.
    pub radius: f64,
    /// Velocity, m/s.
    pub velocity: Solid,
    /// Species.
    pub species: Species,
}

impl Fill {
    /// Returns the number of lattice cells along each axis, as whole numbers of any size; infinite if the box is too long for
    /// a number.
    fn cells(&self, dimension: Dimension) -> [f64; 3] {
        let (low, high) = (self.low.padded(), self.high.padded());
        // The corners of a box far from the origin are rounded themselves.
        let round_off = (low.abs() + high.abs()) * f64::EPSILON;
        let size = high - low + round_off;
        let along = |axis: usize| (size[axis] / self.spacing.get() * (1.0 + 1e-12)).floor().max(0.0);
        [along(0), along(1), if dimension == Dimension::Solid { along(2) } else { 1.0 }]
    }

    /// Returns the number of grains that fit; it may be infinite.
    #[must_use]
    pub fn capacity(&self, dimension: Dimension) -> f64 {
        let cells = self.cells(dimension);
        // Zero times infinity is no number.
        if cells.contains(&0.0) { 0.0 } else { cells.into_iter().product() }
    }

    /// Returns the number of grains; `None` if they are more than [`MOST_GRAINS`].
    #[must_use]
    pub fn size(&self, dimension: Dimension) -> Option<u32> {
        let capacity = self.capacity(dimension);
        let wanted = self.count.map_or(capacity, f64::from).min(capacity);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 1e7, not negative")]
        let size = (wanted <= f64::from(MOST_GRAINS)).then_some(wanted as u32);
        size
    }

    /// Returns the grains, with ids from `first_id` on, until ids run out. `number` is the number of this `fill` in the
    /// scene and selects its random numbers.
    pub fn grains(
        &self,
        dimension: Dimension,
        mass: Option<MassLaw>,
        seed: u64,
        number: usize,
        first_id: u32,
    ) -> Vec<GrainRow> {
        let count = self.size(dimension).unwrap_or(0);
        // A longer row than there are grains makes no difference.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped; at most 1e7")]
        let [columns, rows, _] = self.cells(dimension).map(|cells| cells.clamp(1.0, f64::from(MOST_GRAINS)) as u32);
        let random = Stream::new(seed, &format!("fill {number}"));
        let mut quotas = self.radius.quotas(count);
        let axes =
            |v: [f64; 3]| if dimension == Dimension::Solid { Solid::from(v) } else { Solid::new(v[0], v[1], 0.0) };
        let jitter = self.jitter.map_or(0.0, NonNegative::get);
        let velocity = self.velocity.map_or(Solid::ZERO, FiniteVector::padded);
        let agitation = self.agitation.map_or(Solid::ZERO, FiniteVector::padded);
        (0..count)
            .filter_map(|n| {
                let [size, x, y, z, vx, vy, vz] = random.uniform::<7>(u64::from(n));
                let (radius, species) = self.radius.choose(size, &mut quotas);
                let cell = [n % columns, n / columns % rows, n / columns / rows].map(|c| f64::from(c) + 0.5);
                let displaced = axes([x, y, z].map(|u| jitter * (2.0 * u - 1.0)));
                let agitated = agitation * axes([vx, vy, vz].map(|u| 2.0 * u - 1.0));
                Some(GrainRow {
                    id: GrainId::grain(first_id.checked_add(n)?)?,
                    radius,
                    mass: mass.map_or(1.0, |law| law.of(radius)),
                    position: self.low.padded() + axes(cell) * self.spacing.get() + displaced,
                    velocity: velocity + agitated,
                    spin: Solid::ZERO,
                    species: Species(self.species.saturating_add(species.0)),
                })
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::parse;

    fn fill(text: &str) -> Fill {
        parse::parse("fill.ron", text).unwrap()
    }

    #[test]
    fn a_box_is_filled_row_by_row_and_layer_by_layer() {
        let block = fill("(low: (0.0, 0.0, 0.0), high: (0.3, 0.2, 0.2), spacing: 0.1, radius: Fixed(0.04))");
        assert_eq!(block.size(Dimension::Solid), Some(12));
        let grains = block.grains(Dimension::Solid, None, 1, 0, 5);
        let near = |n: usize, x: f64, y: f64, z: f64| grains[n].position.distance(Solid::new(x, y, z)) < 1e-16;
        assert!(near(0, 0.05, 0.05, 0.05) && near(3, 0.05, 0.15, 0.05) && near(11, 0.25, 0.15, 0.15));
        assert_eq!((grains[0].id, grains[11].id), (GrainId::grain(5).unwrap(), GrainId::grain(16).unwrap()));
    }

    #[test]
    fn boxes_of_any_size_have_a_capacity_and_a_count_bounds_their_grains() {
        let long = |count: &str| {
            fill(&format!("(low: (0.0, 0.0), high: (1.0e10, 1.0), spacing: 1.0, radius: Fixed(0.3){count})"))
        };
        assert_eq!((long("").capacity(Dimension::Plane), long("").size(Dimension::Plane)), (1.0e10, None));
        let few = long(", count: 3");
        assert_eq!(few.size(Dimension::Plane), Some(3));
        assert_eq!(few.grains(Dimension::Plane, None, 1, 0, 1)[2].position, Solid::new(2.5, 0.5, 0.0));
        let endless = fill("(low: (-1.7e308, 0.0), high: (1.7e308, 0.1), spacing: 1.0, radius: Fixed(0.3))");
        assert_eq!((endless.capacity(Dimension::Plane), endless.size(Dimension::Plane)), (0.0, Some(0)));
    }

    #[test]
    fn as_many_fit_far_from_the_origin() {
        let far =
            fill("(low: (999999.96, -1.0e6), high: (1000000.04, -999999.68), spacing: 0.08, radius: Fixed(0.04))");
        assert_eq!(far.size(Dimension::Plane), Some(4));
    }

    #[test]
    fn jitter_and_agitation_stay_within_their_half_widths_and_follow_the_seed() {
        let gas = fill(
            "(low: (0.0, 0.0), high: (1.0, 1.0), spacing: 0.1, radius: Fixed(0.01), jitter: 0.02, velocity: (1.0, 0.0),
              agitation: (0.5, 0.0))",
        );
        let grains = |seed: u64| gas.grains(Dimension::Plane, None, seed, 0, 1);
        for grain in grains(1) {
            let off = (grain.position / 0.1 - Solid::splat(0.5)) * 0.1;
            let from_site = off - (off / 0.1).round() * 0.1;
            assert!(from_site.x.abs() <= 0.02 + 1e-15 && from_site.y.abs() <= 0.02 + 1e-15);
            assert!((0.5..=1.5).contains(&grain.velocity.x) && grain.velocity.y == 0.0 && grain.position.z == 0.0);
        }
        assert_eq!(grains(1), grains(1));
        assert_ne!(grains(1), grains(2));
    }
}
