//! Fields of vertical velocity, each in units of its own mean downward speed, and how far two of them disagree.
//!
//! Over the cells that both fields have, with the reference's count of grains a sample as weight w, and d = -v_y:
//!
//! * mean D = sum w d/sum w, of each field; u = d/D is its pattern;
//! * disagreement: sqrt(sum w (u - u_ref)^2/sum w), 0 for the same pattern, in units of the mean speed;
//! * correlation (Pearson's, with the same weights): what is left if the contrast of the patterns does not count either.
//!
//! A field has a cell if it saw at least a given number of grains in it, over all its samples: the mean of n of them is
//! known to their spread over sqrt(n). Limit: how different the cells are that only one of the fields has is not told, but
//! how many there are.

use std::collections::BTreeMap;

use thiserror::Error;

use crate::measure::flow::FlowMeans;

/// One cell.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Grains that were seen in it.
    pub looks: f64,
    /// Grains a sample.
    pub count: f64,
    /// Mean downward speed, m/s or m/step.
    pub down: f64,
}

/// A field in cells.
#[derive(Clone, Debug)]
pub struct Field {
    /// Side of the cells, m.
    pub side: f64,
    /// By row, then column: the middle of cell [j, i] is at ((i + 1/2), (j + 1/2)) sides.
    pub cells: BTreeMap<[i64; 2], Cell>,
}

/// Why two fields cannot be compared.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum Trouble {
    /// Other cells.
    #[error("their cells have sides of {0} and {1} m")]
    OtherCells(f64, f64),
    /// No cell that both saw enough grains in.
    #[error("their fields have no cell in common")]
    NothingInCommon,
    /// A mean that is no unit.
    #[error("a field does not flow down on the average")]
    NotDown,
}

/// How two fields compare.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Rms difference of the patterns.
    pub rms: f64,
    /// Pearson's; `None` if a pattern is the same everywhere.
    pub correlation: Option<f64>,
    /// Cells that both have.
    pub common: usize,
    /// Cells that only the reference has.
    pub only_reference: usize,
    /// Cells that only the other one has.
    pub only_run: usize,
    /// Mean downward speed over the common cells, m/s or m/step: the reference's.
    pub mean_reference: f64,
    /// The other one's.
    pub mean_run: f64,
}

/// The side of the cells: the smallest distance of neighbouring middles, to the nine decimals of files.
fn side(means: &[FlowMeans]) -> Option<f64> {
    let smallest = |mut places: Vec<f64>| {
        places.sort_by(f64::total_cmp);
        places.windows(2).map(|pair| pair[1] - pair[0]).filter(|&gap| gap > 0.0).fold(f64::INFINITY, f64::min)
    };
    let [x, y] = [|m: &FlowMeans| m.x, |m: &FlowMeans| m.y].map(|of| smallest(means.iter().map(of).collect()));
    Some((x.min(y) * 1e9).round() / 1e9).filter(|side| side.is_finite())
}

impl Field {
    /// The field with these means; `None` if they are too few to tell the side of their cells, or not in cells at all.
    #[must_use]
    #[expect(clippy::cast_precision_loss, clippy::cast_possible_truncation, reason = "small whole numbers")]
    pub fn new(means: &[FlowMeans]) -> Option<Self> {
        let side = side(means)?;
        let number = |middle: f64| {
            let number = middle / side - 0.5;
            // Files hold nine decimals.
            ((number - number.round()).abs() < 1e-3).then_some(number.round() as i64)
        };
        let cells = means.iter().map(|mean| {
            let cell = Cell { looks: mean.count * mean.samples as f64, count: mean.count, down: -mean.vy };
            Some(([number(mean.y)?, number(mean.x)?], cell))
        });
        Some(Self { side, cells: cells.collect::<Option<_>>()? })
    }

    /// The cells in which at least `looks` grains were seen.
    pub fn seen(&self, looks: f64) -> impl Iterator<Item = ([i64; 2], Cell)> {
        self.cells.iter().filter(move |(_, cell)| cell.looks >= looks).map(|(&key, &cell)| (key, cell))
    }

    /// This field against `reference`, over cells in which both saw at least `looks` grains.
    ///
    /// # Errors
    /// If they have no such cell, or one of them does not flow down.
    pub fn against(&self, reference: &Self, looks: f64) -> Result<Figures, Trouble> {
        if (self.side - reference.side).abs() > 1e-6 * reference.side {
            return Err(Trouble::OtherCells(reference.side, self.side));
        }
        let sees = |cell: &Cell| cell.looks >= looks;
        let partner = |key| self.cells.get(&key).copied().filter(sees);
        // (weight, reference, other)
        let common: Vec<_> =
            reference.seen(looks).filter_map(|(key, cell)| Some((cell.count, cell.down, partner(key)?.down))).collect();
        if common.is_empty() {
            return Err(Trouble::NothingInCommon);
        }
        let weights: f64 = common.iter().map(|cell| cell.0).sum();
        let mean = |of: &dyn Fn(f64, f64) -> f64| common.iter().map(|&(w, a, b)| w * of(a, b)).sum::<f64>() / weights;
        let (mean_reference, mean_run) = (mean(&|a, _| a), mean(&|_, b| b));
        if !(mean_reference > 0.0 && mean_run > 0.0) {
            return Err(Trouble::NotDown);
        }
        let (u_ref, u) = (|a: f64| a / mean_reference - 1.0, |b: f64| b / mean_run - 1.0);
        let spreads = mean(&|a, _| u_ref(a).powi(2)).sqrt() * mean(&|_, b| u(b).powi(2)).sqrt();
        Ok(Figures {
            rms: mean(&|a, b| (u(b) - u_ref(a)).powi(2)).sqrt(),
            // Below that only rounding is spread.
            correlation: (spreads > 1e-24).then(|| mean(&|a, b| u_ref(a) * u(b)) / spreads),
            common: common.len(),
            only_reference: reference.seen(looks).count() - common.len(),
            only_run: self.seen(looks).count() - common.len(),
            mean_reference,
            mean_run,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cells in a row, one a metre, each with (grains a sample, downward speed); ten samples.
    fn field(cells: &[(f64, f64)]) -> Field {
        let means = (0u8..).zip(cells).map(|(i, &(count, down))| FlowMeans {
            x: f64::from(i) + 0.5,
            y: 0.5,
            samples: 10,
            count,
            vx: 0.0,
            vy: -down,
        });
        Field::new(&means.collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn a_known_perturbation_has_its_rms_exactly() {
        // Weights 1 and 3: +0.375 in a quarter of them, -0.125 in the rest leave the mean as it was.
        let reference = field(&[(1.0, 1.0), (3.0, 1.0), (1.0, 1.0), (3.0, 1.0)]);
        let other = field(&[(5.0, 1.375), (5.0, 0.875), (5.0, 1.375), (5.0, 0.875)]);
        let figures = other.against(&reference, 1.0).unwrap();
        let rms = (0.25 * 0.375f64.powi(2) + 0.75 * 0.125f64.powi(2)).sqrt();
        assert!((figures.rms - rms).abs() < 1e-15, "{figures:?}");
        assert_eq!((figures.mean_reference, figures.mean_run, figures.correlation), (1.0, 1.0, None));
    }

    #[test]
    fn the_opposite_contrast_has_the_opposite_correlation() {
        let reference = field(&[(1.0, 0.5), (1.0, 1.0), (1.0, 1.5)]);
        let opposite = field(&[(1.0, 3.0), (1.0, 2.0), (1.0, 1.0)]);
        let figures = opposite.against(&reference, 1.0).unwrap();
        assert!((figures.correlation.unwrap() + 1.0).abs() < 1e-15, "{figures:?}");
        assert!((figures.rms - (2.0f64 / 3.0).sqrt()).abs() < 1e-15, "{figures:?}");
    }

    #[test]
    fn cells_that_saw_too_few_count_for_neither() {
        let reference = field(&[(1.0, 1.0), (1.0, 2.0), (0.1, 90.0), (1.0, 3.0)]);
        let other = field(&[(1.0, 1.0), (1.0, 2.0), (1.0, 1.0)]);
        let figures = other.against(&reference, 5.0).unwrap();
        assert_eq!((figures.common, figures.only_reference, figures.only_run), (2, 1, 1));
        assert_eq!((figures.rms, figures.mean_run), (0.0, 1.5));
        assert_eq!(other.against(&reference, 11.0), Err(Trouble::NothingInCommon));
    }

    #[test]
    fn fields_that_are_no_match_say_why() {
        let reference = field(&[(1.0, 1.0), (1.0, 1.0)]);
        assert_eq!(field(&[(1.0, -1.0), (1.0, 0.5)]).against(&reference, 1.0), Err(Trouble::NotDown));
        let coarse = Field { side: 2.0, cells: reference.cells.clone() };
        assert_eq!(coarse.against(&reference, 1.0), Err(Trouble::OtherCells(1.0, 2.0)));
        let mean = FlowMeans { x: 0.5, y: 0.5, samples: 1, count: 1.0, vx: 0.0, vy: 0.0 };
        assert!(Field::new(&[mean]).is_none() && Field::new(&[]).is_none());
        assert!(Field::new(&[mean, FlowMeans { x: 1.8, ..mean }]).is_none(), "not in cells");
    }
}
