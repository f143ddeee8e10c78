//! A budget of time for checks before a run.
//!
//! A check that could take long asks its budget now and then whether the time is over. If it is, the check ends and notes what it has not
//! examined. So a budget bounds the time of all checks together, whatever the input is. Only warnings depend on it: no result of a run does.
//!
//! The budget is one of time, not of operations: the operations of different checks differ a thousandfold in time. Where a number bounds
//! a check as well (the points of a grid, the pairs that are listed), that number decides first.

use std::cell::{Cell, RefCell};
use std::time::{Duration, Instant};

/// The time of all checks of a scene. Shipped scenes need less than a tenth of it; a user who waits longer takes the program for stuck.
pub const USUAL: Duration = Duration::from_secs(5);

/// Number of questions between two looks at the clock, which takes about 30 ns.
const QUESTIONS: u32 = 256;

/// A budget of time, and what was not examined because it was spent.
#[derive(Debug)]
pub struct Budget {
    whole: Duration,
    end: Cell<Instant>,
    questions: Cell<u32>,
    is_spent: Cell<bool>,
    unfinished: RefCell<Vec<String>>,
}

impl Budget {
    /// Returns a budget of this time, from now on.
    #[must_use]
    pub fn of(time: Duration) -> Self {
        let now = Instant::now();
        // A year is as good as a time that no clock holds.
        let end = now.checked_add(time).unwrap_or(now + Duration::from_hours(24 * 365));
        Self {
            whole: time,
            end: Cell::new(end),
            questions: Cell::new(0),
            is_spent: Cell::new(time.is_zero()),
            unfinished: RefCell::default(),
        }
    }

    /// Returns the usual budget.
    #[must_use]
    pub fn usual() -> Self {
        Self::of(USUAL)
    }

    /// Returns the whole time.
    #[must_use]
    pub fn time(&self) -> Duration {
        self.whole
    }

    /// Whether the time is over. The answer may come a few hundred questions late.
    pub fn is_spent(&self) -> bool {
        let questions = self.questions.get().wrapping_add(1);
        self.questions.set(questions);
        if !self.is_spent.get() && questions.is_multiple_of(QUESTIONS) {
            self.is_spent.set(Instant::now() >= self.end.get());
        }
        self.is_spent.get()
    }

    /// Does work that may take this share of the time that is left, so that the checks after it have the rest.
    pub fn share<T>(&self, share: f64, work: impl FnOnce() -> T) -> T {
        let end = self.end.get();
        let was_spent = self.is_spent.get();
        let left = end.saturating_duration_since(Instant::now());
        self.end.set(Instant::now() + left.mul_f64(share.clamp(0.0, 1.0)));
        let result = work();
        self.end.set(end);
        self.is_spent.set(was_spent || Instant::now() >= end);
        result
    }

    /// Notes what was not examined.
    pub fn give_up(&self, what: impl Into<String>) {
        self.unfinished.borrow_mut().push(what.into());
    }

    /// Returns what was not examined, and forgets it.
    #[must_use]
    pub fn take_unfinished(&self) -> Vec<String> {
        self.unfinished.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_ends_when_its_share_is_spent_and_leaves_the_rest() {
        let start = Instant::now();
        let budget = Budget::of(Duration::from_mins(10));
        budget.share(1e-4, || while !budget.is_spent() {});
        assert!(start.elapsed() >= Duration::from_millis(60) && !budget.is_spent());
        let start = Instant::now();
        let short = Budget::of(Duration::from_millis(60));
        while !short.is_spent() {}
        assert!(start.elapsed() >= Duration::from_millis(60));
        short.share(0.5, || assert!(short.is_spent()));
        budget.give_up("the rest");
        assert_eq!((budget.take_unfinished(), budget.take_unfinished()), (vec!["the rest".to_owned()], vec![]));
    }

    #[test]
    fn an_empty_budget_is_spent_at_once_and_a_long_one_is_not() {
        assert!(Budget::of(Duration::ZERO).is_spent());
        assert!((0..10_000).all(|_| !Budget::of(Duration::MAX).is_spent()));
    }
}
