//! `siloflow run` for a scene of the lattice gas.

use std::fmt::Write as _;
use std::io::{self, Write};
use std::num::NonZeroUsize;

use bevy_ecs::prelude::*;

use crate::assembly::Assembly;
use crate::behaviour::Registry;
use crate::cli::progress::Pace;
use crate::cli::run_grains::declare_files;
use crate::cli::run_path::{Call, Method, Outline};
use crate::lattice_silo::check;
use crate::lattice_silo::flow::FlowPlugin;
use crate::lattice_silo::load::LoadedLattice;
use crate::lattice_silo::pictures::PicturesPlugin;
use crate::lattice_silo::series::SeriesPlugin;
use crate::lattice_silo::summary::{Summary, write_state};
use crate::output::cost::CostPlugin;
use crate::output::summary::Cost;
use crate::simulation::Simulation;
use crate::writers::provenance::Provenance;
use siloflow_dem::outcome::End;
use siloflow_dem::persist::{CheckpointConfig, Section, UnknownState};
use siloflow_dem::step::Clock;
use siloflow_files::hashes::SummaryFiles;
use siloflow_files::run_directory::{RunDirectory, names};
use siloflow_files::run_files::Damage;
use siloflow_lattice::gas::Gas;
use siloflow_lattice::sites::Sites;
use siloflow_text::fault::Fault;
use siloflow_text::source::Source;

impl Method for LoadedLattice {
    type Summary = Summary;

    fn source(&self) -> &Source {
        &self.source
    }

    fn check(&self, registry: &Registry) -> Result<(), Fault> {
        for warning in check::warnings(self) {
            tracing::warn!("{warning}");
        }
        Simulation::of_lattice(self, registry, NonZeroUsize::MIN).map(|_| ())
    }

    fn build(&mut self, call: &Call, directory: &RunDirectory, saved: Option<&[Section]>) -> Result<Simulation, Fault> {
        let outputs = |world: &World| -> io::Result<_> {
            let series = SeriesPlugin::create(self.scene.series, world, &directory.rows(names::SERIES))?;
            let flow =
                self.scene.flow.map(|flow| FlowPlugin::create(flow, &directory.rows(names::FLOW))).transpose()?;
            Ok((series, flow))
        };
        let more = Box::new(|app: &mut Assembly<'_>| {
            // The behaviours have registered their columns.
            let (series, flow) = outputs(app.world()).map_err(|error| directory.unwritable(&error))?;
            declare_files(app.world(), directory)?;
            app.provide(directory.resource());
            app.provide(directory.files().clone());
            app.add("always", CostPlugin);
            app.add("series", series);
            if let Some(flow) = flow {
                app.add("flow", flow);
            }
            if let Some(pictures) = PicturesPlugin::of(self, directory.frames()) {
                app.add("pictures", pictures);
            }
            Ok(())
        });
        Simulation::of_lattice_with(
            self,
            call.registry,
            call.threads,
            more,
            saved.map(|saved| (saved, UnknownState::Refuse)),
        )
    }

    fn checkpoint(&self) -> Option<CheckpointConfig> {
        self.scene.checkpoint
    }

    fn updates(&self, world: &World, _: u64) -> u64 {
        world.resource::<Clock>().steps * world.resource::<Sites>().fluid_count() as u64
    }

    fn line(&self, world: &World, pace: Pace) -> String {
        line(world.resource::<Clock>(), world.resource::<Gas>(), self.scene.until, pace)
    }

    fn summary(&self, world: &mut World, end: &End, cost: Cost) -> Summary {
        Summary::of(world, self, end, cost.wall_s)
    }

    fn write_state(&self, world: &mut World, file: &mut dyn Write) -> io::Result<()> {
        write_state(world.resource::<Sites>(), world.resource::<Gas>(), file)
    }
}

impl Outline for Summary {
    fn failure(&self) -> Option<&str> {
        self.failure.as_deref()
    }

    fn fail(&mut self, reason: String) {
        self.status = "failed";
        self.failure.get_or_insert(reason);
    }

    fn record(&mut self, provenance: Provenance) {
        self.provenance = Some(provenance);
    }

    fn record_files(&mut self, files: SummaryFiles, damaged: Vec<Damage>) {
        (self.files, self.damaged) = (Some(files), damaged);
    }

    fn is_done(&self) -> bool {
        self.failure.is_none()
    }

    fn words(&self) -> String {
        words(self)
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

fn words(summary: &Summary) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{name:<12} {value}");
    };
    let particles = &summary.particles;
    let performance = &summary.performance;
    line(&summary.scene, format!("{}, {} steps of {} sites", summary.status, summary.steps, summary.sites));
    line("particles", format!("{} entered, {} inside, {} out", particles.entered, particles.inside, particles.out));
    let moments =
        [("at rest", summary.rest_step), ("door opened", summary.door_open_step), ("empty", summary.empty_step)];
    for (name, step) in moments {
        if let Some(step) = step {
            line(name, format!("step {step}"));
        }
    }
    let speed = performance.site_updates_per_s / 1e6;
    line(
        "wall clock",
        format!("{:.2} s, {speed:.1} M site updates/s, threads: {}", performance.wall_s, performance.threads),
    );
    line("state hash", summary.state_hash.clone());
    text
}
