//! The marker of a directory that siloflow made, and the lock on it.
//!
//! The marker is the file `.siloflow`. It holds the number of the process that wrote it, and a line `file NAME` for each file that
//! a behaviour declares. A process holds the lock while
//! it uses the directory; the operating system releases the lock when the process ends in any way. A marker without a
//! lock therefore shows that no process uses the directory.
//!
//! Limit: on a file system without locks (some network file systems) a warning is logged and nothing prevents two runs
//! from using one directory.

use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind, Read as _};
use std::path::{Path, PathBuf};

use crate::disk::DiskFile;
use crate::own_files::{self, file_number};

/// Name of the marker.
pub const MARKER: &str = ".siloflow";

/// Most bytes of a marker that is read.
const MOST_BYTES: u64 = 1 << 20;

/// Start of the line of a declared file.
const DECLARED: &str = "file ";

/// Returns the names of the files that the marker of a directory declares; none if it cannot be read.
pub(super) fn declared_in(directory: &Path) -> Vec<String> {
    let text = own_files::read_text(&directory.join(MARKER), MOST_BYTES).unwrap_or_default();
    let names = text.lines().filter_map(|line| line.strip_prefix(DECLARED));
    // The file may have been changed: only names at the top of the directory count.
    let is_name = |name: &&str| !name.is_empty() && !name.starts_with('.') && !name.contains(['/', '\\', '\0']);
    names.filter(is_name).map(str::to_owned).collect()
}

/// Returns the number of this process; 0 on a system without processes (WebAssembly).
pub(super) fn process() -> u32 {
    if cfg!(target_family = "wasm") { 0 } else { std::process::id() }
}

/// The locked marker of a directory.
#[derive(Debug)]
pub(super) struct Marker(DiskFile);

/// The result of an attempt to lock the marker of a directory.
#[derive(Debug)]
pub(super) enum Claim {
    /// The directory has no marker.
    Unmarked,
    /// Another process holds the lock; in words.
    Held(String),
    /// This process holds the lock now.
    Locked(Marker),
}

impl Marker {
    /// Marks and locks a directory that has no marker.
    pub(super) fn create(directory: &Path) -> io::Result<Self> {
        let path = directory.join(MARKER);
        let marker = Self(DiskFile::create_new(&path)?);
        match marker.0.file().try_lock() {
            Err(TryLockError::WouldBlock) => return Err(ErrorKind::NotFound.into()),
            Err(TryLockError::Error(error)) => warn_of_no_locks(directory, &error),
            Ok(()) => {}
        }
        // Before the lock was taken, another process may have removed the marker as a remainder of a killed run.
        if !marker.is_in(directory) {
            return Err(ErrorKind::NotFound.into());
        }
        marker.sign(&[])?;
        Ok(marker)
    }

    /// Locks the marker of a directory, if it has one.
    pub(super) fn claim(directory: &Path) -> io::Result<Claim> {
        let path = directory.join(MARKER);
        match fs::symlink_metadata(&path) {
            Ok(found) if found.is_file() => {}
            Err(error) if error.kind() != ErrorKind::NotFound => return Err(error),
            _ => return Ok(Claim::Unmarked),
        }
        let file = match own_files::change(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Claim::Unmarked),
            opened => opened?,
        };
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => return Ok(Claim::Held(holder(file))),
            Err(TryLockError::Error(error)) => warn_of_no_locks(directory, &error),
            Ok(()) => {}
        }
        let marker = Self(file.into());
        // Another process may have replaced the directory before the lock was taken.
        Ok(if marker.is_in(directory) { Claim::Locked(marker) } else { Claim::Held("another process".to_owned()) })
    }

    /// Writes the number of this process into the marker, and the files that behaviours declare.
    pub(super) fn sign(&self, files: &[String]) -> io::Result<()> {
        let mut text = format!("siloflow keeps its results here; process {}\n", process());
        text.extend(files.iter().flat_map(|name| [DECLARED, name, "\n"]));
        self.0.rewrite(text.as_bytes())
    }

    /// Returns the place of the marker, which is in `directory`.
    pub(super) fn place(&self, directory: &Path) -> Option<MarkerPlace> {
        Some(MarkerPlace { path: directory.join(MARKER), file: file_number(&self.0.file().metadata().ok()?) })
    }

    /// Whether `directory` has this marker.
    fn is_in(&self, directory: &Path) -> bool {
        self.place(directory).is_some_and(|place| place.is_unchanged())
    }
}

/// The place of a marker.
#[derive(Debug)]
pub(super) struct MarkerPlace {
    path: PathBuf,
    file: (u64, u64),
}

impl MarkerPlace {
    /// Whether the marker is still there.
    pub(super) fn is_unchanged(&self) -> bool {
        fs::symlink_metadata(&self.path).is_ok_and(|found| file_number(&found) == self.file)
    }
}

/// The process that a marker names, in words.
pub(super) fn holder(marker: File) -> String {
    let mut text = String::new();
    let _ = marker.take(MOST_BYTES).read_to_string(&mut text);
    let number = text
        .lines()
        .next()
        .unwrap_or_default()
        .split_whitespace()
        .next_back()
        .and_then(|word| word.parse::<u32>().ok());
    number.map_or_else(|| "another process".to_owned(), |number| format!("process {number}"))
}

fn warn_of_no_locks(directory: &Path, error: &io::Error) {
    tracing::warn!("could not lock {}: {error}; start no second run into it", directory.display());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_held_marker_names_its_process_and_an_abandoned_one_is_locked() {
        let here = tempfile::tempdir().unwrap();
        assert!(matches!(Marker::claim(here.path()).unwrap(), Claim::Unmarked));
        let marker = Marker::create(here.path()).unwrap();
        let Claim::Held(holder) = Marker::claim(here.path()).unwrap() else { panic!("not locked") };
        assert_eq!(holder, format!("process {}", std::process::id()));
        assert!(Marker::create(here.path()).is_err());
        drop(marker);
        let Claim::Locked(marker) = Marker::claim(here.path()).unwrap() else { panic!("still locked") };
        assert!(marker.is_in(here.path()));
        fs::remove_file(here.path().join(MARKER)).unwrap();
        assert!(!marker.is_in(here.path()));
    }

    #[test]
    fn declared_files_stand_in_the_marker_until_it_is_signed_anew() {
        let here = tempfile::tempdir().unwrap();
        assert_eq!(declared_in(here.path()), [""; 0]);
        let marker = Marker::create(here.path()).unwrap();
        let names = ["heat.csv", "../escape", "/etc/passwd", ".siloflow", "", "a b"].map(str::to_owned);
        marker.sign(&names).unwrap();
        assert_eq!(declared_in(here.path()), ["heat.csv", "a b"]);
        let Claim::Held(holder) = Marker::claim(here.path()).unwrap() else { panic!("not locked") };
        assert_eq!(holder, format!("process {}", std::process::id()));
        marker.sign(&[]).unwrap();
        assert_eq!(declared_in(here.path()), [""; 0]);
    }

    #[test]
    #[cfg(unix)]
    fn a_link_is_no_marker() {
        let here = tempfile::tempdir().unwrap();
        fs::write(here.path().join("file"), "").unwrap();
        std::os::unix::fs::symlink("file", here.path().join(MARKER)).unwrap();
        assert!(matches!(Marker::claim(here.path()).unwrap(), Claim::Unmarked));
    }
}
