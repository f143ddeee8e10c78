//! `siloflow report`: one HTML file about a run, or about several.

use std::collections::HashSet;
use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::cli::exit_status::ExitStatus;
use crate::cli::say;
use crate::scene::facts;
use siloflow_files::own_files;
use siloflow_files::run_directory::report_of;
use siloflow_files::whole_file;
use siloflow_results::report;
use siloflow_text::fault::Fault;

/// Where the report of several runs is written.
const OF_SEVERAL: &str = "out/report.html";

/// Arguments of `report`.
#[derive(Args, Debug)]
#[command(after_help = "\
The report is one HTML file that opens in any browser, without a network: players, curves, tables, and the origin of the results. \
A run that goes on or was killed is reported as far as its files go. Give several runs to compare them.

  siloflow run scenes/silo1.ron
  siloflow run scenes/silo1-mixture.ron
  siloflow report out/silo1                      # writes out/silo1/report.html
  siloflow report out/silo1 out/silo1-mixture    # writes out/report.html

`siloflow run SCENE --report` writes the report at the end of the run.")]
pub(super) struct ReportArgs {
    /// The run directories. Values of the first are the reference of the others.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
    /// The file to write. Default: report.html in the run directory, for several runs out/report.html.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replace an earlier report.
    #[arg(long)]
    force: bool,
}

pub(super) fn report(args: &ReportArgs) -> Result<ExitStatus, Fault> {
    distinct(&args.runs)?;
    let target = match (&args.out, &args.runs[..]) {
        (Some(out), _) => out.clone(),
        (None, [run]) => report_of(run),
        (None, _) => PathBuf::from(OF_SEVERAL),
    };
    // A missing run is the more helpful message, so that the target is examined after the runs.
    let runs: Vec<&Path> = args.runs.iter().map(PathBuf::as_path).collect();
    let page = report::page(&runs, &facts::read)?;
    check_target(&target, args.force)?;
    write(&target, &page, args.out.is_none())?;
    say(&format!("{}\n", target.display()));
    Ok(ExitStatus::Done)
}

/// Refuses a run that is given twice, and too many.
fn distinct(runs: &[PathBuf]) -> Result<(), Fault> {
    if runs.len() > report::MOST_RUNS {
        return Err(Fault::new("report::too_many", format!("{} runs are too many for one page", runs.len()))
            .help(format!("give at most {}", report::MOST_RUNS)));
    }
    let mut seen = HashSet::new();
    let twice = runs.iter().find(|run| !seen.insert(fs::canonicalize(run).unwrap_or_else(|_| (*run).clone())));
    match twice {
        None => Ok(()),
        Some(run) => {
            Err(Fault::new("report::twice", format!("the run {} is given twice", run.display()))
                .help("give each run once"))
        }
    }
}

/// Refuses a target that exists. With `force` an earlier report is replaced, and nothing else.
fn check_target(target: &Path, force: bool) -> Result<(), Fault> {
    let Ok(found) = target.symlink_metadata() else { return Ok(()) };
    let shown = target.display();
    if found.is_dir() {
        return Err(Fault::new("report::exists", format!("{shown} is a directory"))
            .help("give the name of a file with --out, for example --out report.html"));
    }
    if !force {
        return Err(Fault::new("report::exists", format!("{shown} exists"))
            .help("replace it with --force, or give another file with --out"));
    }
    if !is_report(target) {
        return Err(Fault::new("report::exists", format!("{shown} is no report of siloflow"))
            .help("--force replaces an earlier report only; give another file with --out"));
    }
    Ok(())
}

/// Whether a file begins like a report.
fn is_report(path: &Path) -> bool {
    let mut start = Vec::new();
    let read = own_files::read(path).and_then(|file| file.take(4096).read_to_end(&mut start));
    let start = String::from_utf8_lossy(&start);
    read.is_ok() && start.starts_with("<!DOCTYPE html>") && start.contains("content=\"siloflow ")
}

fn write(target: &Path, page: &str, makes_directory: bool) -> Result<(), Fault> {
    let parent = target.parent().filter(|parent| !parent.as_os_str().is_empty());
    let made = match parent {
        Some(parent) if makes_directory => fs::create_dir_all(parent),
        _ => Ok(()),
    };
    made.and_then(|()| whole_file::write(target, page.as_bytes())).map_err(|error| {
        Fault::new("report::write", format!("could not write {}: {error}", target.display()))
            .help("nothing was written; is there space, and may you write there? Or give another file with --out")
    })
}
