//! Density of the silo just before the outlet opens.
//!
//! phi0 is the density of a block at this time, particles per site.

use super::{History, finite, mean};

/// Heights between which the bottom density is measured, spacings above the outlet. The range is above the layer that
/// the floor orders, and below the height at which the density of the standard silo has visibly fallen.
const BOTTOM_HEIGHTS: (f64, f64) = (4.0, 32.0);

/// Returns the onset density rho0 = sum phi0^2/sum phi0 over all blocks, particles per site. It is the mean over the
/// particles of the density of their block, so the empty upper part of the silo does not contribute. `None` for an
/// empty silo.
#[must_use]
pub fn onset_density(history: &History) -> Option<f64> {
    let onset = history.onset();
    let sum: f64 = history.blocks.counted().map(|block| onset[block.index]).sum();
    let squares: f64 = history.blocks.counted().map(|block| onset[block.index].powi(2)).sum();
    finite(squares / sum)
}

/// Returns the bottom density rhob: the mean of phi0 over the blocks with 4 < y < 32, particles per site.
#[must_use]
pub fn bottom_density(history: &History) -> Option<f64> {
    let onset = history.onset();
    let (low, high) = BOTTOM_HEIGHTS;
    mean(history.blocks.counted().filter(|block| low < block.y && block.y < high).map(|block| onset[block.index]))
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::{Silo, close};
    use super::*;

    #[test]
    fn onset_density_is_the_mean_over_particles() {
        // Halves of density 12 and 4: (144 + 16)/(12 + 4). Exact, because all sums are whole numbers.
        let halves = Silo::STANDARD.history(|_, y| if y < 80.0 { 12.0 } else { 4.0 }, |_, _, _| 0.0);
        close(onset_density(&halves), 10.0, 0.0);
        // Empty blocks do not contribute.
        let half = Silo::STANDARD.history(|_, y| if y < 80.0 { 12.0 } else { 0.0 }, |_, _, _| 0.0);
        close(onset_density(&half), 12.0, 0.0);
        assert!(onset_density(&Silo::STANDARD.history(|_, _| 0.0, |_, _, _| 1.0)).is_none());
    }

    #[test]
    fn ignored_blocks_do_not_contribute() {
        let mut history = Silo::STANDARD.history(|x, y| if x > 0.0 && y < 20.0 { 13.0 } else { 5.0 }, |_, _, _| 0.0);
        let dropped: Vec<_> = history.blocks.counted().filter(|block| block.x > 0.0 && block.y < 20.0).collect();
        for block in &dropped {
            history.blocks.sites[block.index] = 7;
        }
        close(onset_density(&history), 5.0, 0.0);
        close(bottom_density(&history), 5.0, 0.0);
    }

    #[test]
    fn bottom_density_leaves_out_the_floor_and_the_upper_part() {
        // Blocks with their centre at 2, and from 34 on, are denser.
        let history = Silo::STANDARD.history(|_, y| if y > 4.0 && y < 32.0 { 5.0 } else { 9.0 }, |_, _, _| 0.0);
        close(bottom_density(&history), 5.0, 0.0);
        // The centres are at 6, 10, ..., 30. The mean of a linear density is its value at 18.
        let linear = Silo::STANDARD.history(|_, y| 0.25 * y, |_, _, _| 0.0);
        close(bottom_density(&linear), 4.5, 1e-14);
    }
}
