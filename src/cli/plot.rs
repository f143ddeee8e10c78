//! `siloflow plot`: draws figures of one or several runs.

use std::path::PathBuf;

use clap::Args;

use crate::cli::exit_status::ExitStatus;
use crate::cli::{check_results, picture_files, say, write_results};
use siloflow_figures::diagram::Look;
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
  siloflow plot out/silo1 out/silo1-mixture --out out/plots  # curves of both runs
  siloflow plot out/silo1 out/silo1-mixture --out out/plots --label one --label two --title \"Two silos\" --size 320x240 --font-size 11")]
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
    /// Width and height of a panel, px. A figure has up to two panels side by side.
    #[arg(long, value_name = "WxH", default_value = "520x400", value_parser = size)]
    size: (f64, f64),
    /// Height of letters, px. Lines, dots and margins grow with it.
    #[arg(long, value_name = "PX", default_value_t = Look::default().font, value_parser = font_size)]
    font_size: f64,
    /// The name of a run in legends; once for each run. Default: the name of its directory.
    #[arg(long, value_name = "NAME")]
    label: Vec<String>,
    /// A line above each figure.
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
    /// Replace figures of the same names.
    #[arg(long)]
    force: bool,
}

/// Limits of the size of a panel, px: a legible axis, and a picture that fits into memory.
const SIZES: std::ops::RangeInclusive<f64> = 100.0..=4000.0;

fn size(text: &str) -> Result<(f64, f64), String> {
    let numbers = text.split_once('x').and_then(|(width, height)| Some((width.parse().ok()?, height.parse().ok()?)));
    numbers.filter(|(width, height)| SIZES.contains(width) && SIZES.contains(height)).ok_or_else(|| {
        format!("expected a width and a height from {} to {} px, for example 520x400", SIZES.start(), SIZES.end())
    })
}

fn font_size(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| (4.0..=100.0).contains(number));
    number.ok_or_else(|| "expected a height of letters from 4 to 100 px, for example 13".to_owned())
}

/// The look of the figures, in which letters leave space for a plot.
fn look(args: &PlotArgs) -> Result<Look, Fault> {
    // In letters: axes, colour scale and a legend.
    const LEAST: (f64, f64) = (16.0, 13.0);
    let (width, height) = (LEAST.0 * args.font_size, LEAST.1 * args.font_size);
    if args.size.0 < width || args.size.1 < height {
        let message = format!(
            "letters of {} px leave no space in a panel of {} x {} px",
            args.font_size, args.size.0, args.size.1
        );
        return Err(Fault::new("plot::size", message)
            .help(format!("give a --size of at least {width:.0}x{height:.0}, or a smaller --font-size")));
    }
    Ok(Look { size: args.size, font: args.font_size, title: args.title.clone() })
}

/// Gives the runs the names of `--label`.
fn name_runs(runs: &mut [RunResults], labels: &[String]) -> Result<(), Fault> {
    if labels.is_empty() {
        return Ok(());
    }
    if labels.len() != runs.len() || runs.len() == 1 {
        let message = format!("{} of --label for {} of run directories", labels.len(), runs.len());
        return Err(Fault::new("plot::labels", message)
            .help("give --label once for each run of a figure of several; a figure of one run has no names of runs"));
    }
    runs.iter_mut().zip(labels).for_each(|(run, label)| run.name.clone_from(label));
    Ok(())
}

pub(super) fn plot(args: &PlotArgs) -> Result<ExitStatus, Fault> {
    let mut runs = args.runs.iter().map(|run| RunResults::open(run)).collect::<Result<Vec<_>, _>>()?;
    RunResults::distinguish(&mut runs.iter_mut().collect::<Vec<_>>());
    name_runs(&mut runs, &args.label)?;
    let look = look(args)?;
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
        files.extend(picture_files(&figure.name, figure.svg(&look))?);
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
