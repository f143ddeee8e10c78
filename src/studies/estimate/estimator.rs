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
//! 4. Else the next runs, as many as there are cores ([`Design`](super::design::Design)), within the budget.
//!
//! Runs of one rung that end in the same state to the last bit show that the seed has no effect. Then one run at the scene's own stiffness is the
//! answer.
//!
//! Runs of an earlier estimate in the same place all count.
//!
//! The estimator *refuses* if the budget is spent, if more than half of the runs lack the figure, or after [`MOST_RUNS`] runs.

use siloflow_figures::statistics::extrapolation::Ladder;
use siloflow_text::fault::Fault;

use super::answer::Answer;
use super::goal::{Goal, Refusal};
use super::rung::{Rung, Sample};

/// Least degrees of freedom of an interval that is wide by chance.
pub const LEAST_FREEDOM: usize = 6;

/// Longest way from the stiffest rung to the value, in half widths that are asked for.
pub const FARTHEST: f64 = 1.0;

/// Most runs.
pub const MOST_RUNS: usize = 1000;

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

    /// Makes a run of each of these rungs, independent of all others. Numbers beyond the ladder are those of changed scenes, for
    /// [`compare`](super::comparison::compare).
    ///
    /// # Errors
    /// If no run can be made.
    fn take(&mut self, rungs: &[usize]) -> Result<Vec<Sample>, Fault>;

    /// Whether no further runs are wanted.
    fn is_stopped(&self) -> bool;
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
pub(super) fn take(
    goal: &Goal,
    sampler: &mut impl Sampler,
    rungs: &[usize],
    spent: &mut f64,
) -> Result<Vec<Sample>, Fault> {
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
