//! `siloflow compare`: compares the flow patterns of runs with a reference run, and their costs.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::behaviour::Registry;
use crate::cli::exit_status::ExitStatus;
use crate::cli::run::{default_directory, run_scene};
use crate::cli::run_path::runnable::RunOptions;
use crate::cli::signals::Signals;
use crate::cli::{ONE_THREAD, check_results, picture_files, refused, say, write_results};
use crate::scene::facts;
use crate::scene::load;
use crate::scene::loaded::AnyScene;
use siloflow_files::run_directory::RunDirectory;
use siloflow_results::compare::report::Report;
use siloflow_results::compare::{Run, compare as compare_runs, pictures, read};
use siloflow_text::fault::Fault;

/// Arguments of `compare`.
#[derive(Args, Debug)]
#[command(after_help = "\
Speeds are in units of each run's own mean, times in units of the time until half is out, so that models with clocks of their \
own can be compared. The scenes need the key `flow`, with the same cells.

What chance alone makes of the figures, the floor, tell two seeds of one scene:
  siloflow run scenes/silo2d.ron
  siloflow run scenes/silo2d.ron --seed 2 --out out/silo2d-seed2
  siloflow compare out/silo2d out/silo2d-seed2

Pictures: out/compare/fields.png, discharge.png, cost.png; figures: out/compare/compare.csv")]
pub(super) struct CompareArgs {
    /// The reference: a run directory, or a scene (.ron), which is first run into out/<its name>.
    reference: PathBuf,
    /// The runs or scenes to compare with the reference.
    #[arg(required = true)]
    others: Vec<PathBuf>,
    /// Replace earlier runs in the run directories of the scenes.
    #[arg(long)]
    force: bool,
    /// The directory of compare.csv and the pictures.
    #[arg(long, value_name = "DIR", default_value = "out/compare")]
    out: PathBuf,
    /// Use only cells in which both runs counted at least this many grains, over all samples.
    #[arg(long, value_name = "N", default_value = "50")]
    looks: u32,
    /// Print the figures as JSON instead of a table.
    #[arg(long)]
    json: bool,
}

pub(super) fn compare(args: &CompareArgs, registry: &Registry, quiet: bool) -> Result<ExitStatus, Fault> {
    let paths: Vec<&Path> = std::iter::once(&args.reference).chain(&args.others).map(PathBuf::as_path).collect();
    // All arguments are checked before the first scene is run.
    let mut scenes = paths.iter().map(|path| scene(path)).collect::<Result<Vec<_>, Fault>>()?;
    let directories: Vec<PathBuf> = paths
        .iter()
        .zip(&scenes)
        .map(|(path, scene)| scene.as_ref().map_or(Ok(path.into()), default_directory))
        .collect::<Result<_, _>>()?;
    distinct(&directories, &scenes)?;
    let names = names(&directories);
    for (directory, _) in directories.iter().zip(&scenes).filter(|(_, scene)| scene.is_some()) {
        RunDirectory::check(directory, args.force)?;
    }
    let mut runs: Vec<Option<Run>> = Vec::new();
    for ((directory, scene), name) in directories.iter().zip(&scenes).zip(&names) {
        runs.push(if scene.is_none() { Some(read::run(directory, name, &facts::read_outline)?) } else { None });
    }
    check_results(&args.out)?;
    let signals = Signals::catch();
    let options = RunOptions {
        registry,
        threads: ONE_THREAD,
        quiet,
        force: args.force,
        signals: &signals,
        checkpoint_every: None,
        parent: None,
        report: false,
    };
    let mut has_run = false;
    for (((run, scene), directory), name) in runs.iter_mut().zip(&mut scenes).zip(&directories).zip(&names) {
        let Some(loaded) = scene else { continue };
        let status = match run_scene(directory, loaded, &options) {
            Ok(result) => result.exit_status,
            Err(fault) => return refused(fault, has_run),
        };
        has_run = true;
        if status != ExitStatus::Done {
            tracing::error!("{name} did not end as it should: nothing was compared");
            return Ok(status);
        }
        match read::run(directory, name, &facts::read_outline) {
            Ok(read) => *run = Some(read),
            Err(fault) => return refused(fault, has_run),
        }
    }
    write_report(args, runs).or_else(|fault| refused(fault, has_run))
}

/// Compares the runs and writes the results.
fn write_report(args: &CompareArgs, runs: Vec<Option<Run>>) -> Result<ExitStatus, Fault> {
    let runs: Vec<Run> = runs.into_iter().flatten().collect();
    let Some((reference, others)) = runs.split_first() else { return Ok(ExitStatus::Done) };
    let report = compare_runs(reference, others, f64::from(args.looks))?;
    let mut files = vec![("compare.csv".to_owned(), report.csv().into_bytes())];
    for (name, svg) in pictures::all(&runs, &report) {
        files.extend(picture_files(name, svg)?);
    }
    let status = write_results(&args.out, &files);
    show(args, &report);
    Ok(status)
}

/// The scene at `path`, if the path names a scene.
fn scene(path: &Path) -> Result<Option<AnyScene>, Fault> {
    if path.extension().is_none_or(|ending| ending != "ron") {
        return Ok(None);
    }
    let scene = load::any(path, &[])?;
    let has_flow = match &scene {
        AnyScene::Grains(loaded) => loaded.scene.flow.is_some(),
        AnyScene::Lattice(loaded) => loaded.scene.flow.is_some(),
    };
    if !has_flow {
        let message = format!("{} does not say how to sample its flow", path.display());
        return Err(scene
            .source()
            .fault("compare::no_flow", "flow", message)
            .help("add for example `flow: (cell: 0.05, sample: 0.02)`, m and s (of a lattice gas steps)"));
    }
    Ok(Some(scene))
}

/// Checks that no scene would be run into the directory of another argument.
fn distinct(directories: &[PathBuf], scenes: &[Option<AnyScene>]) -> Result<(), Fault> {
    for (n, directory) in directories.iter().enumerate().filter(|&(n, _)| scenes[n].is_some()) {
        let is_same = |other: &PathBuf| {
            other == directory
                || fs::canonicalize(other).ok().zip(fs::canonicalize(directory).ok()).is_some_and(|(a, b)| a == b)
        };
        if directories.iter().enumerate().any(|(m, other)| m != n && is_same(other)) {
            let message = format!("two of the arguments are, or would be run into, {}", directory.display());
            return Err(Fault::new("compare::same_directory", message)
                .help("run them one by one with `siloflow run SCENE --out DIR`, and compare the directories"));
        }
    }
    Ok(())
}

/// A distinct label for each path: its last part, or the whole path where last parts are equal.
fn names(directories: &[PathBuf]) -> Vec<String> {
    let last = |path: &PathBuf| path.file_name().map(|name| name.to_string_lossy().into_owned());
    let short: Vec<_> = directories.iter().map(last).collect();
    let are_distinct = short.iter().collect::<HashSet<_>>().len() == short.len();
    let whole = |path: &PathBuf| path.display().to_string();
    let names = short.iter().zip(directories);
    names.map(|(name, path)| name.clone().filter(|_| are_distinct).unwrap_or_else(|| whole(path))).collect()
}

fn show(args: &CompareArgs, report: &Report) {
    if args.json {
        say(&(serde_json::to_string_pretty(report).unwrap_or_default() + "\n"));
        return;
    }
    let notes = format!(
        "\nfield rms: difference of the vertical velocities, in mean speeds, over cells that saw {} grains or more in both runs\n\
         discharge: largest difference of the share that is out, at the same time in units of the run's own\n\
         wall: clock time of the steps; of ref: over that of {}\n\nwritten to {}\n",
        args.looks,
        report.rows.first().map_or("", |row| &row.run),
        args.out.display()
    );
    say(&(report.table() + &notes));
}
