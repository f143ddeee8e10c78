//! Results of a comparison as a plain-text table, as `compare.csv` and as JSON.
//!
//! | column of `compare.csv` | unit | meaning |
//! |---|---|---|
//! | `run` | | name of the run; the reference is first |
//! | `field_rms` | mean downward speeds | disagreement of the velocity [fields](crate::compare::field) |
//! | `field_correlation` | | correlation of the fields; empty if one of them is uniform |
//! | `common_cells`, `only_reference`, `only_run` | cells | cells of both fields, only the reference, only this run |
//! | `mean_speed` | m/`time_unit` | mean downward speed over the common cells |
//! | `discharge_difference` | fraction | disagreement of the [discharge](crate::compare::discharge) |
//! | `unit_time` | `time_unit` | time from the opening until half (or the largest fraction of all runs) is out |
//! | `time_unit` | | `s` or `step` |
//! | `wall_s`, `wall_ratio` | s | wall-clock time of the steps, and its ratio to the reference's time |
//!
//! The columns of the field, from `field_rms` to `mean_speed`, are empty where this run or the reference has none.

use std::fmt::Write as _;

use serde::Serialize;

/// Comparison of one run with the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Name of the run.
    pub run: String,
    /// Comparison of the fields; `None` where this run or the reference has none.
    #[serde(flatten)]
    pub field: Option<FieldFigures>,
    /// Largest difference of the fractions that are out.
    pub discharge_difference: f64,
    /// Unit of time of the discharge, s or steps.
    pub unit_time: f64,
    /// `s` or `step`.
    pub time_unit: &'static str,
    /// Wall-clock time of the steps, s.
    pub wall_s: f64,
    /// Wall-clock time over the reference's wall-clock time.
    pub wall_ratio: f64,
}

/// Comparison of the field of one run with that of the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FieldFigures {
    /// Rms difference of the patterns of velocity, in mean downward speeds.
    pub field_rms: f64,
    /// Correlation of the fields; `None` if one of them is uniform.
    pub field_correlation: Option<f64>,
    /// Number of cells that both fields have.
    pub common_cells: usize,
    /// Number of cells that only the reference has.
    pub only_reference: usize,
    /// Number of cells that only this run has.
    pub only_run: usize,
    /// Mean downward speed over the common cells, m/s or m/step.
    pub mean_speed: f64,
}

/// Results of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Fraction of the grains that defines the unit of time: the time until this fraction is out.
    pub unit_share: f64,
    /// Smallest number of grains that a cell must have counted to be compared.
    pub looks: f64,
    /// Rows of the reference and then of the other runs.
    pub rows: Vec<Row>,
}

impl Report {
    /// Returns the content of `compare.csv`.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut text = "run,field_rms,field_correlation,common_cells,only_reference,only_run,mean_speed,\
                        discharge_difference,unit_time,time_unit,wall_s,wall_ratio\n"
            .to_owned();
        for row in &self.rows {
            let name = if row.run.contains([',', '"', '\n']) {
                format!("\"{}\"", row.run.replace('"', "\"\""))
            } else {
                row.run.clone()
            };
            let field = row.field.as_ref().map_or_else(
                || ",".repeat(5),
                |field| {
                    let correlation = field.field_correlation.map_or_else(String::new, |r| format!("{r:?}"));
                    format!(
                        "{:?},{correlation},{},{},{},{:e}",
                        field.field_rms, field.common_cells, field.only_reference, field.only_run, field.mean_speed
                    )
                },
            );
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{name},{field},{:?},{:e},{},{:?},{:?}",
                row.discharge_difference, row.unit_time, row.time_unit, row.wall_s, row.wall_ratio
            );
        }
        text
    }

    /// Returns a plain-text table with a line per run and aligned columns.
    #[must_use]
    pub fn table(&self) -> String {
        let half = format!("{} % out after", (1000.0 * self.unit_share).round() / 10.0);
        let mut lines = vec![
            [
                "run",
                "field rms",
                "correlation",
                "cells",
                "only ref",
                "only run",
                "mean speed",
                "discharge",
                &half,
                "wall",
                "of ref",
            ]
            .map(str::to_owned),
        ];
        lines.extend(self.rows.iter().map(|row| {
            let figure = |of: &dyn Fn(&FieldFigures) -> String| row.field.as_ref().map_or_else(|| "-".to_owned(), of);
            [
                row.run.clone(),
                figure(&|field| format!("{:.4}", field.field_rms)),
                figure(&|field| field.field_correlation.map_or_else(|| "-".to_owned(), |r| format!("{r:.4}"))),
                figure(&|field| field.common_cells.to_string()),
                figure(&|field| field.only_reference.to_string()),
                figure(&|field| field.only_run.to_string()),
                figure(&|field| format!("{:.4} m/{}", field.mean_speed, row.time_unit)),
                format!("{:.4}", row.discharge_difference),
                format!("{:.2} {}", row.unit_time, row.time_unit),
                format!("{:.2} s", row.wall_s),
                format!("{:.3}", row.wall_ratio),
            ]
        }));
        let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
        let widths: [usize; 11] = std::array::from_fn(width);
        let mut text = String::new();
        for line in &lines {
            let cells = line.iter().zip(widths).enumerate().map(|(column, (cell, width))| {
                if column == 0 { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
            });
            text.push_str(cells.collect::<Vec<_>>().join("  ").trim_end());
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use crate::compare::{Run, compare, tests::run};

    #[test]
    fn csv_and_table_have_a_line_per_run() {
        let reference = run("a", 1.0, |x, _| 1.0 + x);
        let without = Run { field: None, ..run("d", 2.0, |_, _| 1.0) };
        let report = compare(&reference, &[run("b, c", 2.0, |_, y| 1.0 + y), without], 1.0).unwrap();
        let csv = report.csv();
        // All digits: the correlation of a field with itself may be off by its round-off.
        let first: Vec<_> = csv.lines().nth(1).unwrap().split(',').collect();
        let correlation: f64 = first[2].parse().unwrap();
        assert_eq!(report.rows[0].field.as_ref().unwrap().field_correlation, Some(correlation));
        assert_eq!([&first[..2], &first[3..6]].concat(), ["a", "0.0", "16", "0", "0"], "{csv}");
        assert!(csv.lines().nth(2).unwrap().starts_with("\"b, c\","), "{csv}");
        assert!(csv.lines().nth(3).unwrap().starts_with("d,,,,,,,"), "{csv}");
        let columns: Vec<_> = csv.lines().skip(1).map(|line| line.replace("b, c", "b").split(',').count()).collect();
        assert_eq!(columns, [12; 3]);
        let table = report.table();
        assert_eq!(table.lines().count(), 4);
        assert!(table.contains("50 % out after") && table.contains("m/s"), "{table}");
    }
}
