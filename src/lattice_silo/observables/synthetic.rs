//! Synthetic discharges with known observables, for tests.

use super::{BLOCK_HEIGHT, BLOCK_WIDTH, Blocks, Frame, History};

/// A rectangular silo with the outlet in the middle of its floor.
#[derive(Clone, Copy)]
pub struct Silo {
    pub columns: u32,
    pub rows: u32,
    /// Number of fluid sites in a block. Densities are rounded to a multiple of 1/sites.
    pub sites: u32,
}

impl Silo {
    /// A silo 121 spacings wide and 160 high, of whole blocks.
    pub const STANDARD: Self = Self { columns: 28, rows: 40, sites: 20 };

    /// Like [`Self::STANDARD`], but with densities rounded to a millionth.
    pub const FINE: Self = Self { sites: 1_000_000, ..Self::STANDARD };

    pub fn blocks(self) -> Blocks {
        let middle = 0.5 * f64::from(self.columns) - 0.5;
        Blocks {
            columns: self.columns as usize,
            rows: self.rows as usize,
            sites: vec![self.sites; (self.columns * self.rows) as usize],
            x: (0..self.columns).map(|i| (f64::from(i) - middle) * BLOCK_WIDTH).collect(),
            y: (0..self.rows).map(|j| (f64::from(j) + 0.5) * BLOCK_HEIGHT).collect(),
        }
    }

    /// Returns a history with frames every 10 steps to 300, in which no particle leaves. `start` gives the density at
    /// (x, y) before opening, `later` the density at (step, x, y) afterwards.
    pub fn history(self, start: impl Fn(f64, f64) -> f64, later: impl Fn(u64, f64, f64) -> f64) -> History {
        let blocks = self.blocks();
        let start = frame(&blocks, 0, start);
        let frames = (1..=30).map(|n| frame(&blocks, 10 * n, |x, y| later(10 * n, x, y))).collect();
        History { blocks, start, frames }
    }
}

/// Returns a frame with the given density at (x, y), rounded to whole particles.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "at most a few million; rounding is intended"
)]
pub fn frame(blocks: &Blocks, step: u64, density: impl Fn(f64, f64) -> f64) -> Frame {
    let places = blocks.x.iter().flat_map(|&x| blocks.y.iter().map(move |&y| (x, y)));
    let count = |((x, y), &sites): ((f64, f64), &u32)| (density(x, y) * f64::from(sites)).round() as u32;
    Frame { step, out: 0, counts: places.zip(&blocks.sites).map(count).collect() }
}

/// Turns the silo into a mass-flow silo: hopper walls at 60 degrees to the horizontal start at the ends of an outlet of
/// 20. Blocks with their centre outside the hopper get no sites.
pub fn add_hopper(history: &mut History) {
    let Blocks { rows, sites, x, y, .. } = &mut history.blocks;
    for (i, x) in x.iter().enumerate() {
        for (j, y) in y.iter().enumerate() {
            if *y < (x.abs() - 10.0) * 3f64.sqrt() {
                sites[i * *rows + j] = 0;
            }
        }
    }
}

/// Panics unless `value` is within `tolerance` of `expected`.
#[track_caller]
pub fn close(value: Option<f64>, expected: f64, tolerance: f64) {
    assert!(value.is_some_and(|value| (value - expected).abs() <= tolerance), "{value:?}, expected {expected}");
}
