//! The runs of an estimate: each a process of its own on one core, in a directory like that of a sweep.

use std::num::NonZeroUsize;

use crate::cli::signals::Signals;
use crate::cli::sweep::runs::Runs;
use crate::studies::estimate::estimator::Sampler;
use crate::studies::estimate::growth::overlap_at_rest;
use crate::studies::estimate::results::RunRecord;
use crate::studies::estimate::rung::Sample;
use crate::studies::estimate::variant::{Change, Variant};
use crate::studies::figures::figure::Figure;
use crate::studies::sweep::directory::{State, SweepDirectory};
use crate::studies::sweep::{Sweep, Task};
use siloflow_figures::statistics::extrapolation::Ladder;
use siloflow_results::run_results::RunResults;
use siloflow_text::fault::Fault;

/// The runs of an estimate in a directory.
pub(super) struct SiloRuns<'a> {
    pub sweep: Sweep,
    pub directory: &'a SweepDirectory,
    pub figure: &'a Figure,
    pub ladder: Ladder,
    /// The kinds of the runs of each point.
    pub variants: Vec<Variant>,
    /// Seed of the first run of each point.
    pub seed: u64,
    pub cores: usize,
    pub signals: &'a Signals,
    pub quiet: bool,
    /// Number of runs of each point.
    pub taken: Vec<u64>,
    /// All runs so far.
    pub records: Vec<RunRecord>,
}

/// The run that measures the overlaps of a bed at rest.
pub(super) struct FirstRun {
    /// Mean overlap over the radius; `None` if the bed did not come to rest.
    pub overlap: Option<f64>,
    /// Its time on a core, s.
    pub cost: f64,
}

impl SiloRuns<'_> {
    /// Makes a run of a point, if it is not there, and measures the overlaps of its bed at rest; `None` if the user stops it.
    pub(super) fn first(&mut self, point: usize) -> Result<Option<FirstRun>, Fault> {
        let task = Task { point, seed: self.seed };
        let known = matches!(self.directory.state(&self.sweep, task)?, State::Over(_));
        let sample = if known { Some(self.sample(task, None)?) } else { self.take(&[point])?.pop() };
        let Some(sample) = sample else { return Ok(None) };
        let run = RunResults::open(&self.directory.run(&self.sweep, task))?;
        Ok(Some(FirstRun { overlap: overlap_at_rest(&run)?, cost: sample.cost }))
    }

    /// Reads a run that is over.
    fn sample(&mut self, task: Task, reason: Option<&str>) -> Result<Sample, Fault> {
        let State::Over(summary) = self.directory.state(&self.sweep, task)? else {
            let why = reason.unwrap_or("it has no end");
            let message = format!("run {} has no result: {why}", self.sweep.run_name(task));
            return Err(
                Fault::new("estimate::run", message).help("its messages are in the directory `logs` of the estimate")
            );
        };
        let run = RunResults::open(&self.directory.run(&self.sweep, task))?;
        let value = self.figure.of(&run)?;
        let cost = summary["performance"]["wall_s"].as_f64().unwrap_or(0.0);
        let state = summary["state_hash"].as_str().and_then(|text| u64::from_str_radix(text, 16).ok());
        let Variant { rung, change } = self.variants[task.point];
        self.records.push(RunRecord {
            run: self.sweep.run_name(task),
            softness: self.ladder.softness()[rung],
            overlaps_only: change == Change::Overlaps,
            growth: summary["growth"].as_f64().unwrap_or(0.0),
            step_share: if change == Change::HalfStep { 0.5 } else { 1.0 },
            is_larger: change == Change::Larger,
            seed: task.seed,
            status: summary["status"].as_str().unwrap_or_default().to_owned(),
            value,
            wall_s: cost,
        });
        Ok(Sample { value, cost, state })
    }
}

impl Sampler for SiloRuns<'_> {
    fn known(&mut self) -> Result<Vec<(usize, Sample)>, Fault> {
        let mut found = Vec::new();
        for point in 0..self.ladder.softness().len() {
            loop {
                let task = Task { point, seed: self.seed.wrapping_add(self.taken[point]) };
                if !matches!(self.directory.state(&self.sweep, task)?, State::Over(_)) {
                    break;
                }
                self.taken[point] += 1;
                found.push((point, self.sample(task, None)?));
            }
        }
        Ok(found)
    }

    fn take(&mut self, rungs: &[usize]) -> Result<Vec<Sample>, Fault> {
        let mut tasks = Vec::new();
        for &point in rungs {
            tasks.push(Task { point, seed: self.seed.wrapping_add(self.taken[point]) });
            self.taken[point] += 1;
        }
        let pool = Runs {
            sweep: &self.sweep,
            directory: self.directory,
            cores: NonZeroUsize::new(self.cores).unwrap_or(NonZeroUsize::MIN),
            signals: self.signals,
            quiet: self.quiet,
            force: true,
            retry: false,
        };
        let all: u64 = self.taken.iter().sum();
        let failures = pool.run(usize::try_from(all).unwrap_or(usize::MAX), &tasks)?;
        if self.is_stopped() {
            return Ok(Vec::new());
        }
        let reason = |task: Task| failures.iter().find(|failure| failure.task == task).map(|it| it.reason.clone());
        tasks.into_iter().map(|task| self.sample(task, reason(task).as_deref())).collect()
    }

    fn is_stopped(&self) -> bool {
        self.signals.received().is_some()
    }
}
