//! A field of mean velocity in square cells: what a flow looks like, for any model of grain.
//!
//! Every sample, each grain adds its mass m and momentum m v to the cell that its centre is in; over all samples
//!
//! * *count*: grains a sample, an average over all samples of the field, those without a grain in the cell too;
//! * *velocity*: sum m v / sum m, the mean of the grains (not of the samples: a cell that is empty half of the time is
//!   not half as fast).
//!
//! Cells have their corners at whole multiples of their side, so that fields of two runs, or of two models, share them.
//! What lies on the line between two cells, to a billionth of a cell, belongs to the upper or right one: rounding does
//! not deal out the rows of a lattice. Units are those of what is added, in the grain silo m, kg and m/s.
//!
//! Limit: the mean of a cell contains how the velocity changes across the cell. In a shear u = a x sampled uniformly it is
//! a times the cell's middle, with a standard error of a cell/sqrt(12 n) for n grains.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::{Deserialize, Serialize};

use crate::values::{Positive, Share};

/// The scene's `flow`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Flow {
    /// Side of the square cells, m.
    pub cell: Positive,
    /// Share of the released grains that are out when sampling begins. Default 0.05.
    #[serde(default = "default_from")]
    pub from: Share,
    /// And when it ends. Default 0.4.
    #[serde(default = "default_to")]
    pub to: Share,
    /// Time between samples, s; of a lattice gas a whole number of steps.
    pub sample: Positive,
}

fn default_from() -> Share {
    Share::try_from(0.05).expect("a share")
}

fn default_to() -> Share {
    Share::try_from(0.4).expect("a share")
}

impl Flow {
    /// Whether a sample is wanted when `out` of `released` grains are out.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "fewer than 2^53 grains")]
    pub fn samples_at(&self, out: u64, released: u64) -> bool {
        let share = out as f64 / released.max(1) as f64;
        (self.from.get()..=self.to.get()).contains(&share)
    }
}

/// Sums in one cell.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: u64,
    mass: f64,
    momentum: [f64; 2],
}

/// Means in one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowMeans {
    /// Middle of the cell along the first axis.
    pub x: f64,
    /// Along the second, upwards.
    pub y: f64,
    /// Samples of the field.
    pub samples: u64,
    /// Grains a sample.
    pub count: f64,
    /// Mean velocity along the first axis.
    pub vx: f64,
    /// Along the second.
    pub vy: f64,
}

/// The sums of a field so far.
#[derive(Clone, Debug)]
pub struct FlowField {
    cell: f64,
    samples: u64,
    /// By row, then column: the order of the means.
    cells: BTreeMap<[i64; 2], Sums>,
}

/// The number of the cell, of side `cell`, that a coordinate is in.
#[expect(clippy::cast_possible_truncation, reason = "saturates far outside any silo")]
fn number(coordinate: f64, cell: f64) -> i64 {
    (coordinate / cell + 1e-9).floor() as i64
}

impl FlowField {
    /// The means as rows of `flow.csv`. Writing to a string cannot fail.
    pub(crate) fn rows(&self) -> String {
        self.means().iter().fold(String::new(), |mut text, cell| {
            let FlowMeans { x, y, samples, count, vx, vy } = cell;
            let _ = writeln!(text, "{x:.9},{y:.9},{samples},{count:.6},{vx:e},{vy:e}");
            text
        })
    }

    /// No samples yet, in cells of this side.
    #[must_use]
    pub fn new(cell: f64) -> Self {
        Self { cell, samples: 0, cells: BTreeMap::new() }
    }

    /// Adds a grain to the sample that is being taken.
    pub fn add(&mut self, x: f64, y: f64, mass: f64, vx: f64, vy: f64) {
        self.add_to(x, y, 1, mass, [vx, vy]);
    }

    /// Adds several of mass 1 at one place, with their mean velocity.
    pub fn add_several(&mut self, x: f64, y: f64, count: u32, velocity: [f64; 2]) {
        self.add_to(x, y, count, f64::from(count), velocity);
    }

    fn add_to(&mut self, x: f64, y: f64, count: u32, mass: f64, [vx, vy]: [f64; 2]) {
        let sums = self.cells.entry([number(y, self.cell), number(x, self.cell)]).or_default();
        sums.count += u64::from(count);
        sums.mass += mass;
        sums.momentum[0] += mass * vx;
        sums.momentum[1] += mass * vy;
    }

    /// The sample is complete, whether it held grains or not.
    pub fn end_sample(&mut self) {
        self.samples += 1;
    }

    /// Complete samples.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The means of all cells that ever held a grain, by y, then x.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "counts and cells are far below 2^53")]
    pub fn means(&self) -> Vec<FlowMeans> {
        let middle = |number: i64| (number as f64 + 0.5) * self.cell;
        let cells = self.cells.iter().map(|(&[row, column], sums)| FlowMeans {
            x: middle(column),
            y: middle(row),
            samples: self.samples,
            count: sums.count as f64 / self.samples.max(1) as f64,
            vx: sums.momentum[0] / sums.mass,
            vy: sums.momentum[1] / sums.mass,
        });
        cells.collect()
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, clippy::cast_precision_loss, reason = "exact values, small counts")]
mod tests {
    use super::*;

    #[test]
    fn the_window_holds_both_its_ends_and_no_grain_at_all() {
        let flow: Flow = ron::from_str("(cell: 0.1, from: 0.25, to: 0.5, sample: 0.1)").unwrap();
        assert!([(1, 4), (3, 8), (2, 4)].iter().all(|&(out, released)| flow.samples_at(out, released)));
        assert!(![(0, 0), (0, 4), (3, 4)].iter().any(|&(out, released)| flow.samples_at(out, released)));
    }
    use crate::random::Stream;

    #[test]
    fn a_rigid_motion_has_one_velocity_everywhere() {
        let mut field = FlowField::new(0.25);
        for sample in 0..4u8 {
            for n in 0..100u8 {
                let (x, y) = (0.1 * f64::from(n % 10), 0.1 * f64::from(n / 10));
                field.add(x, y - 0.05 * f64::from(sample), 1.0 + f64::from(n % 3), 0.5, -2.0);
            }
            field.end_sample();
        }
        let means = field.means();
        assert!(means.iter().all(|mean| (mean.vx, mean.vy, mean.samples) == (0.5, -2.0, 4)));
        assert!((means.iter().map(|mean| mean.count).sum::<f64>() - 100.0).abs() < 1e-12);
        assert!(means.is_sorted_by_key(|mean| (mean.y, mean.x)), "{means:?}");
        assert_eq!((means[0].x, means[0].y), (0.125, -0.125));
    }

    #[test]
    fn a_rotation_about_the_origin_is_that_of_the_cell_s_middle() {
        // Four grains at the same distances from the middle of their cell, in each of 6 x 6 cells: u = (-w y, w x).
        let (w, cell) = (3.0, 0.5);
        let mut field = FlowField::new(cell);
        for k in 0..144u8 {
            let at = |n: u8| -1.5 + 0.25 * (f64::from(n) + 0.5);
            let (x, y) = (at(k % 12), at(k / 12));
            field.add(x, y, 2.0, -w * y, w * x);
        }
        field.end_sample();
        assert_eq!(field.means().len(), 36);
        for mean in field.means() {
            assert!((mean.vx + w * mean.y).abs() < 1e-15 && (mean.vy - w * mean.x).abs() < 1e-15, "{mean:?}");
            assert_eq!(mean.count, 4.0);
        }
    }

    #[test]
    fn a_shear_sampled_uniformly_has_the_means_of_the_middles() {
        let (a, cell, looks) = (2.0, 0.25, 40_000);
        let random = Stream::new(5, "shear");
        let mut field = FlowField::new(cell);
        for look in 0..looks {
            let [x, y] = random.uniform::<2>(look);
            field.add(x, y, 1.0, 0.0, a * x);
            if look % 100 == 99 {
                field.end_sample();
            }
        }
        assert_eq!(field.means().len(), 16);
        for mean in field.means() {
            // Five standard errors of the mean of n numbers uniform over a cell.
            let n = mean.count * mean.samples as f64;
            let bound = 5.0 * a * cell / (12.0 * n).sqrt();
            assert!((mean.vy - a * mean.x).abs() < bound && mean.vx == 0.0, "{mean:?} {bound}");
            // ... and of a share of 1/16 of 100 a sample.
            let spread = (looks as f64 / 16.0 * 15.0 / 16.0).sqrt() / mean.samples as f64;
            assert!((mean.count - 100.0 / 16.0).abs() < 5.0 * spread, "{mean:?}");
        }
    }

    #[test]
    fn heavy_grains_count_by_their_mass_and_empty_samples_by_their_absence() {
        let mut field = FlowField::new(1.0);
        field.add(0.5, 0.5, 3.0, 1.0, 0.0);
        field.add(0.5, 0.5, 1.0, 5.0, 0.0);
        field.end_sample();
        field.end_sample();
        let mean = field.means()[0];
        assert_eq!((mean.vx, mean.count, mean.samples), (2.0, 1.0, 2));
    }

    #[test]
    fn rows_on_the_line_between_cells_belong_to_the_upper_one() {
        let mut field = FlowField::new(0.05);
        // 0.15/0.05 is 2.9999999999999996 in binary.
        (0..40u8).for_each(|row| field.add(0.0, 0.01 * f64::from(row), 1.0, 0.0, 0.0));
        field.end_sample();
        assert!(field.means().iter().all(|mean| mean.count == 5.0), "{:?}", field.means());
    }
}
