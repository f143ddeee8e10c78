//! `siloflow sweep`: runs a scene with many values of its keys and several seeds, and gathers means, standard errors and figures.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::builder::PossibleValuesParser;
use clap::{ArgGroup, Args};

use crate::behaviour::Registry;
use crate::cli::exit_status::Verdict;
use crate::cli::progress::Progress;
use crate::cli::run::directory_named;
use crate::cli::signals::Signals;
use crate::cli::sweep_runs::{Failure, Runs};
use crate::cli::{picture_files, program, say, show};
use crate::fault::Fault;
use crate::sweep::directory::{State, SweepDirectory};
use crate::sweep::fit::short;
use crate::sweep::script::{Calls, Part, Scheduler};
use crate::sweep::table::{self, Row};
use crate::sweep::{Sweep, Task, figures, picture};

/// Arguments of `sweep`.
#[derive(Args, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "options of a call")]
#[command(
    group(ArgGroup::new("mode").args(["list", "task", "script", "gather"])),
    after_help = "\
A sweep file names a scene, values of its keys, seeds and figures. Each run is a process on one core, with a directory of its own:

  siloflow sweep scenes/sweeps/beverloo.ron --list    # check all points; run nothing
  siloflow sweep scenes/sweeps/beverloo.ron           # run, or continue where it was
  cat out/beverloo/table.csv                          # mean, standard error, number of runs

As a job array, here of at most 100 jobs:

  siloflow sweep scenes/sweeps/beverloo.ron --script slurm --jobs 100 > job.sh
  sbatch job.sh
  siloflow sweep scenes/sweeps/beverloo.ron --gather  # when the jobs are over"
)]
pub(super) struct SweepArgs {
    /// The sweep, a RON file: scene, axes, seeds, figures.
    sweep: PathBuf,
    /// The sweep directory. Default: out/<name of the sweep file>.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of runs at a time, each on one core. Default: the number of cores; with --task 1.
    #[arg(long, value_name = "N")]
    cores: Option<NonZeroUsize>,
    /// Check all points, and list the runs with their states. Nothing is run or written.
    #[arg(long)]
    list: bool,
    /// Do part I of N of the runs, and gather nothing. N tasks together do every run once.
    #[arg(long, value_name = "I/N", value_parser = Part::parse)]
    task: Option<Part>,
    /// Prepare the sweep directory, and print a script for a job array: slurm, parallel (GNU parallel) or hyperqueue.
    #[arg(long, value_name = "SCHEDULER", value_parser = PossibleValuesParser::new(Scheduler::ALL.map(|(name, _)| name)))]
    script: Option<String>,
    /// Most jobs of the script. Several runs are packed into one job if there are more runs.
    #[arg(long, value_name = "N", default_value = "1000", requires = "script")]
    jobs: NonZeroUsize,
    /// Write the tables and figures of the runs that are there. Nothing is run.
    #[arg(long)]
    gather: bool,
    /// Run failed runs again.
    #[arg(long, conflicts_with_all = ["list", "script", "gather"])]
    retry: bool,
    /// Use the directory of another sweep: its runs that belong to this sweep too are kept, others are replaced.
    #[arg(long, conflicts_with_all = ["list", "gather"])]
    force: bool,
}

pub(super) fn sweep(args: &SweepArgs, registry: &Registry, quiet: bool) -> Result<Verdict, Fault> {
    let sweep = Sweep::read(&args.sweep)?;
    let path = args.out.clone().map_or_else(|| directory_named(&sweep.name), Ok)?;
    if args.list {
        return list(&sweep, &path, registry, quiet);
    }
    if args.gather {
        let directory = SweepDirectory::open(&path, &sweep)?;
        return gather(&sweep, &directory, &[], quiet);
    }
    if let Some(name) = &args.script {
        return script(args, name, &sweep, &path, registry, quiet);
    }
    let all = sweep.tasks();
    let tasks = args.task.map_or_else(|| all.clone(), |part| part.of(&all));
    let signals = Signals::catch();
    let known = match SweepDirectory::find(&path, &sweep) {
        Err(fault) if !args.force => return Err(fault),
        found => found.ok().flatten(),
    };
    // Before the directory is made: an error of a scene changes nothing.
    let todo = todo(args, &sweep, known.as_ref(), &tasks)?;
    check(&sweep, &todo, registry, quiet)?;
    let directory = SweepDirectory::prepare(&path, &sweep, args.force)?;
    let todo = match known {
        Some(_) => todo,
        // The directory of another sweep may have runs that belong to this one.
        None => self::todo(args, &sweep, Some(&directory), &tasks)?,
    };
    let cores = || std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
    let cores = args.cores.unwrap_or_else(|| if args.task.is_some() { NonZeroUsize::MIN } else { cores() });
    let runs = Runs {
        sweep: &sweep,
        directory: &directory,
        cores,
        signals: &signals,
        quiet,
        force: args.force,
        retry: args.retry,
    };
    let failures = runs.run(tasks.len(), &todo)?;
    if let Some(signal) = signals.received() {
        tracing::error!("interrupted: the same command continues the sweep in {}", path.display());
        return Ok(Verdict::Interrupted(signal));
    }
    match args.task {
        Some(_) => Ok(conclude_part(&sweep, &directory, &tasks, &failures)),
        None => gather(&sweep, &directory, &failures, quiet),
    }
}

/// Returns the runs that are not over. Runs of another scene are an error without `--force`.
fn todo(
    args: &SweepArgs,
    sweep: &Sweep,
    directory: Option<&SweepDirectory>,
    tasks: &[Task],
) -> Result<Vec<Task>, Fault> {
    let Some(directory) = directory else { return Ok(tasks.to_vec()) };
    let mut todo = Vec::new();
    for &task in tasks {
        match directory.state(sweep, task)? {
            State::Foreign(key) if !args.force => return Err(foreign(directory, sweep, task, &key)),
            state @ State::Over(_) if !(args.retry && state.is_failure()) => {}
            _ => todo.push(task),
        }
    }
    Ok(todo)
}

fn foreign(directory: &SweepDirectory, sweep: &Sweep, task: Task, key: &str) -> Fault {
    let message = format!("{} is a run of another scene: `{key}` differs", directory.run(sweep, task).display());
    Fault::new("sweep::other_scene", message)
        .help("the scene has changed: give another directory with --out, or run such points again with --force")
}

/// Checks the scenes of all points that have runs to do, and logs their warnings, each once.
fn check(sweep: &Sweep, todo: &[Task], registry: &Registry, quiet: bool) -> Result<(), Fault> {
    let mut warnings: BTreeMap<&str, (String, Vec<usize>)> = BTreeMap::new();
    let mut progress = Progress::new(quiet, 0.0, 0);
    let mut last = None;
    for (number, &task) in (0..).zip(todo) {
        // Seeds of one point share their scene.
        if last.replace(task.point) == Some(task.point) {
            continue;
        }
        progress.show(number, |_| format!("checking point {} of {}", task.point + 1, sweep.points.len()));
        let found = sweep.check(task, registry).inspect_err(|_| {
            progress.finish();
            tracing::error!("the scene is refused for run {}", sweep.in_words(task));
        })?;
        for warning in found {
            let (_, points) = warnings.entry(warning.code).or_insert_with(|| (warning.to_string(), Vec::new()));
            points.push(task.point + 1);
        }
    }
    progress.finish();
    for (text, points) in warnings.into_values() {
        let shown: Vec<_> = points.iter().take(10).map(ToString::to_string).collect();
        let more = if points.len() > shown.len() { ", ..." } else { "" };
        tracing::warn!("points {}{more}: {text}", shown.join(", "));
    }
    Ok(())
}

/// Checks all points and lists all runs.
fn list(sweep: &Sweep, path: &Path, registry: &Registry, quiet: bool) -> Result<Verdict, Fault> {
    let tasks = sweep.tasks();
    let directory = SweepDirectory::find(path, sweep)?;
    check(sweep, &tasks, registry, quiet)?;
    let mut text = String::new();
    for (number, &task) in (1..).zip(&tasks) {
        let state = directory.as_ref().map_or(Ok(State::Missing), |directory| directory.state(sweep, task))?;
        let state = match &state {
            State::Missing => "to do".to_owned(),
            State::Unfinished(true) => "to continue".to_owned(),
            State::Unfinished(false) => "to begin again".to_owned(),
            State::Foreign(key) => format!("of another scene: {key} differs"),
            State::Over(summary) => summary["status"].as_str().unwrap_or_default().to_owned(),
        };
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{number:>5}  {}  {state}", sweep.in_words(task));
    }
    let _ =
        writeln!(text, "{} runs: {} points, {} seeds", tasks.len(), sweep.points.len(), sweep.plan.seeds.list().len());
    say(&text);
    Ok(Verdict::Done)
}

/// Prepares the directory and prints the script of a job array.
fn script(
    args: &SweepArgs,
    name: &str,
    sweep: &Sweep,
    path: &Path,
    registry: &Registry,
    quiet: bool,
) -> Result<Verdict, Fault> {
    let tasks = sweep.tasks();
    check(sweep, &tasks, registry, quiet)?;
    let absolute = |path: &Path| {
        std::path::absolute(path).map_err(|error| {
            Fault::new("sweep::script", format!("{} has no absolute path: {error}", path.display()))
                .help("start the command in a directory that exists")
        })
    };
    let program = program()?;
    let directory = SweepDirectory::prepare(path, sweep, args.force)?;
    let calls = Calls {
        program: &program,
        sweep: &absolute(&args.sweep)?,
        directory: &absolute(directory.path())?,
        name: &sweep.name,
        runs: tasks.len(),
        jobs: args.jobs.get().min(tasks.len()),
    };
    let scheduler = Scheduler::ALL.into_iter().find(|(known, _)| *known == name);
    say(&calls.script(scheduler.map_or(Scheduler::Slurm, |(_, scheduler)| scheduler)));
    Ok(Verdict::Done)
}

/// Most failed or missing runs that are listed.
const MOST_LISTED: usize = 20;

/// Lists runs that failed or are missing. Returns whether there are any.
fn list_failures(sweep: &Sweep, rows: &[Row], failures: &[Failure]) -> bool {
    let reason = |row: &Row| match failures.iter().find(|failure| failure.task == row.task) {
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
fn rows(sweep: &Sweep, directory: &SweepDirectory, tasks: &[Task]) -> Result<Vec<Row>, Fault> {
    let row = |&task: &Task| match directory.state(sweep, task)? {
        State::Over(summary) => Ok(Row::of(sweep, task, Some(&summary))),
        State::Foreign(key) => Err(foreign(directory, sweep, task, &key)),
        _ => Ok(Row::of(sweep, task, None)),
    };
    tasks.iter().map(row).collect()
}

/// Ends a task of a job array.
fn conclude_part(sweep: &Sweep, directory: &SweepDirectory, tasks: &[Task], failures: &[Failure]) -> Verdict {
    match rows(sweep, directory, tasks) {
        Ok(rows) if list_failures(sweep, &rows, failures) => Verdict::Failed,
        Ok(_) => Verdict::Done,
        Err(fault) => {
            show(fault);
            Verdict::Failed
        }
    }
}

/// Writes the tables and figures of all runs.
fn gather(sweep: &Sweep, directory: &SweepDirectory, failures: &[Failure], quiet: bool) -> Result<Verdict, Fault> {
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
        return Ok(Verdict::Failed);
    }
    warn_of_absent_figures(sweep, directory, &rows);
    if !quiet {
        say(&in_words(sweep, directory, &rows, &cells, &fits));
    }
    Ok(if list_failures(sweep, &rows, failures) { Verdict::Failed } else { Verdict::Done })
}

/// Warns of figures that no run has, and tells which numbers a run has.
fn warn_of_absent_figures(sweep: &Sweep, directory: &SweepDirectory, rows: &[Row]) {
    let Some(over) = rows.iter().find(|row| !row.is_failure() && !row.is_missing()) else { return };
    for (number, figure) in sweep.plan.figures.iter().enumerate() {
        if rows.iter().any(|row| row.figures[number].is_some()) {
            continue;
        }
        let known = match directory.state(sweep, over.task) {
            Ok(State::Over(summary)) => Vec::from_iter(figures::paths(&summary)).join(", "),
            _ => String::new(),
        };
        tracing::warn!("no run has the figure `{figure}`; run {} has: {known}", sweep.run_name(over.task));
    }
}

/// Most rows of the table that are printed.
const MOST_ROWS: usize = 60;

/// Returns the result of a sweep in words. Writing to a string cannot fail.
fn in_words(
    sweep: &Sweep,
    directory: &SweepDirectory,
    rows: &[Row],
    cells: &[table::Cell],
    fits: &[picture::GroupFit],
) -> String {
    let count = |of: &dyn Fn(&Row) -> bool| rows.iter().filter(|row| of(row)).count();
    let mut text = format!(
        "{}: {} runs, {} clogged, {} failed, {} missing\n",
        sweep.name,
        rows.len(),
        count(&|row| row.status == "clogged"),
        count(&Row::is_failure),
        count(&Row::is_missing)
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
