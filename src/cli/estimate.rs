//! `siloflow estimate`: a figure of a scene with its error, from runs that the command chooses.

#[cfg(feature = "report")]
mod page;
mod points;
mod runs;
mod subject;

use std::fmt::Write as _;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

use crate::behaviour::Registry;
use crate::cli::estimate::runs::SiloRuns;
use crate::cli::estimate::subject::{Subject, Wishes};
use crate::cli::exit_status::ExitStatus;
use crate::cli::run::directory_named;
use crate::cli::signals::Signals;
use crate::cli::sweep::available_cores;
use crate::cli::{SceneArgs, picture_files, refused, say, say_aside, setting, show};
use crate::scene::loaded::AnyScene;
use crate::studies::estimate::answer::Answer;
use crate::studies::estimate::comparison::{Comparison, compare};
use crate::studies::estimate::estimator::estimate as estimate_mean;
use crate::studies::estimate::goal::{Goal, Refusal, Within};
use crate::studies::estimate::picture::{Round, panels};
use crate::studies::estimate::results::{Estimate, Outcome, rungs_table, runs_table};
use crate::studies::estimate::variant::{Change, Variant};
use crate::studies::figures::figure::Figure;
use crate::studies::sweep::Task;
use crate::studies::sweep::directory::SweepDirectory;
use siloflow_figures::diagram::sheet;
use siloflow_figures::statistics::digits::{digits, short};
use siloflow_text::fault::Fault;

/// Arguments of `estimate`.
#[derive(Args, Debug)]
#[command(after_help = "\
A figure is a path in summary.json, or part of a table in a window of time:

  siloflow estimate silo.ron --figure discharge.rate_per_s --within 2%
  siloflow estimate silo.ron --figure 'series.csv: rate of out, AfterDoor(0.1) to AfterDoor(0.4)' --budget 10min
  siloflow estimate silo.ron --figure 'wall_bands.csv: sides, pressure, 0.1 m to 0.2 m, AfterRest(0) to AfterRest(0.5)'
  siloflow estimate silo.ron --figure 'share of clogged' --within 0.05

The same command continues an estimate that was interrupted; a narrower one uses the runs that are there.")]
pub(super) struct EstimateArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// The figure.
    #[arg(long, value_name = "FIGURE")]
    figure: String,
    /// Half width of the 95 % confidence interval: a share such as 2%, or a number in the unit of the figure. Default: 5%, or with --budget as narrow as it allows.
    #[arg(long, value_name = "WIDTH", value_parser = within)]
    within: Option<Within>,
    /// Time for the runs, for example 90s, 10min, 2h.
    #[arg(long, value_name = "TIME", value_parser = seconds)]
    budget: Option<f64>,
    /// The directory of the estimate. Default: out/<scene name>-estimate.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Number of runs at a time, each on one core. Default: the number of cores.
    #[arg(long, value_name = "N")]
    cores: Option<NonZeroUsize>,
    /// Let radii of softer grains make up for the overlaps of the bed at rest, which one more run measures.
    #[arg(long)]
    grow: bool,
    /// Compare with a larger silo: a key that is in the scene, and its larger value, for example parameters.grains=20000 [may be repeated].
    #[arg(long, value_name = "KEY=VALUE", value_parser = setting)]
    size: Vec<(String, String)>,
    /// Print estimate.json.
    #[arg(long)]
    json: bool,
    /// Use the directory of an estimate of another scene, and replace its runs.
    #[arg(long)]
    force: bool,
}

/// The confidence of all intervals.
const CONFIDENCE: f64 = 0.95;

/// Runs with half of the step.
const RUNS_OF_HALF_STEP: usize = 2;

/// Runs of a larger silo.
const RUNS_OF_LARGER_SILO: usize = 4;

/// The interval without a request.
const USUAL: Within = Within::Share(0.05);

fn within(text: &str) -> Result<Within, String> {
    let positive = |text: &str| text.trim().parse().ok().filter(|x: &f64| *x > 0.0 && x.is_finite());
    let share = text.strip_suffix('%').map(|percent| positive(percent).map(|percent| Within::Share(percent / 100.0)));
    share
        .unwrap_or_else(|| positive(text).map(Within::Absolute))
        .ok_or_else(|| "expected a share such as 2%, or a positive number in the unit of the figure".to_owned())
}

fn seconds(text: &str) -> Result<f64, String> {
    let units = [("min", 60.0), ("h", 3600.0), ("s", 1.0), ("", 1.0)];
    let number = |(unit, factor): (&str, f64)| Some(text.strip_suffix(unit)?.trim().parse::<f64>().ok()? * factor);
    let found = units.into_iter().find_map(number).filter(|x| *x > 0.0 && x.is_finite());
    found.ok_or_else(|| "expected a time such as 90s, 10min or 2h".to_owned())
}

pub(super) fn estimate(args: &EstimateArgs, registry: &Registry, quiet: bool) -> Result<ExitStatus, Fault> {
    let begun = Instant::now();
    let scene = args.scene.load()?;
    let figure = Figure::parse(&args.figure, matches!(scene, AnyScene::Lattice(_)))?;
    let mut subject = Subject::of(&args.scene, &scene, &figure, &Wishes { grows: args.grow, larger: &args.size })?;
    let path = args.out.clone().map_or_else(|| directory_named(&format!("{}-estimate", subject.name)), Ok)?;
    let sweep = subject.sweep(&args.scene)?;
    if !quiet {
        subject.warn(&scene);
    }
    // An error of the scene changes nothing.
    sweep.check(Task { point: 0, seed: subject.seed }, registry)?;
    if let Some(point) = subject.point(Variant { rung: 0, change: Change::Larger }) {
        sweep.check(Task { point, seed: subject.seed }, registry)?;
    }
    let mut goal = Goal {
        within: args.within.or(args.budget.is_none().then_some(USUAL)),
        budget: args.budget,
        cores: args.cores.unwrap_or_else(available_cores).get(),
        confidence: CONFIDENCE,
        is_probability: figure.is_probability(),
    };
    let signals = Signals::catch();
    signals.defer();
    let directory = SweepDirectory::prepare(&path, &sweep, args.force)?;
    let mut runs = SiloRuns {
        taken: vec![0; sweep.points.len()],
        sweep,
        directory: &directory,
        figure: &figure,
        ladder: subject.ladder.clone(),
        variants: subject.points.variants.clone(),
        seed: subject.seed,
        cores: goal.cores,
        signals: &signals,
        quiet,
        records: Vec::new(),
    };
    if subject.grows
        && let Err(fault) = grow(&mut subject, &args.scene, &mut runs, &mut goal)
    {
        return refused(fault, true);
    }
    let mut rounds = Vec::new();
    let result = answer(&subject, &goal, &mut runs, &mut rounds, quiet);
    // A signal while changed scenes were compared ends the estimate too, with the value that it has.
    let signal = signals.received();
    let Found { answer, step, larger } = match result {
        Ok(found) => found,
        Err(fault) => return refused(fault, true),
    };
    let outcome = Outcome {
        scene: &subject.name,
        figure: &args.figure,
        ladder: &subject.ladder,
        confidence: CONFIDENCE,
        within: goal.within,
        answer: &answer,
        step,
        size: &subject.larger,
        larger,
        not_softened: subject.not_softened.as_deref(),
        growth: subject.growth.as_ref(),
        runs: runs.records,
        wall_s: begun.elapsed().as_secs_f64(),
    };
    let estimate = Estimate::of(outcome);
    let json = serde_json::to_string_pretty(&estimate).unwrap_or_default() + "\n";
    let panels = panels(&subject.name, &args.figure, &subject.ladder, &answer, &estimate.runs, &rounds);
    let tables = [("runs.csv", runs_table(&estimate.runs)), ("rungs.csv", rungs_table(&subject.ladder, &answer))];
    let mut files = vec![(PathBuf::from("estimate.json"), json.clone().into_bytes())];
    #[cfg(feature = "report")]
    files.push((PathBuf::from("report.html"), page::page(&estimate, &panels, &tables)?.into_bytes()));
    files.extend(tables.map(|(name, table)| (PathBuf::from(name), table.into_bytes())));
    files.extend(picture_files("estimate", sheet(&panels, 2))?.map(|(name, content)| (PathBuf::from(name), content)));
    if let Err(error) = directory.write(&files) {
        let message = format!("could not write to {}: {error}", path.display());
        show(
            Fault::new("results::write", message)
                .help("the runs are kept: the same command writes the results when there is space"),
        );
        return Ok(ExitStatus::Failed);
    }
    if args.json {
        say(&json);
    } else if !quiet {
        say(&format!("{}written to   {}\n", estimate.in_words(), path.display()));
    }
    Ok(match (signal, answer.refused) {
        (Some(signal), _) => {
            tracing::error!("interrupted: the same command continues the estimate in {}", path.display());
            ExitStatus::Interrupted(signal)
        }
        (None, Some(_)) => ExitStatus::Failed,
        (None, None) => ExitStatus::Done,
    })
}

/// Makes the first run of a ladder with growth, and lets the radii on all rungs make up for its overlaps. Its time counts.
fn grow(subject: &mut Subject, args: &SceneArgs, runs: &mut SiloRuns, goal: &mut Goal) -> Result<(), Fault> {
    let softest = Variant { rung: subject.ladder.softness().len() - 1, change: Change::Overlaps };
    let Some(point) = subject.point(softest) else { return Ok(()) };
    let Some(first) = runs.first(point)? else { return Ok(()) };
    goal.budget = goal.budget.map(|budget| budget - first.cost);
    if let Some(overlap) = first.overlap {
        subject.grow(overlap);
        runs.sweep = subject.sweep(args)?;
    } else {
        tracing::warn!("radii do not grow: the first run did not come to rest, or the scene has no `rest`");
    }
    Ok(())
}

/// The answer and the comparisons that follow it.
struct Found {
    answer: Answer,
    /// The effect of half of the step.
    step: Option<Comparison>,
    /// The effect of a larger silo.
    larger: Option<Comparison>,
}

/// Finds the answer, then compares half of the step and the larger silo.
fn answer(
    subject: &Subject,
    goal: &Goal,
    runs: &mut SiloRuns,
    rounds: &mut Vec<Round>,
    quiet: bool,
) -> Result<Found, Fault> {
    let mut tell = |answer: &Answer| {
        let Some(fit) = answer.fit else { return };
        rounds.push(Round { spent: answer.spent, half: fit.interval.half() });
        if !quiet {
            say_aside(&progress(answer, subject, goal));
        }
    };
    let mut found = Found { answer: estimate_mean(&subject.ladder, goal, runs, &mut tell)?, step: None, larger: None };
    let answer = &mut found.answer;
    // A probability would need another measure of what is small.
    if answer.refused == Some(Refusal::Stopped) || goal.is_probability {
        return Ok(found);
    }
    let with = |change: Change| subject.point(Variant { rung: answer.compared(), change });
    let half_step = with(Change::HalfStep).filter(|_| !answer.is_certain);
    let larger = with(Change::Larger);
    if let Some(point) = half_step {
        found.step = compare(answer, goal, runs, &[point; RUNS_OF_HALF_STEP])?;
        let [half, value] = answer.fit.map_or([0.0, f64::NAN], |fit| [fit.interval.half(), fit.value]);
        let wanted = goal.within.map(|within| within.half(value));
        if found.step.is_some_and(|step| step.matters(half, wanted)) {
            answer.refused = answer.refused.or(Some(Refusal::Step));
        }
    }
    if let Some(point) = larger {
        let count = if answer.is_certain { 1 } else { RUNS_OF_LARGER_SILO };
        found.larger = compare(answer, goal, runs, &vec![point; count])?;
    }
    Ok(found)
}

/// A line about the state of an estimate.
fn progress(answer: &Answer, subject: &Subject, goal: &Goal) -> String {
    let Some(fit) = answer.fit else { return String::new() };
    let half = fit.interval.half();
    let mut text = format!("{} runs: {} ± {}", answer.runs(), short(fit.value), digits(half, 2));
    let left = goal.within.zip(answer.design(&subject.ladder, goal.confidence)).and_then(|(within, design)| {
        let cost = design.cost_of(within.half(fit.value))?;
        Some(cost * answer.spent / answer.cost().max(f64::MIN_POSITIVE))
    });
    if let Some(left) = left.filter(|left| *left > 1.0) {
        // Writing to a string cannot fail.
        let _ = write!(text, ", about {left:.0} s left");
    }
    text
}
