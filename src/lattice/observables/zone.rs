//! The dilatant zone: the material above the outlet that has become looser since it opened.
//!
//! phi is the mean over five frames around a step, phi0 the density before opening, rho0 the onset density. The *bed*
//! are the blocks with phi0 > rho0/2. phi/phi0, averaged over the bed's blocks among a block and its eight neighbours,
//! is below 0.88 in a loose block. The zone are the loose blocks of the bed that hang together, over common sides, with
//! the outlet: with the lowest block of a column whose middle lies over it. No such block, no zone.
//!
//! Only blocks of the bed are averaged because above it phi/phi0 is a ratio of a few particles. The average makes a
//! zone wider or narrower by up to a block on each side, depending on how loose it is.

use super::density::onset_density;
use super::{BLOCK_HEIGHT, BLOCK_WIDTH, Block, Blocks, History, finite, mean};

/// phi/phi0 below which material is loose.
const LOOSE: f64 = 0.88;

/// Half the width of the standard silo's outlet, spacings.
const OUTLET_HALF_WIDTH: f64 = 10.0;

/// |x| of what is central, spacings: a third of the standard silo, half-width 60, and twice the outlet.
const CENTRAL: f64 = 20.0;

/// The blocks of the dilatant zone at a step; `None` if there is no zone, or not five frames around that step.
#[must_use]
pub fn dilatant_zone(history: &History, step: u64) -> Option<Vec<Block>> {
    let blocks = &history.blocks;
    let (onset, now) = (history.onset(), history.short_mean(step)?);
    let threshold = 0.5 * onset_density(history)?;
    let ratio: Vec<_> = onset.iter().zip(&now).map(|(&then, now)| (then > threshold).then_some(now / then)).collect();
    let mut is_loose = vec![false; ratio.len()];
    for block in blocks.counted().filter(|block| ratio[block.index].is_some()) {
        is_loose[block.index] = smoothed(blocks, &ratio, block).is_some_and(|ratio| ratio < LOOSE);
    }
    let over_outlet = (0..blocks.columns).filter(|&column| blocks.x[column].abs() <= OUTLET_HALF_WIDTH);
    let lowest = over_outlet.filter_map(|column| blocks.column(column).next()).collect();
    let zone = connected(blocks, is_loose, lowest);
    (!zone.is_empty()).then_some(zone)
}

/// Mean over a block and its neighbours of what they have.
fn smoothed(blocks: &Blocks, values: &[Option<f64>], block: Block) -> Option<f64> {
    let columns = block.column.saturating_sub(1)..=block.column + 1;
    let rows = block.row.saturating_sub(1)..=block.row + 1;
    let near = columns.flat_map(|column| rows.clone().filter_map(move |row| blocks.block(column, row)));
    mean(near.filter_map(|block| values[block.index]))
}

/// The members that hang together, over common sides, with one of the `seeds`.
fn connected(blocks: &Blocks, mut is_member: Vec<bool>, seeds: Vec<Block>) -> Vec<Block> {
    let (mut found, mut next) = (Vec::new(), seeds);
    while let Some(block) = next.pop() {
        if !std::mem::take(&mut is_member[block.index]) {
            continue;
        }
        found.push(block);
        let (column, row) = (block.column, block.row);
        next.extend(column.checked_sub(1).and_then(|column| blocks.block(column, row)));
        next.extend(row.checked_sub(1).and_then(|row| blocks.block(column, row)));
        next.extend(blocks.block(column + 1, row));
        next.extend(blocks.block(column, row + 1));
    }
    found
}

/// Height zh of the dilatant zone at a step, spacings: the upper edge of its highest block above the outlet.
#[must_use]
pub fn zone_height(history: &History, step: u64) -> Option<f64> {
    let top = dilatant_zone(history, step)?.iter().map(|block| block.y).fold(f64::NEG_INFINITY, f64::max);
    finite(top + 0.5 * BLOCK_HEIGHT)
}

/// Width zw of the dilatant zone at a step, spacings: the blocks that it has in a row, of full width, in the mean over
/// its rows. Gaps within a row do not count.
#[must_use]
pub fn zone_width(history: &History, step: u64) -> Option<f64> {
    let zone = dilatant_zone(history, step)?;
    let width = |row| zone.iter().filter(|block| block.row == row).map(|_| BLOCK_WIDTH).sum();
    mean((0..history.blocks.rows).map(width).filter(|&width| width > 0.0))
}

/// Aspect ratio za = zw/zh of the dilatant zone at a step: small for a slender zone.
#[must_use]
pub fn zone_aspect_ratio(history: &History, step: u64) -> Option<f64> {
    finite(zone_width(history, step)? / zone_height(history, step)?)
}

/// Central share zc of the dilatant zone at a step: the part of its sum of phi0 - phi that blocks with |x| < 20 hold.
/// Blocks of the zone that have become denser count as negative; `None` if the sum is not positive.
#[must_use]
pub fn central_share(history: &History, step: u64) -> Option<f64> {
    let zone = dilatant_zone(history, step)?;
    let (onset, now) = (history.onset(), history.short_mean(step)?);
    let loss = |block: &Block| onset[block.index] - now[block.index];
    let central: f64 = zone.iter().filter(|block| block.x.abs() < CENTRAL).map(loss).sum();
    let total: f64 = zone.iter().map(loss).sum();
    if total > 0.0 { finite(central / total) } else { None }
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::{Silo, close};
    use super::*;

    /// Density 10 in the whole silo before; afterwards 10 times `ratio`.
    fn history(ratio: impl Fn(u64, f64, f64) -> f64) -> History {
        Silo::STANDARD.history(|_, _| 10.0, |step, x, y| 10.0 * ratio(step, x, y))
    }

    /// 0.7 where it is loose. A block at a corner of the loose part has 4 loose among 9: 1 - 0.3 4/9 = 0.867 < 0.88.
    /// One beside its edge has 3 of 9, on the floor 2 of 6: 0.9. So the zone is the loose part.
    fn ratio(is_loose: bool) -> f64 {
        if is_loose { 0.7 } else { 1.0 }
    }

    #[test]
    fn a_rectangular_zone_has_its_height_and_width() {
        // 12 columns, 15 rows. The zone and its figures are sums of 15 rows: rounding only.
        let history = history(|_, x, y| ratio(x.abs() < 6.0 * BLOCK_WIDTH && y < 60.0));
        assert_eq!(dilatant_zone(&history, 200).unwrap().len(), 12 * 15);
        close(zone_height(&history, 200), 60.0, 0.0);
        close(zone_width(&history, 200), 12.0 * BLOCK_WIDTH, 1e-12);
        close(zone_aspect_ratio(&history, 200), 12.0 * BLOCK_WIDTH / 60.0, 1e-13);
        // The middles of 5 of 6 columns on each side are within 20 spacings: 19.5, then 23.8.
        close(central_share(&history, 200), 5.0 / 6.0, 1e-12);
    }

    #[test]
    fn width_is_the_mean_over_rows() {
        // 10 rows of 12 columns, 5 of 4. In the lowest of the 5, the blocks beside have 3 loose blocks below and 2 at
        // their side, 5 of 9: they belong to the zone too.
        let is_loose = |x: f64, y| y < 40.0 && x.abs() < 6.0 * BLOCK_WIDTH || y < 60.0 && x.abs() < 2.0 * BLOCK_WIDTH;
        let history = history(|_, x, y| ratio(is_loose(x, y)));
        let blocks = f64::from(10 * 12 + 6 + 4 * 4);
        close(zone_width(&history, 200), blocks / 15.0 * BLOCK_WIDTH, 1e-12);
        close(zone_height(&history, 200), 60.0, 0.0);
    }

    #[test]
    fn the_central_share_goes_by_what_is_lost() {
        // 4 in the 10 columns within 20 spacings, 3 in 2 more. The zone grows by some blocks that have lost nothing.
        let of = |x: f64| if x.abs() < 20.0 { 0.6 } else { 0.7 };
        let history = history(|_, x, y| if x.abs() < 6.0 * BLOCK_WIDTH && y < 60.0 { of(x) } else { 1.0 });
        close(central_share(&history, 200), 40.0 / 46.0, 1e-12);
    }

    #[test]
    fn the_mean_of_five_frames_counts() {
        // The mean of 0.625 in four frames and 1 at 200 itself is 0.7.
        let is_near = |step| (180..=220).contains(&step) && step != 200;
        let history = history(|step, x, y| if is_near(step) && x.abs() < 20.0 && y < 60.0 { 0.625 } else { 1.0 });
        close(zone_height(&history, 200), 60.0, 0.0);
        assert!(dilatant_zone(&history, 80).is_none() && zone_width(&history, 80).is_none());
        // Too early and too late for five frames.
        assert!(zone_height(&history, 20).is_none() && zone_height(&history, 290).is_none());
    }

    #[test]
    fn only_what_is_looser_than_the_threshold_is_loose() {
        assert_eq!(dilatant_zone(&history(|_, _, _| 0.875), 200).unwrap().len(), 28 * 40);
        assert!(dilatant_zone(&history(|_, _, _| 0.885), 200).is_none());
    }

    #[test]
    fn only_what_hangs_together_with_the_outlet_is_the_zone() {
        let apart = |x: f64, y| x > 40.0 && y > 100.0;
        let both = history(|_, x, y| ratio(x.abs() < 20.0 && y < 60.0 || apart(x, y)));
        close(zone_height(&both, 200), 60.0, 0.0);
        assert!(dilatant_zone(&history(|_, x, y| ratio(apart(x, y))), 200).is_none());
        // On the floor, but beside the outlet.
        assert!(dilatant_zone(&history(|_, x, y| ratio(x.abs() > 25.0 && y < 60.0)), 200).is_none());
        // Over corners nothing hangs together.
        let blocks = Silo { columns: 2, rows: 2, sites: 20 }.blocks();
        let seeds = || blocks.block(0, 0).into_iter().collect();
        assert_eq!(connected(&blocks, vec![true, false, false, true], seeds()).len(), 1);
        assert_eq!(connected(&blocks, vec![true, true, false, true], seeds()).len(), 3);
        // Upwards, across and down again.
        let blocks = Silo { columns: 3, rows: 2, sites: 20 }.blocks();
        let seeds = || blocks.block(0, 0).into_iter().collect();
        assert_eq!(connected(&blocks, vec![true, true, false, true, true, true], seeds()).len(), 5);
        assert!(connected(&blocks, vec![false, true, true, true, true, true], seeds()).is_empty());
    }

    #[test]
    fn what_is_above_the_bed_is_no_zone() {
        // Above 80 there is a gas of density 1. Whether it then is thinner or denser changes nothing.
        for gas in [0.5, 5.0] {
            let later = |_, x: f64, y| if y > 80.0 { gas } else { 10.0 * ratio(x.abs() < 20.0) };
            let history = Silo::STANDARD.history(|_, y| if y > 80.0 { 1.0 } else { 10.0 }, later);
            close(zone_height(&history, 200), 80.0, 0.0);
            close(zone_width(&history, 200), 10.0 * BLOCK_WIDTH, 1e-12);
        }
    }
}
