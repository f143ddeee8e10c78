//! A run as a report sees it: its files, and its scene if that can be loaded.
//!
//! A run that was killed has no `summary.json`, and its tables may end in the middle of a row. That row is left out.

use std::path::Path;

use serde_json::Value;

use crate::run_results::RunResults;
use crate::scene_facts::{ReadFacts, SceneFacts};
use siloflow_files::own_files;
use siloflow_files::run_directory::scene_of;
use siloflow_files::table::Table;
use siloflow_text::fault::Fault;
use siloflow_text::file;

/// A run of a report.
#[derive(Debug)]
pub struct Run {
    /// The files. Their name is short, and different from those of other runs of the report.
    pub files: RunResults,
    /// Text of `scene.ron`; empty if it cannot be read.
    pub scene_text: String,
    /// Facts of the scene, or why it cannot be loaded.
    pub scene: Result<SceneFacts, String>,
}

impl Run {
    /// Opens the run directory at `path`. `read` reads the facts of its scene.
    ///
    /// # Errors
    /// As [`RunResults::open`].
    pub fn open(path: &Path, read: ReadFacts) -> Result<Self, Fault> {
        let mut files = RunResults::open(path)?;
        if let Some(name) = files.summary["scene"].as_str() {
            name.clone_into(&mut files.name);
        }
        let scene = scene_of(path);
        Ok(Self {
            scene_text: own_files::read_text(&scene, file::SCENE_BYTES).unwrap_or_default(),
            scene: read(&scene, &files.name),
            files,
        })
    }

    /// The name of the run among those of the report.
    #[must_use]
    pub fn label(&self) -> &str {
        &self.files.name
    }

    /// Whether the run has a summary, so that it is over.
    #[must_use]
    pub fn has_summary(&self) -> bool {
        !self.files.summary.is_null()
    }

    /// Gives runs of one report different labels: names of their scenes, or of their directories, or whole paths.
    pub fn distinguish(runs: &mut [Self]) {
        RunResults::distinguish(&mut runs.iter_mut().map(|run| &mut run.files).collect::<Vec<_>>());
    }

    /// The title of the scene, or else the name of the run.
    #[must_use]
    pub fn title(&self) -> &str {
        let title = self.scene.as_ref().map_or("", |scene| &scene.title);
        if title.is_empty() { self.label() } else { title }
    }

    /// Whether this is a run of the lattice gas.
    #[must_use]
    pub fn is_lattice(&self) -> bool {
        self.files.is_lattice()
    }

    /// The numbers of a column of `series.csv`.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<Vec<f64>> {
        self.files.series.numbers(name)
    }

    /// A value of the summary, by its JSON pointer.
    #[must_use]
    pub fn value(&self, pointer: &str) -> Option<&Value> {
        self.files.summary.pointer(pointer).filter(|value| !value.is_null())
    }

    /// A number of the summary.
    #[must_use]
    pub fn number(&self, pointer: &str) -> Option<f64> {
        self.files.number(pointer)
    }

    /// A text of the summary.
    #[must_use]
    pub fn text(&self, pointer: &str) -> Option<&str> {
        self.value(pointer)?.as_str()
    }

    /// A number of the summary, or without a summary the last one of a column of `series.csv`.
    #[must_use]
    pub fn last(&self, pointer: &str, column: &str) -> Option<f64> {
        if self.has_summary() { self.number(pointer) } else { self.column(column)?.last().copied() }
    }

    /// Reads a table of the run; `None` if it has no rows or cannot be read.
    #[must_use]
    pub fn table(&self, name: &str) -> Option<Table> {
        self.files.table(name).ok().flatten()
    }
}
