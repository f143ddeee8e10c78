//! A scene that can be run: the parts of a run in which grains and the lattice gas differ.

use std::io::{self, Write};
use std::num::NonZeroUsize;

use bevy_ecs::prelude::*;

use super::words::SummaryWords;
use crate::assembly::Assembly;
use crate::behaviour::Registry;
use crate::cli::exit_status::ExitStatus;
use crate::cli::progress::Pace;
use crate::cli::signals::Signals;
use crate::output::parent::Parent;
use crate::output::summary::{Cost, Results, Summary};
use crate::simulation::{Additions, Simulation};
use crate::writers::provenance::Provenance;
use siloflow_dem::outcome::End;
use siloflow_dem::persist::{CheckpointConfig, Section, UnknownState};
use siloflow_dem::values::NonNegative;
use siloflow_files::run_directory::RunDirectory;
use siloflow_text::fault::Fault;
use siloflow_text::source::Source;

/// Settings of a run that do not change its result.
pub(in crate::cli) struct RunOptions<'a> {
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
pub(in crate::cli) trait RunnableScene: Sync {
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
    /// Adds the summary in words, without the place of the files.
    fn describe(&self, summary: &Summary<Self::Results>, words: &mut SummaryWords);
    fn write_state(&self, world: &mut World, file: &mut dyn Write) -> io::Result<()>;
}

/// The result of a run.
pub(in crate::cli) struct RunResult {
    /// The summary in words.
    pub words: String,
    /// The summary as JSON.
    pub json: String,
    pub exit_status: ExitStatus,
}
