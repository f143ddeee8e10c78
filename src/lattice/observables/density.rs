//! How dense the silo is just before the outlet opens.
//!
//! phi0 is the density of a block at that time, particles per site.

use super::{History, finite, mean};

/// Heights between which the bottom density is taken, spacings above the outlet: above the layer that the floor orders,
/// below where the standard silo's density has visibly fallen.
const BOTTOM: (f64, f64) = (4.0, 32.0);

/// Onset density rho0 = sum phi0^2/sum phi0 over all blocks, particles per site: the density that a particle of the bed
/// finds around it, to which the empty upper part of the silo adds nothing. `None` for an empty silo.
#[must_use]
pub fn onset_density(history: &History) -> Option<f64> {
    let onset = history.onset();
    let sum: f64 = history.blocks.counted().map(|block| onset[block.index]).sum();
    let squares: f64 = history.blocks.counted().map(|block| onset[block.index].powi(2)).sum();
    finite(squares / sum)
}

/// Bottom density rhob: the mean of phi0 over the blocks with 4 < y < 32, particles per site.
#[must_use]
pub fn bottom_density(history: &History) -> Option<f64> {
    let onset = history.onset();
    let (low, high) = BOTTOM;
    mean(history.blocks.counted().filter(|block| low < block.y && block.y < high).map(|block| onset[block.index]))
}

#[cfg(test)]
mod tests {
    use super::super::synthetic::{Silo, close};
    use super::*;

    #[test]
    fn onset_density_is_what_a_particle_finds() {
        // Halves of 12 and 4: (144 + 16)/(12 + 4); exact, as all sums are whole numbers.
        let halves = Silo::STANDARD.history(|_, y| if y < 80.0 { 12.0 } else { 4.0 }, |_, _, _| 0.0);
        close(onset_density(&halves), 10.0, 0.0);
        // What is empty does not count.
        let half = Silo::STANDARD.history(|_, y| if y < 80.0 { 12.0 } else { 0.0 }, |_, _, _| 0.0);
        close(onset_density(&half), 12.0, 0.0);
        assert!(onset_density(&Silo::STANDARD.history(|_, _| 0.0, |_, _, _| 1.0)).is_none());
    }

    #[test]
    fn dropped_blocks_add_nothing() {
        let mut history = Silo::STANDARD.history(|x, y| if x > 0.0 && y < 20.0 { 13.0 } else { 5.0 }, |_, _, _| 0.0);
        let dropped: Vec<_> = history.blocks.counted().filter(|block| block.x > 0.0 && block.y < 20.0).collect();
        for block in &dropped {
            history.blocks.sites[block.index] = 7;
        }
        close(onset_density(&history), 5.0, 0.0);
        close(bottom_density(&history), 5.0, 0.0);
    }

    #[test]
    fn bottom_density_leaves_out_the_floor_and_what_is_high() {
        // Blocks with their middle at 2, and from 34 on, are denser.
        let history = Silo::STANDARD.history(|_, y| if y > 4.0 && y < 32.0 { 5.0 } else { 9.0 }, |_, _, _| 0.0);
        close(bottom_density(&history), 5.0, 0.0);
        // 6, 10, ..., 30: the mean of a linear density is that at 18.
        let linear = Silo::STANDARD.history(|_, y| 0.25 * y, |_, _, _| 0.0);
        close(bottom_density(&linear), 4.5, 1e-14);
    }
}
