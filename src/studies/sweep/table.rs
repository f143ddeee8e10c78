//! The tables of a sweep: `results.csv` with a row for each run, `table.csv` with a row for each point and figure.
//!
//! A row of `table.csv` has the mean over the runs that have the figure, its standard error (the sample standard deviation over the square
//! root of n, if n > 1) and n. It also counts the runs that ended clogged, that failed, and that are missing.

use std::path::Path;

use serde_json::Value;

use crate::studies::figures::figure::Figure;
use crate::studies::figures::summary::is_failure;
use crate::studies::sweep::{Sweep, Task};
use siloflow_figures::statistics::mean::Mean;

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
    /// Returns the row of the run in a directory; without a summary the run is missing.
    #[must_use]
    pub fn of(sweep: &Sweep, task: Task, summary: Option<&Value>, directory: &Path) -> Self {
        let text = |key: &str| summary.and_then(|summary| summary[key].as_str()).unwrap_or_default().to_owned();
        let status = if summary.is_some() { text("status") } else { "missing".to_owned() };
        let lost =
            || format!("{} grains were lost", summary.map_or(0, |it| it["grains"]["lost"].as_u64().unwrap_or(0)));
        let failure = if status == "grains_lost" { lost() } else { text("failure") };
        // A sweep file whose figures cannot be read is refused before a run.
        let figure = |text: &String| Figure::parse(text, true).ok()?.in_text(summary?, directory).ok()?;
        Self { task, status, failure, figures: sweep.plan.figures.iter().map(figure).collect() }
    }

    /// Whether the run failed.
    #[must_use]
    pub fn is_failure(&self) -> bool {
        is_failure(&self.status)
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

/// A column of a table of a sweep: its name, and its cell in the row of a value.
pub(super) struct TextColumn<'a, T> {
    name: String,
    cell: Box<dyn Fn(&T) -> String + 'a>,
}

impl<'a, T> TextColumn<'a, T> {
    /// Makes a column.
    pub(super) fn new(name: impl Into<String>, cell: impl Fn(&T) -> String + 'a) -> Self {
        Self { name: name.into(), cell: Box::new(cell) }
    }
}

/// Returns the columns of the keys, with the values of the point of a row.
fn keys<'a, T: 'a>(sweep: &'a Sweep, point: fn(&T) -> usize) -> impl Iterator<Item = TextColumn<'a, T>> {
    sweep
        .keys
        .iter()
        .enumerate()
        .map(move |(place, key)| TextColumn::new(key, move |row| sweep.points[point(row)].values[place].clone()))
}

/// Returns a number as text, and nothing where there is none.
pub(super) fn number(x: Option<f64>) -> String {
    x.map_or_else(String::new, |x| x.to_string())
}

/// Returns `results.csv`.
#[must_use]
pub fn results(sweep: &Sweep, rows: &[RunRow]) -> Vec<u8> {
    let mut columns = vec![
        TextColumn::new("run", |row: &RunRow| sweep.run_name(row.task)),
        TextColumn::new("point", |row: &RunRow| (row.task.point + 1).to_string()),
        TextColumn::new("seed", |row: &RunRow| row.task.seed.to_string()),
    ];
    columns.extend(keys(sweep, |row: &RunRow| row.task.point));
    columns.push(TextColumn::new("status", |row: &RunRow| row.status.clone()));
    columns.push(TextColumn::new("failure", |row: &RunRow| row.failure.clone()));
    columns.extend(sweep.plan.figures.iter().enumerate().map(|(place, figure)| {
        TextColumn::new(figure, move |row: &RunRow| row.figures[place].clone().unwrap_or_default())
    }));
    csv(&columns, rows)
}

/// Returns `table.csv`.
#[must_use]
pub fn table(sweep: &Sweep, rows: &[RunRow]) -> Vec<u8> {
    let count = |cell: &PointMean, is_counted: fn(&RunRow) -> bool| {
        let of_point = rows.iter().filter(|row| row.task.point == cell.point);
        of_point.filter(|row| is_counted(row)).count().to_string()
    };
    let mut columns = vec![TextColumn::new("point", |cell: &PointMean| (cell.point + 1).to_string())];
    columns.extend(keys(sweep, |cell: &PointMean| cell.point));
    columns.extend([
        TextColumn::new("figure", |cell: &PointMean| sweep.plan.figures[cell.figure].clone()),
        TextColumn::new("mean", |cell: &PointMean| number(cell.mean)),
        TextColumn::new("standard_error", |cell: &PointMean| number(cell.error)),
        TextColumn::new("n", |cell: &PointMean| cell.count.to_string()),
        TextColumn::new("clogged", |cell: &PointMean| count(cell, |row| row.status == "clogged")),
        TextColumn::new("failed", |cell: &PointMean| count(cell, RunRow::is_failure)),
        TextColumn::new("missing", |cell: &PointMean| count(cell, RunRow::is_missing)),
    ]);
    csv(&columns, &cells(sweep, rows))
}

/// Returns a CSV file.
pub(super) fn csv<T>(columns: &[TextColumn<'_, T>], rows: &[T]) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    // Writing to memory cannot fail, and all rows have the same length.
    let _ = writer.write_record(columns.iter().map(|column| &column.name));
    for row in rows {
        let _ = writer.write_record(columns.iter().map(|column| (column.cell)(row)));
    }
    writer.into_inner().unwrap_or_default()
}
