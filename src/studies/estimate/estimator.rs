//! The estimator: asks a sampler for runs, rung by rung, until the interval of the figure is narrow enough. It knows nothing of silos.
//!
//! 1. *First runs*: three at the softest rung, two at the next, one at the third; without a ladder four.
//! 2. *Fit* of v + b (s^p - 1) to all runs ([`Ladder::fit`]). A rung is too soft if the law does not hold with it, at a significance of 5 %. Then the
//!    softest rung no longer counts.
//! 3. *Stop* if the interval is as narrow as asked for after two rounds in a row, with [`LEAST_FREEDOM`] degrees of freedom. An interval that is looked
//!    at after each run, and taken when it happens to be narrow, contains the truth less often than it says (0.88 in place of 0.95, if that begins with
//!    two samples). And the stiffest rung must lie near: the law may carry the value by at most [`FARTHEST`] times the half width that is asked for.
//!    Residuals hardly tell a law that fails on the way, but then it has little way to fail on. For the same reason the value without the softest rung may
//!    not differ by more than that half width: if it does, that rung no longer counts.
//! 4. Else the next runs, as many as there are cores ([`Design`]), within the budget.
//!
//! Runs of one rung that end in the same state to the last bit show that the seed has no effect. Then one run at the scene's own stiffness is the
//! answer.
//!
//! Runs of an earlier estimate in the same place all count.
//!
//! The estimator *refuses* if the budget is spent, if more than half of the runs lack the figure, or after [`MOST_RUNS`] runs.

use std::fmt::{self, Display, Formatter};

use siloflow_figures::statistics::extrapolation::{Fit, Group, Ladder, Powers};
use siloflow_figures::statistics::quantile::{binomial, student};
use siloflow_text::fault::Fault;

use super::design::Design;
use super::rung::{Rung, Sample};

/// Least degrees of freedom of an interval that is wide by chance.
pub const LEAST_FREEDOM: usize = 6;

/// Longest way from the stiffest rung to the value, in half widths that are asked for.
pub const FARTHEST: f64 = 1.0;

/// Most runs.
pub const MOST_RUNS: usize = 1000;

/// Runs with half of the step.
const RUNS_OF_HALF_STEP: usize = 2;

/// Significance of a lack of fit.
const LAW_FAILS: f64 = 0.05;

/// Source of runs.
pub trait Sampler {
    /// Returns the runs that are there from an earlier estimate, each with its rung. They cost nothing, and all of them count.
    ///
    /// # Errors
    /// If one of them cannot be read.
    fn known(&mut self) -> Result<Vec<(usize, Sample)>, Fault> {
        Ok(Vec::new())
    }

    /// Makes a run of each of these rungs, independent of all others. Rung n + m of a ladder with n rungs is rung m with half
    /// of its step.
    ///
    /// # Errors
    /// If no run can be made.
    fn take(&mut self, rungs: &[usize]) -> Result<Vec<Sample>, Fault>;

    /// Whether no further runs are wanted.
    fn is_stopped(&self) -> bool;
}

/// Width of the interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Within {
    /// Half of it over the value.
    Share(f64),
    /// Half of it, in the unit of the figure.
    Absolute(f64),
}

impl Within {
    /// Returns the half width for a value.
    #[must_use]
    pub fn half(self, value: f64) -> f64 {
        match self {
            Self::Share(share) => share * value.abs(),
            Self::Absolute(half) => half,
        }
    }
}

/// A request: the width of the interval, or the time.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    /// Width of the interval; `None`: as narrow as the budget allows.
    pub within: Option<Within>,
    /// Time for all runs, s.
    pub budget: Option<f64>,
    /// Runs at a time.
    pub cores: usize,
    /// Probability that the interval contains the mean.
    pub confidence: f64,
    /// Whether each value is 0 or 1, and its mean a probability.
    pub is_probability: bool,
}

/// Why there is no answer as good as asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The budget is spent.
    Budget,
    /// Most runs lack the figure.
    Absent,
    /// Too many runs.
    Runs,
    /// The user has stopped it.
    Stopped,
    /// Half of the step changes the figure.
    Step,
}

impl Display for Refusal {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Budget => "the budget is spent before the interval is as narrow as asked for",
            Self::Absent => "more than half of the runs do not have the figure",
            Self::Runs => "a thousand runs do not make the interval as narrow as asked for",
            Self::Stopped => "interrupted before the interval is as narrow as asked for",
            Self::Step => "half of the step changes the figure: the step of the scene is too long for it",
        })
    }
}

/// The answer.
#[derive(Clone, Debug)]
pub struct Answer {
    /// The fit; `None` without enough runs.
    pub fit: Option<Fit>,
    /// Whether the seed has no effect.
    pub is_certain: bool,
    /// The softest rung that counts.
    pub softest: usize,
    /// The runs of each rung.
    pub rungs: Vec<Rung>,
    /// Why it is not as good as asked for.
    pub refused: Option<Refusal>,
    /// Cost of all runs over the number of cores, s.
    pub spent: f64,
}

impl Answer {
    /// Number of runs.
    #[must_use]
    pub fn runs(&self) -> usize {
        self.rungs.iter().map(Rung::runs).sum()
    }

    /// Number of runs without the figure.
    #[must_use]
    pub fn missing(&self) -> usize {
        self.rungs.iter().map(|rung| rung.missing).sum()
    }

    /// Fits the runs of all rungs up to one.
    fn fit_up_to(&self, softest: usize, ladder: &Ladder, goal: &Goal) -> Option<Fit> {
        let group = |(number, rung): (usize, &Rung)| Group::of(&rung.values).filter(|_| number <= softest);
        let groups: Vec<_> = self.rungs.iter().enumerate().map(group).collect();
        if goal.is_probability {
            return probability(&groups[0]?, goal.confidence);
        }
        ladder.fit(&groups, goal.confidence)
    }

    /// The stiffest rung with the figure.
    #[must_use]
    pub fn stiffest(&self) -> usize {
        self.rungs.iter().position(|rung| !rung.values.is_empty()).unwrap_or(self.softest)
    }

    /// Time of all runs on their cores, s.
    #[must_use]
    pub fn cost(&self) -> f64 {
        self.rungs.iter().map(|rung| rung.cost).sum()
    }

    /// The design of the runs so far; `None` without a fit.
    #[must_use]
    pub fn design<'a>(&self, ladder: &'a Ladder, confidence: f64) -> Option<Design<'a>> {
        Some(Design::new(ladder, confidence, self.fit.as_ref()?, &self.rungs, self.softest))
    }
}

/// Estimates the mean at softness 1. `tell` receives the state after each round.
///
/// # Errors
/// If a run cannot be made.
pub fn estimate(
    ladder: &Ladder,
    goal: &Goal,
    sampler: &mut impl Sampler,
    tell: &mut dyn FnMut(&Answer),
) -> Result<Answer, Fault> {
    let last = ladder.softness().len() - 1;
    let rungs = vec![Rung::default(); ladder.softness().len()];
    let mut answer = Answer { fit: None, is_certain: false, softest: last, rungs, refused: None, spent: 0.0 };
    let first: &[usize] = match last {
        0 => &[0, 0, 0, 0],
        1 => &[1, 1, 1, 0],
        _ => &[last, last, last, last - 1, last - 1, last - 2],
    };
    let mut next = first.to_vec();
    for (rung, sample) in sampler.known()? {
        answer.rungs[rung].add(sample);
        if let Some(place) = next.iter().position(|other| *other == rung) {
            next.remove(place);
        }
    }
    let mut is_narrow = false;
    loop {
        let made = take(goal, sampler, &next, &mut answer.spent)?;
        next.iter().zip(made).for_each(|(rung, sample)| answer.rungs[*rung].add(sample));
        judge(&mut answer, ladder, goal);
        tell(&answer);
        let was_narrow = std::mem::replace(&mut is_narrow, is_as_narrow(&answer, goal));
        let is_far = is_narrow && is_far(&answer, ladder, goal);
        if is_narrow && !is_far && (was_narrow || answer.is_certain) {
            return Ok(answer);
        }
        if sampler.is_stopped() {
            answer.refused = Some(Refusal::Stopped);
        }
        if answer.refused.is_some() {
            return Ok(answer);
        }
        next = plan(&answer, ladder, goal, is_far);
        if next.is_empty() {
            answer.refused = (goal.within.is_some() || answer.fit.is_none()).then_some(Refusal::Budget);
            return Ok(answer);
        }
    }
}

/// Makes runs, as many at a time as there are cores, until the user stops them. `spent` is the time of all runs so far, s.
fn take(goal: &Goal, sampler: &mut impl Sampler, rungs: &[usize], spent: &mut f64) -> Result<Vec<Sample>, Fault> {
    let mut all = Vec::new();
    for part in rungs.chunks(goal.cores.max(1)) {
        if sampler.is_stopped() {
            break;
        }
        let made = sampler.take(part)?;
        *spent += made.iter().map(|sample| sample.cost).fold(0.0, f64::max);
        all.extend(made);
    }
    Ok(all)
}

/// Fits all runs, leaves out rungs that are too soft, and finds the reasons to give up.
fn judge(answer: &mut Answer, ladder: &Ladder, goal: &Goal) {
    answer.is_certain = answer.rungs.iter().any(Rung::is_certain);
    loop {
        answer.fit = answer.fit_up_to(answer.softest, ladder, goal);
        let fails = answer.fit.is_some_and(|fit| fit.lack_of_fit < LAW_FAILS);
        // A rung without any figure is too soft too, if a stiffer one has some.
        let is_empty = answer.rungs[answer.softest].values.is_empty() && answer.rungs[answer.softest].runs() > 2;
        if answer.softest == 0 || !(fails || is_empty || is_unstable(answer, ladder, goal)) {
            break;
        }
        answer.softest -= 1;
    }
    let runs = answer.runs();
    if runs >= 6 && 2 * answer.missing() > runs {
        answer.refused = Some(Refusal::Absent);
    } else if runs >= MOST_RUNS {
        answer.refused = Some(Refusal::Runs);
    }
}

/// Returns the estimate of a probability from zeros and ones. The runs are all at softness 1.
fn probability(group: &Group, confidence: f64) -> Option<Fit> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "counts of runs")]
    let [hits, trials] = [group.mean * group.count, group.count].map(|count| count.round() as usize);
    let interval = binomial(confidence, hits, trials);
    let powers = Powers { low: 1.0, usual: 1.0, high: 1.0 };
    let deviation = (group.mean * (1.0 - group.mean)).sqrt();
    (trials > 1).then_some(Fit {
        value: group.mean,
        interval,
        chance: interval.half(),
        powers,
        slope: 0.0,
        deviation,
        freedom: trials - 1,
        lack_of_fit: 1.0,
    })
}

/// Whether the value depends on the softest rung: an interval that is narrow enough, and a value without that rung that is farther away.
fn is_unstable(answer: &Answer, ladder: &Ladder, goal: &Goal) -> bool {
    let used = answer.rungs[..answer.softest].iter().filter(|rung| !rung.values.is_empty()).count();
    if used < 3 || !is_as_narrow(answer, goal) {
        return false;
    }
    let without = answer.fit_up_to(answer.softest - 1, ladder, goal);
    let (Some(within), Some(fit), Some(without)) = (goal.within, answer.fit, without) else { return false };
    (without.value - fit.value).abs() > within.half(fit.value)
}

/// Whether the interval is as narrow as asked for.
fn is_as_narrow(answer: &Answer, goal: &Goal) -> bool {
    if answer.is_certain {
        return !answer.rungs[0].values.is_empty();
    }
    let Some((within, fit)) = goal.within.zip(answer.fit) else { return false };
    fit.freedom >= LEAST_FREEDOM && fit.interval.half() <= within.half(fit.value)
}

/// Whether the value is far from the mean of the stiffest rung with runs.
fn is_far(answer: &Answer, ladder: &Ladder, goal: &Goal) -> bool {
    let (Some(within), Some(fit)) = (goal.within, answer.fit) else { return false };
    let way = (fit.at(ladder.softness()[answer.stiffest()]) - fit.value).abs();
    !answer.is_certain && way > FARTHEST * within.half(fit.value)
}

/// Returns the rungs of the next runs: none if the budget does not allow any.
fn plan(answer: &Answer, ladder: &Ladder, goal: &Goal, is_far: bool) -> Vec<usize> {
    let left = goal.budget.map_or(f64::INFINITY, |budget| budget - answer.spent);
    if ladder.softness().len() == 1 && !answer.is_certain {
        let is_affordable = answer.rungs[0].cost_of_a_run() <= left;
        return vec![0; if is_affordable { goal.cores.max(1) } else { 0 }];
    }
    let mut next = Vec::new();
    match answer.design(ladder, goal.confidence) {
        Some(design) if is_far => next.extend(Some(answer.stiffest() - 1).filter(|rung| design.cost(*rung) <= left)),
        Some(mut design) if !answer.is_certain => {
            // An interval that only has to prove itself needs the cheapest runs that keep it narrow.
            let half = goal.within.zip(answer.fit).map(|(within, fit)| within.half(fit.value));
            let target = half.filter(|half| answer.fit.is_some_and(|fit| fit.interval.half() <= *half));
            while next.len() < goal.cores.max(1) {
                let rung = design.add_best(target);
                if design.cost(rung) > left {
                    // A cheaper run is better than none.
                    let affordable = (rung + 1..=answer.softest).find(|rung| design.cost(*rung) <= left);
                    next.extend(affordable);
                    break;
                }
                next.push(rung);
            }
        }
        // Without a fit, or without chance: the scene's own stiffness, or a rung that still lacks runs.
        _ => {
            let rung = if answer.is_certain { 0 } else { answer.softest };
            let known = answer.rungs.iter().find(|rung| rung.runs() > 0).map_or(0.0, Rung::cost_of_a_run);
            if known <= left {
                next.push(rung);
            }
        }
    }
    next
}

/// The effect of half of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepCheck {
    /// Change of the mean.
    pub change: f64,
    /// Its standard error.
    pub error: f64,
    /// Whether it is more than chance, at a significance of 1 %.
    pub is_significant: bool,
}

/// Compares the softest rung that counts with runs of half of its step. `None` if there is nothing to compare.
///
/// # Errors
/// If a run cannot be made.
pub fn check_step(
    answer: &mut Answer,
    goal: &Goal,
    sampler: &mut impl Sampler,
    half_step: usize,
) -> Result<Option<StepCheck>, Fault> {
    let Some(fit) = answer.fit else { return Ok(None) };
    let Some(own) = Group::of(&answer.rungs[answer.softest].values) else { return Ok(None) };
    let mut half = Rung::default();
    let made = take(goal, sampler, &[half_step; RUNS_OF_HALF_STEP], &mut answer.spent)?;
    for sample in made {
        half.add(sample);
    }
    let Some(halved) = Group::of(&half.values) else { return Ok(None) };
    let change = halved.mean - own.mean;
    let error = fit.deviation * (1.0 / halved.count + 1.0 / own.count).sqrt();
    let limit = student(0.99, fit.freedom);
    Ok(Some(StepCheck { change, error, is_significant: change.abs() > limit * error }))
}
