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

use std::io::{self, Write};
use std::num::NonZeroUsize;
use std::path::Path;
use std::time::Instant;

use bevy_ecs::prelude::*;
use serde::Serialize;

use crate::behaviour::Registry;
use crate::cli::exit_status::Verdict;
use crate::cli::progress::{Pace, Progress};
use crate::cli::signals::Signals;
use crate::fault::Fault;
use crate::outcome::{End, Failure};
use crate::output::run_directory::RunDirectory;
use crate::output::summary::Cost;
use crate::simulation::Simulation;
use crate::source::Source;
use crate::step::Clock;

/// Settings of a run that do not change its result.
pub(super) struct Call<'a> {
    pub registry: &'a Registry,
    pub threads: NonZeroUsize,
    pub quiet: bool,
    /// Whether an earlier run in the directory is replaced.
    pub force: bool,
    pub signals: &'a Signals,
}

/// A loaded scene of one method.
pub(super) trait Method: Sync {
    type Summary: Outline;
    fn source(&self) -> &Source;
    /// Logs warnings, and finds all errors of the input.
    fn check(&self, registry: &Registry) -> Result<(), Fault>;
    /// Builds the simulation with its outputs in `directory`.
    fn build(&mut self, call: &Call, directory: &RunDirectory) -> Result<Simulation, Fault>;
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
    let mut directory = RunDirectory::create(path, method.source(), call.force)?;
    let mut simulation = method.build(call, &directory)?;
    simulation.stop_on(call.signals.flag());
    let mut drive = Drive::start(method, call.quiet);
    let first = drive.step_zero(&mut simulation);
    simulation.continue_in(&directory).map_err(|failure| could_not_start(&failure))?;
    if let Some(End::Failed(failure @ Failure::Output { .. })) = first {
        return Err(could_not_start(&failure));
    }
    if let Some(signal) = call.signals.received() {
        return Ok(Report { words: String::new(), json: String::new(), verdict: Verdict::Interrupted(signal) });
    }
    directory.publish()?;
    // No picture is queued, so this cannot fail.
    let _ = simulation.continue_in(&directory);
    let (end, cost) = drive.until_the_end(&mut simulation);
    Ok(finish(method, &mut simulation, &directory, &end, cost, call.signals))
}

/// Ends a run: writes its state and its summary. The state is that of the end of the last step.
fn finish<M: Method>(
    method: &M,
    simulation: &mut Simulation,
    directory: &RunDirectory,
    end: &End,
    cost: Cost,
    signals: &Signals,
) -> Report {
    let world = simulation.world_mut();
    let mut summary = method.summary(world, end, cost);
    if let Err(error) = directory.write_state(|file| method.write_state(world, file)) {
        summary.fail(format!("could not write state.csv: {error}"));
    }
    if let Err(error) = directory.write_summary(&summary) {
        summary.fail(format!("could not write summary.json: {error}"));
        // The error may be a passing one. If it is not, the error message is all that remains.
        let _ = directory.write_summary(&summary);
    }
    if let Some(failure) = summary.failure() {
        tracing::error!("{failure}");
    }
    let verdict = match (summary.failure(), end, signals.received()) {
        (None, End::Interrupted, Some(signal)) => Verdict::Interrupted(signal),
        _ if summary.is_done() => Verdict::Done,
        _ => Verdict::Failed,
    };
    let words = summary.words() + &format!("{:<12} {}\n", "written to", directory.path().display());
    Report { words, json: serde_json::to_string_pretty(&summary).unwrap_or_default() + "\n", verdict }
}

/// The fault of a run that failed before anything was changed.
fn could_not_start(failure: &Failure) -> Fault {
    Fault::new("run::start", failure.to_string()).help("nothing was changed; is there space, and may you write there?")
}

/// The stepping of a run: its progress and its cost.
struct Drive<'a, M> {
    method: &'a M,
    progress: Progress,
    updates: u64,
    wall_s: f64,
}

impl<'a, M: Method> Drive<'a, M> {
    fn start(method: &'a M, quiet: bool) -> Self {
        Self { method, progress: Progress::new(quiet), updates: 0, wall_s: 0.0 }
    }

    fn step_zero(&mut self, simulation: &mut Simulation) -> Option<End> {
        let start = Instant::now();
        let is_fresh = simulation.world().resource::<Clock>().is_step_zero();
        let end = simulation.step_zero();
        if is_fresh {
            self.updates = self.method.updates(simulation.world(), self.updates);
        }
        self.wall_s += start.elapsed().as_secs_f64();
        end
    }

    fn until_the_end(mut self, simulation: &mut Simulation) -> (End, Cost) {
        let start = Instant::now();
        let Self { method, progress, updates, .. } = &mut self;
        let end = simulation.advance_to_end(|world| {
            *updates = method.updates(world, *updates);
            progress.look(*updates, |pace| method.line(world, pace));
        });
        self.wall_s += start.elapsed().as_secs_f64();
        self.progress.finish();
        (end, Cost { wall_s: self.wall_s, particle_steps: self.updates })
    }
}
