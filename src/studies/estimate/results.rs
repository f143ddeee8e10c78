//! The results of an estimate: `estimate.json`, `runs.csv` and `rungs.csv`.
//!
//! Shares of the error are halves of widths: *chance* is what would remain if the power of the law were known, *stiffness* is the rest. The *step* has no
//! share: its effect is either below what the runs can tell, or the estimate is refused.

use std::fmt::Write as _;

use serde::Serialize;

use super::answer::Answer;
use super::comparison::Comparison;
use super::goal::Within;
use super::growth::Growth;
use siloflow_figures::statistics::extrapolation::{Group, Ladder};

/// A run of an estimate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunRecord {
    /// Its directory below `runs`.
    pub run: String,
    /// Softness of its contacts: the stiffness of the scene over theirs.
    pub softness: f64,
    /// Share by which its radii are larger.
    pub growth: f64,
    /// Whether it only measured the overlaps that growth makes up for: it does not count for the value.
    pub overlaps_only: bool,
    /// Its step over that of the other runs of this softness: 1 or 1/2.
    pub step_share: f64,
    /// Whether its silo is the larger one.
    pub is_larger: bool,
    /// Its seed.
    pub seed: u64,
    /// Its status.
    pub status: String,
    /// The figure; `null` if the run does not have it.
    pub value: Option<f64>,
    /// Time on its core, s.
    pub wall_s: f64,
}

impl RunRecord {
    /// Whether its figure may count for the value.
    #[must_use]
    pub fn is_of_ladder(&self) -> bool {
        self.step_share >= 1.0 && !self.is_larger && !self.overlaps_only
    }
}

/// Halves of the width of the interval by their source, in the unit of the figure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sources {
    /// Scatter of runs.
    pub chance: f64,
    /// The unknown power with which the figure depends on the stiffness.
    pub stiffness: f64,
    /// Change of the mean with half of the step; `null` if it was not compared.
    pub step: Option<f64>,
    /// Standard error of this change.
    pub step_error: Option<f64>,
}

/// The overlaps that larger radii make up for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GrowthFigures {
    /// Mean overlap of contacts between grains at rest, over the mean radius of the pair, in a first run without growth.
    pub overlap: f64,
    /// Softness of that run.
    pub softness: f64,
}

/// The effect of a larger silo.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SizeFigures {
    /// Its keys and values, as `--size` gave them.
    pub settings: Vec<String>,
    /// Change of the mean; `null` if it was not compared.
    pub change: Option<f64>,
    /// Standard error of this change.
    pub error: Option<f64>,
    /// Whether it is more than chance, at a significance of 1 %.
    pub is_significant: bool,
}

/// The cost of a narrower interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tighter {
    /// Half of its width, in the unit of the figure.
    pub half_width: f64,
    /// Expected further time with the same number of cores, s; `null` if no number of runs is expected to do.
    pub wall_s: Option<f64>,
}

/// The law through the rungs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LawFigures {
    /// Its power.
    pub power: f64,
    /// The powers that the runs allow.
    pub power_range: [f64; 2],
    /// Its factor, in the unit of the figure.
    pub factor: f64,
    /// Largest softness that counts.
    pub softest: f64,
}

/// `estimate.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// Version of this format.
    pub format: u32,
    /// Name of the scene.
    pub scene: String,
    /// The figure.
    pub figure: String,
    /// The mean of the figure over seeds, at the stiffness and step of the scene; `null` without enough runs.
    pub value: Option<f64>,
    /// Its confidence interval.
    pub interval: Option<[f64; 2]>,
    /// Probability that such an interval contains the mean.
    pub confidence: f64,
    /// Half of the width that was asked for, in the unit of the figure.
    pub wanted_half_width: Option<f64>,
    /// Why the answer is not as good as asked for; else `null`.
    pub refused: Option<String>,
    /// Whether more than one run in twenty lacks the figure: the mean is that of the others.
    pub is_conditional: bool,
    /// Whether all seeds give the same run.
    pub is_certain: bool,
    /// Shares of the error.
    pub sources: Option<Sources>,
    /// Standard deviation of the figure of a single run.
    pub spread: Option<f64>,
    /// The law through the rungs; `null` if all runs have the stiffness of the scene.
    pub law: Option<LawFigures>,
    /// Why the contacts were not made softer; `null` if they were.
    pub not_softened: Option<String>,
    /// The growth of softer grains; `null` without.
    pub growth: Option<GrowthFigures>,
    /// The effect of a larger silo; `null` without.
    pub size: Option<SizeFigures>,
    /// Cost of an interval of half this width.
    pub tighter: Option<Tighter>,
    /// Number of runs without the figure.
    pub missing: usize,
    /// All runs.
    pub runs: Vec<RunRecord>,
    /// Time of this call, s.
    pub wall_s: f64,
    /// Time of all runs on their cores, s.
    pub core_s: f64,
}

/// The parts from which the results are made.
#[derive(Clone, Debug)]
pub struct Outcome<'a> {
    /// Name of the scene.
    pub scene: &'a str,
    /// The figure.
    pub figure: &'a str,
    /// The ladder.
    pub ladder: &'a Ladder,
    /// Confidence of the interval.
    pub confidence: f64,
    /// The width that was asked for.
    pub within: Option<Within>,
    /// The answer.
    pub answer: &'a Answer,
    /// The effect of half of the step.
    pub step: Option<Comparison>,
    /// The keys and values of a larger silo.
    pub size: &'a [String],
    /// Its effect.
    pub larger: Option<Comparison>,
    /// Why the contacts were not made softer.
    pub not_softened: Option<&'a str>,
    /// The growth of softer grains.
    pub growth: Option<&'a Growth>,
    /// All runs.
    pub runs: Vec<RunRecord>,
    /// Time of the call, s.
    pub wall_s: f64,
}

impl Estimate {
    /// Makes the results.
    #[must_use]
    pub fn of(outcome: Outcome) -> Self {
        let Outcome { ladder, answer, step, .. } = outcome;
        let fit = answer.fit;
        // A scene without chance has the figure of its one run.
        let certain = answer.is_certain.then(|| answer.rungs[0].values.first().copied()).flatten();
        let value = certain.or(fit.map(|fit| fit.value));
        let interval = certain.map(|value| [value; 2]).or(fit.map(|fit| [fit.interval.low, fit.interval.high]));
        let sources = fit.filter(|_| certain.is_none()).map(|fit| Sources {
            chance: fit.chance,
            stiffness: (fit.interval.half() - fit.chance).max(0.0),
            step: step.map(|step| step.change),
            step_error: step.map(|step| step.error),
        });
        let is_extrapolated = answer.rungs[1..].iter().any(|rung| !rung.values.is_empty()) && certain.is_none();
        let law = fit.filter(|_| is_extrapolated).map(|fit| LawFigures {
            power: fit.powers.usual,
            power_range: [fit.powers.low, fit.powers.high],
            factor: fit.slope,
            softest: ladder.softness()[answer.softest],
        });
        let half = fit.filter(|_| certain.is_none()).map(|fit| 0.5 * fit.interval.half()).filter(|half| *half > 0.0);
        let tighter = half.zip(answer.design(ladder, outcome.confidence)).map(|(half_width, design)| Tighter {
            half_width,
            wall_s: design.cost_of(half_width).map(|cost| cost * answer.spent / answer.cost().max(f64::MIN_POSITIVE)),
        });
        Self {
            format: 1,
            scene: outcome.scene.to_owned(),
            figure: outcome.figure.to_owned(),
            value,
            interval,
            confidence: outcome.confidence,
            wanted_half_width: outcome.within.zip(value).map(|(within, value)| within.half(value)),
            refused: answer.refused.map(|refusal| refusal.to_string()),
            is_conditional: 20 * answer.missing() > answer.runs(),
            is_certain: answer.is_certain,
            sources,
            spread: fit.filter(|_| certain.is_none()).map(|fit| fit.deviation),
            law,
            not_softened: outcome.not_softened.map(str::to_owned),
            size: (!outcome.size.is_empty()).then(|| SizeFigures {
                settings: outcome.size.to_vec(),
                change: outcome.larger.map(|it| it.change),
                error: outcome.larger.map(|it| it.error),
                is_significant: outcome.larger.is_some_and(|it| it.is_significant),
            }),
            growth: outcome.growth.map(|it| GrowthFigures { overlap: it.overlap, softness: it.softness }),
            tighter,
            missing: answer.missing(),
            // An empty sum of doubles would be -0.
            core_s: outcome.runs.iter().fold(0.0, |sum, run| sum + run.wall_s),
            runs: outcome.runs,
            wall_s: outcome.wall_s,
        }
    }
}

/// Returns a table with a row for each run.
#[must_use]
pub fn runs_table(runs: &[RunRecord]) -> String {
    let mut text = String::from("run,softness,growth,overlaps_only,step_share,is_larger,seed,status,value,wall_s\n");
    for run in runs {
        let value = run.value.map_or_else(String::new, |value| value.to_string());
        let RunRecord { run, softness, growth, overlaps_only, step_share, is_larger, seed, status, wall_s, .. } = run;
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{run},{softness},{growth},{overlaps_only},{step_share},{is_larger},{seed},{status},{value},{wall_s}"
        );
    }
    text
}

/// Returns a table with a row for each rung that has runs.
#[must_use]
pub fn rungs_table(ladder: &Ladder, answer: &Answer) -> String {
    let mut text = String::from("softness,runs,missing,mean,standard_deviation,fit,counts,wall_s_of_a_run\n");
    for (number, (softness, rung)) in ladder.softness().iter().zip(&answer.rungs).enumerate() {
        if rung.runs() == 0 {
            continue;
        }
        let group = Group::of(&rung.values);
        let cell = |number: Option<f64>| number.map_or_else(String::new, |number| number.to_string());
        let mean = cell(group.map(|group| group.mean));
        let deviation =
            cell(group.filter(|group| group.count > 1.0).map(|group| (group.squares / (group.count - 1.0)).sqrt()));
        let fit = cell(answer.fit.map(|fit| fit.at(*softness)));
        let counts = u8::from(number <= answer.softest);
        let (runs, missing, cost) = (rung.runs(), rung.missing, rung.cost_of_a_run());
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{softness},{runs},{missing},{mean},{deviation},{fit},{counts},{cost}");
    }
    text
}
