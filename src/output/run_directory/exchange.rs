//! Exchanges two directories in one step.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::Path;

/// Exchanges the directories `new` and `target`.
///
/// Linux and macOS do it atomically. Where the file system cannot, `target` is renamed to `aside`, `new` to `target`, and
/// `aside` to `new`. A process that is killed in between leaves no `target`; [`recover`] then restores the old one.
///
/// # Errors
/// If a directory cannot be renamed. Both are then where they were.
pub(super) fn exchange(new: &Path, target: &Path, aside: &Path) -> io::Result<()> {
    match exchange_at_once(new, target) {
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => {
            fs::rename(target, aside)?;
            if let Err(error) = fs::rename(new, target) {
                fs::rename(aside, target)?;
                return Err(error);
            }
            fs::rename(aside, new)
        }
        result => result,
    }
}

/// Renames `aside` to `target`, if an exchange was interrupted between its two renames.
pub(super) fn recover(target: &Path, aside: &Path) -> io::Result<()> {
    match fs::symlink_metadata(target) {
        Err(error) if error.kind() == ErrorKind::NotFound => fs::rename(aside, target),
        _ => Ok(()),
    }
}

#[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
fn exchange_at_once(a: &Path, b: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    Ok(renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE)?)
}

#[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
fn exchange_at_once(_: &Path, _: &Path) -> io::Result<()> {
    Err(ErrorKind::Unsupported.into())
}
