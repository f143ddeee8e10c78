//! The files of a run that figures are drawn from.

use std::path::{Path, PathBuf};

use serde_json::Value;

use siloflow_figures::diagram::Mark;
use siloflow_files::own_files;
use siloflow_files::run_directory::{Depth, refuse_odd};
use siloflow_files::table::Table;
use siloflow_text::fault::Fault;
use siloflow_text::file;

/// A run directory, of a run that ended, goes on or was killed.
#[derive(Clone, Debug)]
pub struct RunResults {
    /// The directory.
    pub directory: PathBuf,
    /// Name in legends.
    pub name: String,
    /// Content of `summary.json`; `Null` before the end of a run.
    pub summary: Value,
    /// Content of `series.csv`.
    pub series: Table,
}

impl RunResults {
    /// Opens the run in `directory`.
    ///
    /// # Errors
    /// If there is no run, or its `series.csv` or `summary.json` cannot be read.
    pub fn open(directory: &Path) -> Result<Self, Fault> {
        let fault = |message: String| {
            Fault::new("results::no_run", message)
                .help("give run directories such as out/silo1; `siloflow run` makes them")
        };
        let shown = directory.display();
        if !directory.is_dir() {
            return Err(fault(if directory.exists() {
                format!("{shown} is not a directory")
            } else {
                format!("there is no run directory {shown}")
            }));
        }
        refuse_odd(directory, Depth::Top)?;
        let series = directory.join("series.csv");
        if !own_files::is_file(&series) {
            return Err(fault(format!("{shown} is no run directory: it has no series.csv")));
        }
        Ok(Self {
            directory: directory.to_owned(),
            name: name_of(directory),
            summary: summary(&directory.join("summary.json"))?,
            series: Table::read(&series, "may you read it?")?,
        })
    }

    /// Gives runs different names: their own if those differ, else those of their directories, else their paths.
    pub fn distinguish(runs: &mut [&mut Self]) {
        for name in [name_of, |directory: &Path| directory.display().to_string()] {
            let mut names: Vec<_> = runs.iter().map(|run| &run.name).collect();
            names.sort_unstable();
            if names.windows(2).all(|two| two[0] != two[1]) {
                return;
            }
            for run in runs.iter_mut() {
                run.name = name(&run.directory);
            }
        }
    }

    /// Returns a table of the run; `None` if the run has no such file, or only its header.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn table(&self, file: &str) -> Result<Option<Table>, Fault> {
        let path = self.directory.join(file);
        if !own_files::is_file(&path) {
            return Ok(None);
        }
        Ok(Some(Table::read(&path, "may you read it?")?).filter(|table| !table.is_empty()))
    }

    /// Returns a number of the summary, by its JSON pointer; `None` if it is absent or `null`.
    #[must_use]
    pub fn number(&self, pointer: &str) -> Option<f64> {
        self.summary.pointer(pointer)?.as_f64()
    }

    /// Whether the run is one of the lattice gas, whose times are steps.
    #[must_use]
    pub fn is_lattice(&self) -> bool {
        self.series.names().any(|name| name == "step")
    }

    /// Returns the times of the rows of `series.csv`, in s; of a lattice gas, in steps.
    #[must_use]
    pub fn times(&self) -> Vec<f64> {
        self.series.numbers(if self.is_lattice() { "step" } else { "time_s" }).unwrap_or_default()
    }

    /// Label of the axis of time.
    #[must_use]
    pub fn time_label(&self) -> &'static str {
        if self.is_lattice() { "time, steps" } else { "time, s" }
    }

    /// Returns the time at which the door began to open; `None` if the run has no door, or it stayed shut.
    #[must_use]
    pub fn opening(&self) -> Option<f64> {
        self.number("/door_open_time_s").or(self.number("/door_open_step"))
    }

    /// Returns marks at the times of rest and of the opening of the door.
    #[must_use]
    pub fn marks(&self) -> Vec<Mark> {
        let rest = self.number("/rest_time_s").or(self.number("/rest_step"));
        let mark = |at: f64, name: &str| Mark { at, name: name.to_owned() };
        match (rest, self.opening()) {
            #[expect(clippy::float_cmp, reason = "the same event")]
            (Some(rest), Some(open)) if rest == open => vec![mark(open, "at rest, door opens")],
            (rest, open) => {
                rest.map(|at| mark(at, "at rest")).into_iter().chain(open.map(|at| mark(at, "door opens"))).collect()
            }
        }
    }
}

fn name_of(directory: &Path) -> String {
    let absolute = std::path::absolute(directory).unwrap_or_else(|_| directory.to_owned());
    absolute.file_name().unwrap_or(absolute.as_os_str()).display().to_string()
}

fn summary(path: &Path) -> Result<Value, Fault> {
    if !own_files::is_file(path) {
        return Ok(Value::Null);
    }
    let shown = path.display();
    let text = own_files::read_text(path, file::RESULT_BYTES).map_err(|error| {
        Fault::new("results::unreadable", format!("could not read {shown}: {error}")).help("may you read it?")
    })?;
    serde_json::from_str(&text).map_err(|error| {
        Fault::new("results::unreadable", format!("{shown} is not JSON: {error}")).help("run the scene again")
    })
}
