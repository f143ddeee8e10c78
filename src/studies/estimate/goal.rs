//! The request of an estimate, and the reasons why it may not be kept.

use std::fmt::{self, Display, Formatter};

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
