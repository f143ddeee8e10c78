//! Result files of the studies and comparisons: all of them or none.

use std::fs;
use std::io;
use std::path::Path;

use crate::run_directory::examine::resolve;
use crate::run_directory::marker::{Claim, MARKER, Marker};
use crate::run_directory::stage::Stage;
use crate::whole_file;

/// Writes files of these names and contents into a directory, which is created if needed. Other files in it are kept.
///
/// The directory is replaced at once by one with the new files, so that it never holds a part of them. A run directory, a
/// directory that holds anything but regular files, and one that cannot be replaced (a mount point, the current directory)
/// get the files one by one, each of them complete.
///
/// # Errors
/// If a file cannot be written.
pub fn write_results(directory: &Path, files: &[(String, Vec<u8>)]) -> io::Result<()> {
    if replace(directory, files)? {
        return Ok(());
    }
    fs::create_dir_all(directory)?;
    files.iter().try_for_each(|(name, content)| whole_file::write(&directory.join(name), content))
}

/// Checks that a directory of results can be made or replaced. Leaves no trace.
///
/// # Errors
/// If the directory does not exist and cannot be made.
pub fn check_results(directory: &Path) -> io::Result<()> {
    let is_own = |_: &Path| false;
    let Ok(target) = resolve(directory) else { return fs::metadata(directory).map(|_| ()) };
    if target.exists() && !target.is_dir() {
        return Err(io::ErrorKind::NotADirectory.into());
    }
    match Stage::create(&target, &is_own) {
        Ok(stage) => stage.discard(&is_own),
        // The files of a directory that cannot be replaced are written one by one.
        Err(_) if target.is_dir() => {}
        Err(error) => return Err(error),
    }
    Ok(())
}

/// Replaces the directory. Returns whether that was possible.
fn replace(directory: &Path, files: &[(String, Vec<u8>)]) -> io::Result<bool> {
    let is_own = |path: &Path| files.iter().any(|(name, _)| Path::new(name) == path);
    let Ok(target) = resolve(directory) else { return Ok(false) };
    if !holds_files_only(&target) || !matches!(Marker::claim(&target), Ok(Claim::Unmarked)) {
        return Ok(false);
    }
    let Ok(stage) = Stage::create(&target, &is_own) else { return Ok(false) };
    let written = files.iter().try_for_each(|(name, content)| fs::write(stage.path.join(name), content));
    if let Err(error) = written {
        stage.discard(&is_own);
        return Err(error);
    }
    let is_published = stage.publish(&is_own).is_ok();
    if is_published {
        // The marker belongs to the stage: results are no run.
        whole_file::remove_if_there(&target.join(MARKER))?;
    }
    Ok(is_published)
}

fn holds_files_only(directory: &Path) -> bool {
    fs::read_dir(directory).map_or(true, |mut entries| {
        entries.all(|entry| entry.and_then(|entry| entry.file_type()).is_ok_and(|kind| kind.is_file()))
    })
}
