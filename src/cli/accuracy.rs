//! `siloflow accuracy`: speed against error, of the canonical cases or of a scene.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use rayon::prelude::*;

use crate::accuracy::case::Case;
use crate::accuracy::ladder::{self, Climb, Prepared};
use crate::accuracy::report::Report;
use crate::accuracy::{SCHEMES, cases, cost, figure};
use crate::cli::{Verdict, say};
use crate::fault::Fault;
use crate::output::png;

/// Arguments of `accuracy`.
#[derive(Args, Debug)]
#[command(after_help = "\
Without arguments: all cases, each scheme, over a ladder of steps. See docs/accuracy.md.
  siloflow accuracy
  siloflow accuracy bounce-0.5 bed --quick

Figure: out/accuracy/work-precision.png; figures: out/accuracy/accuracy.csv, accuracy.json")]
pub(super) struct AccuracyArgs {
    /// Cases, by name. Default: all.
    #[arg(value_name = "CASE")]
    what: Vec<String>,
    /// Where the results go.
    #[arg(long, value_name = "DIR", default_value = "out/accuracy")]
    out: PathBuf,
    /// A short ladder.
    #[arg(long)]
    quick: bool,
    /// Runs side by side. Costs are timed one by one in any case.
    #[arg(long, value_name = "N", default_value = "1")]
    threads: NonZeroUsize,
    /// Print the results as JSON instead of a table.
    #[arg(long)]
    json: bool,
}

pub(super) fn accuracy(args: &AccuracyArgs, quiet: bool) -> Result<Verdict, Fault> {
    let cases = chosen(&args.what)?;
    let start = Instant::now();
    let tell = |what: &str| {
        if !quiet {
            eprintln!("{:5.1} s  {what}", start.elapsed().as_secs_f64());
        }
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads.get()).build().map_err(|error| {
        Fault::new("call::threads", format!("could not start the threads: {error}"))
            .help("ask for fewer with --threads")
    })?;
    tell("what a step costs, in the bed");
    let cost = cost::measure(if args.quick { 3 } else { 7 });
    tell("reference solutions");
    let prepared: Vec<Prepared> =
        pool.install(|| cases.into_par_iter().with_max_len(1).map(|case| ladder::prepare(case, args.quick)).collect());
    let tasks: Vec<_> = prepared.iter().flat_map(|case| (0..SCHEMES.len()).map(move |scheme| (case, scheme))).collect();
    let climb = |(prepared, scheme): (&Prepared, usize)| {
        let climb = prepared.climb(scheme);
        tell(&format!("{}, {}", climb.case, SCHEMES[scheme].name()));
        climb
    };
    let climbs: Vec<Climb> = pool.install(|| tasks.into_par_iter().with_max_len(1).map(climb).collect());
    let report = Report::new(&climbs, &cost);
    write(&args.out, &report)?;
    if args.json {
        say(&json(&report));
    } else {
        say(&format!("{}\nwritten to {}\n", report.table(), args.out.display()));
    }
    Ok(Verdict::Done)
}

fn chosen(names: &[String]) -> Result<Vec<Case>, Fault> {
    let all = cases::all();
    if names.is_empty() {
        return Ok(all);
    }
    let known = || all.iter().map(|case| case.name).collect::<Vec<_>>().join(", ");
    let find = |name: &String| {
        all.iter().find(|case| case.name == name).cloned().ok_or_else(|| {
            Fault::new("accuracy::unknown_case", format!("there is no case `{name}`"))
                .help(format!("known are {}; a scene's name ends in .ron", known()))
        })
    };
    names.iter().map(find).collect()
}

fn json(report: &impl serde::Serialize) -> String {
    serde_json::to_string_pretty(report).unwrap_or_default() + "\n"
}

fn write(out: &Path, report: &Report) -> Result<(), Fault> {
    let failed = |error: std::io::Error| {
        Fault::new("accuracy::write", format!("could not write to {}: {error}", out.display()))
            .help("give another directory with --out")
    };
    std::fs::create_dir_all(out).map_err(failed)?;
    std::fs::write(out.join("accuracy.csv"), report.csv()).map_err(failed)?;
    std::fs::write(out.join("accuracy.json"), json(report)).map_err(failed)?;
    let path = out.join("work-precision.svg");
    std::fs::write(&path, figure::work_precision(report)).map_err(failed)?;
    png::render_file(&path)?;
    Ok(())
}
