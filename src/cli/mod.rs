//! The command line. Results go to stdout, progress and messages to stderr. A stream that is closed or full never stops a
//! command.

mod accuracy;
pub mod check;
mod compare;
mod diff;
#[cfg(test)]
#[cfg(target_os = "linux")]
mod disk_recorder;
#[cfg(test)]
mod documented_columns;
mod estimate;
mod exit_status;
mod explain;
mod export;
mod export_scene;
mod from;
mod new;
mod plot;
#[cfg(test)]
#[cfg(target_os = "linux")]
mod power_failure;
mod progress;
mod render;
#[cfg(feature = "report")]
mod report;
mod run;
mod run_grains;
mod run_lattice;
mod run_path;
#[cfg(feature = "shell")]
mod shell;
mod signals;
pub mod sliced;
mod status_line;
mod study;
mod sweep;
mod validate;
mod verify;

use std::ffi::OsString;
use std::io::{self, IsTerminal as _};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::OnceLock;

use clap::error::{ContextKind, ContextValue};
use clap::{Args, Parser, Subcommand};

use crate::behaviour::Registry;
pub use crate::cli::exit_status::EXIT_STATUSES;
use crate::cli::exit_status::{ExitStatus, REFUSED};
use crate::scene::load;
use crate::scene::loaded::AnyScene;
use siloflow_figures::png;
use siloflow_files::run_directory;
use siloflow_text::fault::Fault;
use siloflow_text::safe::for_terminal;

/// Simulates grain in silos from one scene file, and leaves pictures, figures and data.
#[derive(Parser, Debug)]
#[command(
    name = "siloflow",
    version,
    max_term_width = 100,
    after_help = exit_status::help() + "\n\nStart with:  siloflow run scenes/silo1.ron\nPictures:    out/silo1/frames/, \
                  figures: out/silo1/summary.json, series.csv"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Print errors and JSON only: no progress, no warnings, no summary in words.
    #[arg(long, short, global = true)]
    quiet: bool,
    /// Print more: -v events such as lost grains, -vv everything.
    #[arg(long, short, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
}

#[derive(Subcommand, Debug)]
enum Command {
    /// Run a scene.
    Run(run::RunArgs),
    /// Write a commented scene to begin with, or a copy of a shipped one.
    New(new::NewArgs),
    /// List the scenes that come with the program.
    Scenes,
    /// Find bad input, an unstable step and leaky walls before a run.
    Check(check::CheckArgs),
    /// List what a scene will model: components, bytes per grain, systems, and the key that asks for each.
    Explain(SceneArgs),
    /// Run the lattice-gas study: silos, variants and seeds, and a verdict on each claim of its paper.
    Study(study::StudyArgs),
    /// Run a scene with many values and seeds, and gather means, standard errors, fits and figures.
    Sweep(sweep::SweepArgs),
    /// Estimate a figure of a scene with its error: chance, stiffness and step, from as few runs as will do.
    Estimate(estimate::EstimateArgs),
    /// Hold siloflow against silos and impacts that others have measured, and write a page with a figure and verdicts.
    Validate(validate::ValidateArgs),
    /// Check the files of runs against the hashes that the runs have recorded.
    Verify(verify::VerifyArgs),
    /// Compare flow patterns and costs of runs or scenes with a reference.
    Compare(compare::CompareArgs),
    /// Run two scenes together and report the first step, grain and quantity in which they differ.
    Diff(diff::DiffArgs),
    /// Measure speed against error: every scheme over many time steps, for canonical cases or a scene.
    Accuracy(accuracy::AccuracyArgs),
    /// Turn snapshots (SVG) into PNGs, or draw pictures and movies from the frames of a run.
    Render(render::args::RenderArgs),
    /// Draw figures of runs: discharge, energies, forces on walls, profiles, fields.
    Plot(plot::PlotArgs),
    /// Write one HTML file about a run, or compare several: players, curves, tables.
    #[cfg(feature = "report")]
    Report(report::ReportArgs),
    /// Convert the frames of a run for ParaView (VTK) or OVITO (extended XYZ, LAMMPS dump), or write a scene for LAMMPS.
    Export(export::ExportArgs),
    /// Print the completions of a shell.
    #[cfg(feature = "shell")]
    Completions(shell::CompletionsArgs),
    /// Write man pages, one for the program and one for each command.
    #[cfg(feature = "shell")]
    Man(shell::ManArgs),
}

/// A scene, and settings that change it.
#[derive(Args, Debug)]
struct SceneArgs {
    /// The scene, a RON file.
    scene: PathBuf,
    /// Change a key of the scene, for example `--set spawner.count=200`, `--set neighbours=AllPairs`. May be repeated.
    #[arg(long = "set", value_name = "PATH=VALUE", value_parser = setting)]
    set: Vec<(String, String)>,
    /// Seed of all random numbers. Short for `--set seed=N`.
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
}

impl SceneArgs {
    fn load(&self) -> Result<AnyScene, Fault> {
        self.load_with(&[])
    }

    /// Loads the scene with further settings.
    fn load_with(&self, more: &[(String, String)]) -> Result<AnyScene, Fault> {
        load::any(&self.scene, &self.settings(more))
    }

    /// Returns all settings, with further ones.
    fn settings(&self, more: &[(String, String)]) -> Vec<(String, String)> {
        let mut settings = self.set.clone();
        settings.extend(self.seed.map(|seed| ("seed".to_owned(), seed.to_string())));
        settings.extend_from_slice(more);
        settings
    }
}

fn setting(text: &str) -> Result<(String, String), String> {
    let (path, value) = text.split_once('=').ok_or("expected PATH=VALUE, for example spawner.count=200")?;
    Ok((path.trim().to_owned(), value.trim().to_owned()))
}

/// Runs the program on the arguments of the process, without further behaviours.
#[must_use]
pub fn main() -> ExitCode {
    main_with(&Registry::default())
}

/// Runs the program with the behaviours in `registry`, on the arguments of the process. A program that adds
/// behaviours calls this function in its `main`.
#[must_use]
pub fn main_with(registry: &Registry) -> ExitCode {
    run_with(registry, std::env::args_os())
}

/// Runs the program with the behaviours in `registry` on these arguments. The first argument is the program's name.
#[must_use]
pub fn run_with(registry: &Registry, arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    ExitCode::from(status_of(registry, arguments))
}

/// Like [`run_with`], with the [exit status](EXIT_STATUSES) as a number, for callers that are not a `main`.
#[must_use]
pub fn status_of(registry: &Registry, arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            // clap's own: help and version go to stdout with 0, a wrong call to stderr with 2.
            let _ = error.print();
            if let Some(scene) = scene_without_command(&error) {
                say_aside(&format!("\n  help: to run a scene, write `siloflow run {scene}`"));
            }
            return u8::try_from(error.exit_code()).unwrap_or(REFUSED);
        }
    };
    start_log(&cli);
    signals::survive_file_limits();
    let result = match &cli.command {
        Command::Run(args) => run::run(args, registry, cli.quiet),
        Command::New(args) => new::new(args),
        Command::Scenes => Ok(new::scenes()),
        Command::Check(args) => check::check(args, registry),
        Command::Explain(args) => explain::explain(args, registry),
        Command::Study(args) => study::study(args, cli.quiet),
        Command::Sweep(args) => sweep::sweep(args, registry, cli.quiet),
        Command::Estimate(args) => estimate::estimate(args, registry, cli.quiet),
        Command::Validate(args) => validate::validate(args, registry, cli.quiet),
        Command::Verify(args) => verify::verify(args, cli.quiet),
        Command::Compare(args) => compare::compare(args, registry, cli.quiet),
        Command::Diff(args) => diff::diff(args, registry, cli.quiet),
        Command::Accuracy(args) => accuracy::accuracy(args, registry, cli.quiet),
        Command::Render(args) => render::render(args, cli.quiet),
        Command::Plot(args) => plot::plot(args),
        #[cfg(feature = "report")]
        Command::Report(args) => report::report(args),
        Command::Export(args) => export::export(args, cli.quiet),
        #[cfg(feature = "shell")]
        Command::Completions(args) => Ok(shell::completions(args)),
        #[cfg(feature = "shell")]
        Command::Man(args) => shell::man(args),
    };
    match result {
        Ok(status) => status.number(),
        Err(fault) => {
            show(fault);
            REFUSED
        }
    }
}

/// The program that [`set_program`] names.
static PROGRAM: OnceLock<PathBuf> = OnceLock::new();

/// Names the program that `sweep` starts for each run. It is for callers whose process is another program, such as an interpreter of
/// Python; without a call it is the program of the process. Only the first call counts.
pub fn set_program(path: PathBuf) {
    let _ = PROGRAM.set(path);
}

/// The program to start for a command.
fn program() -> Result<PathBuf, Fault> {
    let path = PROGRAM.get().map_or_else(std::env::current_exe, |path| Ok(path.clone()));
    path.map_err(|error| {
        Fault::new("call::program", format!("could not find the program: {error}")).help("start it by its full path")
    })
}

fn show(fault: Fault) {
    say_aside(&format!("{:?}", miette::Report::new(fault)));
}

/// Returns a fault of the input, or reports it as a failure if the command has already changed something.
fn refused(fault: Fault, has_changed: bool) -> Result<ExitStatus, Fault> {
    if !has_changed {
        return Err(fault);
    }
    show(fault);
    Ok(ExitStatus::Failed)
}

/// Checks that results can be written to a directory, before the work for them begins.
fn check_results(directory: &Path) -> Result<(), Fault> {
    run_directory::check_results(directory).map_err(|error| unwritable(directory, &error))
}

fn unwritable(directory: &Path, error: &std::io::Error) -> Fault {
    Fault::new("results::write", format!("could not write to {}: {error}", directory.display()))
        .help("is there space, and may you write there? Or give another directory with --out")
}

/// Writes the results of a study or comparison: all of them or none. A failure comes after the start, so it is no error of
/// the call.
fn write_results(directory: &Path, files: &[(String, Vec<u8>)]) -> ExitStatus {
    let Err(error) = run_directory::write_results(directory, files) else { return ExitStatus::Done };
    show(unwritable(directory, &error));
    ExitStatus::Failed
}

/// Returns a picture as the two files `name.svg` and `name.png`.
fn picture_files(name: &str, svg: String) -> Result<[(String, Vec<u8>); 2], Fault> {
    let png = png::encode(&svg).map_err(|error| {
        Fault::new("results::picture", format!("could not draw {name}: {error}")).help("this is an error of siloflow")
    })?;
    Ok([(format!("{name}.svg"), svg.into_bytes()), (format!("{name}.png"), png)])
}

/// The scene file in the place of a command, if there is one.
fn scene_without_command(error: &clap::Error) -> Option<&str> {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand) else { return None };
    Path::new(word).extension().is_some_and(|ending| ending == "ron").then_some(word)
}

fn start_log(cli: &Cli) {
    let level = match (cli.quiet, cli.verbose) {
        (true, _) => tracing::Level::ERROR,
        (_, 0) => tracing::Level::INFO,
        (_, 1) => tracing::Level::DEBUG,
        _ => tracing::Level::TRACE,
    };
    let colours = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
    // If the calling program has set up a log, that log stays.
    let _ = tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .with_max_level(level)
        .with_target(false)
        .without_time()
        .with_ansi(colours)
        // A closed pipe is not an error here either.
        .log_internal_errors(false)
        .try_init();
}

/// Returns what to do about results that could not be written to a place with a default.
fn help_to_write(error: &io::Error) -> &'static str {
    if error.kind() == io::ErrorKind::ResourceBusy {
        "wait for its end, or give another place with --out"
    } else {
        "nothing was written; is there space, and may you write there? Or give another place with --out"
    }
}

/// Writes a line to stderr: an error or progress. A closed pipe is not an error, so a run goes on without a reader.
fn say_aside(line: &str) {
    use std::io::Write as _;
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Writes a result to stdout, with text from scenes and file names made safe for a terminal. A closed pipe is not an error.
fn say(text: &str) {
    use std::io::Write as _;
    let mut stdout = std::io::stdout().lock();
    let _ = stdout.write_all(for_terminal(text).as_bytes()).and_then(|()| stdout.flush());
}

const ONE_THREAD: NonZeroUsize = NonZeroUsize::MIN;
