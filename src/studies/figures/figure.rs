//! A figure of a run: a number of `summary.json`, or a mean over part of a table in a window of time.
//!
//! | written | the figure |
//! |---|---|
//! | `discharge.rate_per_s` | the number at this path of `summary.json` |
//! | `share of clogged` | the probability of this status |
//! | `series.csv: coordination, 1 s to 2 s` | the mean of a column over the rows of a window |
//! | `series.csv: rate of out, AfterDoor(0.1) to AfterDoor(0.4)` | the slope of a straight line through the column against time |
//! | `wall_bands.csv: sides, pressure, 0.1 m to 0.2 m, AfterDoor(0.5) to AfterDoor(1)` | the same over the rows of a range of places, and of the walls `sides` |
//! | `slopes.csv: heap, angle, 1 s to 2 s` | the same over the rows of the slope `heap` |
//! | `walls.csv: wall = 2, largest fx_n, AfterDoor(0) to AfterDoor(1)` | the largest number of a column, here over the rows of wall 2 |
//!
//! The name of a column may be cut before its unit: `pressure` stands for `pressure_pa`. A row with `from_s` and `to_s` belongs to a window that holds
//! both. [`Moment`](crate::measure::moment::Moment) has the moments of windows.
use std::fmt::{self, Display, Formatter};
use std::path::Path;

use serde_json::Value;

use siloflow_results::run_results::RunResults;
use siloflow_text::fault::Fault;
use siloflow_text::suggestion::did_you_mean;

use crate::studies::figures::excerpt::{Excerpt, fault};
use crate::studies::figures::{rows, summary};

/// A figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    text: String,
    kind: Kind,
}

#[derive(Clone, Debug, PartialEq)]
enum Kind {
    Summary,
    Share(String),
    Table(Excerpt),
}

impl Display for Figure {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Figure {
    /// Reads a figure. `is_lattice` tells whether the scene is one of the lattice gas, whose summary has no schema.
    ///
    /// # Errors
    /// If it is none.
    pub fn parse(text: &str, is_lattice: bool) -> Result<Self, Fault> {
        let text = text.trim();
        let kind = if let Some((file, rest)) = text.split_once(':') {
            Kind::Table(Excerpt::parse(file.trim(), rest)?)
        } else if let Some(status) = text.strip_prefix("share of ") {
            Kind::Share(status_of(status.trim())?)
        } else {
            if !is_lattice {
                summary::check(text).map_err(|(message, help)| fault(message, help))?;
            }
            Kind::Summary
        };
        Ok(Self { text: text.to_owned(), kind })
    }

    /// Whether the figure is a probability, of which a run has 0 or 1.
    #[must_use]
    pub fn is_probability(&self) -> bool {
        matches!(self.kind, Kind::Share(_))
    }

    /// Returns the figure of a run as text, for a table; `None` if the run does not have it. Numbers of the summary are written as there.
    ///
    /// # Errors
    /// If no run of the scene can have it, or if the directory of the run cannot be read.
    pub fn in_text(&self, summary: &Value, directory: &Path) -> Result<Option<String>, Fault> {
        if self.kind == Kind::Summary {
            return Ok(summary::figure(summary, &self.text));
        }
        let value = self.of(&RunResults::open(directory)?)?;
        Ok(value.map(|value| value.to_string()))
    }

    /// Returns the figure of a run; `None` if the run does not have it.
    ///
    /// # Errors
    /// If no run of the scene can have it: there is no such table, column or row.
    pub fn of(&self, run: &RunResults) -> Result<Option<f64>, Fault> {
        match &self.kind {
            Kind::Summary => Ok(summary::figure(&run.summary, &self.text).and_then(|text| text.parse().ok())),
            Kind::Share(status) => {
                let own = run.summary["status"].as_str().unwrap_or_default();
                Ok((!summary::is_failure(own)).then(|| if own == status { 1.0 } else { 0.0 }))
            }
            Kind::Table(_) if summary::is_failure(run.summary["status"].as_str().unwrap_or_default()) => Ok(None),
            Kind::Table(excerpt) => rows::value(excerpt, run),
        }
    }
}

fn status_of(word: &str) -> Result<String, Fault> {
    const ALL: [&str; 6] = ["empty", "at_rest", "end_of_flow", "clogged", "out_reached", "time_reached"];
    if ALL.contains(&word) {
        return Ok(word.to_owned());
    }
    Err(fault(format!("`{word}` is no status of a run"), did_you_mean("statuses", word, &ALL)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(summary: &str, files: &[(&str, &str)]) -> (tempfile::TempDir, RunResults) {
        let here = tempfile::tempdir().unwrap();
        let series = "time_s,out,energy_j\n0,0,9\n1,0,8\n2,10,7\n3,30,6\n4,50,5\n";
        let scene = r#"(wall_bands: [(walls: "floor"), (walls: "sides")])"#;
        for (name, text) in
            [("summary.json", summary), ("series.csv", series), ("scene.ron", scene)].iter().chain(files)
        {
            std::fs::write(here.path().join(name), text).unwrap();
        }
        let run = RunResults::open(here.path()).unwrap();
        (here, run)
    }

    const SUMMARY: &str =
        r#"{"status": "empty", "door_open_time_s": 1.0, "rest_time_s": 0.5, "grains": {"released": 100}, "steps": 7}"#;

    fn value(text: &str) -> Option<f64> {
        let bands = "bands,from_s,to_s,low_m,high_m,pressure_pa\n1,0,1,0,0.1,5\n2,0,1,0,0.1,6\n2,0,1,0.1,0.2,8\n2,1,2,0,0.1,7\n2,1,2,0.1,0.2,NaN\n";
        let (_here, run) = run(SUMMARY, &[("wall_bands.csv", bands)]);
        Figure::parse(text, false).unwrap().of(&run).unwrap()
    }

    #[test]
    fn figures_are_read_from_summaries_and_tables() {
        assert_eq!(value("steps"), Some(7.0));
        assert_eq!((value("share of empty"), value("share of clogged")), (Some(1.0), Some(0.0)));
        // 10, 30, 50 out at 2, 3, 4 s.
        assert!((value("series.csv: rate of out, AfterDoor(1) to 4 s").unwrap() - 20.0).abs() < 1e-12);
        assert_eq!(value("series.csv: energy, AfterRest(0.5) to 3 s"), Some(7.0));
        assert_eq!(value("series.csv: largest energy_j, Out(0.1) to Out(0.3)"), Some(7.0));
        // Half of all grains are never out in a window that begins at nine tenths.
        assert_eq!(value("series.csv: out, Out(0.9) to 4 s"), None);
        assert_eq!(value("wall_bands.csv: sides, pressure, 0 m to 0.2 m, 0 s to 1 s"), Some(7.0));
        assert_eq!(value("wall_bands.csv: bands = 1, pressure_pa"), Some(5.0));
        // A mean of numbers, of which one is missing.
        assert_eq!(value("wall_bands.csv: sides, pressure, AfterDoor(0) to AfterDoor(1)"), Some(7.0));
    }

    #[test]
    fn a_failed_run_has_no_figure() {
        let (_here, run) = run(r#"{"status": "failed", "steps": 7}"#, &[]);
        for text in ["steps", "share of clogged", "series.csv: out"] {
            assert_eq!(Figure::parse(text, false).unwrap().of(&run).unwrap(), None, "{text}");
        }
    }

    #[test]
    fn what_is_no_figure_is_refused_with_a_help() {
        let refused = |text: &str| Figure::parse(text, false).unwrap_err().to_string();
        assert!(refused("discharge.rate_pers").contains("no key"));
        assert!(refused("share of clogs").contains("no status"));
        assert!(refused("../a.csv: out").contains("no table"));
        assert!(refused("series.csv: 1 s to 2 s").contains("one column"));
        assert!(refused("series.csv: out, soon to late").contains("neither"));
        let (_here, run) = run(SUMMARY, &[]);
        let absent = |text: &str| Figure::parse(text, false).unwrap().of(&run).unwrap_err().to_string();
        assert!(absent("walls.csv: fx").contains("no walls.csv"));
        assert!(absent("series.csv: outs").contains("no column `outs`"));
        assert!(absent("series.csv: out, 0.1 m to 0.2 m").contains("no column of places"));
        assert!(absent("series.csv: sides, out").contains("names no rows"));
        assert!(absent("series.csv: out = 3, energy").contains("no row has `3`"));
        assert!(absent("series.csv: out, 2.1 s to 2.9 s").contains("no row lies"));
    }
}
