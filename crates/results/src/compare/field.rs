//! Fields of vertical velocity, each in units of its own mean downward speed, and the disagreement of two fields.
//!
//! All sums run over the cells that both fields have. The weight w of a cell is the reference's number of grains per
//! sample, and d = -v_y is the downward speed.
//!
//! * Mean downward speed of each field: D = sum w d/sum w. The pattern of a field is u = d/D.
//! * Disagreement: sqrt(sum w (u - u_ref)^2/sum w), in units of the mean speed. It is 0 for equal patterns.
//! * Correlation: Pearson's, with the same weights. It ignores the contrast of the patterns as well.
//!
//! A field has a cell if it counted at least a given number of grains in it over all samples. The mean over n grains
//! has an uncertainty of their spread over sqrt(n). Limit: cells that only one field has are counted but not compared.

use std::collections::BTreeMap;

use thiserror::Error;

use siloflow_files::flow_means::FlowMeans;

/// One cell of a field.
#[derive(Clone, Copy, Debug)]
pub struct Cell {
    /// Number of grains counted in the cell, over all samples.
    pub looks: f64,
    /// Mean number of grains per sample.
    pub count: f64,
    /// Mean downward speed, m/s or m/step.
    pub down: f64,
}

/// A field of vertical velocity on square cells.
#[derive(Clone, Debug)]
pub struct Field {
    /// Side of the cells, m.
    pub side: f64,
    /// Cells by [row, column]. The middle of cell [j, i] is at x = (i + 1/2) sides and y = (j + 1/2) sides.
    pub cells: BTreeMap<[i64; 2], Cell>,
}

/// Reason why two fields cannot be compared.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum Trouble {
    /// The cells have different sides.
    #[error("their cells have sides of {0} and {1} m")]
    OtherCells(f64, f64),
    /// No cell has enough grains in both fields.
    #[error("their fields have no cell in common")]
    NothingInCommon,
    /// A mean downward speed is not positive, so it cannot be a unit.
    #[error("a field does not flow down on average")]
    NotDown,
}

/// Comparison of a field with the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Rms difference of the patterns, in mean downward speeds.
    pub rms: f64,
    /// Pearson's correlation of the patterns; `None` if a pattern is uniform.
    pub correlation: Option<f64>,
    /// Number of cells that both fields have.
    pub common: usize,
    /// Number of cells that only the reference has.
    pub only_reference: usize,
    /// Number of cells that only the compared field has.
    pub only_run: usize,
    /// Mean downward speed of the reference over the common cells, m/s or m/step.
    pub mean_reference: f64,
    /// Mean downward speed of the compared field over the common cells, m/s or m/step.
    pub mean_run: f64,
}

/// Returns the side of the cells (m): the smallest distance of neighbouring middles, rounded to the nine decimals of
/// files.
fn side(means: &[FlowMeans]) -> Option<f64> {
    let smallest = |mut places: Vec<f64>| {
        places.sort_by(f64::total_cmp);
        places.windows(2).map(|pair| pair[1] - pair[0]).filter(|&gap| gap > 0.0).fold(f64::INFINITY, f64::min)
    };
    let [x, y] = [|m: &FlowMeans| m.x, |m: &FlowMeans| m.y].map(|axis| smallest(means.iter().map(axis).collect()));
    Some((x.min(y) * 1e9).round() / 1e9).filter(|side| side.is_finite())
}

impl Field {
    /// Returns the field with these means; `None` if they do not lie on a grid or are too few to determine its side.
    #[must_use]
    #[expect(clippy::cast_precision_loss, clippy::cast_possible_truncation, reason = "small whole numbers")]
    pub fn new(means: &[FlowMeans]) -> Option<Self> {
        let side = side(means)?;
        let number = |middle: f64| {
            let number = middle / side - 0.5;
            // Files have nine decimals, so middles are rounded.
            ((number - number.round()).abs() < 1e-3).then_some(number.round() as i64)
        };
        let cells = means.iter().map(|mean| {
            let cell = Cell { looks: mean.count * mean.samples as f64, count: mean.count, down: -mean.vy };
            Some(([number(mean.y)?, number(mean.x)?], cell))
        });
        Some(Self { side, cells: cells.collect::<Option<_>>()? })
    }

    /// Iterates over the cells in which at least `looks` grains were counted.
    pub fn seen(&self, looks: f64) -> impl Iterator<Item = ([i64; 2], Cell)> {
        self.cells.iter().filter(move |(_, cell)| cell.looks >= looks).map(|(&key, &cell)| (key, cell))
    }

    /// Compares this field with `reference`, over cells in which both counted at least `looks` grains.
    ///
    /// # Errors
    /// If the sides of the cells differ, if there is no common cell, or if a field does not flow down on average.
    pub fn against(&self, reference: &Self, looks: f64) -> Result<Figures, Trouble> {
        if (self.side - reference.side).abs() > 1e-6 * reference.side {
            return Err(Trouble::OtherCells(reference.side, self.side));
        }
        let has_enough = |cell: &Cell| cell.looks >= looks;
        let partner = |key| self.cells.get(&key).copied().filter(has_enough);
        // (weight, downward speed of the reference, downward speed of this field)
        let common: Vec<_> =
            reference.seen(looks).filter_map(|(key, cell)| Some((cell.count, cell.down, partner(key)?.down))).collect();
        if common.is_empty() {
            return Err(Trouble::NothingInCommon);
        }
        let weights: f64 = common.iter().map(|cell| cell.0).sum();
        let mean =
            |value: &dyn Fn(f64, f64) -> f64| common.iter().map(|&(w, a, b)| w * value(a, b)).sum::<f64>() / weights;
        let mean_reference = mean(&|a, _| a);
        let mean_run = mean(&|_, b| b);
        if !(mean_reference > 0.0 && mean_run > 0.0) {
            return Err(Trouble::NotDown);
        }
        let u_ref = |a: f64| a / mean_reference - 1.0;
        let u = |b: f64| b / mean_run - 1.0;
        let spreads = mean(&|a, _| u_ref(a).powi(2)).sqrt() * mean(&|_, b| u(b).powi(2)).sqrt();
        Ok(Figures {
            rms: mean(&|a, b| (u(b) - u_ref(a)).powi(2)).sqrt(),
            // A smaller spread is round-off.
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

    /// Returns a field of cells of 1 m in a row, each with (grains per sample, downward speed), after ten samples.
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
    fn rms_of_a_known_perturbation_is_exact() {
        // The weights are 1 and 3: +0.375 in a quarter of the weight and -0.125 in the rest do not change the mean.
        let reference = field(&[(1.0, 1.0), (3.0, 1.0), (1.0, 1.0), (3.0, 1.0)]);
        let other = field(&[(5.0, 1.375), (5.0, 0.875), (5.0, 1.375), (5.0, 0.875)]);
        let figures = other.against(&reference, 1.0).unwrap();
        let rms = (0.25 * 0.375f64.powi(2) + 0.75 * 0.125f64.powi(2)).sqrt();
        assert!((figures.rms - rms).abs() < 1e-15, "{figures:?}");
        assert_eq!((figures.mean_reference, figures.mean_run, figures.correlation), (1.0, 1.0, None));
    }

    #[test]
    fn opposite_contrast_has_correlation_minus_one() {
        let reference = field(&[(1.0, 0.5), (1.0, 1.0), (1.0, 1.5)]);
        let opposite = field(&[(1.0, 3.0), (1.0, 2.0), (1.0, 1.0)]);
        let figures = opposite.against(&reference, 1.0).unwrap();
        assert!((figures.correlation.unwrap() + 1.0).abs() < 1e-15, "{figures:?}");
        assert!((figures.rms - (2.0f64 / 3.0).sqrt()).abs() < 1e-15, "{figures:?}");
    }

    #[test]
    fn cells_with_too_few_grains_are_ignored() {
        let reference = field(&[(1.0, 1.0), (1.0, 2.0), (0.1, 90.0), (1.0, 3.0)]);
        let other = field(&[(1.0, 1.0), (1.0, 2.0), (1.0, 1.0)]);
        let figures = other.against(&reference, 5.0).unwrap();
        assert_eq!((figures.common, figures.only_reference, figures.only_run), (2, 1, 1));
        assert_eq!((figures.rms, figures.mean_run), (0.0, 1.5));
        assert_eq!(other.against(&reference, 11.0), Err(Trouble::NothingInCommon));
    }

    #[test]
    fn incomparable_fields_are_refused_with_the_reason() {
        let reference = field(&[(1.0, 1.0), (1.0, 1.0)]);
        assert_eq!(field(&[(1.0, -1.0), (1.0, 0.5)]).against(&reference, 1.0), Err(Trouble::NotDown));
        let coarse = Field { side: 2.0, cells: reference.cells.clone() };
        assert_eq!(coarse.against(&reference, 1.0), Err(Trouble::OtherCells(1.0, 2.0)));
        let mean = FlowMeans { x: 0.5, y: 0.5, samples: 1, count: 1.0, vx: 0.0, vy: 0.0 };
        assert!(Field::new(&[mean]).is_none() && Field::new(&[]).is_none());
        assert!(Field::new(&[mean, FlowMeans { x: 1.8, ..mean }]).is_none(), "not in cells");
    }
}
