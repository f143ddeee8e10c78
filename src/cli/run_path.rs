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

use std::fmt::{Display, Write as _};
use std::io::{self, Write};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use bevy_ecs::prelude::*;

use crate::assembly::Assembly;
use crate::behaviour::Registry;
use crate::cli::exit_status::ExitStatus;
use crate::cli::progress::{Pace, Progress};
use crate::cli::show;
use crate::cli::signals::Signals;
use crate::measure::outputs::BehaviourOutputs;
use crate::output::checkpoint::file::Checkpoint;
use crate::output::checkpoint::{self, Checkpoints};
use crate::output::cost::{CostPlugin, RunCost};
use crate::output::parent::Parent;
use crate::output::run_path::RunPath;
use crate::output::summary::{Cost, FileRecord, Results, Summary};
use crate::simulation::{Additions, Simulation};
use crate::writers::provenance::Provenance;
use siloflow_dem::outcome::{End, Failure};
use siloflow_dem::persist::{CheckpointConfig, Section, UnknownState};
use siloflow_dem::values::NonNegative;
use siloflow_files::hashes;
use siloflow_files::run_directory::RunDirectory;
use siloflow_text::fault::Fault;
use siloflow_text::source::Source;

/// Settings of a run that do not change its result.
pub(super) struct RunOptions<'a> {
    pub registry: &'a Registry,
    pub threads: NonZeroUsize,
    pub quiet: bool,
    /// Whether an earlier run in the directory is replaced.
    pub force: bool,
    pub signals: &'a Signals,
    /// The run from whose state this run starts.
    pub parent: Option<Parent>,
    /// Time between checkpoints, minutes, if the command line gives it.
    pub checkpoint_every: Option<NonNegative>,
    /// Whether `report.html` is written at the end.
    pub report: bool,
}

/// A loaded scene of one method: the parts of a run in which grains and the lattice gas differ.
pub(super) trait RunnableScene: Sync {
    type Results: Results;
    fn source(&self) -> &Source;
    /// Logs warnings, and finds all errors of the input.
    fn check(&self, registry: &Registry) -> Result<(), Fault>;
    /// Adds the outputs of the scene, with files in `directory`. The world has the columns that behaviours have registered.
    fn add_outputs(&self, app: &mut Assembly, directory: &RunDirectory, options: &RunOptions) -> Result<(), Fault>;
    /// Builds the simulation with more plugins. With `saved` it continues that state.
    fn simulation(
        &self,
        options: &RunOptions,
        more: Additions,
        saved: Option<(&[Section], UnknownState)>,
    ) -> Result<Simulation, Fault>;
    /// Frees the memory of the state at the start, which the world has now.
    fn forget_start(&mut self);
    /// The scene key `checkpoint`.
    fn checkpoint(&self) -> Option<CheckpointConfig>;
    /// Returns the number of updates after a step, from the number before it.
    fn updates(&self, world: &World, before: u64) -> u64;
    /// Returns the line of the progress.
    fn line(&self, world: &World, pace: Pace) -> String;
    fn summary(&self, world: &mut World, end: &End, cost: Cost, provenance: Provenance) -> Summary<Self::Results>;
    /// Adds the results in words, without the scene and the files.
    fn describe(&self, summary: &Summary<Self::Results>, words: &mut SummaryWords);
    fn write_state(&self, world: &mut World, file: &mut dyn Write) -> io::Result<()>;
}

/// A summary in words: lines of a name and a value.
#[derive(Default)]
pub(super) struct SummaryWords(String);

impl SummaryWords {
    pub(super) fn line(&mut self, name: &str, value: impl Display) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{name:<12} {value}");
    }

    /// Adds a line for each event that happened, with its moment in words.
    pub(super) fn moments<T: Copy>(&mut self, moments: [(&str, Option<T>); 3], in_words: impl Fn(T) -> String) {
        for (name, moment) in moments {
            if let Some(moment) = moment {
                self.line(name, in_words(moment));
            }
        }
    }
}

/// The result of a run.
pub(super) struct RunResult {
    /// The summary in words.
    pub words: String,
    /// The summary as JSON.
    pub json: String,
    pub exit_status: ExitStatus,
}

/// Steps a scene from its start to its end and writes the run directory at `path`. A failure after the start is logged and stands in the
/// summary.
pub(super) fn run_from_start(
    scene: &mut impl RunnableScene,
    path: &Path,
    options: &RunOptions,
) -> Result<RunResult, Fault> {
    scene.check(options.registry)?;
    options.signals.defer();
    let mut directory = RunDirectory::create(path, scene.source(), options.force)?;
    let mut simulation = build(scene, &directory, options, None)?;
    let config = checkpoint_config(scene, &mut simulation, options)?;
    simulation.stop_on(options.signals.flag());
    let first = step_zero(scene, &mut simulation);
    simulation.continue_in(&directory).map_err(|failure| could_not_start(&failure))?;
    if let Some(End::Failed(failure @ Failure::Output { .. })) = first {
        return Err(could_not_start(&failure));
    }
    if let Some(signal) = options.signals.received() {
        let exit_status = ExitStatus::Interrupted(signal);
        return Ok(RunResult { words: String::new(), json: String::new(), exit_status });
    }
    directory.publish()?;
    Ok(run_to_end(scene, simulation, &directory, config, options))
}

/// Resumes a run from a checkpoint in its directory.
pub(super) fn resume_from(
    scene: &mut impl RunnableScene,
    directory: &RunDirectory,
    checkpoint: &Checkpoint,
    options: &RunOptions,
) -> Result<RunResult, Fault> {
    options.signals.defer();
    let mut simulation = build(scene, directory, options, Some(&checkpoint.sections))?;
    let config = checkpoint_config(scene, &mut simulation, options)?;
    simulation.stop_on(options.signals.flag());
    directory.remove_results().map_err(|error| directory.unwritable(&error))?;
    Ok(run_to_end(scene, simulation, directory, config, options))
}

/// Builds the simulation of a scene with its outputs in `directory`. With `saved` it continues that state.
fn build<S: RunnableScene>(
    scene: &mut S,
    directory: &RunDirectory,
    options: &RunOptions,
    saved: Option<&[Section]>,
) -> Result<Simulation, Fault> {
    let this: &S = scene;
    let outputs = Box::new(|app: &mut Assembly<'_>| {
        // The behaviours have registered the files that they will write.
        directory.declare(&BehaviourOutputs::files(app.world())).map_err(|error| directory.unwritable(&error))?;
        app.provide(RunPath::of(directory));
        app.add("always", CostPlugin);
        this.add_outputs(app, directory, options)
    });
    let simulation = this.simulation(options, outputs, saved.map(|saved| (saved, UnknownState::Refuse)))?;
    scene.forget_start();
    Ok(simulation)
}

/// Steps a simulation, whose directory is in its place, to the end.
fn run_to_end<S: RunnableScene>(
    scene: &S,
    mut simulation: Simulation,
    directory: &RunDirectory,
    config: Option<CheckpointConfig>,
    options: &RunOptions,
) -> RunResult {
    // No picture is queued, so this cannot fail.
    let _ = simulation.continue_in(directory);
    if let Some(config) = config {
        let name = scene.source().name.clone();
        let is_chosen = options.checkpoint_every.is_some() || scene.source().value_of("checkpoint.every").is_some();
        simulation.take_checkpoints(Checkpoints::new(directory, name, config, is_chosen));
    }
    let (end, cost) = step_to_the_end(scene, &mut simulation, options.quiet);
    finish(scene, &mut simulation, directory, &end, cost, options)
}

/// Returns how checkpoints are taken; `None` if the scene wants none, or has state that no checkpoint would save.
fn checkpoint_config(
    scene: &impl RunnableScene,
    simulation: &mut Simulation,
    options: &RunOptions,
) -> Result<Option<CheckpointConfig>, Fault> {
    let config = match options.checkpoint_every {
        Some(every) => Some(CheckpointConfig { every, ..scene.checkpoint().unwrap_or_default() }),
        None => scene.checkpoint(),
    };
    let Some(unsaved) = config.and_then(|_| simulation.unsaved_state()) else { return Ok(config) };
    let message = format!("checkpoints would not save all state: {unsaved}");
    if options.checkpoint_every.is_none() && scene.source().value_of("checkpoint").is_none() {
        tracing::warn!("no checkpoints: {message}; a behaviour saves it with `app.persist::<...>()`");
        return Ok(None);
    }
    let fault = match options.checkpoint_every {
        Some(_) => Fault::new("checkpoint::unsaved_state", message),
        None => scene.source().fault("checkpoint::unsaved_state", "checkpoint", message),
    };
    Err(fault.help(
        "in the plugin that owns it, call `app.persist::<...>()`, `app.persist_component::<...>()` or, for a cache, \
         `app.derived::<...>()`",
    ))
}

/// Ends a run: writes its state and its summary. The state is that of the end of the last step.
fn finish<S: RunnableScene>(
    scene: &S,
    simulation: &mut Simulation,
    directory: &RunDirectory,
    end: &End,
    cost: Cost,
    options: &RunOptions,
) -> RunResult {
    let world = simulation.own_world();
    let mut summary = scene.summary(world, end, cost, Provenance::now());
    if let Err(error) = directory.write_state(|file| scene.write_state(world, file)) {
        summary.fail(format!("could not write state.csv: {error}"));
    }
    if let Err(failure) = checkpoint::close_writers(world) {
        summary.fail(failure.to_string());
    }
    match directory.write_hashes() {
        Ok(files) => summary.written = FileRecord { damaged: directory.files().damage(), files: Some(files) },
        Err(error) => summary.fail(format!("could not write hashes.txt: {error}")),
    }
    if let Err(error) = directory.write_summary(&summary) {
        summary.fail(format!("could not write summary.json: {error}"));
        // The error may be a passing one. If it is not, the error message is all that remains.
        let _ = directory.write_summary(&summary);
    }
    match &summary.head.failure {
        Some(failure) => tracing::error!("{failure}"),
        // A run that is killed before this checkpoint is complete can be resumed from an earlier one.
        None => checkpoint::at_end(world),
    }
    let status = match (&summary.head.failure, end, options.signals.received()) {
        (None, End::Interrupted, Some(signal)) => ExitStatus::Interrupted(signal),
        _ if summary.is_done() => ExitStatus::Done,
        _ => ExitStatus::Failed,
    };
    let mut words = SummaryWords::default();
    scene.describe(&summary, &mut words);
    words.line("written to", directory.path().display());
    let exit_status = match options.report.then(|| write_report(directory)) {
        None => status,
        Some(Ok(path)) => {
            words.line("report", path.display());
            status
        }
        Some(Err(fault)) => {
            show(fault);
            if status == ExitStatus::Done { ExitStatus::Failed } else { status }
        }
    };
    let json = hashes::sealed(serde_json::to_string_pretty(&summary).unwrap_or_default() + "\n");
    RunResult { words: words.0, json, exit_status }
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
fn step_zero(scene: &impl RunnableScene, simulation: &mut Simulation) -> Option<End> {
    simulation.cost_mut().resume();
    let end = simulation.step_zero();
    simulation.cost_mut().pause();
    simulation.cost_mut().updates = scene.updates(simulation.world(), 0);
    end
}

/// Steps to the end of the run, and shows the progress.
fn step_to_the_end(scene: &impl RunnableScene, simulation: &mut Simulation, quiet: bool) -> (End, Cost) {
    simulation.cost_mut().resume();
    let Cost { wall_s, updates } = simulation.cost_mut().cost();
    let mut progress = Progress::new(quiet, wall_s, updates);
    let end = simulation.advance_to_end(|world| {
        let updates = scene.updates(world, world.resource::<RunCost>().updates);
        world.resource_mut::<RunCost>().updates = updates;
        progress.look(updates, |pace| scene.line(world, pace));
    });
    let cost = simulation.cost_mut().cost();
    progress.finish();
    (end, cost)
}
