//! Fields on grids: densities, velocity, temperature, stress and shares of species, as averages over time.
//!
//! Each sample adds to a cell, with a weight w (1/m^3; in the plane 1/m^2) of each grain or contact in it:
//!
//! | field | from |
//! |---|---|
//! | solid fraction | sum w V of the volumes (in the plane: areas) V of grains |
//! | mass density rho | sum w m |
//! | velocity u | sum w m v / sum w m |
//! | granular temperature | trace of the kinetic stress / (D rho), D = 2 or 3 components |
//! | kinetic stress | sum w m v v - rho u u |
//! | contact stress | sum W f l, with the force f on one grain and the vector l from its partner to it |
//! | share of a species | sum w m over its grains / sum w m |
//!
//! The sums are means over all samples of the average; u is their velocity, so the kinetic stress and the temperature contain the
//! variation of u in the cell and in time. Compression is positive. A bed at rest fulfils div(stress) = rho g. A sum f l has the force
//! as first index.
//!
//! With the kernel `Cells`, w = 1/(volume of the cell) for a centre in the cell, and W is the part of l in the cell over that volume.
//! Both are exact, so the sum of rho times volume is the mass. With `Gaussian(s)`, fields are values at the middle of the cell: w is
//! the normal density of standard deviation s about it, and W is its mean along l, to 1e-11
//! (Goldhirsch, Granular Matter 12, 239 (2010)). Densities are cut off at 6 s along each axis, where 2e-9 of the mass is missing.
//!
//! Branches l run from centre to centre, or from the centre to the contact point on a wall or a fixed grain. So a field that a
//! Gaussian spreads beyond a wall misses the load of that wall within about 3 s of it. Fixed grains have no mass here.
//!
//! On (r, z) grids the components of each grain are taken at its centre, and those of a contact at the middle of its part in a ring.
//! Near the axis, where a grain is not small against r, radial and angular stress mix.

mod axis_cells;
mod blocks;
mod grid;
mod kernel;
mod visit;

use serde::{Deserialize, Serialize};

pub use self::blocks::{Blocks, FEWEST_BLOCKS, MOST_BLOCKS};
pub use self::grid::Grid;
use siloflow_dem::contact::{Memory, Pair};
use siloflow_dem::space::{Dimension, Space};
use siloflow_dem::survey::{Partner, Survey};
use siloflow_dem::values::{Finite, NonNegative, Positive};

/// One entry of the scene key `fields`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Field {
    /// The grid.
    pub grid: FieldGrid,
    /// The weight of grains and contacts. Default `Cells`.
    #[serde(default)]
    pub kernel: Kernel,
    /// Time between samples, s.
    pub sample: Positive,
    /// Time of the first sample, s. Default 0.
    pub from: Option<NonNegative>,
    /// Time over which samples are averaged, s. Default: the whole run.
    pub average: Option<Positive>,
}

/// The weight of grains and contacts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub enum Kernel {
    /// Sharp cells.
    #[default]
    Cells,
    /// A Gaussian of this standard deviation, m, about the middle of each cell.
    Gaussian(Positive),
}

/// A grid of the scene. Lengths are in m; `cells` are numbers of cells.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum FieldGrid {
    /// Rectangles in the plane.
    XY {
        /// Lower left corner, m.
        low: (Finite, Finite),
        /// Upper right corner, m.
        high: (Finite, Finite),
        /// Columns and rows.
        cells: (u16, u16),
    },
    /// Boxes of solid space that reach through `y`.
    XZ {
        /// Lowest x and z, m.
        low: (Finite, Finite),
        /// Highest x and z, m.
        high: (Finite, Finite),
        /// Columns and rows.
        cells: (u16, u16),
        /// Lowest and highest y, m. Default: the periodic side.
        y: Option<(Finite, Finite)>,
    },
    /// Rings of solid space about a vertical axis.
    RZ {
        /// Place (x, y) of the axis, m. Default (0, 0).
        #[serde(default = "origin")]
        axis: (Finite, Finite),
        /// Outer radius of the last ring, m.
        radius: Positive,
        /// Lowest z, m.
        low: Finite,
        /// Highest z, m.
        high: Finite,
        /// Rings and layers.
        cells: (u16, u16),
    },
    /// Boxes of solid space.
    XYZ {
        /// Lowest corner, m.
        low: (Finite, Finite, Finite),
        /// Highest corner, m.
        high: (Finite, Finite, Finite),
        /// Cells along x, y and z.
        cells: (u16, u16, u16),
    },
}

impl FieldGrid {
    /// Number of cells.
    #[must_use]
    pub fn cells(&self) -> usize {
        let along = match *self {
            Self::XY { cells, .. } | Self::XZ { cells, .. } | Self::RZ { cells, .. } => [cells.0, cells.1, 1],
            Self::XYZ { cells, .. } => [cells.0, cells.1, cells.2],
        };
        along.into_iter().map(usize::from).fold(1, usize::saturating_mul)
    }
}

fn origin() -> (Finite, Finite) {
    let zero = Finite::try_from(0.0).expect("0 is finite");
    (zero, zero)
}

/// The means of a cell, in their order. [`Layout::means_of`] computes them.
pub const MEANS: [Mean; 7] = [
    Mean::new("solid_fraction", "", "volume of grains over volume; in the plane, areas", Indices::None),
    Mean::new("density", "kg/m^3, in the plane kg/m^2", "mass of grains over volume", Indices::None),
    Mean::new("v", "m/s", "momentum over mass", Indices::Axis),
    Mean::new(
        "temperature",
        "m^2/s^2",
        "granular temperature: trace of the kinetic stress over the density and the number of axes",
        Indices::None,
    ),
    Mean::new(
        "kinetic_",
        "Pa, in the plane N/m",
        "kinetic stress: mean of m v v, less density times the mean velocities",
        Indices::Symmetric,
    ),
    Mean::new(
        "contact_",
        "Pa, in the plane N/m",
        "contact stress; the force is along the first axis, the branch along the second",
        Indices::TwoAxes,
    ),
    Mean::new("share_", "", "share of each species in the mass; absent with one species", Indices::Species),
];

/// A mean of a cell, with all its components.
#[derive(Clone, Copy, Debug)]
pub struct Mean {
    /// The name in the header, before the indices.
    name: &'static str,
    /// Unit, as in `m^2/s^2`.
    pub unit: &'static str,
    /// Meaning, as in the documentation.
    pub meaning: &'static str,
    indices: Indices,
}

/// The indices of the components of a mean. Axes are numbered from 1, species from 0.
#[derive(Clone, Copy, Debug)]
enum Indices {
    None,
    Axis,
    /// Two axes, the second not below the first.
    Symmetric,
    TwoAxes,
    Species,
}

impl Mean {
    const fn new(name: &'static str, unit: &'static str, meaning: &'static str, indices: Indices) -> Self {
        Self { name, unit, meaning, indices }
    }

    /// Returns the names of the components.
    #[must_use]
    pub fn names(self, layout: Layout) -> Vec<String> {
        let Self { name, indices, .. } = self;
        let axes = 1..=layout.components;
        match indices {
            Indices::None => vec![name.to_owned()],
            Indices::Axis => axes.map(|a| format!("{name}{a}")).collect(),
            Indices::Symmetric => {
                axes.flat_map(|a| (a..=layout.components).map(move |b| format!("{name}{a}{b}"))).collect()
            }
            Indices::TwoAxes => axes.clone().flat_map(|a| axes.clone().map(move |b| format!("{name}{a}{b}"))).collect(),
            Indices::Species => (0..layout.species).map(|species| format!("{name}{species}")).collect(),
        }
    }
}

/// The layout of the sums of a cell, and of its means.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// Components of a vector.
    pub components: usize,
    /// Number of species.
    pub species: usize,
}

impl Layout {
    /// Components of a symmetric tensor.
    fn symmetric(self) -> usize {
        self.components * (self.components + 1) / 2
    }

    /// Index of the first sum of the kinetic stress: after volume, mass and momentum.
    fn kinetic(self) -> usize {
        2 + self.components
    }

    fn contact(self) -> usize {
        self.kinetic() + self.symmetric()
    }

    fn shares(self) -> usize {
        self.contact() + self.components * self.components
    }

    /// Number of sums of a cell.
    #[must_use]
    pub fn sums(self) -> usize {
        self.shares() + self.species
    }

    /// Number of means of a cell: the temperature is added to the sums.
    #[must_use]
    pub fn means(self) -> usize {
        self.sums() + 1
    }

    /// Returns the names of the means, in the order of [`Self::means_of`].
    #[must_use]
    pub fn names(self) -> Vec<String> {
        MEANS.iter().flat_map(|mean| mean.names(self)).collect()
    }

    /// Returns the fields of a cell whose sums are, for one sample, `sums`. Fields that are means over grains are NaN in a cell without grains.
    #[must_use]
    pub fn means_of(self, sums: &[f64]) -> Vec<f64> {
        let mass = sums[1];
        let per_mass = |sum: f64| if mass > 0.0 { sum / mass } else { f64::NAN };
        let velocity: Vec<_> = sums[2..self.kinetic()].iter().map(|&momentum| per_mass(momentum)).collect();
        let mut kinetic = sums[self.kinetic()..self.contact()].to_vec();
        let mut trace = 0.0;
        let mut index = 0;
        for a in 0..self.components {
            for b in a..self.components {
                if mass > 0.0 {
                    kinetic[index] -= mass * velocity[a] * velocity[b];
                }
                if a == b {
                    // Rounding of the difference must not give a negative temperature.
                    kinetic[index] = kinetic[index].max(0.0);
                    trace += kinetic[index];
                }
                index += 1;
            }
        }
        #[expect(clippy::cast_precision_loss, reason = "two or three")]
        let temperature = per_mass(trace / self.components as f64);
        let mut means = vec![sums[0], mass];
        means.extend(velocity);
        means.push(temperature);
        means.extend(kinetic);
        means.extend(&sums[self.contact()..self.shares()]);
        means.extend(sums[self.shares()..].iter().map(|&of_species| per_mass(of_species)));
        means
    }
}

/// Sums of a field so far.
pub struct FieldSampler<V: Space> {
    /// The entry of the scene.
    pub field: Field,
    /// The grid.
    pub grid: Grid<V>,
    /// The layout of the sums.
    pub layout: Layout,
    /// The sums, by cell.
    pub blocks: Blocks,
}

impl<V: Space> FieldSampler<V> {
    /// Makes a sampler without samples, of grains of `species` species.
    #[must_use]
    pub fn new(field: Field, grid: Grid<V>, species: usize) -> Self {
        let layout = Layout { components: V::COMPONENTS, species };
        let blocks = Blocks::new(grid.len() * layout.sums());
        Self { field, grid, layout, blocks }
    }

    /// Adds a sample of the grains that are present and of all their contacts.
    pub fn add(&mut self, survey: &Survey<'_, V>) {
        let store = survey.store;
        let layout = self.layout;
        let grid = &self.grid;
        let sums = self.blocks.present();
        for i in store.integrated_rows().filter(|&i| store.is_present(i)) {
            let body = &store.body[i];
            let mass = store.mass[i];
            let species = usize::from(store.species[i].0);
            grid.visit_point(body.position, store.periodic.as_ref(), |cell, weight, at| {
                let sums = &mut sums[cell * layout.sums()..][..layout.sums()];
                let v = grid.components(body.velocity, at);
                sums[0] += weight * volume::<V>(body.radius);
                sums[1] += weight * mass;
                let mut index = layout.kinetic();
                for a in 0..layout.components {
                    sums[2 + a] += weight * mass * v[a];
                    for b in a..layout.components {
                        sums[index] += weight * mass * v[a] * v[b];
                        index += 1;
                    }
                }
                if let Some(share) = sums.get_mut(layout.shares() + species) {
                    *share += weight * mass;
                }
            });
        }
        survey.contacts(|i, partner, pair, memory| {
            if !store.is_present(i) || matches!(partner, Partner::Particle(j) if !store.is_present(j)) {
                return;
            }
            let (force, branch) = force_and_branch(survey, partner, pair, memory);
            // Branches join centres of mass.
            let arm = store.bodies.arm(i);
            let of_partner = match partner {
                Partner::Particle(j) => store.bodies.arm(j),
                Partner::Wall(_) => V::ZERO,
            };
            let branch = arm + branch - of_partner;
            let from = store.body[i].position - arm;
            let from = store.periodic.map_or(from, |periodic| periodic.wrapped(from));
            grid.visit_branch(from, branch, store.periodic.as_ref(), |cell, weight, at| {
                let sums = &mut sums[cell * layout.sums()..][..layout.sums()];
                let f = grid.components(force, at);
                let l = grid.components(-branch, at);
                let mut index = layout.contact();
                for f in &f[..layout.components] {
                    for l in &l[..layout.components] {
                        sums[index] += weight * f * l;
                        index += 1;
                    }
                }
            });
        });
        self.blocks.end_sample();
    }
}

/// Returns the force on the first particle, N, and the vector from its centre to the end of the branch, m.
fn force_and_branch<V: Space>(survey: &Survey<'_, V>, partner: Partner, pair: &Pair<V>, memory: &Memory) -> (V, V) {
    let force = survey.law.force(pair, &mut { *memory });
    let length = match partner {
        Partner::Particle(j) if survey.store.is_fixed(j) => pair.radii[0] - 0.5 * pair.overlap,
        Partner::Particle(_) => pair.radii[0] + pair.radii[1] - pair.overlap,
        Partner::Wall(_) => pair.radii[0] - pair.overlap,
    };
    (force.normal + force.resistance.friction, pair.normal * -length)
}

/// Returns the volume of a grain, m^3; in the plane its area, m^2.
fn volume<V: Space>(radius: f64) -> f64 {
    match V::DIMENSION {
        Dimension::Plane => std::f64::consts::PI * radius * radius,
        Dimension::Solid => 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3),
    }
}
