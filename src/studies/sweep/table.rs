//! The tables of a sweep: `results.csv` with a row for each run, `table.csv` with a row for each point and figure.
//!
//! A row of `table.csv` has the mean over the runs that have the figure, its standard error (the sample standard deviation over the square
//! root of n, if n > 1) and n. It also counts the runs that ended clogged, that failed, and that are missing.

use serde_json::Value;

use crate::statistics::mean::Mean;
use crate::studies::sweep::{Sweep, Task, figures};

/// A run as the tables need it.
#[derive(Clone, Debug)]
pub struct RunRow {
    /// The run.
    pub task: Task,
    /// Status; `missing` without an end.
    pub status: String,
    /// Reason of a failure.
    pub failure: String,
    /// The figures as text, in the order of the sweep file.
    pub figures: Vec<Option<String>>,
}

impl RunRow {
    /// Returns the row of a run; without a summary the run is missing.
    #[must_use]
    pub fn of(sweep: &Sweep, task: Task, summary: Option<&Value>) -> Self {
        let text = |key: &str| summary.and_then(|summary| summary[key].as_str()).unwrap_or_default().to_owned();
        let status = if summary.is_some() { text("status") } else { "missing".to_owned() };
        let lost =
            || format!("{} grains were lost", summary.map_or(0, |it| it["grains"]["lost"].as_u64().unwrap_or(0)));
        let failure = if status == "grains_lost" { lost() } else { text("failure") };
        let figure = |path: &String| summary.and_then(|summary| figures::figure(summary, path));
        Self { task, status, failure, figures: sweep.plan.figures.iter().map(figure).collect() }
    }

    /// Whether the run failed.
    #[must_use]
    pub fn is_failure(&self) -> bool {
        figures::is_failure(&self.status)
    }

    /// Whether the run has no end.
    #[must_use]
    pub fn is_missing(&self) -> bool {
        self.status == "missing"
    }
}

/// The mean of a figure at a point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointMean {
    /// Index of the point.
    pub point: usize,
    /// Index of the figure.
    pub figure: usize,
    /// The mean; `None` if no run has the figure.
    pub mean: Option<f64>,
    /// The standard error; `None` with fewer than two runs.
    pub error: Option<f64>,
    /// Number of runs that have the figure.
    pub count: usize,
}

/// Returns the means of all figures at all points.
#[must_use]
pub fn cells(sweep: &Sweep, rows: &[RunRow]) -> Vec<PointMean> {
    let mut all = Vec::new();
    for point in 0..sweep.points.len() {
        for figure in 0..sweep.plan.figures.len() {
            let runs = rows.iter().filter(|row| row.task.point == point);
            let values: Vec<f64> = runs.filter_map(|row| row.figures[figure].as_ref()?.parse().ok()).collect();
            let mean = Mean::of(&values);
            let error = mean.filter(|_| values.len() > 1).map(|mean| mean.error);
            all.push(PointMean { point, figure, mean: mean.map(|mean| mean.value), error, count: values.len() });
        }
    }
    all
}

/// Returns `results.csv`.
#[must_use]
pub fn results(sweep: &Sweep, rows: &[RunRow]) -> Vec<u8> {
    let start = ["run", "point", "seed"].map(str::to_owned).into_iter().chain(sweep.keys.iter().cloned());
    let header = start.chain(["status", "failure"].map(str::to_owned)).chain(sweep.plan.figures.iter().cloned());
    let rows = rows.iter().map(|row| {
        let Task { point, seed } = row.task;
        let own = [sweep.run_name(row.task), (point + 1).to_string(), seed.to_string()];
        let values = own.into_iter().chain(sweep.points[point].values.iter().cloned());
        let end = [row.status.clone(), row.failure.clone()];
        values.chain(end).chain(row.figures.iter().cloned().map(Option::unwrap_or_default)).collect()
    });
    csv(header.collect(), rows)
}

/// Returns `table.csv`.
#[must_use]
pub fn table(sweep: &Sweep, rows: &[RunRow]) -> Vec<u8> {
    let start = ["point".to_owned()].into_iter().chain(sweep.keys.iter().cloned());
    let header = start
        .chain(["figure", "mean", "standard_error", "n", "clogged", "failed", "missing"].map(str::to_owned))
        .collect();
    let number = |x: Option<f64>| x.map_or_else(String::new, |x| x.to_string());
    let rows = cells(sweep, rows).into_iter().map(|cell| {
        let of_point = || rows.iter().filter(|row| row.task.point == cell.point);
        let clogged = of_point().filter(|row| row.status == "clogged").count();
        let failed = of_point().filter(|row| row.is_failure()).count();
        let missing = of_point().filter(|row| row.is_missing()).count();
        let own = [(cell.point + 1).to_string()].into_iter().chain(sweep.points[cell.point].values.iter().cloned());
        let mean = [sweep.plan.figures[cell.figure].clone(), number(cell.mean), number(cell.error)];
        own.chain(mean).chain([cell.count, clogged, failed, missing].map(|count| count.to_string())).collect()
    });
    csv(header, rows)
}

/// Returns a CSV file.
pub(super) fn csv(header: Vec<String>, rows: impl Iterator<Item = Vec<String>>) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in std::iter::once(header).chain(rows) {
        // Writing to memory cannot fail, and all rows have the same length.
        let _ = writer.write_record(row);
    }
    writer.into_inner().unwrap_or_default()
}
