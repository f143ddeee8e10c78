//! `siloflow estimate`: a figure of a scene with its error, from runs that the command chooses.

mod runs;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

use crate::behaviour::Registry;
use crate::cli::estimate::runs::SiloRuns;
use crate::cli::exit_status::ExitStatus;
use crate::cli::run::directory_named;
use crate::cli::signals::Signals;
use crate::cli::sweep::available_cores;
use crate::cli::{SceneArgs, picture_files, refused, say, say_aside, show};
use crate::scene::check::{self, Estimates};
use crate::scene::load;
use crate::scene::loaded::AnyScene;
use crate::studies::estimate::estimator::{Answer, Goal, Refusal, Within, check_step, estimate as estimate_mean};
use crate::studies::estimate::figure::Figure;
use crate::studies::estimate::picture::{Round, picture};
use crate::studies::estimate::results::{Estimate, Outcome, rungs_table, runs_table};
use crate::studies::estimate::softening::Softening;
use crate::studies::estimate::softness::{DEEPEST_AT_REST, DEEPEST_IMPACT, powers, softnesses};
use crate::studies::sweep::Sweep;
use crate::studies::sweep::design::Point;
use crate::studies::sweep::directory::SweepDirectory;
use siloflow_figures::statistics::digits::{digits, short};
use siloflow_figures::statistics::extrapolation::{Ladder, Powers};
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
    /// Print estimate.json.
    #[arg(long)]
    json: bool,
    /// Use the directory of an estimate of another scene, and replace its runs.
    #[arg(long)]
    force: bool,
}

/// The confidence of all intervals.
const CONFIDENCE: f64 = 0.95;

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

/// The scene of an estimate.
struct Subject {
    name: String,
    ladder: Ladder,
    /// Why the contacts are not made softer.
    not_softened: Option<String>,
    keys: Vec<String>,
    /// The points of all runs: the rungs, then the rungs with half of their step.
    points: Vec<Point>,
    is_lattice: bool,
    seed: u64,
}

pub(super) fn estimate(args: &EstimateArgs, registry: &Registry, quiet: bool) -> Result<ExitStatus, Fault> {
    let begun = Instant::now();
    let scene = args.scene.load()?;
    let figure = Figure::parse(&args.figure, matches!(scene, AnyScene::Lattice(_)))?;
    let subject = Subject::of(args, &scene, &figure)?;
    let path = args.out.clone().map_or_else(|| directory_named(&format!("{}-estimate", subject.name)), Ok)?;
    let sweep = subject.sweep(args)?;
    if !quiet {
        subject.warn(&scene);
    }
    // An error of the scene changes nothing.
    sweep.check(crate::studies::sweep::Task { point: 0, seed: subject.seed }, registry)?;
    let goal = Goal {
        within: args.within.or(args.budget.is_none().then_some(USUAL)),
        budget: args.budget,
        cores: args.cores.unwrap_or_else(available_cores).get(),
        confidence: CONFIDENCE,
        is_probability: figure.is_probability(),
    };
    let signals = Signals::catch();
    signals.defer();
    let directory = SweepDirectory::prepare(&path, &sweep, args.force)?;
    let mut runs =
        SiloRuns::new(&sweep, &directory, &figure, &subject.ladder, subject.seed, goal.cores, &signals, quiet);
    let mut rounds = Vec::new();
    let result = answer(&subject, &goal, &mut runs, &mut rounds, quiet);
    let (answer, step) = match result {
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
        not_softened: subject.not_softened.as_deref(),
        runs: runs.records(),
        wall_s: begun.elapsed().as_secs_f64(),
    };
    let records = outcome.runs.clone();
    let estimate = Estimate::of(outcome);
    let json = serde_json::to_string_pretty(&estimate).unwrap_or_default() + "\n";
    let svg = picture(&subject.name, &args.figure, &subject.ladder, &answer, &records, &rounds);
    let mut files = vec![
        (PathBuf::from("estimate.json"), json.clone().into_bytes()),
        (PathBuf::from("runs.csv"), runs_table(&records).into_bytes()),
        (PathBuf::from("rungs.csv"), rungs_table(&subject.ladder, &answer).into_bytes()),
    ];
    files.extend(picture_files("estimate", svg)?.map(|(name, content)| (PathBuf::from(name), content)));
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
    Ok(match (signals.received(), answer.refused) {
        (Some(signal), Some(Refusal::Stopped)) => {
            tracing::error!("interrupted: the same command continues the estimate in {}", path.display());
            ExitStatus::Interrupted(signal)
        }
        (_, Some(_)) => ExitStatus::Failed,
        _ => ExitStatus::Done,
    })
}

/// Finds the answer, then compares half of the step.
fn answer(
    subject: &Subject,
    goal: &Goal,
    runs: &mut SiloRuns,
    rounds: &mut Vec<Round>,
    quiet: bool,
) -> Result<(Answer, Option<crate::studies::estimate::estimator::StepCheck>), Fault> {
    let mut tell = |answer: &Answer| {
        let Some(fit) = answer.fit else { return };
        rounds.push(Round { spent: answer.spent, half: fit.interval.half() });
        if !quiet {
            say_aside(&progress(answer, subject, goal));
        }
    };
    let mut answer = estimate_mean(&subject.ladder, goal, runs, &mut tell)?;
    // A lattice gas has no step, and a scene without chance would need another measure of what is small.
    if subject.is_lattice || answer.is_certain || answer.refused == Some(Refusal::Stopped) || goal.is_probability {
        return Ok((answer, None));
    }
    let half_step = subject.ladder.softness().len() + answer.softest;
    let step = check_step(&mut answer, goal, runs, half_step)?;
    if step.is_some_and(|step| step.is_significant) {
        answer.refused = answer.refused.or(Some(Refusal::Step));
    }
    Ok((answer, step))
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

impl Subject {
    fn of(args: &EstimateArgs, scene: &AnyScene, figure: &Figure) -> Result<Self, Fault> {
        let source = scene.source();
        let mut common = args.scene.set.clone();
        // Pictures and frames change no figure.
        common.push(("pictures".to_owned(), "None".to_owned()));
        let (seed, powers, softening, is_lattice) = match scene {
            AnyScene::Grains(loaded) => {
                common.push(("data_frames".to_owned(), "None".to_owned()));
                (loaded.scene.seed, powers(&loaded.scene.contact), Softening::of(source), false)
            }
            AnyScene::Lattice(loaded) => {
                let powers = Powers { low: 1.0, usual: 1.0, high: 1.0 };
                (loaded.scene.seed, powers, Err("a lattice gas has no stiffness".to_owned()), true)
            }
        };
        let softening = softening.and_then(|softening| {
            if figure.is_probability() {
                Err("a probability is counted, not extrapolated".to_owned())
            } else {
                Ok(softening)
            }
        });
        let mut not_softened = softening.as_ref().err().cloned();
        let softening = softening.ok();
        let softness = softening
            .as_ref()
            .map_or_else(|| vec![1.0], |softening| softnesses(|softness| args.estimates(softening, softness)));
        if softness.len() == 1 && not_softened.is_none() {
            not_softened = Some(format!(
                "with softer contacts grains would overlap by more than {DEEPEST_AT_REST} of their radius at rest, or {DEEPEST_IMPACT} in an impact"
            ));
        }
        let mut keys: Vec<String> = common.iter().map(|(key, _)| key.clone()).collect();
        keys.extend(softening.iter().flat_map(|it| it.paths().map(str::to_owned)));
        keys.push("step".to_owned());
        let mut points = Vec::new();
        for share in [1.0, 0.5] {
            for &softness in &softness {
                let mut values: Vec<String> = common.iter().map(|(_, value)| value.clone()).collect();
                values.extend(softening.iter().flat_map(|it| it.values(softness)));
                let step = if is_lattice { None } else { args.step(softening.as_ref(), softness, share)? };
                values.push(step.unwrap_or_default());
                points.push(Point { values });
            }
            if is_lattice {
                keys.pop();
                for point in &mut points {
                    point.values.pop();
                }
                break;
            }
        }
        Ok(Self {
            name: source.name.clone(),
            ladder: Ladder::new(softness, powers),
            not_softened,
            keys,
            points,
            is_lattice,
            seed,
        })
    }

    /// The sweep whose points are the rungs.
    fn sweep(&self, args: &EstimateArgs) -> Result<Sweep, Fault> {
        let mut text = format!(
            "// The scene of this estimate, and the changes of its keys.\n(\n    scene: {:?},\n    set: {{\n",
            args.scene.scene.display().to_string()
        );
        for (key, value) in &args.scene.set {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "        {key:?}: {value:?},");
        }
        let _ = writeln!(text, "    }},\n    softness: {:?},\n)", self.ladder.softness());
        Sweep::of_points(
            self.name.clone(),
            &args.scene.scene,
            text,
            "estimate.ron",
            self.keys.clone(),
            self.points.clone(),
        )
    }

    /// Logs the warnings of the scene.
    fn warn(&self, scene: &AnyScene) {
        let mut told = BTreeMap::new();
        let AnyScene::Grains(loaded) = scene else { return };
        for warning in check::warnings(loaded) {
            told.entry(warning.code).or_insert_with(|| warning.to_string());
        }
        for warning in told.into_values() {
            tracing::warn!("{}: {warning}", self.name);
        }
    }
}

impl EstimateArgs {
    /// The scene with softer contacts; `None` if it is refused.
    fn softer(&self, softening: Option<&Softening>, softness: f64) -> Option<Box<crate::scene::loaded::Loaded>> {
        let values = softening.map(|it| it.paths().map(str::to_owned).zip(it.values(softness)).collect::<Vec<_>>());
        match load::any(&self.scene.scene, &self.scene.settings(&values.unwrap_or_default())) {
            Ok(AnyScene::Grains(loaded)) => Some(loaded),
            _ => None,
        }
    }

    fn estimates(&self, softening: &Softening, softness: f64) -> Option<Estimates> {
        Estimates::of(&*self.softer(Some(softening), softness)?)
    }

    /// The key `step` of a rung: that of the scene, with softer contacts, times `share`.
    fn step(&self, softening: Option<&Softening>, softness: f64, share: f64) -> Result<Option<String>, Fault> {
        let Some(loaded) = self.softer(softening, softness) else {
            let message = format!("the scene is refused with contacts {softness} times softer");
            return Err(Fault::new("estimate::softness", message).help("this is an error of siloflow"));
        };
        Ok(Some(format!("Fixed({:e})", share * loaded.step())))
    }
}
