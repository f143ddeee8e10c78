//! `siloflow run` for a scene of grains.

mod outputs;
mod phase;
mod words;

use std::io::{self, Write};
use std::num::NonZeroUsize;

use bevy_ecs::prelude::*;

use self::outputs::Outputs;
use self::phase::phase;
use crate::assembly::Assembly;
use crate::behaviour::Registry;
use crate::cli::progress::Pace;
use crate::cli::run_path::runnable::{RunOptions, RunnableScene};
use crate::cli::run_path::words::SummaryWords;
use crate::grains::file;
use crate::ledger::Ledger;
use crate::output::parent::ParentPlugin;
use crate::output::summary::grains::{GrainResults, free_grains};
use crate::output::summary::{Cost, Summary};
use crate::scene::TimeStep;
use crate::scene::check::automatic::{Automatic, automatic};
use crate::scene::check::{self, Estimates};
use crate::scene::expected::{self, Work};
use crate::scene::loaded::Loaded;
use crate::simulation::{Additions, Caller, MOST_THREADS, Simulation};
use crate::writers::provenance::Provenance;
use siloflow_dem::neighbours::ROWS_PER_THREAD;
use siloflow_dem::outcome::End;
use siloflow_dem::persist::{CheckpointConfig, Section, UnknownState};
use siloflow_dem::space::{Dimension, Plane, Solid, Space};
use siloflow_dem::step::Clock;
use siloflow_dem::store::ParticleStore;
use siloflow_files::run_directory::RunDirectory;
use siloflow_text::fault::Fault;
use siloflow_text::source::Source;

impl RunnableScene for Loaded {
    type Results = GrainResults;

    fn source(&self) -> &Source {
        &self.source
    }

    fn check(&self, registry: &Registry) -> Result<(), Fault> {
        for warning in check::warnings(self) {
            tracing::warn!("{warning}");
        }
        if let (TimeStep::Auto { error }, Some(estimates)) = (self.scene.step, Estimates::of(self)) {
            let Automatic { dt, reason } = automatic(&estimates, error.get());
            tracing::info!("step {dt:.1e} s: {reason}");
        }
        if let Some(dt) = expected::known_step(self) {
            Work::of_grains(self, dt).tell();
        }
        Simulation::check(self, registry)
    }

    fn add_outputs(&self, app: &mut Assembly, directory: &RunDirectory, options: &RunOptions) -> Result<(), Fault> {
        app.add("always", ParentPlugin(options.parent.clone()));
        match self.scene.space {
            Dimension::Plane => add_outputs::<Plane>(self, app, directory),
            Dimension::Solid => add_outputs::<Solid>(self, app, directory),
        }
    }

    fn simulation(
        &self,
        options: &RunOptions,
        more: Additions,
        saved: Option<(&[Section], UnknownState)>,
    ) -> Result<Simulation, Fault> {
        let threads = useful_threads(self, options.threads);
        Simulation::with(self, options.registry, threads, Caller::CommandLine, more, saved)
    }

    fn forget_start(&mut self) {
        self.grains = Vec::new();
    }

    fn checkpoint(&self) -> Option<CheckpointConfig> {
        self.scene.checkpoint
    }

    fn updates(&self, world: &World, before: u64) -> u64 {
        before + free_grains(world) as u64
    }

    fn line(&self, world: &World, pace: Pace) -> String {
        line(world, self.scene.until.get(), pace)
    }

    fn summary(&self, world: &mut World, end: &End, cost: Cost, provenance: Provenance) -> Summary<GrainResults> {
        Summary::of_grains(world, self, end, cost, Some(provenance))
    }

    fn describe(&self, summary: &Summary<GrainResults>, words: &mut SummaryWords) {
        words::describe(summary, words);
    }

    fn write_state(&self, world: &mut World, file: &mut dyn Write) -> io::Result<()> {
        match self.scene.space {
            Dimension::Plane => file::write_to::<Plane>(world, file),
            Dimension::Solid => file::write_to::<Solid>(world, file),
        }
    }
}

/// Returns how many of the threads asked for have work in this scene, and says if that is fewer. Behaviours may make grains, so a scene with
/// behaviours gets all of them.
fn useful_threads(loaded: &Loaded, wanted: NonZeroUsize) -> NonZeroUsize {
    let spheres = expected::shapes(loaded);
    let most = NonZeroUsize::new(spheres / ROWS_PER_THREAD).unwrap_or(NonZeroUsize::MIN);
    if wanted <= most || wanted.get() > MOST_THREADS || !loaded.scene.behaviours.is_empty() {
        return wanted;
    }
    tracing::info!(
        "{most} of {wanted} threads have work: a thread needs {ROWS_PER_THREAD} discs or spheres, and the scene has {spheres}"
    );
    most
}

fn add_outputs<V: Space>(loaded: &Loaded, app: &mut Assembly, directory: &RunDirectory) -> Result<(), Fault> {
    let outputs = Outputs::<V>::create(loaded, app.world(), directory);
    outputs.map_err(|error| directory.unwritable(&error))?.add_to(app, loaded, directory)
}

fn line(world: &World, until: f64, pace: Pace) -> String {
    let time = world.resource::<Clock>().time();
    let ledger = world.resource::<Ledger>();
    let kinetic = match Dimension::of_world(world) {
        Dimension::Plane => kinetic::<Plane>(world),
        Dimension::Solid => kinetic::<Solid>(world),
    };
    format!(
        "{}t = {time:.2} s of at most {until} s | {:.1} M particle-steps/s | at most {:.0} s to go | inside {}, out {}, \
         lost {} | kinetic {kinetic:.3e} J",
        phase(world),
        pace.millions_per_s,
        pace.left(time, until - time),
        ledger.inside(),
        ledger.out(),
        ledger.lost()
    )
}

/// Kinetic energy of translation, J, from velocities that may be half a step old.
fn kinetic<V: Space>(world: &World) -> f64 {
    let columns = world.resource::<ParticleStore<V>>();
    columns.integrated_rows().map(|i| columns.kinetic_energy(i)).sum()
}
