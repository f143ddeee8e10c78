//! Observables of a discharge: numbers that characterise how a lattice gas leaves a silo.
//!
//! The sites of the silo are grouped into blocks of 5 columns x 4 rows. The *density* phi of a block is its number of
//! particles divided by its number of fluid sites, 0 to 13. phi0 is the density just before the outlet opens. Blocks
//! with fewer than 8 fluid sites (corners that a wall cuts off) are ignored: they have no density and are no
//! neighbours.
//!
//! Conventions of all observables:
//!
//! * Lengths are in lattice spacings, angles in degrees, times in steps since the outlet opened.
//! * A block belongs to a range of x or y if its centre is in the range. A mean over blocks gives all blocks equal
//!   weight, independent of their number of sites.
//! * An average over 100..300 steps evaluates a quantity in each frame with 100 <= step <= 300, and is the mean over
//!   the frames in which the quantity is defined. It is `None` for a history that does not cover 100 to 300.
//! * A result is `None` if there is nothing to measure, and never NaN.
//! * Distances such as |x| < 20 are chosen for the standard silo, 120 wide with an outlet of 20. They are not scaled.
//!   If a silo has no blocks in such a range, the result is `None`.
//!
//! Frames are expected in ascending order of time, one every 10 steps. With other frames the functions work, but "5
//! frames" and "the last five frames" cover other times.

pub mod density;
pub mod dilation;
pub mod outflow;
pub mod summary;
pub mod surface;
pub mod uniformity;
pub mod zone;

#[cfg(test)]
mod synthetic;

pub use density::{bottom_density, onset_density};
pub use dilation::threshold_free_height;
pub use outflow::outflow_rate;
pub use summary::{Observables, QUANTITIES, Quantity};
pub use surface::{dip, inclination, surface_heights};
pub use uniformity::{centre_to_side_ratio, overall_variation, row_variation};
pub use zone::{central_share, dilatant_zone, zone_aspect_ratio, zone_height, zone_width};

/// Numbers of columns and rows of sites in a block.
pub const BLOCK: (usize, usize) = (5, 4);

/// Width of a block, spacings: 5 columns, each sqrt(3)/2 apart.
pub const BLOCK_WIDTH: f64 = 4.330_127_018_922_193;

/// Height of a block, spacings: 4 rows.
pub const BLOCK_HEIGHT: f64 = 4.0;

/// Least number of fluid sites of a valid block.
pub const FEWEST_SITES: u32 = 8;

/// First and last step of averages over the developed flow.
pub const FLOW_WINDOW: (u64, u64) = (100, 300);

/// Half the time span of a short mean, steps. With a frame every 10 steps it covers 5 frames.
const SHORT_MEAN_REACH: u64 = 20;

/// Least number of frames in a short mean.
const SHORT_MEAN_FRAMES: usize = 5;

/// The blocks of a silo: `columns` x `rows` blocks of 5 columns x 4 rows of sites. Block (i, j) has index
/// i * `rows` + j, with j upwards.
#[derive(Clone, Debug, PartialEq)]
pub struct Blocks {
    /// Number of block columns.
    pub columns: usize,
    /// Number of block rows.
    pub rows: usize,
    /// Number of fluid sites in each block.
    pub sites: Vec<u32>,
    /// x of the centre of each block column, from the middle of the outlet, spacings.
    pub x: Vec<f64>,
    /// y of the centre of each block row, above the outlet, spacings.
    pub y: Vec<f64>,
}

/// Numbers of particles at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Steps since the outlet opened.
    pub step: u64,
    /// Number of particles that have left so far.
    pub out: u64,
    /// Number of particles in each block.
    pub counts: Vec<u32>,
}

/// The frames of a discharge: one just before the outlet opens, then one every 10 steps.
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    /// The blocks of the silo.
    pub blocks: Blocks,
    /// The frame just before the outlet opens, step 0.
    pub start: Frame,
    /// The frames after the outlet has opened, in ascending order of time.
    pub frames: Vec<Frame>,
}

/// A valid block: a block with at least [`FEWEST_SITES`] fluid sites.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Index of the block in lists of all blocks.
    pub index: usize,
    /// Block column, from the left.
    pub column: usize,
    /// Block row, from the lowest.
    pub row: usize,
    /// x of the centre, from the middle of the outlet, spacings.
    pub x: f64,
    /// y of the centre, above the outlet, spacings.
    pub y: f64,
}

impl Blocks {
    /// Returns the block at a column and row; `None` if there is no valid block.
    #[must_use]
    pub fn block(&self, column: usize, row: usize) -> Option<Block> {
        if column >= self.columns || row >= self.rows {
            return None;
        }
        let index = column * self.rows + row;
        let block = Block { index, column, row, x: self.x[column], y: self.y[row] };
        (self.sites[index] >= FEWEST_SITES).then_some(block)
    }

    /// Returns the valid blocks of a column, upwards.
    #[must_use]
    pub fn column(&self, column: usize) -> impl DoubleEndedIterator<Item = Block> + '_ {
        (0..self.rows).filter_map(move |row| self.block(column, row))
    }

    /// Returns the valid blocks of a row, from left to right.
    pub fn row(&self, row: usize) -> impl Iterator<Item = Block> + '_ {
        (0..self.columns).filter_map(move |column| self.block(column, row))
    }

    /// Returns all valid blocks.
    pub fn counted(&self) -> impl Iterator<Item = Block> + '_ {
        (0..self.columns).flat_map(|column| self.column(column))
    }

    /// Returns phi of every block in a frame, particles per site; 0 for blocks that are not valid.
    #[must_use]
    pub fn density(&self, frame: &Frame) -> Vec<f64> {
        let density = |(&count, &sites): (&u32, &u32)| {
            if sites < FEWEST_SITES { 0.0 } else { f64::from(count) / f64::from(sites) }
        };
        frame.counts.iter().zip(&self.sites).map(density).collect()
    }
}

impl History {
    /// Returns phi0 of every block, the density just before the outlet opens, particles per site.
    #[must_use]
    pub fn onset(&self) -> Vec<f64> {
        self.blocks.density(&self.start)
    }

    /// Returns the mean of phi of every block over the frames from 20 steps before to 20 steps after `step`. With a
    /// frame every 10 steps these are five frames. `None` if there are fewer, as near the beginning and the end of a
    /// discharge. The frame `start` is not used.
    #[must_use]
    pub fn short_mean(&self, step: u64) -> Option<Vec<f64>> {
        let near = self.frames.iter().filter(|frame| frame.step.abs_diff(step) <= SHORT_MEAN_REACH);
        let densities: Vec<_> = near.map(|frame| self.blocks.density(frame)).collect();
        if densities.len() < SHORT_MEAN_FRAMES {
            return None;
        }
        (0..self.blocks.sites.len()).map(|index| mean(densities.iter().map(|density| density[index]))).collect()
    }

    /// Returns the mean of `figure` over the frames of the flow window ([`FLOW_WINDOW`]). `figure` gets the densities
    /// of all blocks.
    fn flow_mean(&self, figure: impl Fn(&[f64]) -> Option<f64>) -> Option<f64> {
        let (first, last) = FLOW_WINDOW;
        let reaches = self.times().any(|step| step <= first) && self.times().any(|step| step >= last);
        let frames = self.frames.iter().filter(|frame| reaches && (first..=last).contains(&frame.step));
        mean(frames.filter_map(|frame| figure(&self.blocks.density(frame))))
    }

    fn times(&self) -> impl Iterator<Item = u64> + '_ {
        std::iter::once(&self.start).chain(&self.frames).map(|frame| frame.step)
    }
}

/// Returns the mean of the values; `None` if there are no values or the mean is not finite.
fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.into_iter().fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    finite(sum / count)
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

#[expect(clippy::cast_precision_loss, reason = "particles and steps stay far below 2^53")]
fn real(number: u64) -> f64 {
    number as f64
}

#[cfg(test)]
mod tests {
    use super::synthetic::{Silo, close};
    use super::*;

    #[test]
    fn a_block_is_five_columns_wide() {
        // The tolerance covers one rounding of the literal and one of the square root.
        close(Some(BLOCK_WIDTH), 5.0 * 3f64.sqrt() / 2.0, 4.0 * f64::EPSILON);
    }

    #[test]
    fn blocks_of_few_sites_are_ignored() {
        let mut blocks = Silo { columns: 3, rows: 2, sites: 20 }.blocks();
        (blocks.sites[2], blocks.sites[3]) = (7, 8);
        assert!(blocks.block(1, 0).is_none() && blocks.block(3, 0).is_none() && blocks.block(0, 2).is_none());
        assert_eq!(blocks.counted().map(|block| block.index).collect::<Vec<_>>(), [0, 1, 3, 4, 5]);
        assert_eq!(blocks.row(0).map(|block| block.column).collect::<Vec<_>>(), [0, 2]);
        let frame = Frame { step: 0, out: 0, counts: vec![40, 20, 7, 8, 0, 10] };
        assert_eq!(blocks.density(&frame), [2.0, 1.0, 0.0, 1.0, 0.0, 0.5]);
    }

    #[test]
    fn a_short_mean_takes_five_frames() {
        // The density is n modulo 13 in the n-th frame. The mean of frames 6 to 10 is the density of the middle one.
        let history =
            Silo::STANDARD.history(|_, _| 13.0, |step, _, _| f64::from(u32::try_from(step / 10).unwrap()) % 13.0);
        close(history.short_mean(80).map(|density| density[0]), 8.0, 0.0);
        assert!(history.short_mean(20).is_none() && history.short_mean(290).is_none());
        assert!(history.short_mean(30).is_some() && history.short_mean(280).is_some());
        assert!(history.short_mean(u64::MAX).is_none());
    }

    #[test]
    fn flow_is_averaged_from_100_to_300() {
        // The density is 1 within the window and 9 outside it.
        let density = |step, _, _| if (100..=300).contains(&step) { 1.0 } else { 9.0 };
        let mut history = Silo::STANDARD.history(|_, _| 9.0, density);
        close(history.flow_mean(|density| Some(density[0])), 1.0, 0.0);
        assert!(history.flow_mean(|_| None).is_none());
        history.frames.pop();
        assert!(history.flow_mean(|density| Some(density[0])).is_none());
    }
}
