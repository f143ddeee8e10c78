//! Exchanges two directories in one step.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::Path;

use crate::disk;

/// Exchanges the directories `new` and `target`.
///
/// Linux and macOS do it atomically. Where the file system cannot, `target` is renamed to `aside`, `new` to `target`, and
/// `aside` to `new`. A process that is killed in between leaves no `target`; [`recover`] then restores the old one.
///
/// # Errors
/// If a directory cannot be renamed. Both are then where they were.
pub(super) fn exchange(new: &Path, target: &Path, aside: &Path) -> io::Result<()> {
    match disk::exchange(new, target) {
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => {
            disk::rename(target, aside)?;
            if let Err(error) = disk::rename(new, target) {
                disk::rename(aside, target)?;
                return Err(error);
            }
            disk::rename(aside, new)
        }
        result => result,
    }
}

/// Renames `aside` to `target`, if an exchange was interrupted between its two renames.
pub(super) fn recover(target: &Path, aside: &Path) -> io::Result<()> {
    match fs::symlink_metadata(target) {
        Err(error) if error.kind() == ErrorKind::NotFound => disk::rename(aside, target),
        _ => Ok(()),
    }
}
