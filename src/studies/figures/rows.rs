//! The rows of a table of a run that belong to a figure.

use siloflow_files::own_files;
use siloflow_files::run_directory::scene_of;
use siloflow_files::table::Table;
use siloflow_results::run_results::RunResults;
use siloflow_text::fault::Fault;
use siloflow_text::file;
use siloflow_text::source::Source;
use siloflow_text::suggestion::did_you_mean;

use crate::measure::moment::{Events, Moment};
use crate::studies::figures::excerpt::{Excerpt, fault};

/// Returns the number of a run; `None` if the run does not have it.
pub(super) fn value(excerpt: &Excerpt, run: &RunResults) -> Result<Option<f64>, Fault> {
    let Some(table) = run.table(&excerpt.file)? else {
        let message = format!("{}: there is no {}, or it has no row", run.directory.display(), excerpt.file);
        return Err(fault(message, "the scene must ask for it"));
    };
    let rows = Rows { excerpt, run, table };
    let Some(value) = rows.table.names().find(|name| names_column(name, &excerpt.column)).map(str::to_owned) else {
        return Err(rows.no_column(&excerpt.column));
    };
    let mut mine = vec![true; rows.table.len()];
    rows.keep_texts(&mut mine)?;
    rows.keep_places(&mut mine)?;
    let [starts, ends] = rows.times();
    if let Some((from, to)) = excerpt.window {
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
    Ok(excerpt.of.of(&points))
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
                _ if has("slope") => ("slope".to_owned(), named.clone()),
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
    const UNITS: [&str; 11] =
        ["_deg", "_pa", "_n_per_m", "_n", "_nm", "_m_per_s", "_j", "_kg", "_per_s", "_rad", "_m2_per_s2"];
    name == wanted || UNITS.iter().any(|unit| name.strip_suffix(unit) == Some(wanted))
}

/// Returns the number of the entry of `wall_bands` for walls of this name, from 1.
fn band(run: &RunResults, name: &str) -> Option<usize> {
    let text = own_files::read_text(&scene_of(&run.directory), file::SCENE_BYTES).ok()?;
    let source = Source::new("scene.ron", "scene", &run.directory, text);
    let walls = |entry: usize| source.value_of(&format!("wall_bands[{entry}].walls"));
    (0..).map_while(walls).position(|walls| walls.trim_matches('"') == name).map(|entry| entry + 1)
}
