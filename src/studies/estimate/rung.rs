//! The runs of one stiffness.

/// A run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// The figure; `None` if the run does not have it.
    pub value: Option<f64>,
    /// Time on a core, s.
    pub cost: f64,
    /// Hash of the state at the end; `None` if it is unknown.
    pub state: Option<u64>,
}

/// The runs of a rung.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rung {
    /// Figures of the runs that have it.
    pub values: Vec<f64>,
    /// Number of runs without it.
    pub missing: usize,
    /// Time of all runs on their cores, s.
    pub cost: f64,
    /// Hashes of their states at the end.
    states: Vec<Option<u64>>,
}

impl Rung {
    /// Number of runs.
    #[must_use]
    pub fn runs(&self) -> usize {
        self.values.len() + self.missing
    }

    /// Mean time of a run, s; not a number without runs.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "counts of runs")]
    pub fn cost_of_a_run(&self) -> f64 {
        self.cost / self.runs() as f64
    }

    /// Adds a run.
    pub fn add(&mut self, sample: Sample) {
        match sample.value.filter(|value| value.is_finite()) {
            Some(value) => self.values.push(value),
            None => self.missing += 1,
        }
        self.cost += sample.cost;
        self.states.push(sample.state);
    }

    /// Whether several runs ended in one and the same state.
    #[must_use]
    pub fn is_certain(&self) -> bool {
        self.states.len() > 1 && self.states.iter().all(|state| state.is_some() && *state == self.states[0])
    }
}
