//! The surface of the bed: its height, its inclination, and its dip over the outlet.
//!
//! The *surface* y_s of a block column is the height at which the density falls through rho0/2. It is interpolated
//! linearly between the centre of the highest block with phi > rho0/2 and the centre of the block above. If there is no
//! block above (under the lid), the surface is the upper edge of the highest block. A column without a block of
//! phi > rho0/2 has no surface. The error is at most 6 - 4 sqrt(2) = 0.34 spacings for a sharp surface (see the tests),
//! and smaller for a surface that is diffuse over several blocks.
//!
//! Inclination and dip are means over the frames in which 15 to 25 % of the particles have left the silo. If there is
//! no frame in this range, because the run ends before it or the outflow skips it, the last five frames are used.

use super::density::onset_density;
use super::{BLOCK_HEIGHT, Blocks, Frame, History, finite, mean, real};

use siloflow_dem::math;

/// Range of the share of particles out, in which the surface is measured.
const DISCHARGED: (f64, f64) = (0.15, 0.25);

/// Number of frames that are used if no frame is in the range [`DISCHARGED`].
const LAST_FRAMES: usize = 5;

/// |x| of the columns next to the walls, spacings: the outer quarter of the standard silo, half-width 60.
const NEAR_WALL: f64 = 45.0;

/// |x| of the columns over the outlet, spacings: the inner quarter of the standard silo, half-width 60.
const OVER_OUTLET: f64 = 15.0;

/// Least sum of squared deviations of |x| for which a slope is computed, spacings^2. Two columns left and right of the
/// outlet, at nominally equal distance, can differ in |x| by a site column. Such a small spread gives no useful slope.
const LEAST_SPREAD: f64 = 1.0;

/// Returns y_s of every block column, spacings above the outlet: the height at which `density` falls through
/// `threshold`.
#[must_use]
pub fn surface_heights(blocks: &Blocks, density: &[f64], threshold: f64) -> Vec<Option<f64>> {
    (0..blocks.columns).map(|column| column_surface(blocks, density, threshold, column)).collect()
}

fn column_surface(blocks: &Blocks, density: &[f64], threshold: f64, column: usize) -> Option<f64> {
    let highest = blocks.column(column).rev().find(|block| density[block.index] > threshold)?;
    let Some(above) = blocks.block(column, highest.row + 1) else {
        return finite(highest.y + 0.5 * BLOCK_HEIGHT);
    };
    let inside = density[highest.index];
    let outside = density[above.index];
    finite(highest.y + (inside - threshold) / (inside - outside) * (above.y - highest.y))
}

/// Returns the mean of y_s over the columns, spacings: the height of the bed, used by other observables.
pub(super) fn surface_level(blocks: &Blocks, density: &[f64], threshold: f64) -> Option<f64> {
    mean(surface_heights(blocks, density, threshold).into_iter().flatten())
}

/// Returns the inclination incl of the surface, degrees from the horizontal: the atan of the slope of y_s against |x|.
/// It is positive if the surface rises towards the walls. The slope is a least-squares fit over the columns of a frame,
/// averaged over the frames. Frames with a surface at fewer than two distances from the middle are left out.
#[must_use]
pub fn inclination(history: &History) -> Option<f64> {
    let slope = surface_mean(history, slope)?;
    finite(math::atan(slope).to_degrees())
}

/// Returns the dip of the surface over the outlet, spacings: the mean of y_s over the columns with |x| > 45 minus its
/// mean over the columns with |x| < 15. The dip is averaged over the same frames as the inclination. Frames without a
/// surface in one of the two ranges are left out.
#[must_use]
pub fn dip(history: &History) -> Option<f64> {
    surface_mean(history, |points| {
        let at_walls = mean(points.iter().filter(|(distance, _)| *distance > NEAR_WALL).map(|(_, height)| *height))?;
        let over_outlet = points.iter().filter(|(distance, _)| *distance < OVER_OUTLET).map(|(_, height)| *height);
        Some(at_walls - mean(over_outlet)?)
    })
}

/// Returns the mean of `figure` over the frames to measure. `figure` gets the points (|x|, y_s) of a frame.
fn surface_mean(history: &History, figure: impl Fn(&[(f64, f64)]) -> Option<f64>) -> Option<f64> {
    let threshold = 0.5 * onset_density(history)?;
    let points = |frame: &Frame| -> Vec<(f64, f64)> {
        let heights = surface_heights(&history.blocks, &history.blocks.density(frame), threshold);
        history.blocks.x.iter().zip(heights).filter_map(|(x, height)| Some((x.abs(), height?))).collect()
    };
    mean(frames_to_measure(history).into_iter().filter_map(|frame| figure(&points(frame))))
}

fn frames_to_measure(history: &History) -> Vec<&Frame> {
    let total: f64 = history.start.counts.iter().map(|&count| f64::from(count)).sum();
    let share = |frame: &Frame| (real(frame.out) - real(history.start.out)) / total;
    let (least, most) = DISCHARGED;
    let inside: Vec<_> = history.frames.iter().filter(|frame| (least..=most).contains(&share(frame))).collect();
    if inside.is_empty() {
        let first = history.frames.len().checked_sub(LAST_FRAMES);
        return first.map_or(Vec::new(), |first| history.frames[first..].iter().collect());
    }
    inside
}

/// Returns the slope of the least-squares line through the points.
fn slope(points: &[(f64, f64)]) -> Option<f64> {
    let middle = mean(points.iter().map(|(x, _)| *x))?;
    let spread: f64 = points.iter().map(|(x, _)| (x - middle).powi(2)).sum();
    let moment: f64 = points.iter().map(|(x, y)| (x - middle) * y).sum();
    if spread < LEAST_SPREAD { None } else { finite(moment / spread) }
}

#[cfg(test)]
mod tests {
    use super::super::BLOCK_WIDTH;
    use super::super::synthetic::{Silo, close};
    use super::*;

    /// Returns the share of the block at height y that is below `surface`.
    fn filled(surface: f64, y: f64) -> f64 {
        ((surface - y) / BLOCK_HEIGHT + 0.5).clamp(0.0, 1.0)
    }

    /// Returns a history with a V-shaped surface. The start has density 10 everywhere, so that the threshold is 5.
    fn vee(slope: f64, density: impl Fn(f64, f64) -> f64) -> History {
        Silo::FINE.history(|_, _| 10.0, |_, x, y| density(80.0 + slope * (x.abs() - 30.0), y))
    }

    /// Returns the largest error of the least-squares slope for heights with errors up to 1: sum|d|/sum d^2, with d =
    /// |x| minus its mean. The error of the inclination, in radians, is not larger, because atan has slope 1 at most.
    fn lever(blocks: &Blocks) -> f64 {
        let middle = mean(blocks.x.iter().map(|x| x.abs())).unwrap();
        let deviations = || blocks.x.iter().map(|x| (x.abs() - middle).abs());
        deviations().sum::<f64>() / deviations().map(|d| d * d).sum::<f64>()
    }

    #[test]
    fn a_diffuse_surface_is_interpolated_exactly() {
        // The density falls linearly from 10 to 0 over 24 spacings around the surface. It is rounded to a millionth,
        // with errors up to 5e-7. With the gradient 10/24 this is an error of 1.2e-6 in height at both ends of the
        // interpolation, and not more between them. The remaining 1e-7 covers the rounding of the heights.
        let error = 1.3e-6;
        for slope in [-0.5, -0.1, 0.0, 0.3, 0.7] {
            let history = vee(slope, |surface, y| (5.0 + (surface - y) * 10.0 / 24.0).clamp(0.0, 10.0));
            close(inclination(&history), slope.atan().to_degrees(), (error * lever(&history.blocks)).to_degrees());
            // The columns with |x| > 45 have centres at 10.5 to 13.5 block widths, the columns with |x| < 15 at 0.5 to
            // 2.5.
            close(dip(&history), slope * 10.5 * BLOCK_WIDTH, 2.0 * error);
        }
    }

    #[test]
    fn a_sharp_surface_is_found_within_a_tenth_of_a_block() {
        // Let the block at the surface be filled to the share f; heights are relative to its centre. The true surface
        // is at 4 f - 2. If f > 1/2, the measured surface is at 4 (f - 1/2)/f. The error is 6 - 2/f - 4 f, at most 6 -
        // 4 sqrt(2) for f = 1/sqrt(2). If f <= 1/2, the measured surface is at 2/(1 - f) - 4. The error then has the
        // opposite sign and the same size as for 1 - f. Rounding of densities to a millionth adds less than 1e-5.
        let error = 6.0 - 4.0 * 2f64.sqrt() + 1e-5;
        for slope in [-0.6, 0.0, 0.25, 0.577, 0.8] {
            let history = vee(slope, |surface, y| 10.0 * filled(surface, y));
            close(inclination(&history), slope.atan().to_degrees(), (error * lever(&history.blocks)).to_degrees());
            close(dip(&history), slope * 10.5 * BLOCK_WIDTH, 2.0 * error);
        }
        for tenths in 0..=40 {
            let level = 40.0 + 0.1 * f64::from(tenths);
            let history = Silo::FINE.history(|_, _| 10.0, |_, _, y| 10.0 * filled(level, y));
            let density = history.blocks.density(&history.frames[0]);
            close(surface_level(&history.blocks, &density, 5.0), level, error);
        }
    }

    #[test]
    fn the_surface_is_at_half_the_onset_density() {
        // The onset density is 10. At height 80 the density changes from 5.5 to 4.5 outside |x| = 30, from 10 to 0
        // inside.
        let outside = |y| if y < 80.0 { 5.5 } else { 4.5 };
        let inside = |y| if y < 80.0 { 10.0 } else { 0.0 };
        let density = |_, x: f64, y| if x.abs() > 30.0 { outside(y) } else { inside(y) };
        let history = Silo::STANDARD.history(|_, _| 10.0, density);
        close(dip(&history), 0.0, 0.0);
        close(inclination(&history), 0.0, 1e-12);
    }

    #[test]
    fn the_surface_of_a_full_silo_is_its_lid_and_an_empty_one_has_none() {
        let history = Silo::STANDARD.history(|_, _| 10.0, |_, x, _| if x < 0.0 { 6.0 } else { 4.0 });
        let heights = surface_heights(&history.blocks, &history.blocks.density(&history.frames[0]), 5.0);
        assert_eq!(heights, [[Some(160.0); 14], [None; 14]].concat());
    }

    #[test]
    fn frames_with_15_to_25_percent_discharged_are_measured() {
        // At step t, t/10 % of the particles are out. The slope is 0 below 15 %, 0.5 up to 25 %, and 0.2 above.
        let slope = |step| -> f64 {
            match step {
                ..150 => 0.0,
                150..=250 => 0.5,
                _ => 0.2,
            }
        };
        let density =
            |step, x: f64, y: f64| (5.0 + (80.0 + slope(step) * (x.abs() - 30.0) - y) * 10.0 / 24.0).clamp(0.0, 10.0);
        let mut history = Silo::FINE.history(|_, _| 10.0, density);
        let total: u64 = history.start.counts.iter().map(|&count| u64::from(count)).sum();
        // A tenth was out before the outlet opened, and must not count.
        history.start.out = total / 10;
        history.frames.iter_mut().for_each(|frame| frame.out = total / 10 + total / 1000 * frame.step);
        close(inclination(&history), 0.5f64.atan().to_degrees(), 1e-5);
        // No frame is in the range: the last five frames, from step 260 on, are used.
        history.frames.retain(|frame| !(150..=250).contains(&frame.step));
        close(inclination(&history), 0.2f64.atan().to_degrees(), 1e-5);
        history.frames.truncate(4);
        assert!(inclination(&history).is_none() && dip(&history).is_none());
    }

    #[test]
    fn columns_at_one_distance_give_no_slope() {
        let narrow = Silo { columns: 2, rows: 10, sites: 20 }.history(|_, _| 10.0, |_, _, _| 10.0);
        assert!(inclination(&narrow).is_none() && dip(&narrow).is_none());
        // Two distances that differ by a site column give no slope either; the surfaces are at 10 and at 40.
        let mut uneven = Silo { columns: 2, rows: 10, sites: 20 }
            .history(|_, _| 10.0, |_, x, y| if x < 0.0 || y < 10.0 { 10.0 } else { 0.0 });
        uneven.blocks.x = vec![-2.6, 1.7];
        assert!(inclination(&uneven).is_none());
    }
}
