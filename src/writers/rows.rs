//! A CSV file that grows by rows. All rows of a call are written at once, so that they survive a crash of the run. If the
//! disk is full, the file is cut to its last complete rows.
//!
//! Header and rows of a file follow from the list of its [columns](siloflow_files::columns). The time of a row is the product of steps and step (0.3 s may be
//! `0.30000000000000004`), equal in all files of a run, so that rows of several files can be joined by it.

use std::fmt::{self, Write as _};
use std::path::Path;
use std::sync::Mutex;

use siloflow_dem::outcome::{Failure, Outcome};
use siloflow_dem::persist::Problem;
use siloflow_files::growing::{Growing, OutputPlace};
use siloflow_files::run_files::RunFile;

/// An open CSV file.
#[derive(Debug)]
pub struct Rows {
    file: Growing,
    buffer: String,
}

impl Rows {
    /// Creates the file at `place` with its header, or opens it if the run is continued.
    ///
    /// # Errors
    /// If the file cannot be written, or a new one exists.
    pub fn at(place: &OutputPlace, header: &str) -> std::io::Result<Self> {
        Self::started(Growing::at(&place.path, place.record(), b"", place.is_continued)?, header)
    }

    /// Creates the file at `path` with its header.
    ///
    /// # Errors
    /// If the file exists or cannot be written.
    pub fn create(path: &Path, header: &str) -> std::io::Result<Self> {
        Self::at(&OutputPlace { path: path.to_owned(), ..OutputPlace::default() }, header)
    }

    /// Opens the file at `path`, to continue it. [`Rows::restore`] says from where.
    ///
    /// # Errors
    /// If it is no regular file or cannot be written.
    pub fn reopen(path: &Path) -> std::io::Result<Self> {
        Ok(Self { file: Growing::reopen(path, RunFile::default(), b"")?, buffer: String::new() })
    }

    /// Writes the header of a new file.
    fn started(file: Growing, header: &str) -> std::io::Result<Self> {
        let mut rows = Self { file, buffer: String::new() };
        if rows.file.is_new() {
            rows.write(format_args!("{header}\n"))?;
        }
        Ok(rows)
    }

    /// Returns the bytes of all rows so far. A checkpoint brings the files of the run to the disk before it saves this number.
    ///
    /// # Errors
    /// None; the result fits [`persist_part`](siloflow_dem::persist::PersistApp::persist_part).
    pub fn saved(&self) -> Result<u64, Problem> {
        Ok(self.file.length())
    }

    /// Removes all rows beyond the first `length` bytes. A file that this process has made keeps its rows: it takes the place of a
    /// damaged one.
    ///
    /// # Errors
    /// If the file is shorter, or cannot be cut.
    pub fn restore(&mut self, length: u64) -> Result<(), Problem> {
        self.file.restore(length)
    }

    /// Adds rows, each with its line break. A write error makes the run fail.
    pub fn append(&mut self, rows: fmt::Arguments<'_>, outcome: &mut Outcome) {
        if let Err(error) = self.write(rows) {
            outcome.fail(Failure::Output { path: self.file.name().to_owned(), reason: error.to_string() });
        }
    }

    fn write(&mut self, rows: fmt::Arguments<'_>) -> std::io::Result<()> {
        self.buffer.clear();
        // Writing to a string cannot fail.
        let _ = self.buffer.write_fmt(rows);
        self.file.append(self.buffer.as_bytes())
    }
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
