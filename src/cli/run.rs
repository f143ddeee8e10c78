//! `siloflow run`: steps a scene to its end and writes the run directory.

use std::fmt::Write as _;
use std::marker::PhantomData;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use crate::behaviour::Registry;
use crate::check;
use crate::cli::progress::Progress;
use crate::cli::{SceneArgs, Verdict, say};
use crate::fault::Fault;
use crate::outcome::End;
use crate::output::flow::FlowPlugin;
use crate::output::frames::{FramesPlugin, Studio};
use crate::output::profiles::ProfilesPlugin;
use crate::output::run_directory::RunDirectory;
use crate::output::series::SeriesPlugin;
use crate::output::summary::{Cost, Energy, Summary, movable_grains};
use crate::output::walls::WallForcesPlugin;
use crate::scene::load::Loaded;
use crate::simulation::Simulation;
use crate::space::{Dimension, Plane, Solid, Space};

/// Arguments of `run`.
#[derive(Args, Debug)]
pub(super) struct RunArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// The run directory. Default: out/<scene name>.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Threads of the force pass. The result does not depend on it, to the last bit.
    #[arg(long, value_name = "N", default_value = "1")]
    threads: NonZeroUsize,
    /// End at this simulated time, s, at the latest: short for `--set until=T`.
    #[arg(long, value_name = "T")]
    until: Option<f64>,
    /// Write PNGs beside the SVG snapshots: short for `--set pictures.png=true`.
    #[arg(long)]
    png: bool,
    /// Print the summary as JSON instead of in words.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &RunArgs, registry: &Registry, quiet: bool) -> Result<Verdict, Fault> {
    let mut scene = SceneArgs { scene: args.scene.scene.clone(), set: args.scene.set.clone(), seed: args.scene.seed };
    scene.set.extend(args.until.map(|until| ("until".to_owned(), format!("{until:?}"))));
    if args.png {
        scene.set.extend(pictures_with_png(&args.scene)?);
    }
    let loaded = scene.load()?;
    let path = args.out.clone().unwrap_or_else(|| default_directory(&loaded));
    let (summary, directory) = run_into(&path, &loaded, registry, args.threads, quiet)?;
    report(&summary, args, &directory);
    Ok(if summary.is_done() { Verdict::Done } else { Verdict::SimulationFailed })
}

/// Where the run of a scene goes if nobody says otherwise.
pub(super) fn default_directory(loaded: &Loaded) -> PathBuf {
    PathBuf::from("out").join(&loaded.name)
}

/// Steps a scene to its end and leaves the run directory at `path`. A failure of the simulation is told, and in the summary.
pub(super) fn run_into(
    path: &Path,
    loaded: &Loaded,
    registry: &Registry,
    threads: NonZeroUsize,
    quiet: bool,
) -> Result<(Summary, RunDirectory), Fault> {
    for warning in check::warnings(loaded) {
        tracing::warn!("{warning}");
    }
    // Everything that can be wrong with the input is found before the first file is written.
    Simulation::new(loaded, registry, NonZeroUsize::MIN)?;
    let directory = RunDirectory::prepare(path, loaded)?;
    let mut simulation = build(loaded, registry, threads, &directory)?;
    let (end, cost) = drive(&mut simulation, loaded, quiet);
    let summary = Summary::of(simulation.world_mut(), loaded, &end, cost);
    directory.finish(simulation.world_mut(), &summary).map_err(|error| {
        Fault::new("run::write", format!("could not write the results to {}: {error}", path.display()))
            .help("is there space left?")
    })?;
    if let Some(failure) = &summary.failure {
        tracing::error!("{failure}");
    }
    Ok((summary, directory))
}

/// `pictures: (...)` may be missing from the scene, or `None`: then it is there with the one key.
fn pictures_with_png(scene: &SceneArgs) -> Result<Vec<(String, String)>, Fault> {
    let loaded = scene.load()?;
    let has_section = loaded.scene.pictures.is_some() && loaded.offset_of("pictures").is_some();
    let (key, value) = if has_section { ("pictures.png", "true") } else { ("pictures", "(png: true)") };
    Ok(vec![(key.to_owned(), value.to_owned())])
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
    let outputs = Outputs::<V>::create(loaded, directory).map_err(|error| {
        Fault::new("run::write", format!("could not write to {}: {error}", directory.path().display()))
            .help("is there space, and may you write there?")
    })?;
    Simulation::with(loaded, registry, threads, |app| {
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
        if let Some(studio) = Studio::of(loaded, directory.frames()) {
            app.add("pictures", FramesPlugin::<V>(studio, PhantomData));
        }
    })
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
            series: SeriesPlugin::create(loaded.scene.series, &directory.series())?,
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
    let mut progress = Progress::new(loaded.scene.until.get(), quiet);
    let mut cost = Cost::default();
    let start = Instant::now();
    loop {
        let end = simulation.step();
        cost.particle_steps += movable_grains(simulation.world()) as u64;
        if let Some(end) = end {
            cost.wall_s = start.elapsed().as_secs_f64();
            progress.finish();
            return (end, cost);
        }
        progress.look(simulation.world_mut(), cost.particle_steps);
    }
}

fn report(summary: &Summary, args: &RunArgs, directory: &RunDirectory) {
    if args.json {
        say(&(serde_json::to_string_pretty(summary).unwrap_or_default() + "\n"));
        return;
    }
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
        line("discharge", format!("{:.2} s, {:.1} grains/s", flow.duration_s, flow.rate_per_s));
    }
    line("overlap", format!("largest {:.4} of the radius", summary.max_overlap_ratio));
    let Energy { balance_error, flows, .. } = &summary.energy;
    line("energy", format!("{:.3e} J dissipated, balance error {balance_error:.3e} J", flows.dissipated));
    let nanoseconds = 1e9 / performance.particle_steps_per_s;
    line(
        "wall clock",
        format!("{:.2} s, {nanoseconds:.1} ns a particle-step, threads: {}", performance.wall_s, performance.threads),
    );
    line("state hash", summary.state_hash.clone());
    line("written to", directory.path().display().to_string());
    say(&text);
}
