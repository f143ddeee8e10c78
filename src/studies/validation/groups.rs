//! Groups of runs by a number of theirs, and means over runs.

use crate::studies::validation::runs::FinishedRun;
use crate::studies::validation::verdict::FigureRow;
use siloflow_figures::statistics::mean::{Mean, mean};
use siloflow_text::fault::Fault;

/// Returns runs by a number of theirs, in ascending order; runs without the number are left out.
#[must_use]
pub fn groups_by<'a>(
    runs: impl IntoIterator<Item = &'a FinishedRun>,
    number: impl Fn(&FinishedRun) -> Option<f64>,
) -> Vec<(f64, Vec<&'a FinishedRun>)> {
    let mut groups: Vec<(f64, Vec<&FinishedRun>)> = Vec::new();
    for (run, number) in runs.into_iter().filter_map(|run| Some((run, number(run)?))) {
        match groups.iter_mut().find(|(of_group, _)| of_group.to_bits() == number.to_bits()) {
            Some((_, group)) => group.push(run),
            None => groups.push((number, vec![run])),
        }
    }
    groups.sort_by(|a, b| a.0.total_cmp(&b.0));
    groups
}

/// Returns the mean of a number over runs, with its standard error; runs without the number do not count.
#[must_use]
pub fn mean_of<'a>(
    runs: impl IntoIterator<Item = &'a FinishedRun>,
    number: impl Fn(&FinishedRun) -> Option<f64>,
) -> Option<Mean> {
    mean(runs.into_iter().filter_map(number))
}

/// Returns the mean discharge rate of runs from a time after the opening on (s), grains/s, with its row. A run that clogs has no rate.
///
/// # Errors
/// If the curve of a run cannot be read.
pub fn mean_rate(quantity: String, runs: &[&FinishedRun], from: f64) -> Result<(Option<Mean>, FigureRow), Fault> {
    let flowing: Vec<_> = runs.iter().filter(|run| run.status() != "clogged").collect();
    let rates = flowing.iter().map(|run| run.rate(from, f64::INFINITY)).collect::<Result<Vec<_>, _>>()?;
    let rate = Mean::of(&rates);
    let remark = format!("runs: {}, of which {} clogged", runs.len(), runs.len() - flowing.len());
    Ok((rate, FigureRow::of_mean(quantity, "grains/s", rate).remark(remark)))
}
