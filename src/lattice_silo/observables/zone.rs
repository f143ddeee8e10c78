//! The dilatant zone: material above the outlet that has become looser since the outlet opened.
//!
//! phi is the mean density over five frames around a step, phi0 the density before opening, and rho0 the onset density.
//! The *bed* consists of the blocks with phi0 > rho0/2. For each block, phi/phi0 is averaged over the block and its
//! eight neighbours, as far as they belong to the bed. The block is *loose* if this average is below 0.88.
//!
//! The zone consists of the loose blocks of the bed that are connected to the outlet over common sides. The connection
//! starts at the lowest block of each column with its centre over the outlet. If no such block is loose, there is no
//! zone.
//!
//! Limits. Blocks above the bed are left out, because their phi/phi0 is a ratio of a few particles. The average makes
//! the zone wider or narrower by up to a block on each side, depending on its looseness.

use super::density::onset_density;
use super::{BLOCK_HEIGHT, BLOCK_WIDTH, Block, Blocks, History, finite, mean};

/// Value of phi/phi0 below which material is loose.
const LOOSE_BELOW: f64 = 0.88;

/// Half the width of the outlet of the standard silo, spacings.
const OUTLET_HALF_WIDTH: f64 = 10.0;

/// Largest |x| of the central part, spacings: a third of the standard silo, half-width 60, and twice the outlet.
const CENTRAL_WITHIN: f64 = 20.0;

/// Returns the blocks of the dilatant zone at a step. `None` if there is no zone, or fewer than five frames around the
/// step.
#[must_use]
pub fn dilatant_zone(history: &History, step: u64) -> Option<Vec<Block>> {
    let blocks = &history.blocks;
    let onset = history.onset();
    let now = history.short_mean(step)?;
    let threshold = 0.5 * onset_density(history)?;
    let ratio: Vec<_> = onset.iter().zip(&now).map(|(&then, now)| (then > threshold).then_some(now / then)).collect();
    let mut is_loose = vec![false; ratio.len()];
    for block in blocks.counted().filter(|block| ratio[block.index].is_some()) {
        is_loose[block.index] = smoothed(blocks, &ratio, block).is_some_and(|ratio| ratio < LOOSE_BELOW);
    }
    let over_outlet = (0..blocks.columns).filter(|&column| blocks.x[column].abs() <= OUTLET_HALF_WIDTH);
    let lowest = over_outlet.filter_map(|column| blocks.column(column).next()).collect();
    let zone = connected(blocks, is_loose, lowest);
    (!zone.is_empty()).then_some(zone)
}

/// Returns the mean of the values of a block and its eight neighbours, leaving out blocks without a value.
fn smoothed(blocks: &Blocks, values: &[Option<f64>], block: Block) -> Option<f64> {
    let columns = block.column.saturating_sub(1)..=block.column + 1;
    let rows = block.row.saturating_sub(1)..=block.row + 1;
    let near = columns.flat_map(|column| rows.clone().filter_map(move |row| blocks.block(column, row)));
    mean(near.filter_map(|block| values[block.index]))
}

/// Returns the member blocks that are connected over common sides with one of the start blocks.
fn connected(blocks: &Blocks, mut is_member: Vec<bool>, starts: Vec<Block>) -> Vec<Block> {
    let mut found = Vec::new();
    let mut next = starts;
    while let Some(block) = next.pop() {
        if !std::mem::take(&mut is_member[block.index]) {
            continue;
        }
        found.push(block);
        let column = block.column;
        let row = block.row;
        next.extend(column.checked_sub(1).and_then(|column| blocks.block(column, row)));
        next.extend(row.checked_sub(1).and_then(|row| blocks.block(column, row)));
        next.extend(blocks.block(column + 1, row));
        next.extend(blocks.block(column, row + 1));
    }
    found
}

/// Returns the height zh of the dilatant zone at a step, spacings: the upper edge of its highest block, above the
/// outlet.
#[must_use]
pub fn zone_height(history: &History, step: u64) -> Option<f64> {
    let top = dilatant_zone(history, step)?.iter().map(|block| block.y).fold(f64::NEG_INFINITY, f64::max);
    finite(top + 0.5 * BLOCK_HEIGHT)
}

/// Returns the width zw of the dilatant zone at a step, spacings: the total width of its blocks in a row, averaged over
/// its rows. Gaps within a row do not contribute.
#[must_use]
pub fn zone_width(history: &History, step: u64) -> Option<f64> {
    let zone = dilatant_zone(history, step)?;
    let width = |row| zone.iter().filter(|block| block.row == row).map(|_| BLOCK_WIDTH).sum();
    mean((0..history.blocks.rows).map(width).filter(|&width| width > 0.0))
}

/// Returns the aspect ratio za = zw/zh of the dilatant zone at a step. It is small for a slender zone.
#[must_use]
pub fn zone_aspect_ratio(history: &History, step: u64) -> Option<f64> {
    finite(zone_width(history, step)? / zone_height(history, step)?)
}

/// Returns the central share zc of the dilatant zone at a step: the sum of phi0 - phi over its blocks with |x| < 20,
/// divided by the sum over all its blocks. Blocks that have become denser contribute negative values. `None` if the sum
/// over all blocks is not positive.
#[must_use]
pub fn central_share(history: &History, step: u64) -> Option<f64> {
    let zone = dilatant_zone(history, step)?;
    let onset = history.onset();
    let now = history.short_mean(step)?;
    let loss = |block: &Block| onset[block.index] - now[block.index];
    let central: f64 = zone.iter().filter(|block| block.x.abs() < CENTRAL_WITHIN).map(loss).sum();
    let total: f64 = zone.iter().map(loss).sum();
    if total > 0.0 { finite(central / total) } else { None }
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::{Silo, close};
    use super::*;

    /// Returns a history with density 10 everywhere before opening, and 10 times `ratio` afterwards.
    fn history(ratio: impl Fn(u64, f64, f64) -> f64) -> History {
        Silo::STANDARD.history(|_, _| 10.0, |step, x, y| 10.0 * ratio(step, x, y))
    }

    /// Returns 0.7 for a loose block, else 1. The zone then equals the loose part: the average at a corner of the loose
    /// part, with 4 loose blocks of 9, is 1 - 0.3 4/9 = 0.867 < 0.88. Beside its edge, with 3 of 9 (on the floor 2 of
    /// 6), the average is 0.9.
    fn ratio(is_loose: bool) -> f64 {
        if is_loose { 0.7 } else { 1.0 }
    }

    #[test]
    fn a_rectangular_zone_has_its_height_and_width() {
        // The zone has 12 columns and 15 rows. The tolerances cover the rounding of sums over 15 rows.
        let history = history(|_, x, y| ratio(x.abs() < 6.0 * BLOCK_WIDTH && y < 60.0));
        assert_eq!(dilatant_zone(&history, 200).unwrap().len(), 12 * 15);
        close(zone_height(&history, 200), 60.0, 0.0);
        close(zone_width(&history, 200), 12.0 * BLOCK_WIDTH, 1e-12);
        close(zone_aspect_ratio(&history, 200), 12.0 * BLOCK_WIDTH / 60.0, 1e-13);
        // The centres of 5 of 6 columns on each side are within 20 spacings; the last two are at 19.5 and 23.8.
        close(central_share(&history, 200), 5.0 / 6.0, 1e-12);
    }

    #[test]
    fn width_is_the_mean_over_rows() {
        // The loose part has 10 rows of 12 columns and 5 rows of 4 columns. In the lowest of the 5 rows, the block on
        // each side has 5 loose blocks of 9 (3 below, 2 beside), so it belongs to the zone too.
        let is_loose = |x: f64, y| y < 40.0 && x.abs() < 6.0 * BLOCK_WIDTH || y < 60.0 && x.abs() < 2.0 * BLOCK_WIDTH;
        let history = history(|_, x, y| ratio(is_loose(x, y)));
        let blocks = f64::from(10 * 12 + 6 + 4 * 4);
        close(zone_width(&history, 200), blocks / 15.0 * BLOCK_WIDTH, 1e-12);
        close(zone_height(&history, 200), 60.0, 0.0);
    }

    #[test]
    fn the_central_share_is_weighted_by_the_loss() {
        // The loss is 4 in the 10 columns within 20 spacings and 3 in 2 more columns. The zone also includes some
        // blocks without loss.
        let of = |x: f64| if x.abs() < 20.0 { 0.6 } else { 0.7 };
        let history = history(|_, x, y| if x.abs() < 6.0 * BLOCK_WIDTH && y < 60.0 { of(x) } else { 1.0 });
        close(central_share(&history, 200), 40.0 / 46.0, 1e-12);
    }

    #[test]
    fn the_zone_is_measured_in_the_mean_of_five_frames() {
        // The mean of 0.625 in four frames and 1 in the frame at step 200 is 0.7.
        let is_near = |step| (180..=220).contains(&step) && step != 200;
        let history = history(|step, x, y| if is_near(step) && x.abs() < 20.0 && y < 60.0 { 0.625 } else { 1.0 });
        close(zone_height(&history, 200), 60.0, 0.0);
        assert!(dilatant_zone(&history, 80).is_none() && zone_width(&history, 80).is_none());
        // There are fewer than five frames around steps near the beginning and the end.
        assert!(zone_height(&history, 20).is_none() && zone_height(&history, 290).is_none());
    }

    #[test]
    fn blocks_below_the_threshold_are_loose() {
        assert_eq!(dilatant_zone(&history(|_, _, _| 0.875), 200).unwrap().len(), 28 * 40);
        assert!(dilatant_zone(&history(|_, _, _| 0.885), 200).is_none());
    }

    #[test]
    fn the_zone_is_connected_to_the_outlet() {
        let apart = |x: f64, y| x > 40.0 && y > 100.0;
        let both = history(|_, x, y| ratio(x.abs() < 20.0 && y < 60.0 || apart(x, y)));
        close(zone_height(&both, 200), 60.0, 0.0);
        assert!(dilatant_zone(&history(|_, x, y| ratio(apart(x, y))), 200).is_none());
        // Loose material on the floor beside the outlet is not connected to the outlet.
        assert!(dilatant_zone(&history(|_, x, y| ratio(x.abs() > 25.0 && y < 60.0)), 200).is_none());
        // Blocks that touch only at corners are not connected.
        let blocks = Silo { columns: 2, rows: 2, sites: 20 }.blocks();
        let starts = || blocks.block(0, 0).into_iter().collect();
        assert_eq!(connected(&blocks, vec![true, false, false, true], starts()).len(), 1);
        assert_eq!(connected(&blocks, vec![true, true, false, true], starts()).len(), 3);
        // The connection leads up, across and down.
        let blocks = Silo { columns: 3, rows: 2, sites: 20 }.blocks();
        let starts = || blocks.block(0, 0).into_iter().collect();
        assert_eq!(connected(&blocks, vec![true, true, false, true, true, true], starts()).len(), 5);
        assert!(connected(&blocks, vec![false, true, true, true, true, true], starts()).is_empty());
    }

    #[test]
    fn the_zone_does_not_extend_above_the_bed() {
        // Above 80 there is a gas of density 1. Whether its density later falls or rises does not matter.
        for gas in [0.5, 5.0] {
            let later = |_, x: f64, y| if y > 80.0 { gas } else { 10.0 * ratio(x.abs() < 20.0) };
            let history = Silo::STANDARD.history(|_, y| if y > 80.0 { 1.0 } else { 10.0 }, later);
            close(zone_height(&history, 200), 80.0, 0.0);
            close(zone_width(&history, 200), 10.0 * BLOCK_WIDTH, 1e-12);
        }
    }
}
