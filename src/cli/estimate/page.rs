//! The page of an estimate, `report.html` in its directory.

use std::slice;

use crate::studies::estimate::results::Estimate;
use crate::studies::estimate::words::Line;
use siloflow_figures::diagram::{Panel, sheet};
use siloflow_files::table::Table;
use siloflow_results::report::estimate::EstimatePage;
use siloflow_results::report::sheet::{Cell, Sheet};
use siloflow_text::fault::Fault;

/// Returns the page of the answer, with the panels of its figure and its tables, which are `runs.csv` and `rungs.csv`.
pub(super) fn page(estimate: &Estimate, panels: &[Panel], tables: &[(&str, String); 2]) -> Result<String, Fault> {
    // Each panel is a drawing of its own, so that they stand below each other where the page is narrow.
    let drawings: String = panels.iter().map(|panel| sheet(slice::from_ref(panel), 1)).collect();
    let [every_run, by_stiffness] = tables.each_ref().map(|(name, text)| Table::parse(*name, text));
    let mut answer = Sheet::of_words();
    for Line { name, words } in estimate.lines() {
        answer.add(name, vec![Cell::text(Some(&words))]);
    }
    let page = EstimatePage {
        title: &estimate.title(),
        answer: &answer,
        refused: estimate.refused.as_deref(),
        drawings: &drawings,
        rungs: Some(&by_stiffness?),
        runs: Some(&every_run?),
    };
    Ok(page.html())
}
