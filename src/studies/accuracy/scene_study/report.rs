//! Results of a scene study, and the recommended step.
//!
//! The recommended step is the coarsest step with this property: at this and all finer steps, no observable differs
//! from its value at the finest step by more than both the noise and the target error. The error of the energy balance
//! is shown but does not affect the recommendation, because it measures the quality of the energy balance itself.

use std::fmt::Write as _;

use serde::Serialize;

use super::observe::{Kind, OBSERVABLES, Rung};
use super::verdict::{MeanOfRuns, Standing};
use siloflow_figures::statistics::mean::median;

/// An observable at one step.
#[derive(Clone, Debug, Serialize)]
pub struct Figure {
    /// Name with unit.
    pub name: &'static str,
    /// Mean and standard error.
    #[serde(flatten)]
    pub mean: MeanOfRuns,
    /// Relative difference from the mean at the finest step; `null` at the finest step and for [`Kind::Error`].
    pub difference: Option<f64>,
    /// Comparison with the finest step; `null` for [`Kind::Error`].
    pub standing: Option<Standing>,
}

/// Results at one step of the ladder.
#[derive(Clone, Debug, Serialize)]
pub struct Step {
    /// Step in units of the scene's own step.
    pub factor: f64,
    /// Step, s.
    pub step_s: f64,
    /// Reason why the step was not run.
    pub refused: Option<String>,
    /// Number of failed runs.
    pub failed: usize,
    /// Reason of the first failure.
    pub failure: Option<String>,
    /// Median wall-clock time of a run, s.
    pub wall_s: Option<f64>,
    /// Median computing time per particle-step, ns.
    pub ns_per_particle_step: Option<f64>,
    /// Observables of the runs that did not fail.
    pub observables: Vec<Figure>,
}

impl Step {
    /// Returns whether the step was run and no run failed.
    fn is_usable(&self) -> bool {
        self.refused.is_none() && self.failed == 0 && self.wall_s.is_some()
    }

    fn standings(&self) -> impl Iterator<Item = Standing> {
        self.observables.iter().filter_map(|figure| figure.standing)
    }
}

/// The full results of a scene study.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    /// Version of the JSON format.
    pub format: u32,
    /// Name of the scene.
    pub scene: String,
    /// Requested number of seeds.
    pub seeds: u32,
    /// Whether the seed has any effect.
    pub seed_matters: bool,
    /// Target relative error.
    pub error: f64,
    /// Results by step, coarse to fine.
    pub steps: Vec<Step>,
    /// Whether no step can be distinguished from the finest step in any observable.
    pub no_step_told_apart: bool,
    /// Recommended step, s.
    ///
    /// It is `null` if only the finest step is acceptable, because no finer step exists against which to judge it.
    pub recommended_step_s: Option<f64>,
    /// Explanation of the recommendation.
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
                "every step except the finest one differs from the finest one by more than {:e}: set a smaller `step` in \
                 the scene",
                self.error
            );
        };
        let step = &self.steps[chosen];
        let mut words = format!("step {:.3e} s, {} times the scene's own", step.step_s, step.factor);
        if chosen == 0 {
            words += ", the coarsest step of the ladder";
        }
        if !self.seed_matters && self.seeds > 1 {
            words += "; the seed changes nothing here, so every difference is due to the step";
        } else if self.seeds == 1 {
            words += "; one seed cannot separate chance from the effect of the step: use more seeds with --seeds";
        } else if self.no_step_told_apart {
            words += "; no step differs by more than the noise of the seeds: any stable step gives these statistics";
        } else {
            let (affected, unaffected) = self.affected_and_unaffected();
            let _ = write!(words, "; the step affects {}", affected.join(", "));
            if !unaffected.is_empty() {
                let _ = write!(words, "; any stable step gives the same {}, within the noise", unaffected.join(", "));
            }
        }
        if let Some((name, bound, runs)) = self.noisiest(chosen).filter(|(_, bound, _)| *bound > self.error) {
            let _ = write!(
                words,
                "; noise hides differences of {name} below {bound:.1e}: to resolve {:e} needs about {:.0} seeds",
                self.error,
                runs.ceil()
            );
        }
        words
    }

    /// Returns the observables that the step affects by more than the noise, and the other judged observables.
    fn affected_and_unaffected(&self) -> (Vec<&'static str>, Vec<&'static str>) {
        let is_affected = |name: &str| {
            let figures = self.steps.iter().filter(|step| step.is_usable()).flat_map(|step| &step.observables);
            let mut standings = figures.filter(|figure| figure.name == name).filter_map(|figure| figure.standing);
            standings.any(Standing::is_told_apart)
        };
        let judged = |name: &&str| {
            let mut figures = self.steps.iter().filter(|step| step.is_usable()).flat_map(|step| &step.observables);
            figures.any(|figure| figure.name == *name && figure.standing.is_some())
        };
        OBSERVABLES.iter().map(|(name, _)| *name).filter(judged).partition(|name| is_affected(name))
    }

    /// Returns the observable with the largest relative noise at step number `n`, that noise, and the number of seeds
    /// that would resolve the target error.
    fn noisiest(&self, n: usize) -> Option<(&'static str, f64, f64)> {
        let finest = self.steps.iter().rfind(|step| step.is_usable())?;
        let relative_noise = |figure: &Figure| {
            figure.standing?;
            let other = &finest.observables.iter().find(|other| other.name == figure.name)?.mean;
            let mean = &figure.mean;
            Some((figure.name, mean.noise(other) / other.mean.abs(), mean.runs_for(other, self.error)))
        };
        self.steps[n].observables.iter().filter_map(relative_noise).max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Returns the study as a plain-text table.
    #[must_use]
    pub fn table(&self) -> String {
        let mut text = format!("{}: {} seeds, target error {:e}\n", self.scene, self.seeds, self.error);
        for step in &self.steps {
            let factor = step.factor;
            let dt = step.step_s;
            // Writing to a string cannot fail.
            let _ = match (&step.refused, step.wall_s, step.ns_per_particle_step) {
                (Some(why), ..) => writeln!(text, "\nstep {dt:.3e} s, {factor} of the scene's: refused: {why}"),
                (None, Some(wall), Some(ns)) => {
                    writeln!(
                        text,
                        "\nstep {dt:.3e} s, {factor} of the scene's: {wall:.2} s per run, {ns:.1} ns per particle-step"
                    )
                }
                _ => writeln!(text, "\nstep {dt:.3e} s, {factor} of the scene's"),
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
                let name = figure.name;
                let mean = figure.mean.mean;
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
        Some(Figure { name, mean: MeanOfRuns::of(&values?)?, difference: None, standing: None })
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

/// Compares every observable with its value at the finest usable step, and sets the results in `steps`.
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
