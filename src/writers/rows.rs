//! A CSV file that grows by rows. Every row is flushed at once, so that it survives a crash of the run.

use std::fmt;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use crate::outcome::{Failure, Outcome};
use crate::space::Space;

/// An open CSV file.
#[derive(Debug)]
pub struct Rows {
    path: PathBuf,
    file: BufWriter<File>,
}

impl Rows {
    /// Creates the file at `path` with its header.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(path: &Path, header: &str) -> std::io::Result<Self> {
        let mut rows = Self { path: path.to_owned(), file: BufWriter::new(File::create(path)?) };
        writeln!(rows.file, "{header}")?;
        rows.file.flush()?;
        Ok(rows)
    }

    /// Adds rows, each with its line break. A write error makes the run fail.
    pub fn append(&mut self, rows: fmt::Arguments<'_>, outcome: &mut Outcome) {
        if let Err(error) = self.file.write_fmt(rows).and_then(|()| self.file.flush()) {
            outcome.fail(Failure::Output { path: self.path.display().to_string(), reason: error.to_string() });
        }
    }
}

/// Returns the components of a vector as comma-separated cells of a row.
pub(crate) fn numbers<V: Space>(v: V) -> String {
    v.components().iter().map(|x| format!("{x:e}")).collect::<Vec<_>>().join(",")
}

/// A value that a plugin moves into the world. A plugin is built through a shared reference, so the value needs a cell.
#[derive(Debug)]
pub(crate) struct TakenOnce<T>(Mutex<Option<T>>);

impl<T> TakenOnce<T> {
    pub(crate) fn new(content: T) -> Self {
        Self(Mutex::new(Some(content)))
    }

    /// Takes the value out; `None` after the first call.
    pub(crate) fn open(&self) -> Option<T> {
        self.0.lock().ok()?.take()
    }
}
