//! `siloflow run`: steps a scene to its end and writes the run directory.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::behaviour::Registry;
use crate::cli::exit_status::Verdict;
use crate::cli::run_path::{Call, Report, carry_out};
use crate::cli::signals::Signals;
use crate::cli::{SceneArgs, say};
use crate::fault::Fault;
use crate::scene::load::AnyScene;

/// Arguments of `run`.
#[derive(Args, Debug)]
pub(super) struct RunArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// The run directory. Default: out/<scene name>.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace an earlier run in the run directory.
    #[arg(long)]
    force: bool,
    /// Number of threads. The result does not depend on it, to the last bit.
    #[arg(long, value_name = "N", default_value = "1")]
    pub(super) threads: NonZeroUsize,
    /// Latest end: simulated time in s (lattice gas: step). Short for `--set until=T`.
    #[arg(long, value_name = "T")]
    until: Option<f64>,
    /// Write PNGs beside the SVG snapshots. Short for `--set pictures.png=true`.
    #[arg(long)]
    png: bool,
    /// Print the summary as JSON instead of in words.
    #[arg(long)]
    pub(super) json: bool,
}

pub(super) fn run(args: &RunArgs, registry: &Registry, quiet: bool) -> Result<Verdict, Fault> {
    let mut scene = args.load()?;
    let path = args.out.clone().map_or_else(|| default_directory(&scene), Ok)?;
    let signals = Signals::catch();
    let call = Call { registry, threads: args.threads, quiet, force: args.force, signals: &signals };
    let report = run_into(&path, &mut scene, &call)?;
    if args.json {
        say(&report.json);
    } else if !quiet {
        say(&report.words);
    }
    Ok(report.verdict)
}

impl RunArgs {
    /// Loads the scene, with the settings that the short options stand for.
    fn load(&self) -> Result<AnyScene, Fault> {
        let mut more: Vec<_> = self.until.map(|until| ("until".to_owned(), until.to_string())).into_iter().collect();
        if self.png {
            // If `pictures` is missing or `None`, the whole section is added.
            let has_section = self.scene.load()?.source().value_of("pictures").is_some_and(|value| value != "None");
            let (key, value) = if has_section { ("pictures.png", "true") } else { ("pictures", "(png: true)") };
            more.push((key.to_owned(), value.to_owned()));
        }
        self.scene.load_with(&more)
    }
}

/// Steps a scene to its end and writes the run directory at `path`. Afterwards the scene's own list of grains is empty.
pub(super) fn run_into(path: &Path, scene: &mut AnyScene, call: &Call) -> Result<Report, Fault> {
    match scene {
        AnyScene::Grains(loaded) => carry_out(&mut **loaded, path, call),
        AnyScene::Lattice(loaded) => carry_out(&mut **loaded, path, call),
    }
}

/// The default run directory of a scene.
pub(super) fn default_directory(scene: &AnyScene) -> Result<PathBuf, Fault> {
    let name = &scene.source().name;
    // A scene file `...ron` has the name `..`.
    if matches!(name.as_str(), "." | "..") {
        return Err(Fault::new("run::directory", format!("the scene's name, {name}, is no name of a directory"))
            .help("rename the scene file, or give a directory with --out"));
    }
    Ok(PathBuf::from("out").join(name))
}
