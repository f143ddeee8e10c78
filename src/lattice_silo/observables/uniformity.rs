//! Uniformity of the density during flow, averaged over 100 to 300 steps.
//!
//! Each observable is computed per frame and then averaged, so it includes the noise from frame to frame. phi is the
//! density of a block in one frame. y_s is the surface height in this frame for the threshold rho0/2, as a mean over
//! the columns: one level for all columns.

use super::density::onset_density;
use super::surface::surface_level;
use super::{Block, Blocks, History, finite, mean};

/// Largest |x| of the centre, spacings: about the outlet of the standard silo, half-width 60.
const CENTRE_WITHIN: f64 = 12.0;

/// Least |x| of the sides, spacings: the outer third of the standard silo, half-width 60.
const SIDES_BEYOND: f64 = 40.0;

/// Least height at which centre and sides are compared, spacings: above the rarefaction at the outlet.
const ABOVE_OUTLET: f64 = 12.0;

/// Share of y_s up to which centre and sides are compared.
const COMPARED_BELOW: f64 = 0.6;

/// Share of y_s up to which rows contribute to the variation within rows.
const VARIATION_BELOW: f64 = 0.75;

/// Returns the ratio cs of the density in the centre, |x| < 12, to the density at the sides, |x| > 40, both for
/// 12 < y < 0.6 y_s. It is 1 for horizontal layering and smaller if a core flows faster.
///
/// Each density is the mean over rows of its row means. Only rows with blocks in both ranges are used. In a rectangular
/// silo this is the mean over the blocks. In a hopper the low rows have no sides. There, a plain mean over blocks would
/// compare densities at different heights, and differ from 1 for horizontal layers.
#[must_use]
pub fn centre_to_side_ratio(history: &History) -> Option<f64> {
    let threshold = 0.5 * onset_density(history)?;
    let blocks = &history.blocks;
    history.flow_mean(|density| {
        let top = COMPARED_BELOW * surface_level(blocks, density, threshold)?;
        let rows = (0..blocks.rows).filter(|&row| ABOVE_OUTLET < blocks.y[row] && blocks.y[row] < top);
        let pairs = rows.filter_map(|row| {
            let centre = row_mean(blocks, density, row, |block| block.x.abs() < CENTRE_WITHIN)?;
            Some((centre, row_mean(blocks, density, row, |block| block.x.abs() > SIDES_BEYOND)?))
        });
        let (centre, sides) = pairs.fold((0.0, 0.0), |sum, pair| (sum.0 + pair.0, sum.1 + pair.1));
        finite(centre / sides)
    })
}

/// Returns the variation within rows, cvr: the root mean square of phi minus its row mean, divided by the mean of phi,
/// for y < 0.75 y_s. It is 0 for horizontal layers.
#[must_use]
pub fn row_variation(history: &History) -> Option<f64> {
    let threshold = 0.5 * onset_density(history)?;
    let blocks = &history.blocks;
    history.flow_mean(|density| {
        let top = VARIATION_BELOW * surface_level(blocks, density, threshold)?;
        let rows = (0..blocks.rows).filter(|&row| blocks.y[row] < top);
        let rows = rows.filter_map(|row| Some((row, row_mean(blocks, density, row, |_| true)?)));
        let deviations =
            rows.clone().flat_map(|(row, mean)| blocks.row(row).map(move |block| density[block.index] - mean));
        let square = mean(deviations.map(|deviation| deviation.powi(2)))?;
        finite(square.sqrt() / mean(rows.flat_map(|(row, _)| blocks.row(row)).map(|block| density[block.index]))?)
    })
}

/// Returns the variation of the whole silo, cvg: the standard deviation of phi divided by its mean. It covers all
/// blocks, including blocks above the surface.
#[must_use]
pub fn overall_variation(history: &History) -> Option<f64> {
    history.flow_mean(|density| {
        let all = || history.blocks.counted().map(|block| density[block.index]);
        let middle = mean(all())?;
        finite(mean(all().map(|phi| (phi - middle).powi(2)))?.sqrt() / middle)
    })
}

/// Returns the mean density of the blocks of a row for which `is_wanted` holds.
fn row_mean(blocks: &Blocks, density: &[f64], row: usize, is_wanted: impl Fn(&Block) -> bool) -> Option<f64> {
    mean(blocks.row(row).filter(is_wanted).map(|block| density[block.index]))
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::{Silo, add_hopper, close};
    use super::*;

    // Rounding errors of sums of up to 1120 densities, with a relative error of 1e-16 in each addition.
    const ROUNDING: f64 = 1120.0 * f64::EPSILON;

    #[test]
    fn horizontal_layers_have_no_variation_within_rows() {
        // The density falls linearly with height, in multiples of 1/20, which blocks of 20 sites represent exactly.
        let layers = |_, _, y: f64| 12.0 - y / 20.0;
        let mut history = Silo::STANDARD.history(|_, _| 10.0, layers);
        close(centre_to_side_ratio(&history), 1.0, ROUNDING);
        close(row_variation(&history), 0.0, ROUNDING);
        assert!(overall_variation(&history).unwrap() > 0.1);
        // The same in a hopper, where the low rows have no sides. The surface is at 140, so sides are from 53 to 84.
        add_hopper(&mut history);
        close(centre_to_side_ratio(&history), 1.0, ROUNDING);
        close(row_variation(&history), 0.0, ROUNDING);
    }

    #[test]
    fn a_uniform_density_does_not_vary() {
        let history = Silo::STANDARD.history(|_, _| 10.0, |_, _, _| 9.0);
        close(overall_variation(&history), 0.0, 0.0);
        close(row_variation(&history), 0.0, 0.0);
        close(centre_to_side_ratio(&history), 1.0, 0.0);
    }

    #[test]
    fn a_loose_core_gives_its_density_ratio() {
        // The rows from 14 to below 0.6 160 = 96 are compared. The mean density in the centre is 8 over columns and
        // rows: the excess of the first and the last row cancels the deficit of a row between them. The mean at the
        // sides is 10 over 5 columns. Other places have other densities, which must not contribute.
        let row = |y: f64| match y {
            ..12.0 | 96.0.. => 3.0,
            ..16.0 | 92.0.. => 2.0,
            52.0..56.0 => -4.0,
            _ => 0.0,
        };
        let density = |_, x: f64, y| match x.abs() {
            ..8.0 => 7.0 + row(y),
            8.0..12.0 => 10.0 + row(y),
            12.0..40.0 => 13.0,
            40.0..44.0 => 6.0,
            _ => 11.0,
        };
        close(centre_to_side_ratio(&Silo::STANDARD.history(|_, _| 10.0, density)), 0.8, ROUNDING);
    }

    #[test]
    fn centre_and_sides_are_compared_below_the_sunken_surface() {
        // The surface is at 80, between full and empty blocks, so the rows below 48 are compared.
        let density = |_, x: f64, y: f64| match y {
            ..48.0 if x.abs() < 12.0 => 8.0,
            ..80.0 => 10.0,
            _ => 0.0,
        };
        close(centre_to_side_ratio(&Silo::STANDARD.history(|_, _| 10.0, density)), 0.8, ROUNDING);
    }

    #[test]
    fn variation_within_rows_is_the_deviation_from_row_means() {
        // The density is 10 + d on the left, 10 - d on the right. 30 rows are below 0.75 160 = 120. In 29 of them,
        // below 116, d is 2. In the last one and above, d is 3.
        let density = |_, x: f64, y: f64| 10.0 - x.signum() * if y < 116.0 { 2.0 } else { 3.0 };
        let history = Silo::STANDARD.history(|_, _| 10.0, density);
        close(row_variation(&history), (29.0_f64 * 4.0 + 9.0).sqrt() / 30f64.sqrt() / 10.0, ROUNDING);
    }

    #[test]
    fn a_half_filled_silo_has_variation_one() {
        // Equal parts have density 8 and 0: mean 4, standard deviation 4.
        let half = Silo::STANDARD.history(|_, _| 8.0, |_, _, y| if y < 80.0 { 8.0 } else { 0.0 });
        close(overall_variation(&half), 1.0, ROUNDING);
        // The variation is 1 in frames at multiples of 20 steps, else 0. These are 11 of the 21 frames from 100 to 300.
        let every_second = |step, _, y| {
            if y < 80.0 {
                8.0
            } else if step % 20 == 0 {
                0.0
            } else {
                8.0
            }
        };
        let history = Silo::STANDARD.history(|_, _| 8.0, every_second);
        close(overall_variation(&history), 11.0 / 21.0, ROUNDING);
    }

    #[test]
    fn an_empty_silo_has_no_variation() {
        let history = Silo::STANDARD.history(|_, _| 8.0, |_, _, _| 0.0);
        let figures = [centre_to_side_ratio(&history), row_variation(&history), overall_variation(&history)];
        assert_eq!(figures, [None; 3]);
    }
}
