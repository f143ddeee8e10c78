//! Fill: places the initial grains on a lattice, or at random. Examples are a block that falls, a gas, or the rough wall of a
//! chute or a shear cell.
//!
//! With `place: Lattice`, a square lattice of side `spacing` (in solid space a cubic one) fills the box from `low` to `high`. Its x index runs
//! fastest, then y, then z. Space that does not hold a whole cell stays free at the upper ends. Each grain is displaced
//! by a uniform `jitter`, and starts with `velocity` plus a uniform `agitation`. Both are half-widths. The random
//! numbers depend only on the seed and the number of the grain.
//!
//! With `place: Random`, grains are placed one after the other (random sequential addition). Each lies wholly in the box, and its place is
//! uniform among those where it overlaps no grain and no wall. Places are drawn until one is free. If one grain has drawn
//! [`MOST_TRIES`] places in vain, the fill ends, and the scene is refused with the number that was reached. Equal discs reach at most 0.547 of
//! the area (Feder 1980, J. Theor. Biol. 87, 237), equal spheres 0.385 of the volume (Cooper 1988, Phys. Rev. A 38, 522); such dense fills
//! take many tries.
//!
//! With `fixed: true` the grains never move by forces. A fixed grain with a shape is a set of fixed spheres: each of them is a wall grain of its
//! own, and stands where the orientation of the grain puts it. With a `name`, or as a door, these spheres are walls, like a `Sphere` of
//! `walls` with this name.

use serde::{Deserialize, Serialize};

use crate::grains::MOST_GRAINS;
use crate::grains::file::GrainRow;
use crate::grains::mass::MassLaw;
use crate::grains::occupied::Occupied;
use crate::grains::shaped::{
    OrientationLaw, Posture, ShapeNames, Shaped, SizeRange, largest_reach, reach, size_ranges,
};
use crate::grains::sizes::{GrainSize, RadiusLaw};
use crate::random::Stream;
use siloflow_dem::particle::{GrainId, Species};
use siloflow_dem::space::{Dimension, Plane, Solid};
use siloflow_dem::values::{FiniteVector, NonNegative, Positive};

/// One entry of the scene key `fill`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Fill {
    /// Lower corner of the box, m.
    pub low: FiniteVector,
    /// Upper corner of the box, m.
    pub high: FiniteVector,
    /// Where the grains stand in the box.
    #[serde(default)]
    pub place: Placement,
    /// Side of the lattice, m; needed by a lattice.
    pub spacing: Option<Positive>,
    /// Radii, m; of shaped grains those of spheres (discs) of equal volume (area). Default: none, needed without `shape`.
    #[serde(default)]
    pub radius: RadiusLaw,
    /// Name of the shape of these grains, or one for each size of a mixture. Default: spheres (discs).
    pub shape: Option<ShapeNames>,
    /// Sizes over that of the shape. Default: 1.
    pub scale: Option<RadiusLaw>,
    /// Orientations of shaped grains. Default: random.
    pub orientation: Option<OrientationLaw>,
    /// The shape, once the scene is loaded.
    #[serde(skip)]
    pub shaped: Option<Shaped>,
    /// Number of grains; needed by random places. Default on a lattice: as many as fit.
    pub count: Option<u32>,
    /// Half-width of the displacement of each coordinate, m. Default 0.
    #[serde(default)]
    pub jitter: Option<NonNegative>,
    /// Velocity, m/s. Default 0. Fixed grains keep it.
    pub velocity: Option<FiniteVector>,
    /// Half-widths of a uniform random velocity, m/s. Default 0.
    pub agitation: Option<FiniteVector>,
    /// Whether the grains are fixed: each is a wall grain, or with a `shape` as many as it has spheres.
    #[serde(default)]
    pub fixed: bool,
    /// Name of fixed grains, which are walls then, for `motions` and `doors`; walls and other fills may share it. Default: none.
    pub name: Option<String>,
    /// Whether fixed grains are part of the door of the key `door`. They are walls then, which vanish when the door opens, and grains that
    /// pass through their places are out.
    #[serde(default)]
    pub door: bool,
    /// Species of the first size of `radius`. Default 0.
    #[serde(default)]
    pub species: u8,
    /// Law for the masses of these grains. Default: the scene's `mass`.
    pub mass: Option<MassLaw>,
}

/// Where the grains of a fill stand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum Placement {
    /// On a square or cubic lattice.
    #[default]
    Lattice,
    /// At random places without overlap.
    Random,
}

/// Most places that a random fill draws in vain for one grain.
pub const MOST_TRIES: u32 = 20_000;

/// A wall grain of the scene: a fixed grain, or a sphere of one with a shape.
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

/// Selects the random numbers of a fill.
#[derive(Clone, Copy)]
pub(crate) struct FillStream {
    /// The scene's seed.
    pub(crate) seed: u64,
    /// The number of the fill in the scene.
    pub(crate) number: usize,
}

impl FillStream {
    fn of(self, what: &str) -> Stream {
        Stream::new(self.seed, &format!("fill {}{what}", self.number))
    }
}

impl Fill {
    /// Returns the number of lattice cells along each axis, as whole numbers of any size; infinite if the box is too long for
    /// a number.
    fn cells(&self, dimension: Dimension) -> [f64; 3] {
        let low = self.low.padded();
        let high = self.high.padded();
        // The corners of a box far from the origin are rounded themselves.
        let round_off = (low.abs() + high.abs()) * f64::EPSILON;
        let size = high - low + round_off;
        let spacing = self.spacing.map_or(f64::INFINITY, Positive::get);
        let along = |axis: usize| (size[axis] / spacing * (1.0 + 1e-12)).floor().max(0.0);
        [along(0), along(1), if dimension == Dimension::Solid { along(2) } else { 1.0 }]
    }

    /// Returns the number of grains that fit; it may be infinite. How many fit at random places is not known before.
    #[must_use]
    pub fn capacity(&self, dimension: Dimension) -> f64 {
        if self.place == Placement::Random {
            return f64::INFINITY;
        }
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

    /// Whether the fixed grains are walls with a name, or a door.
    #[must_use]
    pub fn makes_walls(&self) -> bool {
        self.name.is_some() || self.door
    }

    /// Returns the number of spheres of the grain that has most.
    #[must_use]
    pub fn most_spheres(&self) -> usize {
        size_ranges(&self.radius, self.shaped.as_ref()).iter().map(SizeRange::count).max().unwrap_or(1)
    }

    /// Returns whether the grains depend on the seed.
    #[must_use]
    pub fn is_random(&self) -> bool {
        let is_jittered = self.jitter.is_some_and(|jitter| jitter.get() > 0.0);
        is_jittered
            || self.agitation.is_some()
            || self.shaped.as_ref().is_some_and(|shaped| shaped.orientation == OrientationLaw::Random)
            || self.place == Placement::Random
            || !matches!(self.radius, RadiusLaw::Fixed(_))
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
        let stream = FillStream { seed, number };
        let random = stream.of("");
        let turns = stream.of(" orientation");
        let mut quotas = self.radius.quotas(count);
        let axes = |v| axes(dimension, v);
        let jitter = self.jitter.map_or(0.0, NonNegative::get);
        let spacing = self.spacing.map_or(0.0, Positive::get);
        (0..count)
            .filter_map(|n| {
                let [size, x, y, z, vx, vy, vz] = random.uniform::<7>(u64::from(n));
                let size = self.radius.choose(size, &mut quotas);
                let cell = [n % columns, n / columns % rows, n / columns / rows].map(|c| f64::from(c) + 0.5);
                let displaced = axes([x, y, z].map(|u| jitter * (2.0 * u - 1.0)));
                let position = self.low.padded() + axes(cell) * spacing + displaced;
                let id = GrainId::grain(first_id.checked_add(n)?)?;
                let row = self.row(id, position, size, mass, axes([vx, vy, vz]));
                Some(GrainRow { posture: self.posture(dimension, size, &turns, n), ..row })
            })
            .collect()
    }

    /// Returns the grain with this id, place and size. `u` holds uniform numbers for its velocity.
    fn row(&self, id: GrainId, position: Solid, size: GrainSize, mass: Option<MassLaw>, u: Solid) -> GrainRow {
        let GrainSize { radius, species } = size;
        let velocity = self.velocity.map_or(Solid::ZERO, FiniteVector::padded);
        let agitation = self.agitation.map_or(Solid::ZERO, FiniteVector::padded);
        GrainRow {
            id,
            radius,
            mass: self.mass.or(mass).map_or(1.0, |law| law.of(radius)),
            position,
            velocity: velocity + agitation * (2.0 * u - Solid::ONE),
            spin: Solid::ZERO,
            posture: None,
            species: Species(self.species.saturating_add(species.0)),
        }
    }

    /// Returns the posture of grain `n` of this size.
    fn posture(&self, dimension: Dimension, size: GrainSize, turns: &Stream, n: u32) -> Option<Posture> {
        let shaped = self.shaped.as_ref()?;
        let numbers = turns.uniform::<3>(u64::from(n));
        let GrainSize { radius, species } = size;
        Some(match dimension {
            Dimension::Plane => shaped.posture::<Plane>(usize::from(species.0), radius, numbers),
            Dimension::Solid => shaped.posture::<Solid>(usize::from(species.0), radius, numbers),
        })
    }

    /// Returns the largest radius (m) of the smallest sphere about its centre that holds a grain.
    #[must_use]
    pub fn largest_reach(&self) -> f64 {
        largest_reach(&self.radius, self.shaped.as_ref())
    }

    /// Like [`Fill::grains`], at random places that `occupied` and `is_clear` (of walls; centre and radius, m) leave free. The places are
    /// occupied then. Returns fewer grains than `count` if the next one finds no place.
    pub(crate) fn random_grains(
        &self,
        dimension: Dimension,
        mass: Option<MassLaw>,
        stream: FillStream,
        first_id: u32,
        occupied: &mut Occupied,
        is_clear: impl Fn(Solid, f64) -> bool,
    ) -> Vec<GrainRow> {
        let count = self.count.unwrap_or(0);
        let [sizes, places, turns] = ["", " place", " orientation"].map(|what| stream.of(what));
        let mut quotas = self.radius.quotas(count);
        let low = self.low.padded();
        let high = self.high.padded();
        let place = |n: u32, radius: f64, occupied: &Occupied| {
            let size = high - low - axes(dimension, [2.0 * radius; 3]);
            let low = low + axes(dimension, [radius; 3]);
            let tries = (0..MOST_TRIES).filter(|_| size.cmpge(Solid::ZERO).all());
            let mut drawn =
                tries.map(|t| low + size * axes(dimension, places.uniform(u64::from(n) << 32 | u64::from(t))));
            drawn.find(|&x| occupied.is_free(x, radius) && is_clear(x, radius))
        };
        let mut rows = Vec::new();
        for n in 0..count {
            let [size, _, _, _, vx, vy, vz] = sizes.uniform::<7>(u64::from(n));
            let size = self.radius.choose(size, &mut quotas);
            let Some(id) = first_id.checked_add(n).and_then(GrainId::grain) else { break };
            let reach = reach(self.shaped.as_ref(), usize::from(size.species.0), size.radius);
            let Some(x) = place(n, reach, occupied) else { break };
            occupied.add(x, reach);
            let row = self.row(id, x, size, mass, axes(dimension, [vx, vy, vz]));
            rows.push(GrainRow { posture: self.posture(dimension, size, &turns, n), ..row });
        }
        rows
    }
}

/// Returns the vector with these components; in the plane without the third.
fn axes(dimension: Dimension, v: [f64; 3]) -> Solid {
    if dimension == Dimension::Solid { Solid::from(v) } else { Solid::new(v[0], v[1], 0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use siloflow_text::source::parse;

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
    fn the_mass_of_a_fill_has_precedence_over_that_of_the_scene() {
        let own = fill(
            "(low: (0.0, 0.0, 0.0), high: (0.1, 0.1, 0.1), spacing: 0.1, radius: Fixed(0.04), mass: Sphere(7200.0))",
        );
        let scene = Some(MassLaw::Sphere(2500.0.try_into().unwrap()));
        let mass = |fill: &Fill| fill.grains(Dimension::Solid, scene, 1, 0, 1)[0].mass;
        let usual = Fill { mass: None, ..own.clone() };
        // Products of five rounded numbers.
        assert!((mass(&own) / mass(&usual) - 7200.0 / 2500.0).abs() < 10.0 * f64::EPSILON);
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
