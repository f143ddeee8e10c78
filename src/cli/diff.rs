//! `siloflow diff`: runs two scenes together and reports the first step, grain and quantity in which they differ.
//!
//! Each argument is a run directory, whose `scene.ron` is run again, or a scene. Nothing is written. [`crate::studies::diff`]
//! documents the compared quantities and the limits of the comparison.

use std::fmt::Write as _;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use bevy_ecs::prelude::*;
use clap::Args;
use serde::Serialize;

use crate::behaviour::Registry;
use crate::cli::exit_status::ExitStatus;
use crate::cli::progress::Progress;
use crate::cli::say;
use crate::scene::load;
use crate::scene::loaded::AnyScene;
use crate::simulation::Simulation;
use crate::studies::diff::{Divergence, Pair};
use siloflow_dem::outcome::{End, Outcome};
use siloflow_dem::step::Clock;
use siloflow_files::own_files;
use siloflow_files::run_directory::{self, Depth, refuse_odd};
use siloflow_text::fault::Fault;
use siloflow_text::source::keys::{Change, changes};

/// Arguments of `diff`.
#[derive(Args, Debug)]
#[command(after_help = "\
Both are run in memory from their start by this program, and compared bit by bit after every step. Nothing is written.

Which grain feels a stiffer contact first, and when:
  siloflow run scenes/silo1.ron --until 5
  siloflow run scenes/silo1.ron --until 5 --set contact.k=1.1e4 --out out/stiffer
  siloflow diff out/silo1 out/stiffer

Exit status: 0 the same to the last bit; 1 different; 2 the input or the call was wrong.")]
pub(super) struct DiffArgs {
    /// A run directory, whose scene.ron is run again, or a scene (.ron).
    #[arg(value_name = "RUN_A")]
    first: PathBuf,
    /// The run or scene to compare with the first.
    #[arg(value_name = "RUN_B")]
    second: PathBuf,
    /// Compare until this simulated time, s (lattice gas: until this step). Default: the end of the shorter scene.
    #[arg(long, value_name = "T")]
    until: Option<f64>,
    /// Threads of each run. The result does not depend on their number, to the last bit.
    #[arg(long, value_name = "N", default_value = "1")]
    threads: NonZeroUsize,
    /// Print the result as JSON instead of in words.
    #[arg(long)]
    json: bool,
}

/// The report that `--json` prints.
#[derive(Serialize)]
struct DiffReport {
    same: bool,
    first: String,
    second: String,
    keys: Vec<Change>,
    /// Steps done when the comparison ended.
    steps: u64,
    time_s: f64,
    /// How each run ended, if it has ended.
    end: Option<End>,
    divergence: Option<Divergence>,
}

pub(super) fn diff(args: &DiffArgs, registry: &Registry, quiet: bool) -> Result<ExitStatus, Fault> {
    let mut scenes = [open(&args.first, args.until)?, open(&args.second, args.until)?];
    let until = end_together(&mut scenes);
    let build = |scene: &AnyScene| match scene {
        AnyScene::Grains(loaded) => Simulation::new(loaded, registry, args.threads),
        AnyScene::Lattice(loaded) => Simulation::of_lattice(loaded, registry, args.threads),
    };
    let mut pair = Pair::new(build(&scenes[0])?, build(&scenes[1])?)?;
    let divergence = compare(&mut pair, until, quiet);
    let world = pair.runs()[0].world();
    let clock = world.resource::<Clock>();
    let report = DiffReport {
        same: divergence.is_none(),
        first: args.first.display().to_string(),
        second: args.second.display().to_string(),
        keys: changes(scenes[0].source(), scenes[1].source()),
        steps: clock.steps,
        time_s: clock.time(),
        end: world.resource::<Outcome>().end().cloned().filter(|_| divergence.is_none()),
        divergence,
    };
    say(&if args.json { serde_json::to_string_pretty(&report).unwrap_or_default() + "\n" } else { words(&report) });
    Ok(if report.same { ExitStatus::Done } else { ExitStatus::Different })
}

/// The scene of a run directory, or at a path.
fn open(path: &Path, until: Option<f64>) -> Result<AnyScene, Fault> {
    let settings: Vec<_> = until.map(|until| ("until".to_owned(), until.to_string())).into_iter().collect();
    if !path.exists() {
        return Err(Fault::new("diff::missing", format!("there is no {}", path.display())).help(
            "give a run directory such as out/silo1, which `siloflow run` makes, or a scene such as scenes/silo1.ron",
        ));
    }
    if !path.is_dir() {
        return load::any(path, &settings);
    }
    refuse_odd(path, Depth::Top)?;
    let scene = run_directory::scene_of(path);
    if !own_files::is_file(&scene) {
        return Err(Fault::new("diff::no_run", format!("{} is no run directory: it has no scene.ron", path.display()))
            .help("`siloflow run SCENE --out DIR` makes one"));
    }
    load::any(&scene, &settings)
}

/// Ends both scenes at the earlier of their end times. Returns that time, s, or that step for a lattice gas.
#[expect(clippy::cast_precision_loss, reason = "2^53 steps are out of reach")]
fn end_together(scenes: &mut [AnyScene; 2]) -> f64 {
    match scenes {
        [AnyScene::Grains(a), AnyScene::Grains(b)] => {
            let a = &mut a.scene.until;
            let b = &mut b.scene.until;
            let until = if a.get() < b.get() { *a } else { *b };
            (*a, *b) = (until, until);
            until.get()
        }
        [AnyScene::Lattice(a), AnyScene::Lattice(b)] => {
            let until = a.scene.until.min(b.scene.until);
            (a.scene.until, b.scene.until) = (until, until);
            until as f64
        }
        // Such runs are refused before the first step.
        _ => 0.0,
    }
}

/// Steps both runs to the first difference or to the end, and shows progress.
fn compare(pair: &mut Pair, until: f64, quiet: bool) -> Option<Divergence> {
    let mut progress = Progress::new(quiet, 0.0, 0);
    let divergence = pair.first_divergence(u64::MAX, |world: &World| {
        let clock = world.resource::<Clock>();
        progress.look(clock.steps, |pace| {
            format!(
                "step {}, t = {:.2} of at most {until}: the same so far | at most {:.0} s to go",
                clock.steps,
                clock.time(),
                pace.left(clock.time(), until - clock.time())
            )
        });
    });
    progress.finish();
    divergence
}

fn words(report: &DiffReport) -> String {
    let mut text = format!("first   {}\nsecond  {}\n", report.first, report.second);
    // Writing to a string cannot fail.
    for Change { key, first, second } in &report.keys {
        let [first, second] = [first, second].map(|value| value.as_deref().unwrap_or("not there"));
        let _ = writeln!(text, "key     {key}: {first} | {second}");
    }
    let _ = if let Some(divergence) = &report.divergence {
        writeln!(text, "differ at {divergence}")
    } else {
        let end = report.end.as_ref().map_or("", End::word);
        writeln!(text, "the same to the last bit in all {} steps, to t = {} s ({end})", report.steps, report.time_s)
    };
    text
}
