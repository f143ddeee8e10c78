//! `siloflow plot`: draws figures of one or several runs.

use std::path::PathBuf;

use clap::Args;

use crate::cli::exit_status::ExitStatus;
use crate::cli::{check_results, picture_files, say, write_results};
use siloflow_results::plot::{self, Figure};
use siloflow_results::run_results::RunResults;
use siloflow_text::fault::Fault;
use siloflow_text::suggestion::closest;

/// Arguments of `plot`.
#[derive(Args, Debug)]
#[command(after_help = "\
Figures: discharge, grains, energy, contacts, speed, walls, free_walls, bands, slopes, profiles, fields, and each further column of series.csv.

  siloflow plot out/silo1                                    # all figures, into out/silo1/plots
  siloflow plot out/silo1 --what discharge
  siloflow plot out/silo1 out/silo1-mixture --out out/plots  # curves of both runs")]
pub(super) struct PlotArgs {
    /// Run directories. A run that goes on is drawn up to its last row.
    #[arg(required = true)]
    runs: Vec<PathBuf>,
    /// The figure to draw. May be repeated. Default: all that the runs have data for.
    #[arg(long, value_name = "FIGURE")]
    what: Vec<String>,
    /// The directory of the figures, each as SVG and PNG. Default: plots in the run directory; needed for several runs.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace figures of the same names.
    #[arg(long)]
    force: bool,
}

pub(super) fn plot(args: &PlotArgs) -> Result<ExitStatus, Fault> {
    let mut runs = args.runs.iter().map(|run| RunResults::open(run)).collect::<Result<Vec<_>, _>>()?;
    RunResults::distinguish(&mut runs.iter_mut().collect::<Vec<_>>());
    let runs: Vec<_> = runs.iter().collect();
    let directory = match (&args.out, &runs[..]) {
        (Some(out), _) => out.clone(),
        (None, [run]) => run.directory.join("plots"),
        _ => {
            return Err(Fault::new("plot::out", "the figures of several runs need a directory")
                .help("name it with --out, for example --out out/plots"));
        }
    };
    let figures = match &args.what[..] {
        [] => plot::figures(&runs)?,
        names => names.iter().map(|name| named(&runs, name)).collect::<Result<_, _>>()?,
    };
    let mut files = Vec::new();
    for figure in figures {
        files.extend(picture_files(&figure.name, figure.svg)?);
    }
    let existing = files.iter().map(|file| directory.join(&file.0)).find(|path| path.symlink_metadata().is_ok());
    if let (Some(existing), false) = (existing, args.force) {
        return Err(Fault::new("plot::exists", format!("{} exists", existing.display()))
            .help("replace it with --force, or give another directory with --out"));
    }
    check_results(&directory)?;
    let status = write_results(&directory, &files);
    if status == ExitStatus::Done {
        for (name, _) in &files {
            say(&format!("{}\n", directory.join(name).display()));
        }
    }
    Ok(status)
}

/// Returns the figure of this name.
fn named(runs: &[&RunResults], name: &str) -> Result<Figure, Fault> {
    if let Some(figure) = plot::named(runs, name)? {
        return Ok(figure);
    }
    let is_known = plot::names().any(|known| known == name);
    let columns = runs.iter().flat_map(|run| run.series.names());
    let mut known: Vec<&str> = plot::names().map(|name| -> &str { name }).chain(columns).collect();
    known.sort_unstable();
    known.dedup();
    Err(if is_known {
        Fault::new("plot::no_data", format!("there is nothing to draw for `{name}`")).help(
            "the run measured no such thing, or nothing happened; docs/reference/command-line.md names the scene keys",
        )
    } else {
        let meant = closest(name, &known).map_or_else(String::new, |near| format!("did you mean `{near}`? "));
        Fault::new("plot::unknown", format!("there is no figure and no column `{name}`"))
            .help(format!("{meant}known: {}", known.join(", ")))
    })
}
