//! `siloflow run`: steps a scene to its end and writes the run directory.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};

use crate::behaviour::Registry;
use crate::cli::exit_status::ExitStatus;
use crate::cli::from::Origin;
use crate::cli::run_path::runnable::{RunOptions, RunResult};
use crate::cli::run_path::{resume_from, run_from_start};
use crate::cli::signals::Signals;
use crate::cli::{SceneArgs, say};
use crate::output::checkpoint::find;
use crate::scene::load;
use crate::scene::loaded::AnyScene;
use siloflow_dem::values::NonNegative;
use siloflow_files::run_directory::{RunDirectory, scene_of};
use siloflow_text::fault::Fault;

/// Arguments of `run`.
#[derive(Args, Debug)]
#[expect(clippy::struct_excessive_bools, reason = "options of a command")]
#[command(group(ArgGroup::new("start").required(true).args(["scene", "resume"])))]
pub(super) struct RunArgs {
    #[command(flatten)]
    scene: Option<SceneArgs>,
    /// Continue the interrupted run in this directory from its latest checkpoint, to the bits of a run without
    /// interruption.
    #[arg(long, value_name = "DIR", conflicts_with_all = ["set", "seed", "from", "out", "force", "until", "png"])]
    resume: Option<PathBuf>,
    /// With --resume: go on although files of the run are missing or have changed. What is left of them is kept as NAME.damaged.
    #[arg(long, requires = "resume")]
    accept_damage: bool,
    /// Start with the grains and contacts of the run in this directory, instead of the scene's own grains at the start.
    #[arg(long, value_name = "DIR")]
    from: Option<PathBuf>,
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
    /// Wall-clock time between checkpoints, minutes. Default: `checkpoint.every` of the scene, or else 10.
    #[arg(long, value_name = "MINUTES", value_parser = minutes)]
    checkpoint_every: Option<NonNegative>,
    /// Write a report, report.html in the run directory, at the end of the run. `siloflow report` writes it later.
    #[arg(long)]
    report: bool,
    /// Print the summary as JSON instead of in words.
    #[arg(long)]
    pub(super) json: bool,
}

fn minutes(text: &str) -> Result<NonNegative, String> {
    let number: f64 = text.parse().map_err(|_| "expected a number of minutes, for example 30")?;
    NonNegative::try_from(number)
}

pub(super) fn run(args: &RunArgs, registry: &Registry, quiet: bool) -> Result<ExitStatus, Fault> {
    let signals = Signals::catch();
    let RunArgs { threads, force, checkpoint_every, report, .. } = *args;
    let origin = args.from.as_ref().map(|run| Origin::of(run, registry)).transpose()?;
    let parent = origin.as_ref().map(|origin| origin.parent.clone());
    let options = RunOptions { registry, threads, quiet, force, signals: &signals, checkpoint_every, parent, report };
    let result = match (&args.resume, &args.scene) {
        (Some(directory), _) => resume(directory, args.accept_damage, &options)?,
        (None, Some(scene)) => {
            let mut scene = args.load(scene, origin)?;
            let path = args.out.clone().map_or_else(|| default_directory(&scene), Ok)?;
            run_scene(&path, &mut scene, &options)?
        }
        // The command line asks for one of them.
        (None, None) => return Err(Fault::new("call::scene", "no scene is given").help("siloflow run SCENE.ron")),
    };
    if args.json {
        say(&result.json);
    } else if !quiet {
        say(&result.words);
    }
    Ok(result.exit_status)
}

/// Continues the run in a directory from its latest checkpoint.
pub(super) fn resume(path: &Path, accepts_damage: bool, options: &RunOptions) -> Result<RunResult, Fault> {
    let directory = RunDirectory::reopen(path)?;
    let found = find::latest(path)?;
    let header = found.header().clone();
    if header.is_final {
        return Err(Fault::new("checkpoint::final", format!("the run in {} is over", path.display()))
            .help("start a new one from its state with `siloflow run SCENE --from DIR`"));
    }
    tracing::info!("continuing after step {}, t = {:.6}", header.steps, header.time);
    let mut scene = load::named(&scene_of(path), &header.scene)?;
    let checkpoint = found.read(&scene)?;
    directory.continue_from(header.files, header.steps, accepts_damage)?;
    match &mut scene {
        AnyScene::Grains(loaded) => resume_from(&mut **loaded, &directory, &checkpoint, options),
        AnyScene::Lattice(loaded) => resume_from(&mut **loaded, &directory, &checkpoint, options),
    }
}

impl RunArgs {
    /// Loads the scene, with the settings that the short options stand for.
    fn load(&self, scene: &SceneArgs, origin: Option<Origin>) -> Result<AnyScene, Fault> {
        let mut more: Vec<_> = self.until.map(|until| ("until".to_owned(), until.to_string())).into_iter().collect();
        if self.png {
            // If `pictures` is missing or `None`, the whole section is added.
            let has_section = scene.load()?.source().value_of("pictures").is_some_and(|value| value != "None");
            let (key, value) = if has_section { ("pictures.png", "true") } else { ("pictures", "(png: true)") };
            more.push((key.to_owned(), value.to_owned()));
        }
        match origin {
            Some(origin) => origin.load(&scene.scene, &scene.settings(&more)).map(AnyScene::Grains),
            None => scene.load_with(&more),
        }
    }
}

/// Steps a scene to its end and writes the run directory at `path`. Afterwards the scene's own list of grains is empty.
pub(super) fn run_scene(path: &Path, scene: &mut AnyScene, options: &RunOptions) -> Result<RunResult, Fault> {
    match scene {
        AnyScene::Grains(loaded) => run_from_start(&mut **loaded, path, options),
        AnyScene::Lattice(loaded) => run_from_start(&mut **loaded, path, options),
    }
}

/// The default run directory of a scene.
pub(super) fn default_directory(scene: &AnyScene) -> Result<PathBuf, Fault> {
    directory_named(&scene.source().name)
}

/// The default directory of the results of a scene or a sweep of this name.
pub(super) fn directory_named(name: &str) -> Result<PathBuf, Fault> {
    // A file `...ron` has the name `..`.
    if matches!(name, "." | "..") {
        return Err(Fault::new("run::directory", format!("the file's name, {name}, is no name of a directory"))
            .help("rename the file, or give a directory with --out"));
    }
    Ok(PathBuf::from("out").join(name))
}
