//! `siloflow run` for a scene of grains.

use std::fmt::Write as _;
use std::marker::PhantomData;
use std::num::NonZeroUsize;
use std::path::Path;
use std::time::Instant;

use bevy_ecs::prelude::*;

use crate::assembly::Assembly;
use crate::behaviour::Registry;
use crate::cli::progress::{Pace, Progress};
use crate::cli::run::{Report, unwritable};
use crate::fault::Fault;
use crate::grains::file;
use crate::ledger::Ledger;
use crate::outcome::End;
use crate::output::flow::FlowPlugin;
use crate::output::frames::{FrameRenderer, FramesPlugin};
use crate::output::profiles::ProfilesPlugin;
use crate::output::run_directory::RunDirectory;
use crate::output::series::SeriesPlugin;
use crate::output::summary::{Cost, Energy, Summary, movable_grains};
use crate::output::walls::WallForcesPlugin;
use crate::scene::TimeStep;
use crate::scene::check::step::{Automatic, automatic};
use crate::scene::check::{self, Estimates};
use crate::scene::load::Loaded;
use crate::simulation::Simulation;
use crate::space::{Dimension, Plane, Solid, Space};
use crate::step::Clock;
use crate::store::ParticleStore;

pub(super) fn run_into(
    path: &Path,
    loaded: &mut Loaded,
    registry: &Registry,
    threads: NonZeroUsize,
    quiet: bool,
) -> Result<Report, Fault> {
    for warning in check::warnings(loaded) {
        tracing::warn!("{warning}");
    }
    if let (TimeStep::Auto { error }, Some(estimates)) = (loaded.scene.step, Estimates::of(loaded)) {
        let Automatic { dt, reason } = automatic(&estimates, error.get());
        tracing::info!("step {dt:.1e} s: {reason}");
    }
    // Everything that can be wrong with the input is found before the first file is written.
    Simulation::check(loaded, registry)?;
    let directory = RunDirectory::prepare(path, &loaded.source)?;
    let mut simulation = build(loaded, registry, threads, &directory)?;
    // They are in the world now.
    loaded.grains = Vec::new();
    let (end, cost) = drive(&mut simulation, loaded, quiet);
    let world = simulation.world_mut();
    let summary = Summary::of(world, loaded, &end, cost);
    let written = match loaded.scene.space {
        Dimension::Plane => directory.finish(|state| file::write_to::<Plane>(world, state), &summary),
        Dimension::Solid => directory.finish(|state| file::write_to::<Solid>(world, state), &summary),
    };
    written.map_err(|error| unwritable(&directory, &error))?;
    if let Some(failure) = &summary.failure {
        tracing::error!("{failure}");
    }
    Ok(Report::new(words(&summary, &directory), &summary, summary.is_done()))
}

fn build(
    loaded: &Loaded,
    registry: &Registry,
    threads: NonZeroUsize,
    directory: &RunDirectory,
) -> Result<Simulation, Fault> {
    match loaded.scene.space {
        Dimension::Plane => build_in::<Plane>(loaded, registry, threads, directory),
        Dimension::Solid => build_in::<Solid>(loaded, registry, threads, directory),
    }
}

fn build_in<V: Space>(
    loaded: &Loaded,
    registry: &Registry,
    threads: NonZeroUsize,
    directory: &RunDirectory,
) -> Result<Simulation, Fault> {
    let outputs = Outputs::<V>::create(loaded, directory).map_err(|error| unwritable(directory, &error))?;
    let more = Box::new(|app: &mut Assembly<'_>| {
        app.add("series", outputs.series);
        if let Some(walls) = outputs.walls {
            app.add("walls", walls);
        }
        if let Some(profiles) = outputs.profiles {
            app.add("profiles", profiles);
        }
        if let Some(flow) = outputs.flow {
            app.add("flow", flow);
        }
        if let Some(frames) = FrameRenderer::of(loaded, directory.frames()) {
            app.add("pictures", FramesPlugin::<V>(frames, PhantomData));
        }
    });
    Simulation::with(loaded, registry, threads, more)
}

/// The files that grow while a scene runs.
struct Outputs<V: Space> {
    series: SeriesPlugin<V>,
    walls: Option<WallForcesPlugin<V>>,
    profiles: Option<ProfilesPlugin<V>>,
    flow: Option<FlowPlugin>,
}

impl<V: Space> Outputs<V> {
    fn create(loaded: &Loaded, directory: &RunDirectory) -> std::io::Result<Self> {
        let has_walls = !loaded.surfaces::<V>().is_empty();
        let profiles = loaded.profiles();
        let species = u8::try_from(loaded.largest_species()).unwrap_or(u8::MAX);
        Ok(Self {
            series: SeriesPlugin::create(loaded.scene.series, loaded.scene.energy_balance, &directory.series())?,
            walls: if has_walls { Some(WallForcesPlugin::create(&directory.walls())?) } else { None },
            profiles: if profiles.is_empty() {
                None
            } else {
                Some(ProfilesPlugin::create(&profiles, species, &directory.profiles(), &directory.centres())?)
            },
            flow: loaded.scene.flow.map(|flow| FlowPlugin::create(flow, &directory.flow())).transpose()?,
        })
    }
}

/// Steps to the end, with progress.
fn drive(simulation: &mut Simulation, loaded: &Loaded, quiet: bool) -> (End, Cost) {
    let mut progress = Progress::new(quiet);
    let mut cost = Cost::default();
    let start = Instant::now();
    let until = loaded.scene.until.get();
    let end = simulation.advance_to_end(|world| {
        cost.particle_steps += movable_grains(world) as u64;
        progress.look(cost.particle_steps, |pace| line(world, until, pace));
    });
    cost.wall_s = start.elapsed().as_secs_f64();
    progress.finish();
    (end, cost)
}

fn line(world: &World, until: f64, pace: Pace) -> String {
    let (time, ledger) = (world.resource::<Clock>().time(), world.resource::<Ledger>());
    let kinetic = match Dimension::of_world(world) {
        Dimension::Plane => kinetic::<Plane>(world),
        Dimension::Solid => kinetic::<Solid>(world),
    };
    format!(
        "t = {time:.2} s of at most {until} s | {:.1} M particle-steps/s | at most {:.0} s to go | inside {}, out {}, \
         lost {} | kinetic {kinetic:.3e} J",
        pace.millions_per_s,
        pace.left(time, until - time),
        ledger.inside(),
        ledger.out(),
        ledger.lost()
    )
}

/// Kinetic energy of translation, J; by velocities that may be half a step old.
fn kinetic<V: Space>(world: &World) -> f64 {
    let columns = world.resource::<ParticleStore<V>>();
    (0..columns.movable_end).map(|i| columns.kinetic_energy(i)).sum()
}

fn words(summary: &Summary, directory: &RunDirectory) -> String {
    let grains = &summary.grains;
    let performance = &summary.performance;
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{name:<12} {value}");
    };
    line(&summary.scene, format!("{}, {} steps, {:.3} s simulated", summary.status, summary.steps, summary.time_s));
    line(
        "grains",
        format!("{} released, {} inside, {} out, {} lost", grains.released, grains.inside, grains.out, grains.lost),
    );
    let moments =
        [("at rest", summary.rest_time_s), ("door opened", summary.door_open_time_s), ("empty", summary.empty_time_s)];
    for (name, time) in moments {
        if let Some(time) = time {
            line(name, format!("{time:.3} s"));
        }
    }
    if let Some(bed) = summary.bed {
        line("bed", format!("height {:.3} m, packing fraction {:.4}", bed.fill_height_m, bed.packing_fraction));
    }
    if let Some(flow) = summary.discharge {
        line("discharge", format!("{:.2} s, {:.1} grains/s from 10 to 90 % out", flow.duration_s, flow.rate_per_s));
    }
    line("overlap", format!("largest {:.4} of the radius", summary.max_overlap_ratio));
    if let Energy { flows: Some(flows), balance_error: Some(error), .. } = &summary.energy {
        line("energy", format!("{:.3e} J dissipated, balance error {error:.3e} J", flows.dissipated));
    }
    line("contacts", format!("{:.3} a grain at the end", summary.coordination));
    let nanoseconds = 1e9 / performance.particle_steps_per_s;
    line(
        "wall clock",
        format!("{:.2} s, {nanoseconds:.1} ns a particle-step, threads: {}", performance.wall_s, performance.threads),
    );
    line("state hash", summary.state_hash.clone());
    line("written to", directory.path().display().to_string());
    text
}
