//! The figure of a run that is estimated: a number of `summary.json`, or a mean over part of a table in a window of time.
//!
//! | written | the figure |
//! |---|---|
//! | `discharge.rate_per_s` | the number at this path of `summary.json` |
//! | `share of clogged` | the probability of this status |
//! | `series.csv: coordination, 1 s to 2 s` | the mean of a column over the rows of a window |
//! | `series.csv: rate of out, AfterDoor(0.1) to AfterDoor(0.4)` | the slope of a straight line through the column against time |
//! | `wall_bands.csv: sides, pressure, 0.1 m to 0.2 m, AfterDoor(0.5) to AfterDoor(1)` | the same over the rows of a range of places, and of the walls `sides` |
//! | `walls.csv: wall = 2, largest fx_n, AfterDoor(0) to AfterDoor(1)` | the largest number of a column, here over the rows of wall 2 |
//!
//! The name of a column may be cut before its unit: `pressure` stands for `pressure_pa`. A row with `from_s` and `to_s` belongs to a window that holds
//! both. [`Moment`] has the moments of windows.

use std::fmt::{self, Display, Formatter};

use siloflow_files::own_files;
use siloflow_files::run_directory::scene_of;
use siloflow_files::table::Table;
use siloflow_results::run_results::RunResults;
use siloflow_text::fault::Fault;
use siloflow_text::file;
use siloflow_text::source::Source;
use siloflow_text::suggestion::did_you_mean;

use crate::measure::moment::{Events, Moment};
use crate::studies::sweep::figures;

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

/// Part of a table.
#[derive(Clone, Debug, Default, PartialEq)]
struct Excerpt {
    file: String,
    column: String,
    of: Statistic,
    /// Column and text that a row must have.
    only: Vec<(String, String)>,
    /// Words without a column: names of walls.
    named: Option<String>,
    places: Option<(f64, f64)>,
    window: Option<(Moment, Moment)>,
}

/// The statistic of the numbers of a column.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Statistic {
    #[default]
    Mean,
    Largest,
    Slope,
}

impl Display for Figure {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

fn fault(message: String, help: impl Into<String>) -> Fault {
    Fault::new("estimate::figure", message).help(help)
}

/// Example of a figure of a table.
const EXAMPLE: &str = "for example `series.csv: rate of out, AfterDoor(0.1) to AfterDoor(0.4)`";

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
                figures::check(text).map_err(|(message, help)| fault(message, help))?;
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

    /// Returns the figure of a run; `None` if the run does not have it.
    ///
    /// # Errors
    /// If no run of the scene can have it: there is no such table, column or row.
    pub fn of(&self, run: &RunResults) -> Result<Option<f64>, Fault> {
        match &self.kind {
            Kind::Summary => Ok(figures::figure(&run.summary, &self.text).and_then(|text| text.parse().ok())),
            Kind::Share(status) => {
                let own = run.summary["status"].as_str().unwrap_or_default();
                Ok((!figures::is_failure(own)).then(|| if own == status { 1.0 } else { 0.0 }))
            }
            Kind::Table(_) if figures::is_failure(run.summary["status"].as_str().unwrap_or_default()) => Ok(None),
            Kind::Table(excerpt) => excerpt.of(run),
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

impl Excerpt {
    fn parse(file: &str, rest: &str) -> Result<Self, Fault> {
        let is_table = std::path::Path::new(file).extension().is_some_and(|ending| ending == "csv");
        if !is_table || file.contains(['/', '\\']) {
            return Err(fault(format!("`{file}` is no table of a run directory"), EXAMPLE));
        }
        let mut found = Self { file: file.to_owned(), ..Self::default() };
        let mut words = Vec::new();
        for part in rest.split(',').map(str::trim) {
            if let Some((low, high)) = part.split_once(" to ") {
                found.range(part, low.trim(), high.trim())?;
            } else if let Some((column, text)) = part.split_once('=') {
                found.only.push((column.trim().to_owned(), text.trim().to_owned()));
            } else if !part.is_empty() {
                words.push(part);
            }
        }
        let (column, named) = match words[..] {
            [column] => (column, None),
            [named, column] => (column, Some(named)),
            _ => return Err(fault(format!("`{file}:{rest}` does not name one column"), EXAMPLE)),
        };
        found.named = named.map(str::to_owned);
        let statistics = [("rate of ", Statistic::Slope), ("largest ", Statistic::Largest), ("mean ", Statistic::Mean)];
        let statistic = statistics.iter().find_map(|(word, of)| Some((column.strip_prefix(word)?, *of)));
        let (column, of) = statistic.unwrap_or((column, Statistic::Mean));
        column.trim().clone_into(&mut found.column);
        found.of = of;
        Ok(found)
    }

    /// Takes a range of places or of times.
    fn range(&mut self, part: &str, low: &str, high: &str) -> Result<(), Fault> {
        let metres = |words: &str| words.strip_suffix('m')?.trim().parse().ok().filter(|place: &f64| place.is_finite());
        match (metres(low), metres(high), Moment::parse(low), Moment::parse(high)) {
            (Some(low), Some(high), ..) if low < high => self.places = Some((low, high)),
            (_, _, Ok(from), Ok(to)) => self.window = Some((from, to)),
            _ => {
                let help = "a range of places is `0.1 m to 0.2 m`, a window of time `1 s to 2 s`, or with moments \
                            AfterDoor(seconds), AfterRest(seconds), Out(share)";
                return Err(fault(format!("`{part}` is neither a range of places nor a window of time"), help));
            }
        }
        Ok(())
    }

    fn of(&self, run: &RunResults) -> Result<Option<f64>, Fault> {
        let Some(table) = run.table(&self.file)? else {
            let message = format!("{}: there is no {}, or it has no row", run.directory.display(), self.file);
            return Err(fault(message, "the scene must ask for it"));
        };
        let rows = Rows { excerpt: self, run, table };
        let Some(value) = rows.table.names().find(|name| names_column(name, &self.column)).map(str::to_owned) else {
            return Err(rows.no_column(&self.column));
        };
        let mut mine = vec![true; rows.table.len()];
        rows.keep_texts(&mut mine)?;
        rows.keep_places(&mut mine)?;
        let [starts, ends] = rows.times();
        if let Some((from, to)) = self.window {
            let (Some(from), Some(to)) = (time(from, run), time(to, run)) else { return Ok(None) };
            keep_between(&mut mine, [&starts, &ends], (from, to));
        }
        if mine.iter().all(|mine| !mine) {
            let help =
                "make the window or range longer, or the intervals of the table shorter (`average`, `series.interval`)";
            return Err(rows.absent("no row lies in the window and range", help));
        }
        let values = rows.table.numbers(&value).unwrap_or_default();
        let finite = (0..values.len()).filter(|row| mine[*row] && values[*row].is_finite());
        let points: Vec<_> = finite.map(|row| (0.5 * (starts[row] + ends[row]), values[row])).collect();
        Ok(self.of.of(&points))
    }
}

/// The rows of a table of a run.
struct Rows<'a> {
    excerpt: &'a Excerpt,
    run: &'a RunResults,
    table: Table,
}

impl Rows<'_> {
    fn absent(&self, what: &str, help: impl Into<String>) -> Fault {
        fault(format!("{}, {}: {what}", self.run.directory.display(), self.excerpt.file), help)
    }

    fn no_column(&self, wanted: &str) -> Fault {
        let names: Vec<&str> = self.table.names().collect();
        self.absent(&format!("there is no column `{wanted}`"), did_you_mean("columns", wanted, &names))
    }

    /// Keeps the rows with the texts that the figure names.
    fn keep_texts(&self, mine: &mut [bool]) -> Result<(), Fault> {
        let mut only = self.excerpt.only.clone();
        if let Some(named) = &self.excerpt.named {
            let has = |wanted: &str| self.table.names().any(|name| name == wanted);
            only.push(match band(self.run, named).filter(|_| has("bands")) {
                _ if has("walls") => ("walls".to_owned(), named.clone()),
                Some(number) => ("bands".to_owned(), number.to_string()),
                None => {
                    let help = "write `column = text` for the rows with this text in a column";
                    return Err(self.absent(&format!("`{named}` names no rows"), help));
                }
            });
        }
        for (name, text) in &only {
            let Some(texts) = self.table.texts(name) else { return Err(self.no_column(name)) };
            if !texts.contains(&text.as_str()) {
                let mut known: Vec<&str> = texts.clone();
                known.sort_unstable();
                known.dedup();
                let help = did_you_mean(&format!("texts of `{name}`"), text, &known);
                return Err(self.absent(&format!("no row has `{text}` in the column `{name}`"), help));
            }
            mine.iter_mut().zip(texts).for_each(|(mine, own)| *mine &= own == text);
        }
        Ok(())
    }

    /// Keeps the rows in the range of places.
    fn keep_places(&self, mine: &mut [bool]) -> Result<(), Fault> {
        let Some(range) = self.excerpt.places else { return Ok(()) };
        let numbers = |name: &str| self.table.numbers(name);
        let [lows, highs] = match (numbers("low_m"), numbers("high_m"), numbers("place_m")) {
            (Some(lows), Some(highs), _) => [lows, highs],
            (_, _, Some(places)) => [places.clone(), places],
            _ => return Err(self.absent("there is no column of places", "leave the range of places out")),
        };
        keep_between(mine, [&lows, &highs], range);
        Ok(())
    }

    /// The times at which the rows begin and end.
    fn times(&self) -> [Vec<f64>; 2] {
        let numbers = |name: &str| self.table.numbers(name);
        if let (Some(starts), Some(ends)) = (numbers("from_s"), numbers("to_s")) {
            return [starts, ends];
        }
        let times = numbers("time_s").or(numbers("step")).unwrap_or_else(|| vec![0.0; self.table.len()]);
        [times.clone(), times]
    }
}

/// Keeps the rows that lie between two numbers. Rounding does not put a row outside.
fn keep_between(mine: &mut [bool], [lows, highs]: [&[f64]; 2], (low, high): (f64, f64)) {
    let slack = 1e-9 * (high - low).abs();
    for (row, mine) in mine.iter_mut().enumerate() {
        *mine &= low - slack <= lows[row] && highs[row] <= high + slack;
    }
}

/// Returns the time of a moment in a run, s (in a lattice gas: steps); `None` if the event did not happen.
fn time(moment: Moment, run: &RunResults) -> Option<f64> {
    let events = Events { door: run.opening(), rest: run.number("/rest_time_s").or(run.number("/rest_step")) };
    moment.time(events, |share| {
        let out = run.series.numbers("out")?;
        let wanted = share * run.number("/grains/released").or(run.number("/released"))?;
        let row = out.iter().position(|out| *out >= wanted)?;
        run.times().get(row).copied()
    })
}

/// Whether a word names a column: as a whole, or without the unit at its end.
fn names_column(name: &str, wanted: &str) -> bool {
    const UNITS: [&str; 10] = ["_pa", "_n_per_m", "_n", "_nm", "_m_per_s", "_j", "_kg", "_per_s", "_rad", "_m2_per_s2"];
    name == wanted || UNITS.iter().any(|unit| name.strip_suffix(unit) == Some(wanted))
}

/// Returns the number of the entry of `wall_bands` for walls of this name, from 1.
fn band(run: &RunResults, name: &str) -> Option<usize> {
    let text = own_files::read_text(&scene_of(&run.directory), file::SCENE_BYTES).ok()?;
    let source = Source::new("scene.ron", "scene", &run.directory, text);
    let walls = |entry: usize| source.value_of(&format!("wall_bands[{entry}].walls"));
    (0..).map_while(walls).position(|walls| walls.trim_matches('"') == name).map(|entry| entry + 1)
}

impl Statistic {
    /// Returns the statistic of values with their times; `None` if there are too few.
    fn of(self, points: &[(f64, f64)]) -> Option<f64> {
        #[expect(clippy::cast_precision_loss, reason = "rows of a table")]
        let count = points.len() as f64;
        match self {
            Self::Mean => (!points.is_empty()).then(|| points.iter().map(|point| point.1).sum::<f64>() / count),
            Self::Largest => points.iter().map(|point| point.1).reduce(f64::max),
            Self::Slope => siloflow_figures::statistics::points::slope(points),
        }
    }
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
