//! The surface of the bed: how high it stands, how steep it is, how deep it dips over the outlet.
//!
//! In every block column the *surface* y_s is where the density falls through rho0/2: from the middle of the highest
//! block with phi > rho0/2 to the middle of the block above, linearly. Under the lid there is no block above; the
//! surface is then put at the upper edge of the highest block. A column without such a block has no surface. A sharp
//! surface is found within 6 - 4 sqrt(2) = 0.34 spacings (see the tests), one that is diffuse over several blocks
//! better.
//!
//! Inclination and dip are means over the frames in which 15 to 25 % of the particles have left the silo; if no frame
//! does, because the run ends before or the outflow steps over it, over the last five frames.

use super::density::onset_density;
use super::{BLOCK_HEIGHT, Blocks, Frame, History, finite, mean, real};

/// Shares of the particles out between which the surface is measured.
const DISCHARGED: (f64, f64) = (0.15, 0.25);

/// How many frames stand in where none is in that range.
const LAST_FRAMES: usize = 5;

/// |x| of the columns next to the walls, spacings: the outer quarter of the standard silo, half-width 60.
const NEAR_WALL: f64 = 45.0;

/// |x| of the columns over the outlet, spacings: the inner quarter of the standard silo, half-width 60.
const OVER_OUTLET: f64 = 15.0;

/// Least sum of squared deviations of |x| that gives a slope, spacings^2: two columns at the same distance left and
/// right of the outlet may lie a site column apart, which is no base for one.
const LEAST_SPREAD: f64 = 1.0;

/// y_s of every block column, spacings above the outlet: where `density` falls through `threshold`.
#[must_use]
pub fn surface_heights(blocks: &Blocks, density: &[f64], threshold: f64) -> Vec<Option<f64>> {
    (0..blocks.columns).map(|column| column_surface(blocks, density, threshold, column)).collect()
}

fn column_surface(blocks: &Blocks, density: &[f64], threshold: f64, column: usize) -> Option<f64> {
    let highest = blocks.column(column).rev().find(|block| density[block.index] > threshold)?;
    let Some(above) = blocks.block(column, highest.row + 1) else {
        return finite(highest.y + 0.5 * BLOCK_HEIGHT);
    };
    let (inside, outside) = (density[highest.index], density[above.index]);
    finite(highest.y + (inside - threshold) / (inside - outside) * (above.y - highest.y))
}

/// Mean of y_s over the columns, spacings: the height of the bed that other figures refer to.
pub(super) fn surface_level(blocks: &Blocks, density: &[f64], threshold: f64) -> Option<f64> {
    mean(surface_heights(blocks, density, threshold).into_iter().flatten())
}

/// Inclination incl of the surface, degrees to the horizontal: atan of the slope of y_s against |x|, positive where the
/// surface rises towards the walls. The slope is that of least squares over the columns of a frame, the mean over the
/// frames; frames with a surface at fewer than two distances from the middle are left out.
#[must_use]
pub fn inclination(history: &History) -> Option<f64> {
    let slope = surface_mean(history, slope)?;
    finite(slope.atan().to_degrees())
}

/// Dip of the surface over the outlet, spacings: the mean of y_s over the columns with |x| > 45 less that over the
/// columns with |x| < 15, in the mean over the same frames as the inclination. Frames without a surface in either are
/// left out.
#[must_use]
pub fn dip(history: &History) -> Option<f64> {
    surface_mean(history, |points| {
        let at_walls = mean(points.iter().filter(|(distance, _)| *distance > NEAR_WALL).map(|(_, height)| *height))?;
        let over_outlet = points.iter().filter(|(distance, _)| *distance < OVER_OUTLET).map(|(_, height)| *height);
        Some(at_walls - mean(over_outlet)?)
    })
}

/// The mean over the frames to measure of a figure of the points (|x|, y_s).
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

/// Slope of the least-squares line.
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

    /// Share of the block at height y that lies below `surface`.
    fn filled(surface: f64, y: f64) -> f64 {
        ((surface - y) / BLOCK_HEIGHT + 0.5).clamp(0.0, 1.0)
    }

    /// The start has density 10 everywhere, so that the threshold is 5; the later frames have a V-shaped surface.
    fn vee(slope: f64, density: impl Fn(f64, f64) -> f64) -> History {
        Silo::FINE.history(|_, _| 10.0, |_, x, y| density(80.0 + slope * (x.abs() - 30.0), y))
    }

    /// How much the least-squares slope may err for heights that err by 1: sum|d|/sum d^2, d = |x| less its mean. The
    /// inclination, in radians, errs by no more, as atan is nowhere steeper than at 0.
    fn lever(blocks: &Blocks) -> f64 {
        let middle = mean(blocks.x.iter().map(|x| x.abs())).unwrap();
        let deviations = || blocks.x.iter().map(|x| (x.abs() - middle).abs());
        deviations().sum::<f64>() / deviations().map(|d| d * d).sum::<f64>()
    }

    #[test]
    fn a_diffuse_surface_is_interpolated_exactly() {
        // The density falls from 10 to 0 over 24 spacings around the surface, linearly across the blocks on both sides
        // of it. It is rounded to a millionth, within 5e-7, which the gradient 10/24 makes 1.2e-6 of height at each end
        // of the interpolation, so no more between them. 1e-7 is for the heights' own rounding, and to spare.
        let error = 1.3e-6;
        for slope in [-0.5, -0.1, 0.0, 0.3, 0.7] {
            let history = vee(slope, |surface, y| (5.0 + (surface - y) * 10.0 / 24.0).clamp(0.0, 10.0));
            close(inclination(&history), slope.atan().to_degrees(), (error * lever(&history.blocks)).to_degrees());
            // The middles of the columns beyond 45 are at 10.5 to 13.5 block widths, those within 15 at 0.5 to 2.5.
            close(dip(&history), slope * 10.5 * BLOCK_WIDTH, 2.0 * error);
        }
    }

    #[test]
    fn a_sharp_surface_is_found_within_a_tenth_of_a_block() {
        // The block that the surface cuts is filled to f. If f > 1/2 the surface is put at 4 (f - 1/2)/f above its
        // middle and is at 4 f - 2: it errs by 6 - 2/f - 4 f, at most 6 - 4 sqrt(2) for f = 1/sqrt(2). If f <= 1/2 it
        // is put at 2/(1 - f) - 4 and errs by as much to the other side, with 1 - f for f. Densities rounded to a
        // millionth add less than 1e-5.
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
        // Onset density 10. On the outside it changes from 5.5 to 4.5 at 80, inside from 10 to 0.
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
    fn frames_of_a_fifth_discharged_are_measured() {
        // Out at step t: t/10 % of all. From 15 to 25 % the slope is 0.5, afterwards 0.2, before 0.
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
        // A tenth was out before.
        history.start.out = total / 10;
        history.frames.iter_mut().for_each(|frame| frame.out = total / 10 + total / 1000 * frame.step);
        close(inclination(&history), 0.5f64.atan().to_degrees(), 1e-5);
        // Frames that step over the range: the last five, from 260 on.
        history.frames.retain(|frame| !(150..=250).contains(&frame.step));
        close(inclination(&history), 0.2f64.atan().to_degrees(), 1e-5);
        history.frames.truncate(4);
        assert!(inclination(&history).is_none() && dip(&history).is_none());
    }

    #[test]
    fn one_distance_gives_no_slope() {
        let narrow = Silo { columns: 2, rows: 10, sites: 20 }.history(|_, _| 10.0, |_, _, _| 10.0);
        assert!(inclination(&narrow).is_none() && dip(&narrow).is_none());
        // Nor do two that differ by a site column, whose surfaces are at 10 and at 40.
        let mut uneven = Silo { columns: 2, rows: 10, sites: 20 }
            .history(|_, _| 10.0, |_, x, y| if x < 0.0 || y < 10.0 { 10.0 } else { 0.0 });
        uneven.blocks.x = vec![-2.6, 1.7];
        assert!(inclination(&uneven).is_none());
    }
}
