//! How high the loss of density reaches, without a threshold for what is loose.
//!
//! phi is the mean over five frames around a step, phi0 the density before opening, rho0 the onset density. The *bed*
//! are the blocks with phi0 > rho0/2.

use super::density::onset_density;
use super::surface::surface_level;
use super::{History, finite, mean};

/// Share of the surface's height that the threshold-free height looks at: what lies above is loose because the surface
/// sinks, not because of the zone.
const BELOW_SURFACE: f64 = 0.8;

/// Threshold-free height hz of the dilatant zone at a step, spacings: 2 sum(y w)/sum(w) over the rows, twice the height
/// of the centre of what was lost. w is the mean of max(phi0 - phi, 0) over the blocks of the row that belong to the
/// bed; rows with y < 0.8 of the surface before opening (mean over the columns) count. It is the height of a zone that
/// is equally loose all the way up. `None` if nothing was lost.
#[must_use]
pub fn threshold_free_height(history: &History, step: u64) -> Option<f64> {
    let blocks = &history.blocks;
    let (onset, now) = (history.onset(), history.short_mean(step)?);
    let threshold = 0.5 * onset_density(history)?;
    let top = BELOW_SURFACE * surface_level(blocks, &onset, threshold)?;
    let loss = |row| {
        let bed = blocks.row(row).map(|block| block.index).filter(|&index| onset[index] > threshold);
        mean(bed.map(|index| (onset[index] - now[index]).max(0.0)))
    };
    let rows = (0..blocks.rows).filter(|&row| blocks.y[row] < top);
    let rows: Vec<_> = rows.filter_map(|row| Some((blocks.y[row], loss(row)?))).collect();
    let total: f64 = rows.iter().map(|(_, loss)| loss).sum();
    finite(2.0 * rows.iter().map(|(y, loss)| y * loss).sum::<f64>() / total)
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::{Silo, close};
    use super::*;

    /// Some 30 rows whose sums are rounded, of a height of some 50 spacings.
    const ROUNDING: f64 = 30.0 * 50.0 * f64::EPSILON;

    #[test]
    fn an_even_loss_has_the_height_that_it_reaches() {
        // Loss of 3 below 60. Gain above that, and loss above 0.8 160 = 128, count for nothing.
        let density = |_, _, y| match y {
            ..60.0 => 7.0,
            60.0..128.0 => 11.0,
            _ => 2.0,
        };
        close(threshold_free_height(&Silo::STANDARD.history(|_, _| 10.0, density), 80), 60.0, ROUNDING);
    }

    #[test]
    fn the_surface_before_opening_limits_it() {
        // Filled to 80, so that 0.8 of the surface is 64; 3 is lost below, all above.
        let density = |_, _, y| if y < 64.0 { 7.0 } else { 0.0 };
        let history = Silo::STANDARD.history(|_, y| if y < 80.0 { 10.0 } else { 0.0 }, density);
        close(threshold_free_height(&history, 80), 64.0, ROUNDING);
    }

    #[test]
    fn a_loss_that_fades_upwards_has_two_thirds() {
        // Loss proportional to H - y below H = 60, at rows h = 4 apart from h/2 on. With n = H/h rows, sum y = n H/2
        // and sum y^2 = n (H^2/3 - h^2/12): twice the centre is 2 (H^2/6 + h^2/12)/(H/2) = 2 H/3 + h^2/(3 H).
        let history = Silo::STANDARD.history(|_, _| 10.0, |_, _, y| 10.0 - (60.0 - y).max(0.0) / 20.0);
        close(threshold_free_height(&history, 80), 40.0 + 16.0 / 180.0, ROUNDING);
    }

    #[test]
    fn a_row_is_averaged_over_the_bed() {
        // A hole on the right, below 20, is no part of the bed: an even loss elsewhere is even.
        let is_hole = |x: f64, y: f64| x > 0.0 && y < 20.0;
        let before = |x, y| if is_hole(x, y) { 0.0 } else { 10.0 };
        let after = |_, x, y| if y < 60.0 { 0.7 * before(x, y) } else { before(x, y) };
        close(threshold_free_height(&Silo::STANDARD.history(before, after), 80), 60.0, ROUNDING);
    }

    #[test]
    fn without_loss_or_frames_there_is_no_height() {
        let history = Silo::STANDARD.history(|_, _| 10.0, |_, _, _| 10.0);
        assert!(threshold_free_height(&history, 80).is_none());
        let loss = Silo::STANDARD.history(|_, _| 10.0, |_, _, _| 7.0);
        assert!(threshold_free_height(&loss, 80).is_some() && threshold_free_height(&loss, 20).is_none());
    }
}
