//! How evenly the density is spread while the silo flows, averaged over 100 to 300 steps.
//!
//! phi is the density of a block in one frame, with its noise from frame to frame: these figures are formed in each
//! frame and then averaged. y_s is the height of the surface in that frame, mean over the columns (so one level for all
//! of them), with the threshold rho0/2.

use super::density::onset_density;
use super::surface::surface_level;
use super::{Block, Blocks, History, finite, mean};

/// |x| of the centre, spacings: about the outlet of the standard silo, half-width 60.
const CENTRE: f64 = 12.0;

/// |x| of the sides, spacings: the outer third of the standard silo, half-width 60.
const SIDES: f64 = 40.0;

/// Height from which centre and sides are compared, spacings: above the outlet's own rarefaction.
const ABOVE_OUTLET: f64 = 12.0;

/// Share of y_s up to which centre and sides are compared.
const COMPARED: f64 = 0.6;

/// Share of y_s up to which rows are looked at.
const ROWS: f64 = 0.75;

/// Ratio cs of the density in the centre, |x| < 12, to that at the sides, |x| > 40, both for 12 < y < 0.6 y_s: 1 for
/// horizontal layering, less for a core that flows ahead.
///
/// Each density is the mean over the rows of its row means, and only rows that have blocks in both count. In a
/// rectangular silo that is the mean over the blocks. In a hopper, whose low rows have no sides, the plain mean would
/// compare the bottom's density with that further up and not give 1 for horizontal layers.
#[must_use]
pub fn centre_to_side_ratio(history: &History) -> Option<f64> {
    let threshold = 0.5 * onset_density(history)?;
    let blocks = &history.blocks;
    history.flow_mean(|density| {
        let top = COMPARED * surface_level(blocks, density, threshold)?;
        let rows = (0..blocks.rows).filter(|&row| ABOVE_OUTLET < blocks.y[row] && blocks.y[row] < top);
        let pairs = rows.filter_map(|row| {
            let centre = row_mean(blocks, density, row, |block| block.x.abs() < CENTRE)?;
            Some((centre, row_mean(blocks, density, row, |block| block.x.abs() > SIDES)?))
        });
        let (centre, sides) = pairs.fold((0.0, 0.0), |sum, pair| (sum.0 + pair.0, sum.1 + pair.1));
        finite(centre / sides)
    })
}

/// Variation cvr within rows: the root of the mean square of phi less the mean of its row, over the mean of phi, for
/// y < 0.75 y_s. Horizontal layers have none.
#[must_use]
pub fn row_variation(history: &History) -> Option<f64> {
    let threshold = 0.5 * onset_density(history)?;
    let blocks = &history.blocks;
    history.flow_mean(|density| {
        let top = ROWS * surface_level(blocks, density, threshold)?;
        let rows = (0..blocks.rows).filter(|&row| blocks.y[row] < top);
        let rows = rows.filter_map(|row| Some((row, row_mean(blocks, density, row, |_| true)?)));
        let deviations =
            rows.clone().flat_map(|(row, mean)| blocks.row(row).map(move |block| density[block.index] - mean));
        let square = mean(deviations.map(|deviation| deviation.powi(2)))?;
        finite(square.sqrt() / mean(rows.flat_map(|(row, _)| blocks.row(row)).map(|block| density[block.index]))?)
    })
}

/// Variation cvg of the whole silo: the standard deviation of phi over its mean, over all blocks, those above the
/// surface too.
#[must_use]
pub fn overall_variation(history: &History) -> Option<f64> {
    history.flow_mean(|density| {
        let all = || history.blocks.counted().map(|block| density[block.index]);
        let middle = mean(all())?;
        finite(mean(all().map(|phi| (phi - middle).powi(2)))?.sqrt() / middle)
    })
}

/// Mean density of a row's blocks that are wanted.
fn row_mean(blocks: &Blocks, density: &[f64], row: usize, is_wanted: impl Fn(&Block) -> bool) -> Option<f64> {
    mean(blocks.row(row).filter(is_wanted).map(|block| density[block.index]))
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::{Silo, add_hopper, close};
    use super::*;

    // Sums of up to 1120 densities, rounded to 1e-16 of the sum at each addition.
    const ROUNDING: f64 = 1120.0 * f64::EPSILON;

    #[test]
    fn horizontal_layers_are_even() {
        // Density falls upwards by a 20th a block, exactly as counts of 20 sites can have it.
        let layers = |_, _, y: f64| 12.0 - y / 20.0;
        let mut history = Silo::STANDARD.history(|_, _| 10.0, layers);
        close(centre_to_side_ratio(&history), 1.0, ROUNDING);
        close(row_variation(&history), 0.0, ROUNDING);
        assert!(overall_variation(&history).unwrap() > 0.1);
        // In the hopper too, where the low rows have no sides: the surface stands at 140, sides from 53 to 84.
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
    fn a_loose_core_has_its_ratio() {
        // Compared are rows from 14 to below 0.6 160 = 96: 8 in their centre in the mean over 3 columns, and over rows,
        // since what the first and the last have more is missing in one between; 10 at the sides in the mean over 5
        // columns. Elsewhere other values.
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
        // At 80, where full and empty blocks meet, so that the rows to 48 are compared.
        let density = |_, x: f64, y: f64| match y {
            ..48.0 if x.abs() < 12.0 => 8.0,
            ..80.0 => 10.0,
            _ => 0.0,
        };
        close(centre_to_side_ratio(&Silo::STANDARD.history(|_, _| 10.0, density)), 0.8, ROUNDING);
    }

    #[test]
    fn variation_within_rows_is_that_of_the_columns() {
        // 10 + d on the left, 10 - d on the right. 30 rows lie below 0.75 160 = 120: in 29 of them, below 116, d is 2,
        // in the last and above it is 3.
        let density = |_, x: f64, y: f64| 10.0 - x.signum() * if y < 116.0 { 2.0 } else { 3.0 };
        let history = Silo::STANDARD.history(|_, _| 10.0, density);
        close(row_variation(&history), (29.0_f64 * 4.0 + 9.0).sqrt() / 30f64.sqrt() / 10.0, ROUNDING);
    }

    #[test]
    fn half_a_silo_varies_by_its_mean() {
        // 8 and 0 in equal parts: mean 4, deviation 4.
        let half = Silo::STANDARD.history(|_, _| 8.0, |_, _, y| if y < 80.0 { 8.0 } else { 0.0 });
        close(overall_variation(&half), 1.0, ROUNDING);
        // Frames of 1 and of 0, averaged over 100, 110, ..., 300: 11 of 21.
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
