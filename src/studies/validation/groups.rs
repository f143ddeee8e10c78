//! Groups of runs by a number of theirs, and means over runs.

use crate::studies::validation::runs::FinishedRun;
use siloflow_figures::statistics::mean::{Mean, mean};

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
