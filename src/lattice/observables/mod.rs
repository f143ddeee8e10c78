//! Observables of a silo that a lattice gas fills and leaves: what a discharge is reduced to.
//!
//! The sites of the silo are counted in blocks of 5 columns x 4 rows. The *density* phi of a block is its particles
//! over its fluid sites, 0 to 13; phi0 is the density just before the outlet opens. Blocks with fewer than 8 fluid
//! sites (corners that a wall cuts off) are dropped everywhere: they have no density and no neighbours.
//!
//! Conventions of all observables:
//!
//! * Lengths are in lattice spacings, angles in degrees, times in steps since the outlet opened.
//! * A block belongs to a range of x or y if its middle does. Every mean over blocks counts each block once, however
//!   many sites it has.
//! * An average over 100..300 steps takes the figure of every frame with 100 <= step <= 300, and the mean of those
//!   frames that have it; a history that does not reach from 100 to 300 has no such average.
//! * The result is `None` where there is nothing to measure, never NaN.
//! * Distances such as |x| < 20 belong to the standard silo, 120 wide with an outlet of 20. They are not scaled: a silo
//!   that has no blocks there has no such figure.
//!
//! Frames are expected in ascending order of time, one every 10 steps; others change what "5 frames" and "the last
//! five" mean, not whether the functions work.

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

/// Columns and rows of sites in a block.
pub const BLOCK: (usize, usize) = (5, 4);

/// Width of a block, spacings: 5 columns, each sqrt(3)/2 apart.
pub const BLOCK_WIDTH: f64 = 4.330_127_018_922_193;

/// Height of a block, spacings: 4 rows.
pub const BLOCK_HEIGHT: f64 = 4.0;

/// Fewest fluid sites of a block that counts.
pub const FEWEST_SITES: u32 = 8;

/// First and last step of the averages of developed flow.
pub const FLOW_WINDOW: (u64, u64) = (100, 300);

/// A short mean takes the frames up to this many steps before and after: 5 of them, one every 10 steps.
const SHORT_MEAN_REACH: u64 = 20;

/// Fewest frames in a short mean.
const SHORT_MEAN_FRAMES: usize = 5;

/// The blocks that a silo's sites are counted in: `columns` x `rows` blocks of 5 columns x 4 rows of sites, block (i,
/// j) at index i * `rows` + j, j upwards.
#[derive(Clone, Debug, PartialEq)]
pub struct Blocks {
    /// Block columns.
    pub columns: usize,
    /// Block rows.
    pub rows: usize,
    /// Fluid sites in each block.
    pub sites: Vec<u32>,
    /// Middle of each block column, from the middle of the outlet, spacings.
    pub x: Vec<f64>,
    /// Middle of each block row above the outlet, spacings.
    pub y: Vec<f64>,
}

/// The particles in each block at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Steps since the outlet opened.
    pub step: u64,
    /// Particles out so far.
    pub out: u64,
    /// Particles in each block.
    pub counts: Vec<u32>,
}

/// A discharge: blocks, the last frame before opening, then a frame every 10 steps after opening.
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    /// What the particles are counted in.
    pub blocks: Blocks,
    /// The last frame before the outlet opens, step 0.
    pub start: Frame,
    /// The frames after, in ascending order of time.
    pub frames: Vec<Frame>,
}

/// A block that counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Where its figures are in a list of all blocks.
    pub index: usize,
    /// Its block column.
    pub column: usize,
    /// Its block row, from the lowest.
    pub row: usize,
    /// Its middle, from the middle of the outlet, spacings.
    pub x: f64,
    /// Its middle above the outlet, spacings.
    pub y: f64,
}

impl Blocks {
    /// A block, if there is one that counts.
    #[must_use]
    pub fn block(&self, column: usize, row: usize) -> Option<Block> {
        if column >= self.columns || row >= self.rows {
            return None;
        }
        let index = column * self.rows + row;
        let block = Block { index, column, row, x: self.x[column], y: self.y[row] };
        (self.sites[index] >= FEWEST_SITES).then_some(block)
    }

    /// The blocks of a column that count, upwards.
    #[must_use]
    pub fn column(&self, column: usize) -> impl DoubleEndedIterator<Item = Block> + '_ {
        (0..self.rows).filter_map(move |row| self.block(column, row))
    }

    /// The blocks of a row that count, from left to right.
    pub fn row(&self, row: usize) -> impl Iterator<Item = Block> + '_ {
        (0..self.columns).filter_map(move |column| self.block(column, row))
    }

    /// All blocks that count.
    pub fn counted(&self) -> impl Iterator<Item = Block> + '_ {
        (0..self.columns).flat_map(|column| self.column(column))
    }

    /// phi of every block at one time, particles per site; 0 in a block that is dropped.
    #[must_use]
    pub fn density(&self, frame: &Frame) -> Vec<f64> {
        let density = |(&count, &sites): (&u32, &u32)| {
            if sites < FEWEST_SITES { 0.0 } else { f64::from(count) / f64::from(sites) }
        };
        frame.counts.iter().zip(&self.sites).map(density).collect()
    }
}

impl History {
    /// phi0 of every block: the density just before the outlet opens.
    #[must_use]
    pub fn onset(&self) -> Vec<f64> {
        self.blocks.density(&self.start)
    }

    /// phi of every block in the mean of the frames from 20 steps before to 20 steps after `step`: five frames, one
    /// every 10 steps. `None` if there are fewer, as at the beginning and the end of a discharge: the start is none of
    /// them.
    #[must_use]
    pub fn short_mean(&self, step: u64) -> Option<Vec<f64>> {
        let near = self.frames.iter().filter(|frame| frame.step.abs_diff(step) <= SHORT_MEAN_REACH);
        let densities: Vec<_> = near.map(|frame| self.blocks.density(frame)).collect();
        if densities.len() < SHORT_MEAN_FRAMES {
            return None;
        }
        (0..self.blocks.sites.len()).map(|index| mean(densities.iter().map(|density| density[index]))).collect()
    }

    /// The mean over the frames of the flow window ([`FLOW_WINDOW`]) of a figure of their densities.
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

/// The mean; `None` if there are no values, or it is not finite.
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
        // The literal and the root are rounded once each.
        close(Some(BLOCK_WIDTH), 5.0 * 3f64.sqrt() / 2.0, 4.0 * f64::EPSILON);
    }

    #[test]
    fn blocks_of_few_sites_are_dropped() {
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
        // n in the n-th frame, up to 12: the mean of five is the middle one.
        let history =
            Silo::STANDARD.history(|_, _| 13.0, |step, _, _| f64::from(u32::try_from(step / 10).unwrap()) % 13.0);
        close(history.short_mean(80).map(|density| density[0]), 8.0, 0.0);
        assert!(history.short_mean(20).is_none() && history.short_mean(290).is_none());
        assert!(history.short_mean(30).is_some() && history.short_mean(280).is_some());
        assert!(history.short_mean(u64::MAX).is_none());
    }

    #[test]
    fn flow_is_averaged_from_100_to_300() {
        // 1 within the window, far more outside it.
        let density = |step, _, _| if (100..=300).contains(&step) { 1.0 } else { 9.0 };
        let mut history = Silo::STANDARD.history(|_, _| 9.0, density);
        close(history.flow_mean(|density| Some(density[0])), 1.0, 0.0);
        assert!(history.flow_mean(|_| None).is_none());
        history.frames.pop();
        assert!(history.flow_mean(|density| Some(density[0])).is_none());
    }
}
