//! `siloflow sweep`: runs a scene with many values of its keys and several seeds, and gathers means, standard errors and figures.

mod results;
pub(in crate::cli) mod runs;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::builder::PossibleValuesParser;
use clap::{ArgGroup, Args};

use crate::behaviour::Registry;
use crate::cli::exit_status::ExitStatus;
use crate::cli::progress::Progress;
use crate::cli::run::directory_named;
use crate::cli::signals::Signals;
use crate::cli::sweep::results::{conclude_part, gather};
use crate::cli::sweep::runs::{Failure, Runs};
use crate::cli::{program, say};
use crate::studies::sweep::directory::{State, SweepDirectory};
use crate::studies::sweep::script::{Calls, Part, Scheduler};
use crate::studies::sweep::{Sweep, Task};
use siloflow_text::fault::Fault;

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

pub(super) fn sweep(args: &SweepArgs, registry: &Registry, quiet: bool) -> Result<ExitStatus, Fault> {
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
    let cores = args.cores.unwrap_or_else(|| if args.task.is_some() { NonZeroUsize::MIN } else { available_cores() });
    let effort = Effort { cores, force: args.force, retry: args.retry };
    let (directory, failures) = complete(&sweep, &path, &tasks, effort, &signals, registry, quiet)?;
    if let Some(signal) = signals.received() {
        tracing::error!("interrupted: the same command continues the sweep in {}", path.display());
        return Ok(ExitStatus::Interrupted(signal));
    }
    match args.task {
        Some(_) => Ok(conclude_part(&sweep, &directory, &tasks, &failures)),
        None => gather(&sweep, &directory, &failures, quiet),
    }
}

/// The effort for the runs of a sweep.
#[derive(Clone, Copy)]
pub(super) struct Effort {
    /// Most processes at a time.
    pub cores: NonZeroUsize,
    /// Whether the directory of another sweep is used, and runs of another scene are replaced.
    pub force: bool,
    /// Whether failed runs are replaced.
    pub retry: bool,
}

/// Returns the number of cores.
pub(super) fn available_cores() -> NonZeroUsize {
    std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN)
}

/// Does those of `tasks` that are not over. Returns the directory and the runs without a result. After a signal no run is started.
pub(super) fn complete(
    sweep: &Sweep,
    path: &Path,
    tasks: &[Task],
    effort: Effort,
    signals: &Signals,
    registry: &Registry,
    quiet: bool,
) -> Result<(SweepDirectory, Vec<Failure>), Fault> {
    let Effort { cores, force, retry } = effort;
    let known = match SweepDirectory::find(path, sweep) {
        Err(fault) if !force => return Err(fault),
        found => found.ok().flatten(),
    };
    // Before the directory is made: an error of a scene changes nothing.
    let found = todo(effort, sweep, known.as_ref(), tasks)?;
    check(sweep, &found, registry, quiet)?;
    signals.defer();
    let directory = SweepDirectory::prepare(path, sweep, force)?;
    let todo = match known {
        Some(_) => found,
        // The directory of another sweep may have runs that belong to this one.
        None => todo(effort, sweep, Some(&directory), tasks)?,
    };
    let runs = Runs { sweep, directory: &directory, cores, signals, quiet, force, retry };
    let failures = runs.run(tasks.len(), &todo)?;
    Ok((directory, failures))
}

/// Returns the runs that are not over. Runs of another scene are an error without `--force`.
fn todo(
    Effort { force, retry, .. }: Effort,
    sweep: &Sweep,
    directory: Option<&SweepDirectory>,
    tasks: &[Task],
) -> Result<Vec<Task>, Fault> {
    let Some(directory) = directory else { return Ok(tasks.to_vec()) };
    let mut todo = Vec::new();
    for &task in tasks {
        match directory.state(sweep, task)? {
            State::Foreign(key) if !force => return Err(directory.refuse(sweep, task, &key)),
            state @ State::Over(_) if !(retry && state.is_failure()) => {}
            _ => todo.push(task),
        }
    }
    Ok(todo)
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
fn list(sweep: &Sweep, path: &Path, registry: &Registry, quiet: bool) -> Result<ExitStatus, Fault> {
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
    Ok(ExitStatus::Done)
}

/// Prepares the directory and prints the script of a job array.
fn script(
    args: &SweepArgs,
    name: &str,
    sweep: &Sweep,
    path: &Path,
    registry: &Registry,
    quiet: bool,
) -> Result<ExitStatus, Fault> {
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
    Ok(ExitStatus::Done)
}
