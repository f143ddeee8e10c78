//! `siloflow run`: steps a scene to its end and writes the run directory.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use crate::behaviour::Registry;
use crate::cli::{SceneArgs, Verdict, run_grains, run_lattice, say};
use crate::fault::Fault;
use crate::output::run_directory::RunDirectory;
use crate::scene::load::AnyScene;

/// Arguments of `run`.
#[derive(Args, Debug)]
pub(super) struct RunArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// The run directory. Default: out/<scene name>.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Threads. The result does not depend on it, to the last bit.
    #[arg(long, value_name = "N", default_value = "1")]
    pub(super) threads: NonZeroUsize,
    /// End at this simulated time, s (of a lattice gas: at this step), at the latest: short for `--set until=T`.
    #[arg(long, value_name = "T")]
    until: Option<f64>,
    /// Write PNGs beside the SVG snapshots: short for `--set pictures.png=true`.
    #[arg(long)]
    png: bool,
    /// Print the summary as JSON instead of in words.
    #[arg(long)]
    pub(super) json: bool,
}

pub(super) fn run(args: &RunArgs, registry: &Registry, quiet: bool) -> Result<Verdict, Fault> {
    let mut scene = args.load()?;
    let path = args.out.clone().unwrap_or_else(|| default_directory(&scene));
    let report = run_into(&path, &mut scene, registry, args.threads, quiet)?;
    if args.json {
        say(&report.json);
    } else if !quiet {
        say(&report.words);
    }
    Ok(if report.is_done { Verdict::Done } else { Verdict::SimulationFailed })
}

impl RunArgs {
    /// The scene, with what the short options stand for.
    fn load(&self) -> Result<AnyScene, Fault> {
        let mut more: Vec<_> = self.until.map(|until| ("until".to_owned(), until.to_string())).into_iter().collect();
        if self.png {
            // `pictures: (...)` may be missing from the scene, or `None`: then it is there with the one key.
            let has_section = self.scene.load()?.source().value_of("pictures").is_some_and(|value| value != "None");
            let (key, value) = if has_section { ("pictures.png", "true") } else { ("pictures", "(png: true)") };
            more.push((key.to_owned(), value.to_owned()));
        }
        self.scene.load_with(&more)
    }
}

/// Steps a scene to its end and leaves the run directory at `path`. A failure of the simulation is told, and in the summary.
/// The scene's own list of grains is empty afterwards.
pub(super) fn run_into(
    path: &Path,
    scene: &mut AnyScene,
    registry: &Registry,
    threads: NonZeroUsize,
    quiet: bool,
) -> Result<Report, Fault> {
    match scene {
        AnyScene::Grains(loaded) => run_grains::run_into(path, loaded, registry, threads, quiet),
        AnyScene::Lattice(loaded) => run_lattice::run_into(path, loaded, registry, threads, quiet),
    }
}

/// Where the run of a scene goes if nobody says otherwise.
pub(super) fn default_directory(scene: &AnyScene) -> PathBuf {
    PathBuf::from("out").join(&scene.source().name)
}

/// What a run came to.
pub(super) struct Report {
    /// For people.
    pub words: String,
    /// The summary, for programs.
    pub json: String,
    /// Whether the run did what it was asked to.
    pub is_done: bool,
}

impl Report {
    pub(super) fn new(words: String, summary: &impl Serialize, is_done: bool) -> Self {
        Self { words, json: serde_json::to_string_pretty(summary).unwrap_or_default() + "\n", is_done }
    }
}

/// What is wrong if a run directory cannot be written.
pub(super) fn unwritable(directory: &RunDirectory, error: &std::io::Error) -> Fault {
    Fault::new("run::write", format!("could not write to {}: {error}", directory.path().display()))
        .help("is there space, and may you write there?")
}
