//! `siloflow run` for a scene of the lattice gas.

use std::io::{self, Write};
use std::num::NonZeroUsize;

use bevy_ecs::prelude::*;

use crate::assembly::Assembly;
use crate::behaviour::Registry;
use crate::cli::progress::Pace;
use crate::cli::run_path::runnable::{RunOptions, RunnableScene};
use crate::cli::run_path::words::SummaryWords;
use crate::lattice_silo::check;
use crate::lattice_silo::loaded::LoadedLattice;
use crate::lattice_silo::pictures::{PictureSettings, PicturesPlugin};
use crate::lattice_silo::series::SeriesPlugin;
use crate::output::flow::FlowPlugin;
use crate::output::flow::lattice::FlowOfLattice;
use crate::output::summary::lattice::{LatticeResults, site_updates, write_state};
use crate::output::summary::{Cost, Summary};
use crate::scene::expected::Work;
use crate::simulation::{Additions, Simulation};
use crate::writers::provenance::Provenance;
use siloflow_dem::outcome::End;
use siloflow_dem::persist::{CheckpointConfig, Section, UnknownState};
use siloflow_dem::step::Clock;
use siloflow_files::run_directory::{RunDirectory, names};
use siloflow_lattice::gas::Gas;
use siloflow_lattice::sites::Sites;
use siloflow_text::fault::Fault;
use siloflow_text::source::Source;

impl RunnableScene for LoadedLattice {
    type Results = LatticeResults;

    fn source(&self) -> &Source {
        &self.source
    }

    fn check(&self, registry: &Registry) -> Result<(), Fault> {
        for warning in check::warnings(self) {
            tracing::warn!("{warning}");
        }
        Work::of_lattice(self.scene.until, self.sites.fluid_count()).tell();
        Simulation::of_lattice(self, registry, NonZeroUsize::MIN).map(|_| ())
    }

    fn add_outputs(&self, app: &mut Assembly, directory: &RunDirectory, _: &RunOptions) -> Result<(), Fault> {
        let unwritable = |error: io::Error| directory.unwritable(&error);
        let rows = directory.rows(names::SERIES);
        app.add("series", SeriesPlugin::create(self.scene.series, app.world(), &rows).map_err(unwritable)?);
        if let Some(flow) = self.scene.flow {
            let rows = directory.rows(names::FLOW);
            app.add("flow", FlowPlugin::<FlowOfLattice>::create(flow, &rows).map_err(unwritable)?);
        }
        if let Some(pictures) = self.scene.pictures.clone() {
            let title = if self.scene.title.is_empty() { &self.source.name } else { &self.scene.title };
            let settings = PictureSettings {
                pictures,
                title: title.clone(),
                view: self.view(),
                door: self.scene.door.map(|door| (door.from.get(), door.to.get())),
            };
            app.add("pictures", PicturesPlugin { settings, directory: directory.frames() });
        }
        Ok(())
    }

    fn simulation(
        &self,
        options: &RunOptions,
        more: Additions,
        saved: Option<(&[Section], UnknownState)>,
    ) -> Result<Simulation, Fault> {
        Simulation::of_lattice_with(self, options.registry, options.threads, more, saved)
    }

    fn forget_start(&mut self) {}

    fn checkpoint(&self) -> Option<CheckpointConfig> {
        self.scene.checkpoint
    }

    fn updates(&self, world: &World, _: u64) -> u64 {
        site_updates(world)
    }

    fn line(&self, world: &World, pace: Pace) -> String {
        line(world.resource::<Clock>(), world.resource::<Gas>(), self.scene.until, pace)
    }

    fn summary(&self, world: &mut World, end: &End, cost: Cost, provenance: Provenance) -> Summary<LatticeResults> {
        Summary::of_lattice(world, self, end, cost.wall_s, Some(provenance))
    }

    fn describe(&self, summary: &Summary<LatticeResults>, words: &mut SummaryWords) {
        describe(summary, words);
    }

    fn write_state(&self, world: &mut World, file: &mut dyn Write) -> io::Result<()> {
        write_state(world.resource::<Sites>(), world.resource::<Gas>(), file)
    }
}

#[expect(clippy::cast_precision_loss, reason = "figures for people")]
fn line(clock: &Clock, gas: &Gas, until: u64, pace: Pace) -> String {
    format!(
        "step {} of at most {until} | {:.1} M site updates/s | at most {:.0} s to go | inside {}, out {}",
        clock.steps,
        pace.millions_per_s,
        pace.left(clock.time(), until.saturating_sub(clock.steps) as f64),
        gas.inside(),
        gas.out()
    )
}

fn describe(summary: &Summary<LatticeResults>, words: &mut SummaryWords) {
    let head = &summary.head;
    let results = &summary.results;
    let particles = &results.particles;
    let performance = &results.performance;
    words.line(&head.scene, format!("{}, {} steps of {} sites", head.status, head.steps, results.sites));
    words.line(
        "particles",
        format!("{} entered, {} inside, {} out", particles.entered, particles.inside, particles.out),
    );
    let moments =
        [("at rest", results.rest_step), ("door opened", results.door_open_step), ("empty", results.empty_step)];
    words.moments(moments, |step| format!("step {step}"));
    let speed = performance.site_updates_per_s / 1e6;
    words.line(
        "wall clock",
        format!("{:.2} s, {speed:.1} M site updates/s, threads: {}", performance.wall_s, performance.threads),
    );
    words.line("state hash", &results.state_hash);
}
