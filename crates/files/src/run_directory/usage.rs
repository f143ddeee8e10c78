//! Whether a directory holds a run, and whether a process uses it.

use std::fs::{File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::Path;

use super::marker::{MARKER, holder};
use super::names::{FRAMES, HASHES, SCENE, SERIES, SUMMARY};
use crate::own_files;

/// The use of a run directory.
#[derive(Debug)]
pub enum Use {
    /// No process uses it, and none begins to while the lock is held. There is no lock on a copy without a marker, and on a file
    /// system without locks.
    Free(Option<File>),
    /// A process uses it; in words.
    Held(String),
}

/// Returns whether a process uses the run directory `run`. Nothing is changed.
///
/// # Errors
/// If the marker cannot be read.
pub fn watch(run: &Path) -> io::Result<Use> {
    let marker = match own_files::read(&run.join(MARKER)) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Use::Free(None)),
        opened => opened?,
    };
    Ok(match marker.try_lock_shared() {
        Err(TryLockError::WouldBlock) => Use::Held(holder(marker)),
        Err(TryLockError::Error(_)) => Use::Free(None),
        Ok(()) => Use::Free(Some(marker)),
    })
}

/// Whether a directory holds a run, also one that has lost some of its files.
#[must_use]
pub fn holds_run(directory: &Path) -> bool {
    let has = |name: &str| directory.join(name).symlink_metadata().is_ok();
    has(MARKER) || has(SCENE) && [SERIES, FRAMES, SUMMARY].into_iter().any(has) || has(SUMMARY) && has(HASHES)
}
