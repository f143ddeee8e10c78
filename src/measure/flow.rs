//! Flow field: mean velocity in square cells. It works for any model of grains.
//!
//! In each sample, each grain adds its mass m and momentum m v to the cell that contains its centre. The results are
//! averages over all samples:
//!
//! * *count*: grains per sample, including samples without a grain in the cell;
//! * *velocity*: sum m v / sum m. It is a mean over grains, not over samples: a cell that is empty half of the time is
//!   not half as fast.
//!
//! Corners of cells are at whole multiples of the cell side, so that the fields of two runs, or of two models, share
//! cells. A point on the line between two cells, within a billionth of a cell, belongs to the upper or right cell.
//! Rounding therefore does not scatter the rows of a lattice over two cells. Units are the units of the input: m, kg
//! and m/s in the grain silo.
//!
//! Limit: the mean of a cell averages over the variation of the velocity in it. In a shear u = a x sampled uniformly,
//! the mean is a times the middle of the cell. Its standard error for n grains is a L/sqrt(12 n), with the cell side L.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use siloflow_dem::values::{Positive, Share};
use siloflow_files::flow_means::FlowMeans;

/// The scene key `flow`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Flow {
    /// Side of the square cells, m.
    pub cell: Positive,
    /// Share of the released grains that are out when sampling starts. Default 0.05.
    #[serde(default = "default_from")]
    pub from: Share,
    /// Share of the released grains that are out when sampling ends. Default 0.4.
    #[serde(default = "default_to")]
    pub to: Share,
    /// Time between samples, s. In a lattice gas it must be a whole number of steps.
    pub sample: Positive,
}

fn default_from() -> Share {
    Share::try_from(0.05).expect("0.05 is a share")
}

fn default_to() -> Share {
    Share::try_from(0.4).expect("0.4 is a share")
}

impl Flow {
    /// Returns whether a sample is due when `out` of `released` grains are out.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "fewer than 2^53 grains")]
    pub fn samples_at(&self, out: u64, released: u64) -> bool {
        let share = out as f64 / released.max(1) as f64;
        (self.from.get()..=self.to.get()).contains(&share)
    }
}

/// Sums over one cell.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
struct Sums {
    count: u64,
    mass: f64,
    momentum: [f64; 2],
}

/// Sums of a flow field so far.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct FlowField {
    cell: f64,
    samples: u64,
    /// Cells by row, then column, in the order of the means.
    cells: BTreeMap<[i64; 2], Sums>,
}

/// Returns the number of the cell of side `cell` that contains a coordinate.
#[expect(clippy::cast_possible_truncation, reason = "saturates far outside any silo")]
fn number(coordinate: f64, cell: f64) -> i64 {
    (coordinate / cell + 1e-9).floor() as i64
}

impl FlowField {
    /// Makes a field without samples, with cells of side `cell`.
    #[must_use]
    pub fn new(cell: f64) -> Self {
        Self { cell, samples: 0, cells: BTreeMap::new() }
    }

    /// Adds a grain to the present sample.
    pub fn add(&mut self, x: f64, y: f64, mass: f64, vx: f64, vy: f64) {
        self.add_to(x, y, 1, mass, [vx, vy]);
    }

    /// Adds `count` grains of mass 1 at one place, with their mean velocity.
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

    /// Ends the present sample, with or without grains.
    pub fn end_sample(&mut self) {
        self.samples += 1;
    }

    /// Takes over the sums of a field with the same cells.
    ///
    /// # Errors
    /// If the cells have another size.
    pub(crate) fn restore(&mut self, saved: Self) -> Result<(), &'static str> {
        if saved.cell.to_bits() != self.cell.to_bits() {
            return Err("the cells of the flow field have another size");
        }
        *self = saved;
        Ok(())
    }

    /// Returns the number of complete samples.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Returns the means of all cells that ever held a grain, by y, then x.
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
    fn sampling_includes_both_limits_and_needs_a_released_grain() {
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
                let x = 0.1 * f64::from(n % 10);
                let y = 0.1 * f64::from(n / 10);
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
    fn a_rotation_has_the_velocity_of_each_cell_s_middle() {
        // Four grains at equal distances from the middle of their cell, in each of 6 x 6 cells: u = (-w y, w x).
        let w = 3.0;
        let cell = 0.5;
        let mut field = FlowField::new(cell);
        for k in 0..144u8 {
            let at = |n: u8| -1.5 + 0.25 * (f64::from(n) + 0.5);
            let x = at(k % 12);
            let y = at(k / 12);
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
    fn a_uniformly_sampled_shear_has_the_velocity_of_each_cell_s_middle() {
        let a = 2.0;
        let cell = 0.25;
        let grains = 40_000;
        let random = Stream::new(5, "shear");
        let mut field = FlowField::new(cell);
        for grain in 0..grains {
            let [x, y] = random.uniform::<2>(grain);
            field.add(x, y, 1.0, 0.0, a * x);
            if grain % 100 == 99 {
                field.end_sample();
            }
        }
        assert_eq!(field.means().len(), 16);
        for mean in field.means() {
            // Five standard errors of the mean of n numbers that are uniform over a cell.
            let n = mean.count * mean.samples as f64;
            let bound = 5.0 * a * cell / (12.0 * n).sqrt();
            assert!((mean.vy - a * mean.x).abs() < bound && mean.vx == 0.0, "{mean:?} {bound}");
            // Five standard errors of the number of grains in the cell: each of 100 per sample is there with
            // probability 1/16.
            let spread = (grains as f64 / 16.0 * 15.0 / 16.0).sqrt() / mean.samples as f64;
            assert!((mean.count - 100.0 / 16.0).abs() < 5.0 * spread, "{mean:?}");
        }
    }

    #[test]
    fn velocity_is_weighted_by_mass_and_empty_samples_lower_the_count() {
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
