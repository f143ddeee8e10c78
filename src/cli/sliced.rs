//! The command `run` in slices, for a caller that shows a run while it goes on and lets its user pause it: a web page has one thread.
//!
//! The run directory, its files and the summary are those of `siloflow run`, to the bit, except for times and the machine.

use std::path::Path;
use std::time::{Duration, Instant};

use bevy_ecs::prelude::*;

use crate::behaviour::Registry;
use crate::cli::ONE_THREAD;
use crate::cli::exit_status::ExitStatus;
use crate::cli::run_path::finish::finish;
use crate::cli::run_path::runnable::{RunOptions, RunnableScene};
use crate::cli::run_path::{Prepared, count_updates, prepare};
use crate::cli::signals::Signals;
use crate::scene::loaded::AnyScene;
use crate::simulation::Simulation;
use siloflow_dem::outcome::{End, Outcome};
use siloflow_dem::step::Clock;
use siloflow_text::fault::Fault;

/// Steps between two readings of the wall clock.
const CHUNK: u32 = 8;

/// A run of a scene.
pub struct SlicedRun {
    scene: AnyScene,
    registry: Registry,
    signals: Signals,
    prepared: Prepared,
}

/// The end of a slice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slice {
    /// Its time is over.
    Over,
    /// The condition of the caller holds.
    Reached,
    /// The run has ended.
    Ended,
}

/// The results of a run.
#[derive(Clone, Debug)]
pub struct Finished {
    /// The summary in words.
    pub words: String,
    /// The summary, `summary.json`.
    pub json: String,
    /// Whether the run came to a regular end.
    pub is_done: bool,
}

fn options<'a>(registry: &'a Registry, signals: &'a Signals) -> RunOptions<'a> {
    RunOptions {
        registry,
        threads: ONE_THREAD,
        quiet: true,
        force: false,
        signals,
        parent: None,
        checkpoint_every: None,
        report: false,
    }
}

impl SlicedRun {
    /// Checks a scene, builds its simulation and runs step zero, with the run directory at `path`.
    ///
    /// # Errors
    /// If the scene cannot be run, or its directory cannot be written.
    pub fn start(mut scene: AnyScene, registry: Registry, path: &Path) -> Result<Self, Fault> {
        let signals = Signals::default();
        let options = options(&registry, &signals);
        let prepared = match &mut scene {
            AnyScene::Grains(loaded) => prepare(&mut **loaded, path, &options),
            AnyScene::Lattice(loaded) => prepare(&mut **loaded, path, &options),
        }?;
        // No signal is caught.
        let mut prepared = prepared.ok_or_else(|| Fault::new("run::interrupted", "the run was interrupted"))?;
        prepared.simulation.cost_mut().pause();
        Ok(Self { scene, registry, signals, prepared })
    }

    /// Steps until `is_reached` holds after a step, the wall-clock time `longest` is over, or the run ends; one step at least.
    pub fn advance(&mut self, longest: Duration, is_reached: impl FnMut(&World) -> bool + Send) -> Slice {
        let simulation = &mut self.prepared.simulation;
        match &self.scene {
            AnyScene::Grains(loaded) => advance(&**loaded, simulation, longest, is_reached),
            AnyScene::Lattice(loaded) => advance(&**loaded, simulation, longest, is_reached),
        }
    }

    /// The scene.
    #[must_use]
    pub fn scene(&self) -> &AnyScene {
        &self.scene
    }

    /// The world between two slices, with components that may be out of date.
    #[must_use]
    pub fn present(&self) -> &World {
        self.prepared.simulation.world()
    }

    /// The world between two slices, with all components as they are. It is to be read: numbers of grains that are changed here do not count.
    pub fn world(&mut self) -> &mut World {
        self.prepared.simulation.own_world()
    }

    /// Ends the run, and writes its state and its summary.
    pub fn finish(mut self) -> Finished {
        let end = self.world().resource::<Outcome>().end().cloned().unwrap_or(End::Interrupted);
        let Self { scene, registry, signals, prepared: Prepared { mut simulation, directory } } = self;
        let cost = simulation.cost_mut().cost();
        let options = options(&registry, &signals);
        let result = match &scene {
            AnyScene::Grains(loaded) => finish(&**loaded, &mut simulation, &directory, &end, cost, &options),
            AnyScene::Lattice(loaded) => finish(&**loaded, &mut simulation, &directory, &end, cost, &options),
        };
        Finished { words: result.words, json: result.json, is_done: result.exit_status == ExitStatus::Done }
    }
}

fn advance(
    scene: &impl RunnableScene,
    simulation: &mut Simulation,
    longest: Duration,
    mut is_reached: impl FnMut(&World) -> bool + Send,
) -> Slice {
    simulation.cost_mut().resume();
    let start = Instant::now();
    let mut slice = Slice::Over;
    let mut steps = 0;
    let before = simulation.world().resource::<Clock>().steps;
    let end = simulation.advance_while(|world| {
        if world.resource::<Clock>().steps > before {
            count_updates(scene, world);
        }
        if is_reached(world) {
            slice = Slice::Reached;
            return false;
        }
        steps += 1;
        steps % CHUNK != 0 || start.elapsed() < longest
    });
    simulation.cost_mut().pause();
    if end.is_some() { Slice::Ended } else { slice }
}
