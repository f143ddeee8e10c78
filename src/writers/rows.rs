//! A CSV file that grows by rows. All rows of a call are written at once, so that they survive a crash of the run. If the
//! disk is full, the file is cut to its last complete rows.
//!
//! A number is written in the shortest form that reads back to the same bits: `{:e}`, or for times, places and means of counts
//! `{:?}`, which has an exponent only below 1e-5 and from 1e16 on. The time of a row is the product of steps and step (0.3 s may be
//! `0.30000000000000004`), equal in all files of a run, so that rows of several files can be joined by it.

use std::fmt::{self, Write as _};
use std::fs::File;
use std::io::{Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use crate::outcome::{Failure, Outcome};
use crate::own_files;
use crate::persist::Problem;
use crate::space::Linear;

/// The path of a CSV file.
#[derive(Clone, Debug)]
pub struct RowsPlace {
    /// The path.
    pub path: PathBuf,
    /// Whether the file belongs to a run that is continued, and so exists.
    pub is_continued: bool,
}

/// An open CSV file.
#[derive(Debug)]
pub struct Rows {
    /// Name of the file in the run directory, for messages. The directory may be moved during a run.
    name: String,
    file: File,
    /// Bytes of complete rows.
    length: u64,
    buffer: String,
}

impl Rows {
    /// Creates the file at `path` with its header, or opens it if the run is continued.
    ///
    /// # Errors
    /// If the file cannot be written, or a new one exists.
    pub fn at(place: &RowsPlace, header: &str) -> std::io::Result<Self> {
        if place.is_continued { Self::reopen(&place.path) } else { Self::create(&place.path, header) }
    }

    /// Creates the file at `path` with its header.
    ///
    /// # Errors
    /// If the file exists or cannot be written.
    pub fn create(path: &Path, header: &str) -> std::io::Result<Self> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        // `create_new` never follows a symbolic link.
        let mut rows = Self { name, file: File::create_new(path)?, length: 0, buffer: String::new() };
        rows.write(format_args!("{header}\n"))?;
        Ok(rows)
    }

    /// Opens the file at `path`, to continue it. [`Rows::restore`] says from where.
    ///
    /// # Errors
    /// If it is no regular file or cannot be written.
    pub fn reopen(path: &Path) -> std::io::Result<Self> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut file = own_files::change(path)?;
        let length = file.seek(SeekFrom::End(0))?;
        Ok(Self { name, file, length, buffer: String::new() })
    }

    /// Returns the bytes of all rows so far, once they are on the disk.
    ///
    /// # Errors
    /// If they cannot be brought there.
    pub fn saved(&self) -> Result<u64, Problem> {
        self.file.sync_data().map_err(|error| format!("could not sync {}: {error}", self.name))?;
        Ok(self.length)
    }

    /// Removes all rows beyond the first `length` bytes.
    ///
    /// # Errors
    /// If the file is shorter, or cannot be cut.
    pub fn restore(&mut self, length: u64) -> Result<(), Problem> {
        if length > self.length {
            return Err(format!("{} has {} bytes, but {length} had been written", self.name, self.length));
        }
        let cut = self.file.set_len(length).and_then(|()| self.file.seek(SeekFrom::Start(length)));
        cut.map_err(|error| format!("could not cut {}: {error}", self.name))?;
        self.length = length;
        Ok(())
    }

    /// Adds rows, each with its line break. A write error makes the run fail.
    pub fn append(&mut self, rows: fmt::Arguments<'_>, outcome: &mut Outcome) {
        if let Err(error) = self.write(rows) {
            outcome.fail(Failure::Output { path: self.name.clone(), reason: error.to_string() });
        }
    }

    fn write(&mut self, rows: fmt::Arguments<'_>) -> std::io::Result<()> {
        self.buffer.clear();
        // Writing to a string cannot fail.
        let _ = self.buffer.write_fmt(rows);
        let written = self.file.write_all(self.buffer.as_bytes());
        if written.is_ok() {
            self.length += self.buffer.len() as u64;
        } else {
            // A part of the rows may have been written. The run reports the first error.
            let _ = self.file.set_len(self.length);
            let _ = self.file.seek(SeekFrom::Start(self.length));
        }
        written
    }
}

/// Returns the components of a vector as comma-separated cells of a row.
pub(crate) fn numbers<V: Linear>(v: V) -> String {
    (0..V::COUNT).map(|axis| format!("{:e}", v.component(axis))).collect::<Vec<_>>().join(",")
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
