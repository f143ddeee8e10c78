//! Height of the density loss, without a threshold for loose material.
//!
//! phi is the mean density over five frames around a step, phi0 the density before opening, and rho0 the onset density.
//! The *bed* consists of the blocks with phi0 > rho0/2.

use super::density::onset_density;
use super::surface::surface_level;
use super::{History, finite, mean};

/// Share of the surface height up to which the threshold-free height is measured. Material above is loose because the
/// surface sinks, not because of the zone.
const BELOW_SURFACE: f64 = 0.8;

/// Returns the threshold-free height of the dilatant zone at a step, hz = 2 sum(y w)/sum(w) over the rows, spacings.
///
/// The loss w of a row is the mean of max(phi0 - phi, 0) over its blocks that belong to the bed. The sum covers rows
/// with y < 0.8 of the surface height before opening (mean over the columns). hz is twice the height of the centre of
/// the lost mass, which is the height of a zone that is equally loose at all heights. `None` if no mass was lost.
#[must_use]
pub fn threshold_free_height(history: &History, step: u64) -> Option<f64> {
    let blocks = &history.blocks;
    let onset = history.onset();
    let now = history.short_mean(step)?;
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

    /// Rounding errors of sums over about 30 rows, for heights of about 50 spacings.
    const ROUNDING: f64 = 30.0 * 50.0 * f64::EPSILON;

    #[test]
    fn a_uniform_loss_gives_its_upper_limit() {
        // The loss is 3 below 60. The gain above 60 and the loss above 0.8 160 = 128 do not contribute.
        let density = |_, _, y| match y {
            ..60.0 => 7.0,
            60.0..128.0 => 11.0,
            _ => 2.0,
        };
        close(threshold_free_height(&Silo::STANDARD.history(|_, _| 10.0, density), 80), 60.0, ROUNDING);
    }

    #[test]
    fn the_surface_before_opening_limits_the_height() {
        // The silo is filled to 80, so 0.8 of the surface height is 64. The loss is 3 below 64, and 10 above.
        let density = |_, _, y| if y < 64.0 { 7.0 } else { 0.0 };
        let history = Silo::STANDARD.history(|_, y| if y < 80.0 { 10.0 } else { 0.0 }, density);
        close(threshold_free_height(&history, 80), 64.0, ROUNDING);
    }

    #[test]
    fn a_loss_that_falls_linearly_gives_two_thirds_of_its_upper_limit() {
        // The loss is proportional to H - y below H = 60. The rows are h = 4 apart, the first at h/2. With n = H/h
        // rows, sum y = n H/2 and sum y^2 = n (H^2/3 - h^2/12), so twice the centre is 2 (H^2/6 + h^2/12)/(H/2) = 2 H/3
        // + h^2/(3 H).
        let history = Silo::STANDARD.history(|_, _| 10.0, |_, _, y| 10.0 - (60.0 - y).max(0.0) / 20.0);
        close(threshold_free_height(&history, 80), 40.0 + 16.0 / 180.0, ROUNDING);
    }

    #[test]
    fn a_row_is_averaged_over_the_bed() {
        // A hole on the right, below 20, does not belong to the bed. The loss of the other blocks is uniform below 60.
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
