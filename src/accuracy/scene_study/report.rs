//! What the ladder of a scene tells, and which step it recommends.
//!
//! Recommended is the coarsest step from which on no observable differs from the finest by more than both the noise and
//! the wanted error. The energy balance is shown and judged by itself, and takes no part: it says how well the books
//! are kept.

use std::fmt::Write as _;

use serde::Serialize;

use super::Rung;
use super::observe::{Kind, OBSERVABLES};
use super::verdict::{Mean, Standing};
use crate::accuracy::cost::median;

/// An observable at one step.
#[derive(Clone, Debug, Serialize)]
pub struct Figure {
    /// With its unit.
    pub name: &'static str,
    /// Mean and standard error.
    #[serde(flatten)]
    pub mean: Mean,
    /// Over the finest's, less 1; of what is an error by itself, `null`.
    pub difference: Option<f64>,
    /// How it stands to the finest.
    pub standing: Option<Standing>,
}

/// A step of the ladder.
#[derive(Clone, Debug, Serialize)]
pub struct Step {
    /// In the scene's own.
    pub factor: f64,
    /// s.
    pub step_s: f64,
    /// Why it was not run.
    pub refused: Option<String>,
    /// How many of the runs failed, and why the first did.
    pub failed: usize,
    /// Why.
    pub failure: Option<String>,
    /// Median wall-clock time of a run, s.
    pub wall_s: Option<f64>,
    /// Median nanoseconds a particle-step.
    pub ns_per_particle_step: Option<f64>,
    /// What was observed.
    pub observables: Vec<Figure>,
}

impl Step {
    /// Whether all its runs ended well.
    fn is_usable(&self) -> bool {
        self.refused.is_none() && self.failed == 0 && self.wall_s.is_some()
    }

    fn standings(&self) -> impl Iterator<Item = Standing> {
        self.observables.iter().filter_map(|figure| figure.standing)
    }
}

/// The answer.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    /// Version of this contract.
    pub format: u32,
    /// Name of the scene.
    pub scene: String,
    /// Seeds asked for.
    pub seeds: u32,
    /// Whether the seed changes anything.
    pub seed_matters: bool,
    /// The wanted error.
    pub error: f64,
    /// Coarse to fine.
    pub steps: Vec<Step>,
    /// Whether no step can be told from the finest in any observable.
    pub no_step_told_apart: bool,
    /// The recommended step, s; `null` if only the finest will do, which then has nothing to be judged by.
    pub recommended_step_s: Option<f64>,
    /// Why, in words.
    pub reason: String,
}

impl Study {
    pub(super) fn new(scene: &str, rungs: &[Rung], seeds: u32, seed_matters: bool, error: f64) -> Self {
        let mut steps: Vec<Step> = rungs.iter().map(step).collect();
        let finest = steps.iter().rposition(Step::is_usable);
        if let Some(finest) = finest {
            judge(&mut steps, finest, error);
        }
        let judged = || steps.iter().enumerate().filter(|(n, step)| Some(*n) != finest && step.is_usable());
        let no_step_told_apart =
            judged().count() > 0 && judged().all(|(_, step)| !step.standings().any(Standing::is_told_apart));
        let fits = |step: &Step| step.is_usable() && step.standings().all(|standing| standing != Standing::Differs);
        let good = finest.map_or(0, |finest| steps[..finest].iter().rev().take_while(|step| fits(step)).count());
        let chosen = finest.filter(|_| good > 0).map(|finest| finest - good);
        let mut study = Self {
            format: 1,
            scene: scene.to_owned(),
            seeds,
            seed_matters,
            error,
            no_step_told_apart,
            recommended_step_s: chosen.map(|n| steps[n].step_s),
            reason: String::new(),
            steps,
        };
        study.reason = study.reason_for(chosen);
        study
    }

    fn reason_for(&self, chosen: Option<usize>) -> String {
        let Some(chosen) = chosen else {
            return format!(
                "every step but the finest that ran differs from it by more than {:e}: run finer steps, by a smaller `step` \
                 in the scene",
                self.error
            );
        };
        let step = &self.steps[chosen];
        let mut words = format!("step {:.3e} s, {} times the scene's own", step.step_s, step.factor);
        if chosen == 0 {
            words += ", the coarsest that was tried";
        }
        if !self.seed_matters && self.seeds > 1 {
            words += "; the seed changes nothing here, so every difference is the step's";
        } else if self.seeds == 1 {
            words += "; with one seed chance cannot be told from the step: ask for more with --seeds";
        } else if self.no_step_told_apart {
            words += "; no step can be told from another within the noise of the seeds: any stable step gives these statistics";
        } else {
            let (shown, hidden) = self.told_apart();
            let _ = write!(words, "; the step shows in {}", shown.join(", "));
            if !hidden.is_empty() {
                let _ = write!(words, "; any stable step gives the same {}, within the noise", hidden.join(", "));
            }
        }
        if let Some((name, bound, runs)) = self.noisiest(chosen).filter(|(_, bound, _)| *bound > self.error) {
            let _ = write!(
                words,
                "; noise hides differences of {name} below {bound:.1e}: to see {:e} would take some {:.0} seeds",
                self.error,
                runs.ceil()
            );
        }
        words
    }

    /// The observables in which a step shows, and those in which none does.
    fn told_apart(&self) -> (Vec<&'static str>, Vec<&'static str>) {
        let shows = |name: &str| {
            let figures = self.steps.iter().filter(|step| step.is_usable()).flat_map(|step| &step.observables);
            let mut standings = figures.filter(|figure| figure.name == name).filter_map(|figure| figure.standing);
            standings.any(Standing::is_told_apart)
        };
        let judged = |name: &&str| {
            let mut figures = self.steps.iter().filter(|step| step.is_usable()).flat_map(|step| &step.observables);
            figures.any(|figure| figure.name == *name && figure.standing.is_some())
        };
        OBSERVABLES.iter().map(|(name, _)| *name).filter(judged).partition(|name| shows(name))
    }

    /// The observable of a step whose noise leaves most room, how much, relatively, and how many seeds would see the
    /// error.
    fn noisiest(&self, n: usize) -> Option<(&'static str, f64, f64)> {
        let finest = self.steps.iter().rfind(|step| step.is_usable())?;
        let of = |figure: &Figure| {
            figure.standing?;
            let other = &finest.observables.iter().find(|other| other.name == figure.name)?.mean;
            let mean = &figure.mean;
            Some((figure.name, mean.noise(other) / other.mean.abs(), mean.runs_for(other, self.error)))
        };
        self.steps[n].observables.iter().filter_map(of).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// For people.
    #[must_use]
    pub fn table(&self) -> String {
        let mut text = format!("{}: {} seeds, wanted error {:e}\n", self.scene, self.seeds, self.error);
        for step in &self.steps {
            let (factor, dt) = (step.factor, step.step_s);
            // Writing to a string cannot fail, here and below.
            let _ = match (&step.refused, step.wall_s, step.ns_per_particle_step) {
                (Some(why), ..) => writeln!(text, "\nstep {dt:.3e} s, {factor} of its own: refused: {why}"),
                (None, Some(wall), Some(ns)) => {
                    writeln!(
                        text,
                        "\nstep {dt:.3e} s, {factor} of its own: {wall:.2} s a run, {ns:.1} ns a particle-step"
                    )
                }
                _ => writeln!(text, "\nstep {dt:.3e} s, {factor} of its own"),
            };
            if let Some(why) = &step.failure {
                let _ = writeln!(text, "  {} failed: {why}", step.failed);
            }
            for figure in &step.observables {
                let error = figure.mean.standard_error.map_or_else(String::new, |se| format!("+- {se:.1e}"));
                let difference = figure.difference.map_or_else(String::new, |d| format!("{d:+.1e}"));
                let standing = figure.standing.map_or("", |standing| match standing {
                    Standing::Finest => "reference",
                    Standing::Within => "same within the error",
                    Standing::NotToldApart => "same within the noise",
                    Standing::DiffersWithin => "* differs, within the error",
                    Standing::Differs => "** differs",
                });
                let (name, mean) = (figure.name, figure.mean.mean);
                let _ = writeln!(text, "  {name:<22} {mean:>12.6e} {error:<10} {difference:>9}  {standing}");
            }
        }
        let _ = writeln!(text, "\nrecommended: {}", self.reason);
        text
    }
}

fn step(rung: &Rung) -> Step {
    let done: Vec<_> = rung.runs.iter().filter(|run| run.failure.is_none()).collect();
    let figure = |(number, (name, _)): (usize, &(&'static str, Kind))| {
        let values: Option<Vec<f64>> = done.iter().map(|run| run.values[number]).collect();
        Some(Figure { name, mean: Mean::of(&values?)?, difference: None, standing: None })
    };
    Step {
        factor: rung.factor,
        step_s: rung.step,
        refused: rung.refusal.clone(),
        failed: rung.runs.len() - done.len(),
        failure: rung.runs.iter().find_map(|run| run.failure.clone()),
        wall_s: median(&mut done.iter().map(|run| run.wall_s).collect::<Vec<_>>()),
        ns_per_particle_step: median(&mut done.iter().map(|run| run.ns_per_particle_step).collect::<Vec<_>>()),
        observables: OBSERVABLES.iter().enumerate().filter_map(figure).collect(),
    }
}

/// Holds every observable against that of the finest usable step.
fn judge(steps: &mut [Step], finest: usize, error: f64) {
    let reference = steps[finest].observables.clone();
    for (n, step) in steps.iter_mut().enumerate() {
        for figure in &mut step.observables {
            let is_value = OBSERVABLES.iter().any(|(name, kind)| *name == figure.name && *kind == Kind::Value);
            let Some(other) = reference.iter().find(|other| other.name == figure.name).filter(|_| is_value) else {
                continue;
            };
            figure.difference = (n != finest).then(|| figure.mean.mean / other.mean.mean - 1.0);
            figure.standing =
                Some(if n == finest { Standing::Finest } else { Standing::of(&figure.mean, &other.mean, error) });
        }
    }
}
