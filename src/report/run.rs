//! A run as a report sees it: what its directory holds. Files that are missing, or that cannot be read, leave gaps.
//!
//! A run that was killed has no `summary.json`, and its tables may end in the middle of a row. That row is left out.

use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::fault::Fault;
use crate::output::run_directory::scene_of;
use crate::scene::load::{self, AnyScene};
use crate::source::files;

/// The files of a run.
#[derive(Debug)]
pub struct Run {
    /// The run directory, as the caller names it.
    pub path: PathBuf,
    /// A short name, different from those of other runs of the report.
    pub label: String,
    /// Content of `summary.json`.
    pub summary: Option<Value>,
    /// Text of `scene.ron`.
    pub scene_text: String,
    /// The scene, or why it cannot be loaded.
    pub scene: Result<AnyScene, String>,
    /// `series.csv`.
    pub series: Table,
}

impl Run {
    /// Opens the run directory at `path`.
    ///
    /// # Errors
    /// If it is no run directory.
    pub fn open(path: &Path) -> Result<Self, Fault> {
        let shown = path.display();
        if !path.exists() {
            return Err(Fault::new("report::missing", format!("there is no {shown}"))
                .help("give a run directory such as out/silo1, which `siloflow run` makes"));
        }
        let scene = scene_of(path);
        if !scene.is_file() {
            let why = if path.is_dir() { "it has no scene.ron" } else { "it is a file" };
            return Err(Fault::new("report::no_run", format!("{shown} is no run directory: {why}"))
                .help("`siloflow run SCENE --out DIR` makes one; give its directory"));
        }
        let scene_text = files::read_text(&scene, files::SCENE_BYTES).map_err(|error| {
            Fault::new("report::read", format!("could not read {}: {error}", scene.display()))
                .help("may you read it, and is it the scene of a run?")
        })?;
        let summary = files::read_text(&path.join("summary.json"), files::RESULT_BYTES).ok();
        let summary: Option<Value> = summary.and_then(|text| serde_json::from_str(&text).ok());
        let name = summary.as_ref().and_then(|summary| summary["scene"].as_str()).map(str::to_owned);
        let name = name.or_else(|| path.file_name().map(|name| name.to_string_lossy().into_owned()));
        let label = name.unwrap_or_else(|| shown.to_string());
        Ok(Self {
            path: path.to_owned(),
            scene: load::named(&scene, &label).map_err(|fault| fault.to_string()),
            label,
            summary,
            scene_text,
            series: Table::read(&path.join("series.csv")),
        })
    }

    /// Gives runs of one report different labels: names of their scenes, or of their directories, or whole paths.
    pub fn distinguish(runs: &mut [Self]) {
        let last = |run: &Self| run.path.file_name().map(|name| name.to_string_lossy().into_owned());
        for name in [last, |run: &Self| Some(run.path.display().to_string())] {
            let mut labels: Vec<_> = runs.iter().map(|run| run.label.clone()).collect();
            labels.sort_unstable();
            if labels.windows(2).all(|two| two[0] != two[1]) {
                return;
            }
            for run in runs.iter_mut() {
                run.label = name(run).unwrap_or_else(|| run.label.clone());
            }
        }
    }

    /// The title of the scene, or else the name of the run.
    #[must_use]
    pub fn title(&self) -> &str {
        let title = match &self.scene {
            Ok(AnyScene::Grains(loaded)) => &loaded.scene.title,
            Ok(AnyScene::Lattice(loaded)) => &loaded.scene.title,
            Err(_) => "",
        };
        if title.is_empty() { &self.label } else { title }
    }

    /// Whether this is a run of the lattice gas.
    #[must_use]
    pub fn is_lattice(&self) -> bool {
        let method = self.summary.as_ref().is_some_and(|summary| summary["method"] == "LatticeGas");
        method || matches!(self.scene, Ok(AnyScene::Lattice(_)))
    }

    /// A value of the summary, by its JSON pointer.
    #[must_use]
    pub fn value(&self, pointer: &str) -> Option<&Value> {
        self.summary.as_ref()?.pointer(pointer).filter(|value| !value.is_null())
    }

    /// A number of the summary.
    #[must_use]
    pub fn number(&self, pointer: &str) -> Option<f64> {
        self.value(pointer)?.as_f64()
    }

    /// A text of the summary.
    #[must_use]
    pub fn text(&self, pointer: &str) -> Option<&str> {
        self.value(pointer)?.as_str()
    }

    /// A number of the summary, or without a summary the last one of a column of `series.csv`.
    #[must_use]
    pub fn last(&self, pointer: &str, column: &str) -> Option<f64> {
        match self.summary {
            Some(_) => self.number(pointer),
            None => self.series.numbers(column)?.last().copied(),
        }
    }

    /// Reads a table of the run; an empty one if the file is missing or cannot be read.
    #[must_use]
    pub fn table(&self, name: &str) -> Table {
        Table::read(&self.path.join(name))
    }
}

/// A CSV table with a header. Only whole rows count.
#[derive(Clone, Debug, Default)]
pub struct Table {
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    fn read(path: &Path) -> Self {
        files::read_text(path, files::RESULT_BYTES).map(|text| Self::parse(&text)).unwrap_or_default()
    }

    /// Reads the text of a table.
    fn parse(text: &str) -> Self {
        // What follows the last line break is a row that was being written.
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(whole.as_bytes());
        let fields = |record: &csv::StringRecord| record.iter().map(str::to_owned).collect::<Vec<_>>();
        let header = reader.headers().map(fields).unwrap_or_default();
        let rows = reader.records().map_while(Result::ok).map(|record| fields(&record));
        let rows = rows.filter(|row| row.len() == header.len()).collect();
        Self { header, rows }
    }

    /// Names of the columns.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.header.iter().map(String::as_str)
    }

    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The texts of a column; `None` without the column.
    #[must_use]
    pub fn texts(&self, name: &str) -> Option<Vec<&str>> {
        let number = self.header.iter().position(|column| column == name)?;
        Some(self.rows.iter().map(|row| &*row[number]).collect())
    }

    /// The numbers of a column; what is no number is NaN. `None` without the column.
    #[must_use]
    pub fn numbers(&self, name: &str) -> Option<Vec<f64>> {
        Some(self.texts(name)?.into_iter().map(|text| text.parse().unwrap_or(f64::NAN)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_that_was_being_written_is_left_out() {
        let table = Table::parse("time_s,out\n0.0,1\n1.0,2\n2.0,3");
        assert_eq!(table.numbers("out"), Some(vec![1.0, 2.0]), "the last number may be cut");
        assert_eq!(Table::parse("time_s,out\n0.0,1\n1.0\n").numbers("time_s"), Some(vec![0.0]));
        assert_eq!(Table::parse("time_s,out\n").numbers("out"), Some(vec![]));
        assert!(Table::parse("").is_empty());
    }
}
