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

pub(super) mod finish;
pub(super) mod runnable;
pub(super) mod words;

use std::path::Path;

use bevy_ecs::prelude::*;

use self::finish::finish;
use self::runnable::{RunOptions, RunResult, RunnableScene};
use crate::assembly::Assembly;
use crate::cli::exit_status::ExitStatus;
use crate::cli::progress::Progress;
use crate::measure::outputs::BehaviourOutputs;
use crate::output::checkpoint::Checkpoints;
use crate::output::checkpoint::file::Checkpoint;
use crate::output::cost::{CostPlugin, RunCost};
use crate::output::summary::Cost;
use crate::simulation::Simulation;
use crate::writers::run_path::RunPath;
use siloflow_dem::outcome::{End, Failure};
use siloflow_dem::persist::{CheckpointConfig, Section, UnknownState};
use siloflow_files::run_directory::RunDirectory;
use siloflow_text::fault::Fault;

/// A run whose directory is in its place, and that has not stepped on from there.
pub(super) struct Prepared {
    pub simulation: Simulation,
    pub directory: RunDirectory,
}

/// Steps a scene from its start to its end and writes the run directory at `path`. A failure after the start is logged and stands in the
/// summary.
pub(super) fn run_from_start(
    scene: &mut impl RunnableScene,
    path: &Path,
    options: &RunOptions,
) -> Result<RunResult, Fault> {
    if let Some(Prepared { simulation, directory }) = prepare(scene, path, options)? {
        return Ok(run_to_end(scene, simulation, &directory, options));
    }
    let exit_status = options.signals.received().map_or(ExitStatus::Failed, ExitStatus::Interrupted);
    Ok(RunResult { words: String::new(), json: String::new(), exit_status })
}

/// Checks a scene, builds its simulation, runs step zero and moves the run directory to `path`; `None` after a signal.
pub(super) fn prepare(
    scene: &mut impl RunnableScene,
    path: &Path,
    options: &RunOptions,
) -> Result<Option<Prepared>, Fault> {
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
    if options.signals.received().is_some() {
        return Ok(None);
    }
    directory.publish()?;
    enter(scene, &mut simulation, &directory, config, options);
    Ok(Some(Prepared { simulation, directory }))
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
    enter(scene, &mut simulation, directory, config, options);
    Ok(run_to_end(scene, simulation, directory, options))
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

/// Lets a simulation write into its directory, which is in its place, and take checkpoints.
fn enter(
    scene: &impl RunnableScene,
    simulation: &mut Simulation,
    directory: &RunDirectory,
    config: Option<CheckpointConfig>,
    options: &RunOptions,
) {
    // No picture is queued, so this cannot fail.
    let _ = simulation.continue_in(directory);
    if let Some(config) = config {
        let name = scene.source().name.clone();
        let is_chosen = options.checkpoint_every.is_some() || scene.source().value_of("checkpoint.every").is_some();
        simulation.take_checkpoints(Checkpoints::new(directory, name, config, is_chosen));
    }
}

/// Steps a simulation, whose directory is in its place, to the end.
fn run_to_end<S: RunnableScene>(
    scene: &S,
    mut simulation: Simulation,
    directory: &RunDirectory,
    options: &RunOptions,
) -> RunResult {
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
        tracing::warn!("no checkpoints: {message}");
        return Ok(None);
    }
    let fault = match options.checkpoint_every {
        Some(_) => Fault::new("checkpoint::unsaved_state", message),
        None => scene.source().fault("checkpoint::unsaved_state", "checkpoint", message),
    };
    Err(fault.help(
        "add the call to the `build` of the behaviour; for a cache that is computed anew from other state it is `app.derived::<...>()`",
    ))
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
        let updates = count_updates(scene, world);
        progress.look(updates, |pace| scene.line(world, pace));
    });
    let cost = simulation.cost_mut().cost();
    progress.finish();
    (end, cost)
}

/// Adds the updates of the last step, and returns the number of all.
pub(super) fn count_updates(scene: &impl RunnableScene, world: &mut World) -> u64 {
    let updates = scene.updates(world, world.resource::<RunCost>().updates);
    world.resource_mut::<RunCost>().updates = updates;
    updates
}
