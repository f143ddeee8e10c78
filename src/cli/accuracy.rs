//! `siloflow accuracy`: measures speed against error, for the canonical cases or for a scene.
//!
//! The arguments decide between the two: names of cases, or one path that ends in `.ron`.

use std::num::{NonZeroU32, NonZeroUsize};
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use rayon::prelude::*;

use crate::behaviour::Registry;
use crate::cli::exit_status::ExitStatus;
use crate::cli::{check_results, picture_files, say, say_aside, setting, write_results};
use crate::studies::accuracy::case::Case;
use crate::studies::accuracy::ladder::{self, Climb, Prepared};
use crate::studies::accuracy::report::Report;
use crate::studies::accuracy::scene_study::Question;
use crate::studies::accuracy::{SCHEMES, cases, cost, figure};
use crate::writers::provenance::Provenance;
use siloflow_text::fault::Fault;

/// Arguments of `accuracy`.
#[derive(Args, Debug)]
#[command(after_help = "\
Without arguments: all cases, each scheme, over a ladder of steps. See docs/explanation/accuracy.md.
  siloflow accuracy
  siloflow accuracy bounce-0.5 bed --quick
Figures: out/accuracy/work-precision.png, in-time.png; figures: out/accuracy/accuracy.csv, .json, .md

With a scene: its own observables over a ladder of its own step, with seeds for what chance decides, and the step for a wanted \
error.
  siloflow accuracy scenes/column.ron --error 1e-3
  siloflow accuracy scenes/silo1.ron --set spawner.count=100 --seeds 8
Figures: out/accuracy/<scene>.json")]
pub(super) struct AccuracyArgs {
    /// Cases, by name, or one scene, a RON file. Default: all cases.
    #[arg(value_name = "CASE|SCENE")]
    what: Vec<String>,
    /// For a scene: change a key, as in `run`. May be repeated.
    #[arg(long = "set", value_name = "PATH=VALUE", value_parser = setting)]
    set: Vec<(String, String)>,
    /// For a scene: the number of seeds, counted up from its own. [default: 4]
    #[arg(long, value_name = "N")]
    seeds: Option<NonZeroU32>,
    /// For a scene: the wanted relative error of its observables. [default: 1e-2]
    #[arg(long, value_name = "E", value_parser = positive)]
    error: Option<f64>,
    /// The directory of the results.
    #[arg(long, value_name = "DIR", default_value = "out/accuracy")]
    out: PathBuf,
    /// Use few time steps, for a quick look.
    #[arg(long)]
    quick: bool,
    /// Number of runs in parallel. Costs are always timed one run at a time.
    #[arg(long, value_name = "N", default_value = "1")]
    threads: NonZeroUsize,
    /// Print the results as JSON instead of a table.
    #[arg(long)]
    json: bool,
}

fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| *number > 0.0 && number.is_finite());
    number.ok_or_else(|| "expected a positive number, for example 1e-2".to_owned())
}

pub(super) fn accuracy(args: &AccuracyArgs, registry: &Registry, quiet: bool) -> Result<ExitStatus, Fault> {
    check_results(&args.out)?;
    let start = Instant::now();
    let tell = |what: &str| {
        if !quiet {
            say_aside(&format!("{:5.1} s  {what}", start.elapsed().as_secs_f64()));
        }
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads.get()).build().map_err(|error| {
        Fault::new("call::threads", format!("could not start the threads: {error}"))
            .help("ask for fewer with --threads")
    })?;
    let is_scene = |what: &String| Path::new(what).extension().is_some_and(|ending| ending == "ron");
    match args.what.as_slice() {
        [scene] if is_scene(scene) => pool.install(|| of_scene(args, Path::new(scene), registry, &tell)),
        all if all.iter().any(is_scene) => {
            Err(Fault::new("accuracy::one_scene", "a scene is studied alone").help("give one scene, or names of cases"))
        }
        _ if !args.set.is_empty() || args.seeds.is_some() || args.error.is_some() => {
            Err(Fault::new("accuracy::no_scene", "--set, --seeds and --error belong to a scene, and there is none")
                .help("give a scene, for example scenes/silo1.ron"))
        }
        names => pool.install(|| of_cases(args, chosen(names)?, &tell)),
    }
}

fn of_scene(
    args: &AccuracyArgs,
    scene: &Path,
    registry: &Registry,
    tell: &(dyn Fn(&str) + Sync),
) -> Result<ExitStatus, Fault> {
    let question = Question {
        scene,
        settings: &args.set,
        seeds: args.seeds.map_or(4, NonZeroU32::get),
        error: args.error.unwrap_or(1e-2),
        quick: args.quick,
        registry,
    };
    let study = question.answer(tell)?;
    let name = format!("{}.json", study.scene);
    let path = args.out.join(&name);
    let status = write_results(&args.out, &[(name, json(&study).into_bytes())]);
    if args.json {
        say(&json(&study));
    } else {
        say(&format!("{}written to {}\n", study.table(), path.display()));
    }
    Ok(status)
}

fn of_cases(args: &AccuracyArgs, cases: Vec<Case>, tell: &(dyn Fn(&str) + Sync)) -> Result<ExitStatus, Fault> {
    tell("what a step costs, in the bed");
    let cost = cost::measure(if args.quick { 3 } else { 7 });
    tell("reference solutions");
    let prepare = |case| ladder::prepare(case, args.quick);
    let prepared: Vec<Prepared> = cases.into_par_iter().with_max_len(1).map(prepare).collect();
    let tasks: Vec<_> = prepared.iter().flat_map(|case| (0..SCHEMES.len()).map(move |scheme| (case, scheme))).collect();
    let climb = |(prepared, scheme): (&Prepared, usize)| {
        let climb = prepared.climb(scheme);
        tell(&format!("{}, {}", climb.case, SCHEMES[scheme].name()));
        climb
    };
    let climbs: Vec<Climb> = tasks.into_par_iter().with_max_len(1).map(climb).collect();
    let report = Report::new(&climbs, &cost);
    let status = write_results(&args.out, &files(&report)?);
    if args.json {
        say(&json(&report));
    } else {
        say(&format!("{}\nwritten to {}\n", report.table(), args.out.display()));
    }
    Ok(status)
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

/// Returns the first line of the page: command, version, day and machine, on which its times depend.
fn origin() -> String {
    let made = Provenance::now();
    let machine = made.processor.as_deref().map_or_else(String::new, |name| format!(" on {name}"));
    format!("`{}`, siloflow {}, {}{machine}.\n\n", made.command, made.version, made.day())
}

fn files(report: &Report) -> Result<Vec<(String, Vec<u8>)>, Fault> {
    let tables = [("csv", report.csv()), ("json", json(report)), ("md", origin() + &report.markdown())];
    let mut files: Vec<_> =
        tables.into_iter().map(|(ending, text)| (format!("accuracy.{ending}"), text.into_bytes())).collect();
    let figures = [("work-precision", Some(figure::work_precision(report))), ("in-time", figure::in_time(report))];
    for (name, svg) in figures.into_iter().filter_map(|(name, svg)| Some((name, svg?))) {
        files.extend(picture_files(name, svg)?);
    }
    Ok(files)
}
