//! The path of every run, from a loaded scene to its summary.
//!
//! | part | if it fails |
//! |---|---|
//! | the input is checked, the run directory is prepared beside its place, threads start, step zero runs and draws | status 2; everything is as before |
//! | the run directory is moved into its place | status 2; everything is as before |
//! | the run steps to its end, or to the step after a signal | status 1, with a summary |
//! | the state and the summary are written | status 1, with a summary if it can be written |
//!
//! At a signal the run ends after the step that follows, with `status: "interrupted"`.

use std::fmt::Write as _;
use std::io::{self, Write};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use bevy_ecs::prelude::*;
use serde::Serialize;

use crate::behaviour::Registry;
use crate::cli::exit_status::Verdict;
use crate::cli::progress::{Pace, Progress};
use crate::cli::show;
use crate::cli::signals::Signals;
use crate::output::checkpoint::file::Checkpoint;
use crate::output::checkpoint::{self, Checkpoints};
use crate::output::cost::RunCost;
use crate::output::parent::Parent;
use crate::output::summary::Cost;
use crate::simulation::Simulation;
use crate::writers::provenance::Provenance;
use siloflow_dem::outcome::{End, Failure};
use siloflow_dem::persist::{CheckpointConfig, Section};
use siloflow_dem::values::NonNegative;
use siloflow_files::hashes::{self, SummaryFiles};
use siloflow_files::run_directory::RunDirectory;
use siloflow_files::run_files::Damage;
use siloflow_text::fault::Fault;
use siloflow_text::source::Source;

/// Settings of a run that do not change its result.
pub(super) struct Call<'a> {
    pub registry: &'a Registry,
    pub threads: NonZeroUsize,
    pub quiet: bool,
    /// Whether an earlier run in the directory is replaced.
    pub force: bool,
    pub signals: &'a Signals,
    /// The run from whose state this run starts.
    pub parent: Option<Parent>,
    /// Time between checkpoints, minutes, if the call gives it.
    pub checkpoint_every: Option<NonNegative>,
    /// Whether `report.html` is written at the end.
    pub report: bool,
}

/// A loaded scene of one method.
pub(super) trait Method: Sync {
    type Summary: Outline;
    fn source(&self) -> &Source;
    /// Logs warnings, and finds all errors of the input.
    fn check(&self, registry: &Registry) -> Result<(), Fault>;
    /// Builds the simulation with its outputs in `directory`.
    /// With `saved` it continues that state.
    fn build(&mut self, call: &Call, directory: &RunDirectory, saved: Option<&[Section]>) -> Result<Simulation, Fault>;
    /// The scene key `checkpoint`.
    fn checkpoint(&self) -> Option<CheckpointConfig>;
    /// Returns the number of updates after a step, from the number before it.
    fn updates(&self, world: &World, before: u64) -> u64;
    /// Returns the line of the progress.
    fn line(&self, world: &World, pace: Pace) -> String;
    fn summary(&self, world: &mut World, end: &End, cost: Cost) -> Self::Summary;
    fn write_state(&self, world: &mut World, file: &mut dyn Write) -> io::Result<()>;
}

/// A summary as the command line sees it.
pub(super) trait Outline: Serialize {
    fn failure(&self) -> Option<&str>;
    /// Records a failure that happened after the last step.
    fn fail(&mut self, reason: String);
    /// Records the origin of the summary.
    fn record(&mut self, provenance: Provenance);
    /// Records the files of the run, and those without which it was continued.
    fn record_files(&mut self, files: SummaryFiles, damaged: Vec<Damage>);
    /// Whether the run succeeded: no failure, and no lost grain.
    fn is_done(&self) -> bool;
    /// Returns the summary in words.
    fn words(&self) -> String;
}

/// The result of a run.
pub(super) struct Report {
    /// The summary in words.
    pub words: String,
    /// The summary as JSON.
    pub json: String,
    pub verdict: Verdict,
}

/// Steps a scene to its end and writes the run directory at `path`. A failure after the start is logged and stands in the
/// summary.
pub(super) fn carry_out(method: &mut impl Method, path: &Path, call: &Call) -> Result<Report, Fault> {
    method.check(call.registry)?;
    call.signals.defer();
    let mut directory = RunDirectory::create(path, method.source(), call.force)?;
    let mut simulation = method.build(call, &directory, None)?;
    let config = checkpoint_config(method, &mut simulation, call)?;
    simulation.stop_on(call.signals.flag());
    let first = step_zero(method, &mut simulation);
    simulation.continue_in(&directory).map_err(|failure| could_not_start(&failure))?;
    if let Some(End::Failed(failure @ Failure::Output { .. })) = first {
        return Err(could_not_start(&failure));
    }
    if let Some(signal) = call.signals.received() {
        return Ok(Report { words: String::new(), json: String::new(), verdict: Verdict::Interrupted(signal) });
    }
    directory.publish()?;
    Ok(run_on(method, simulation, &directory, config, call))
}

/// Continues a run from a checkpoint in its directory.
pub(super) fn carry_on(
    method: &mut impl Method,
    directory: &RunDirectory,
    checkpoint: &Checkpoint,
    call: &Call,
) -> Result<Report, Fault> {
    call.signals.defer();
    let mut simulation = method.build(call, directory, Some(&checkpoint.sections))?;
    let config = checkpoint_config(method, &mut simulation, call)?;
    simulation.stop_on(call.signals.flag());
    directory.remove_results().map_err(|error| directory.unwritable(&error))?;
    Ok(run_on(method, simulation, directory, config, call))
}

/// Steps a simulation, whose directory is in its place, to the end.
fn run_on<M: Method>(
    method: &M,
    mut simulation: Simulation,
    directory: &RunDirectory,
    config: Option<CheckpointConfig>,
    call: &Call,
) -> Report {
    // No picture is queued, so this cannot fail.
    let _ = simulation.continue_in(directory);
    if let Some(config) = config {
        let scene = method.source().name.clone();
        let is_chosen = call.checkpoint_every.is_some() || method.source().value_of("checkpoint.every").is_some();
        simulation.take_checkpoints(Checkpoints::new(directory, scene, config, is_chosen));
    }
    let (end, cost) = step_to_the_end(method, &mut simulation, call.quiet);
    finish(method, &mut simulation, directory, &end, cost, call)
}

/// Returns how checkpoints are taken; `None` if the scene wants none, or has state that no checkpoint would save.
fn checkpoint_config(
    method: &impl Method,
    simulation: &mut Simulation,
    call: &Call,
) -> Result<Option<CheckpointConfig>, Fault> {
    let config = match call.checkpoint_every {
        Some(every) => Some(CheckpointConfig { every, ..method.checkpoint().unwrap_or_default() }),
        None => method.checkpoint(),
    };
    let Some(unsaved) = config.and_then(|_| simulation.unsaved_state()) else { return Ok(config) };
    let message = format!("checkpoints would not save all state: {unsaved}");
    if call.checkpoint_every.is_none() && method.source().value_of("checkpoint").is_none() {
        tracing::warn!("no checkpoints: {message}; a behaviour saves it with `app.persist::<...>()`");
        return Ok(None);
    }
    let fault = match call.checkpoint_every {
        Some(_) => Fault::new("checkpoint::unsaved_state", message),
        None => method.source().fault("checkpoint::unsaved_state", "checkpoint", message),
    };
    Err(fault.help(
        "in the plugin that owns it, call `app.persist::<...>()`, `app.persist_component::<...>()` or, for a cache, \
         `app.derived::<...>()`",
    ))
}

/// Ends a run: writes its state and its summary. The state is that of the end of the last step.
fn finish<M: Method>(
    method: &M,
    simulation: &mut Simulation,
    directory: &RunDirectory,
    end: &End,
    cost: Cost,
    call: &Call,
) -> Report {
    let world = simulation.own_world();
    let mut summary = method.summary(world, end, cost);
    summary.record(Provenance::now());
    if let Err(error) = directory.write_state(|file| method.write_state(world, file)) {
        summary.fail(format!("could not write state.csv: {error}"));
    }
    if let Err(failure) = checkpoint::close_writers(world) {
        summary.fail(failure.to_string());
    }
    match directory.write_hashes() {
        Ok(files) => summary.record_files(files, directory.files().damage()),
        Err(error) => summary.fail(format!("could not write hashes.txt: {error}")),
    }
    if let Err(error) = directory.write_summary(&summary) {
        summary.fail(format!("could not write summary.json: {error}"));
        // The error may be a passing one. If it is not, the error message is all that remains.
        let _ = directory.write_summary(&summary);
    }
    match summary.failure() {
        Some(failure) => tracing::error!("{failure}"),
        // A run that is killed before this checkpoint is complete can be resumed from an earlier one.
        None => checkpoint::at_end(world),
    }
    let verdict = match (summary.failure(), end, call.signals.received()) {
        (None, End::Interrupted, Some(signal)) => Verdict::Interrupted(signal),
        _ if summary.is_done() => Verdict::Done,
        _ => Verdict::Failed,
    };
    let mut words = summary.words() + &format!("{:<12} {}\n", "written to", directory.path().display());
    let verdict = match call.report.then(|| write_report(directory)) {
        None => verdict,
        Some(Ok(path)) => {
            let _ = writeln!(words, "{:<12} {}", "report", path.display());
            verdict
        }
        Some(Err(fault)) => {
            show(fault);
            if verdict == Verdict::Done { Verdict::Failed } else { verdict }
        }
    };
    Report { words, json: hashes::sealed(serde_json::to_string_pretty(&summary).unwrap_or_default() + "\n"), verdict }
}

/// Writes the report of a run that is over, and returns its path.
#[cfg(feature = "report")]
fn write_report(directory: &RunDirectory) -> Result<PathBuf, Fault> {
    use siloflow_files::whole_file;
    let path = siloflow_files::run_directory::report_of(directory.path());
    let page = siloflow_results::report::page(&[directory.path()], &crate::scene::facts::read)?;
    let written =
        directory.guard()().and_then(|()| whole_file::write_synced(&path, |file| file.write_all(page.as_bytes())));
    written.map(|()| path.clone()).map_err(|error| {
        Fault::new("report::write", format!("could not write {}: {error}", path.display()))
            .help("the run itself is complete; `siloflow report` writes the report later")
    })
}

/// A program without the feature `report` writes none.
#[cfg(not(feature = "report"))]
fn write_report(_: &RunDirectory) -> Result<PathBuf, Fault> {
    Err(Fault::new("report::absent", "this program was built without reports")
        .help("build it with the feature `report`"))
}

/// The fault of a run that failed before anything was changed.
fn could_not_start(failure: &Failure) -> Fault {
    Fault::new("run::start", failure.to_string()).help("nothing was changed; is there space, and may you write there?")
}

/// Runs step zero and counts its cost.
fn step_zero(method: &impl Method, simulation: &mut Simulation) -> Option<End> {
    simulation.cost_mut().resume();
    let end = simulation.step_zero();
    simulation.cost_mut().pause();
    simulation.cost_mut().updates = method.updates(simulation.world(), 0);
    end
}

/// Steps to the end of the run, and shows the progress.
fn step_to_the_end(method: &impl Method, simulation: &mut Simulation, quiet: bool) -> (End, Cost) {
    simulation.cost_mut().resume();
    let Cost { wall_s, particle_steps } = simulation.cost_mut().cost();
    let mut progress = Progress::new(quiet, wall_s, particle_steps);
    let end = simulation.advance_to_end(|world| {
        let updates = method.updates(world, world.resource::<RunCost>().updates);
        world.resource_mut::<RunCost>().updates = updates;
        progress.look(updates, |pace| method.line(world, pace));
    });
    let cost = simulation.cost_mut().cost();
    progress.finish();
    (end, cost)
}
