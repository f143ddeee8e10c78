//! `siloflow run` for a scene of the lattice gas.

use std::fmt::Write as _;
use std::num::NonZeroUsize;
use std::path::Path;
use std::time::Instant;

use crate::assembly::Assembly;
use crate::behaviour::Registry;
use crate::cli::progress::{Pace, Progress};
use crate::cli::run::{Report, unwritable};
use crate::fault::Fault;
use crate::lattice::check;
use crate::lattice::flow::FlowPlugin;
use crate::lattice::gas::Gas;
use crate::lattice::load::LoadedLattice;
use crate::lattice::pictures::PicturesPlugin;
use crate::lattice::series::SeriesPlugin;
use crate::lattice::sites::Sites;
use crate::lattice::summary::{Summary, write_state};
use crate::outcome::End;
use crate::output::run_directory::RunDirectory;
use crate::simulation::Simulation;
use crate::step::Clock;

pub(super) fn run_into(
    path: &Path,
    loaded: &LoadedLattice,
    registry: &Registry,
    threads: NonZeroUsize,
    quiet: bool,
) -> Result<Report, Fault> {
    for warning in check::warnings(loaded) {
        tracing::warn!("{warning}");
    }
    // All errors of the input are found before the first file is written.
    Simulation::of_lattice(loaded, registry, NonZeroUsize::MIN)?;
    let directory = RunDirectory::prepare(path, &loaded.source)?;
    let mut simulation = build(loaded, registry, threads, &directory)?;
    let start = Instant::now();
    let end = drive(&mut simulation, loaded, quiet);
    let world = simulation.world();
    let summary = Summary::of(world, loaded, &end, start.elapsed().as_secs_f64());
    let (sites, gas) = (world.resource::<Sites>(), world.resource::<Gas>());
    let written = directory.finish(|file| write_state(sites, gas, file), &summary);
    written.map_err(|error| unwritable(&directory, &error))?;
    if let Some(failure) = &summary.failure {
        tracing::error!("{failure}");
    }
    Ok(Report::new(words(&summary, &directory), &summary, summary.failure.is_none()))
}

fn build(
    loaded: &LoadedLattice,
    registry: &Registry,
    threads: NonZeroUsize,
    directory: &RunDirectory,
) -> Result<Simulation, Fault> {
    let outputs = || -> std::io::Result<_> {
        let series = SeriesPlugin::create(loaded.scene.series, &directory.series())?;
        let flow = loaded.scene.flow.map(|flow| FlowPlugin::create(flow, &directory.flow())).transpose()?;
        Ok((series, flow))
    };
    let (series, flow) = outputs().map_err(|error| unwritable(directory, &error))?;
    let more = Box::new(|app: &mut Assembly<'_>| {
        app.add("series", series);
        if let Some(flow) = flow {
            app.add("flow", flow);
        }
        if let Some(pictures) = PicturesPlugin::of(loaded, directory.frames()) {
            app.add("pictures", pictures);
        }
    });
    Simulation::of_lattice_with(loaded, registry, threads, more)
}

/// Steps to the end and shows progress.
fn drive(simulation: &mut Simulation, loaded: &LoadedLattice, quiet: bool) -> End {
    let mut progress = Progress::new(quiet);
    let until = loaded.scene.until;
    let end = simulation.advance_to_end(|world| {
        let (clock, sites) = (world.resource::<Clock>(), world.resource::<Sites>());
        let updates = clock.steps * sites.fluid_count() as u64;
        progress.look(updates, |pace| line(clock, world.resource::<Gas>(), until, pace));
    });
    progress.finish();
    end
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

fn words(summary: &Summary, directory: &RunDirectory) -> String {
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{name:<12} {value}");
    };
    let (particles, performance) = (&summary.particles, &summary.performance);
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
    line("written to", directory.path().display().to_string());
    text
}
