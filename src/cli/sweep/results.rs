//! The results of a sweep: tables, figures, a summary in words, and the runs without a result.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::cli::exit_status::ExitStatus;
use crate::cli::sweep::runs::Failure;
use crate::cli::{picture_files, say, show};
use crate::studies::figures::figure::Figure;
use crate::studies::figures::summary;
use crate::studies::sweep::directory::{State, SweepDirectory};
use crate::studies::sweep::table::{self, RunRow};
use crate::studies::sweep::{Sweep, Task, picture};
use siloflow_figures::statistics::digits::short;
use siloflow_text::fault::Fault;

/// Most failed or missing runs that are listed.
const MOST_LISTED: usize = 20;

/// Lists runs that failed or are missing. Returns whether there are any.
fn list_failures(sweep: &Sweep, rows: &[RunRow], failures: &[Failure]) -> bool {
    let reason = |row: &RunRow| match failures.iter().find(|failure| failure.task == row.task) {
        Some(failure) => Some(failure.reason.clone()),
        None if row.is_failure() => Some(row.failure.clone()),
        None if row.is_missing() => Some("it has not been run to its end".to_owned()),
        None => None,
    };
    let all: Vec<_> = rows.iter().filter_map(|row| Some((row.task, reason(row)?))).collect();
    for (task, reason) in all.iter().take(MOST_LISTED) {
        tracing::error!("run {} has no result: {reason}", sweep.in_words(*task));
    }
    if all.len() > MOST_LISTED {
        tracing::error!("{} more runs have no result; results.csv lists them", all.len() - MOST_LISTED);
    }
    !all.is_empty()
}

/// Returns the rows of runs, as their directories are now.
fn rows(sweep: &Sweep, directory: &SweepDirectory, tasks: &[Task]) -> Result<Vec<RunRow>, Fault> {
    let row = |&task: &Task| match directory.state(sweep, task)? {
        State::Over(summary) => Ok(RunRow::of(sweep, task, Some(&summary), &directory.run(sweep, task))),
        State::Foreign(key) => Err(directory.refuse(sweep, task, &key)),
        _ => Ok(RunRow::of(sweep, task, None, &directory.run(sweep, task))),
    };
    tasks.iter().map(row).collect()
}

/// Ends a task of a job array.
pub(super) fn conclude_part(
    sweep: &Sweep,
    directory: &SweepDirectory,
    tasks: &[Task],
    failures: &[Failure],
) -> ExitStatus {
    match rows(sweep, directory, tasks) {
        Ok(rows) if list_failures(sweep, &rows, failures) => ExitStatus::Failed,
        Ok(_) => ExitStatus::Done,
        Err(fault) => {
            show(fault);
            ExitStatus::Failed
        }
    }
}

/// Writes the tables and figures of all runs.
pub(super) fn gather(
    sweep: &Sweep,
    directory: &SweepDirectory,
    failures: &[Failure],
    quiet: bool,
) -> Result<ExitStatus, Fault> {
    let rows = rows(sweep, directory, &sweep.tasks())?;
    let cells = table::cells(sweep, &rows);
    let fits = picture::fits(sweep, &cells);
    let mut files = vec![
        (PathBuf::from("results.csv"), table::results(sweep, &rows)),
        (PathBuf::from("table.csv"), table::table(sweep, &rows)),
    ];
    files.extend(picture::fit_table(&fits).map(|table| (PathBuf::from("fit.csv"), table)));
    for (key, svg) in picture::sheets(sweep, &cells) {
        // A key may contain brackets, and in a map any character.
        let name: String = key.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' }).collect();
        let pictures = picture_files(&name, svg)?;
        files.extend(pictures.map(|(name, content)| (Path::new("figures").join(name), content)));
    }
    if let Err(error) = directory.write(&files) {
        show(
            Fault::new("results::write", format!("could not write to {}: {error}", directory.path().display()))
                .help("the runs are kept: `siloflow sweep --gather` writes the results when there is space"),
        );
        return Ok(ExitStatus::Failed);
    }
    warn_of_absent_figures(sweep, directory, &rows);
    if !quiet {
        say(&in_words(sweep, directory, &rows, &cells, &fits));
    }
    Ok(if list_failures(sweep, &rows, failures) { ExitStatus::Failed } else { ExitStatus::Done })
}

/// Warns of figures that no run has, and tells which numbers a run has.
fn warn_of_absent_figures(sweep: &Sweep, directory: &SweepDirectory, rows: &[RunRow]) {
    let Some(over) = rows.iter().find(|row| !row.is_failure() && !row.is_missing()) else { return };
    for (number, figure) in sweep.plan.figures.iter().enumerate() {
        if rows.iter().any(|row| row.figures[number].is_some()) {
            continue;
        }
        let Ok(State::Over(summary)) = directory.state(sweep, over.task) else { continue };
        let run = directory.run(sweep, over.task);
        if let Ok(Err(fault)) = Figure::parse(figure, true).map(|figure| figure.in_text(&summary, &run)) {
            tracing::warn!("no run has the figure `{figure}`: {fault}");
        } else {
            let known = Vec::from_iter(summary::paths(&summary)).join(", ");
            tracing::warn!("no run has the figure `{figure}`; run {} has: {known}", sweep.run_name(over.task));
        }
    }
}

/// Most rows of the table that are printed.
const MOST_ROWS: usize = 60;

/// Returns the result of a sweep in words. Writing to a string cannot fail.
fn in_words(
    sweep: &Sweep,
    directory: &SweepDirectory,
    rows: &[RunRow],
    cells: &[table::PointMean],
    fits: &[picture::GroupFit],
) -> String {
    let count = |of: &dyn Fn(&RunRow) -> bool| rows.iter().filter(|row| of(row)).count();
    let mut text = format!(
        "{}: {} runs, {} clogged, {} failed, {} missing\n",
        sweep.name,
        rows.len(),
        count(&|row| row.status == "clogged"),
        count(&RunRow::is_failure),
        count(&RunRow::is_missing)
    );
    for cell in cells.iter().take(MOST_ROWS) {
        let values = sweep.keys.iter().zip(&sweep.points[cell.point].values);
        let point: Vec<_> = values.map(|(key, value)| format!("{key} = {value}")).collect();
        let error = cell.error.map_or_else(String::new, |error| format!(" ± {}", short(error)));
        let mean = cell.mean.map_or_else(|| "-".to_owned(), |mean| short(mean) + &error);
        let figure = &sweep.plan.figures[cell.figure];
        let _ = writeln!(text, "  {}  {figure} {mean}  (n = {})", point.join(", "), cell.count);
    }
    if cells.len() > MOST_ROWS {
        let _ = writeln!(text, "  ... {} more rows in table.csv", cells.len() - MOST_ROWS);
    }
    for fit in fits {
        let _ = writeln!(text, "fit          {}", picture::fit_in_words(fit));
    }
    let _ = writeln!(text, "written to   {}", directory.path().display());
    text
}
