//! The rate of one slot with two heights of the bed.

use super::bed::{Silo, rate};
use crate::studies::validation::runs::{FinishedRun, Studies};
use crate::studies::validation::verdict::{FigureRow, Rule};
use siloflow_figures::diagram::{Axis, Curve, Panel, colour};
use siloflow_figures::statistics::mean::Mean;
use siloflow_text::fault::Fault;

/// Runs of one slot, by height; those that clogged do not count.
pub(super) struct Heights<'a> {
    /// Width of the slot, d.
    width: f64,
    /// Layers of grains and runs of the lower and the higher bed.
    beds: [(f64, Vec<&'a FinishedRun>); 2],
}

/// Returns the runs of the slot with two heights; `None` without runs of both.
pub(super) fn heights(studies: &Studies) -> Option<Heights<'_>> {
    let low: Vec<_> = studies.first_of(&["full-height.ron", "short-height.ron"]).iter().collect();
    let width = Silo::Slot.width(low.first()?)?;
    let is_wide = |run: &&FinishedRun| Silo::Slot.width(run).is_some_and(|found| found.to_bits() == width.to_bits());
    let high: Vec<_> = studies.first_of(&Silo::Slot.sweeps()).iter().filter(is_wide).collect();
    Some(Heights { width, beds: [bed(low)?, bed(high)?] })
}

/// Returns the layers of a bed and its runs that flow; `None` without a run that flows.
fn bed(runs: Vec<&FinishedRun>) -> Option<(f64, Vec<&FinishedRun>)> {
    let flowing: Vec<_> = runs.into_iter().filter(|run| run.status() != "clogged").collect();
    let layers = flowing.first()?.number("parameters.layers")?;
    Some((layers, flowing))
}

impl Heights<'_> {
    /// Returns the row of the ratio of the rates.
    pub(super) fn row(&self) -> Result<FigureRow, Fault> {
        let mean = |runs: &[&FinishedRun]| {
            let rates = runs.iter().map(|run| rate(run)).collect::<Result<Vec<_>, _>>()?;
            Ok(Mean::of(&rates).unwrap_or(Mean { value: f64::NAN, error: f64::NAN }))
        };
        let [(lower, low), (higher, high)] = &self.beds;
        let [low, high] = [mean(low)?, mean(high)?];
        let ratio = low.value / high.value;
        let error = ratio * (low.error / low.value).hypot(high.error / high.value);
        let quantity = format!("slot of {} d: rate with a bed of {lower} d over the rate with {higher} d", self.width);
        let row = FigureRow::new(quantity, "", ratio).error(Some(error)).published(1.0, Rule::WithinAbsolute(0.05));
        Ok(row.remark("the rate does not depend on the height of the bed"))
    }

    /// Returns the panel of the discharge from both heights, by the first seed of each.
    pub(super) fn panel(&self) -> Result<Panel, Fault> {
        let mut curves = Vec::new();
        for (number, (layers, runs)) in (1..).zip(&self.beds) {
            let Some(run) = runs.first() else { continue };
            let name = format!("filled {layers} d high");
            curves.push(Curve {
                name,
                colour: colour(number),
                points: run.discharge()?,
                has_line: true,
                ..Curve::default()
            });
        }
        let [x, y] = [0, 1].map(|axis| {
            let values = curves.iter().flat_map(|curve| curve.points.iter().map(move |point| [point.0, point.1][axis]));
            Axis::around(["time after the opening, s", "grains out"][axis], values.chain([0.0]))
        });
        Ok(Panel { curves, ..Panel::new(format!("Slot of {} d, two heights of the bed", self.width), x, y) })
    }
}
