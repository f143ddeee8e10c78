//! The finished runs of a validation case, by sweep file.

use std::collections::BTreeMap;
use std::path::Path;

use crate::studies::figures::summary::{figure, is_failure};
use crate::studies::sweep::directory::SweepDirectory;
use crate::studies::sweep::{Sweep, Task};
use siloflow_figures::statistics::points::{between, slope};
use siloflow_files::table::Table;
use siloflow_results::run_results::RunResults;
use siloflow_text::fault::Fault;

/// A run that is over.
#[derive(Debug)]
pub struct FinishedRun {
    /// Keys of the sweep's axes, and their values as RON.
    pub values: BTreeMap<String, String>,
    /// Seed.
    pub seed: u64,
    /// Its run directory, with `summary.json` and `series.csv`.
    pub files: RunResults,
}

impl FinishedRun {
    /// Returns a number of the summary, for example `discharge.rate_per_s`. A clogged run has no rates, and a failed run no numbers.
    #[must_use]
    pub fn number(&self, path: &str) -> Option<f64> {
        figure(&self.files.summary, path)?.parse().ok()
    }

    /// Returns the value of an axis as a number, for example `parameters.orifice`.
    #[must_use]
    pub fn value(&self, key: &str) -> Option<f64> {
        self.values.get(key)?.parse().ok()
    }

    /// Returns the status, for example `clogged`.
    #[must_use]
    pub fn status(&self) -> &str {
        self.files.summary["status"].as_str().unwrap_or_default()
    }

    /// Returns a table of the run directory, for example `walls.csv`.
    ///
    /// # Errors
    /// If there is no such file, or it cannot be read.
    pub fn table(&self, name: &str) -> Result<Table, Fault> {
        let path = self.files.directory.join(name);
        Table::read(&path, "run the case again in another directory")
    }

    /// Returns the curve of the discharge: time since the opening of the door (s), grains out.
    ///
    /// # Errors
    /// If the door did not open, or `series.csv` has other columns.
    pub fn discharge(&self) -> Result<Vec<(f64, f64)>, Fault> {
        let opened = self.files.opening().ok_or_else(|| {
            Fault::new("validate::shut", format!("the door of {} did not open", self.files.directory.display()))
                .help("its summary.json and series.csv tell why")
        })?;
        let times = self.files.times();
        let out = self.files.series.needed("out")?;
        Ok(times.into_iter().map(|time| time - opened).zip(out).filter(|(time, _)| *time >= 0.0).collect())
    }

    /// Returns the slope of a straight line through the discharge between two times after the opening (s), grains/s; NaN without two rows.
    ///
    /// # Errors
    /// As [`FinishedRun::discharge`].
    pub fn rate(&self, from: f64, to: f64) -> Result<f64, Fault> {
        Ok(slope(&between(&self.discharge()?, from, to)).unwrap_or(f64::NAN))
    }

    /// Returns the run's time on its core, s.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.number("performance.wall_s").unwrap_or(0.0)
    }
}

/// The runs of all sweep files of a form.
#[derive(Debug, Default)]
pub struct Studies {
    sweeps: Vec<(&'static str, Vec<FinishedRun>)>,
}

impl Studies {
    /// Adds the runs of a sweep. Runs that failed have no numbers; they are left out, and returned.
    ///
    /// # Errors
    /// If a run cannot be read.
    pub fn add(&mut self, name: &'static str, sweep: &Sweep, directory: &SweepDirectory) -> Result<Vec<Task>, Fault> {
        let mut runs = Vec::new();
        let mut failed = Vec::new();
        for task in sweep.tasks() {
            let files = RunResults::open(&directory.run(sweep, task))?;
            let keys = sweep.keys.iter().cloned();
            let values = keys.zip(sweep.points[task.point].values.iter().cloned()).collect();
            let run = FinishedRun { values, seed: task.seed, files };
            if is_failure(run.status()) {
                failed.push(task);
            } else {
                runs.push(run);
            }
        }
        self.sweeps.push((name, runs));
        Ok(failed)
    }

    /// Returns the runs of a sweep file; none if it is not of this form.
    #[must_use]
    pub fn runs(&self, sweep: &str) -> &[FinishedRun] {
        self.sweeps.iter().find(|(name, _)| *name == sweep).map_or(&[], |(_, runs)| runs)
    }

    /// Returns the runs of all sweep files, in their order.
    pub fn all(&self) -> impl Iterator<Item = &FinishedRun> {
        self.sweeps.iter().flat_map(|(_, runs)| runs)
    }

    /// Returns the runs of the first sweep file of this form among `sweeps`.
    #[must_use]
    pub fn first_of(&self, sweeps: &[&str]) -> &[FinishedRun] {
        let mut found = self.sweeps.iter().filter(|(name, _)| sweeps.contains(name));
        found.next().map_or(&[], |(_, runs)| runs)
    }

    /// Returns the particle-steps of all runs: the number of steps, summed over all grains.
    #[must_use]
    pub fn particle_steps(&self) -> f64 {
        self.all().filter_map(|run| run.number("performance.particle_steps")).sum()
    }

    /// Returns the time of all runs on their cores, s.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.all().map(FinishedRun::seconds).sum()
    }
}

/// Returns the path of a sweep directory below the directory of all cases.
#[must_use]
pub fn sweep_directory(of_case: &Path, sweep: &str) -> std::path::PathBuf {
    of_case.join(sweep.strip_suffix(".ron").unwrap_or(sweep))
}
