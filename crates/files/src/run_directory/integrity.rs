//! Compares files of a run directory with the record of them.

use std::fs;
use std::io::ErrorKind;
use std::path::{Component, Path};

use crate::own_files;
use crate::run_directory::names::is_own;
use crate::run_files::{Extent, FileRecord, Kind};

/// The moment of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// A checkpoint: files may have grown since.
    Checkpoint,
    /// The end of the run.
    End,
}

/// Returns what is wrong with a file of the run directory `run`, in words; `None` if it is as the record says.
#[must_use]
pub fn problem(run: &Path, file: &FileRecord, moment: Moment) -> Option<String> {
    let name = Path::new(&file.name);
    if !is_name(name) {
        return Some("is no name of a file of a run".to_owned());
    }
    if let Some(parent) = name.parent().filter(|parent| *parent != Path::new("")) {
        match fs::symlink_metadata(run.join(parent)) {
            Ok(found) if found.is_dir() => {}
            Err(error) if error.kind() != ErrorKind::NotFound => return Some(format!("could not be read: {error}")),
            Ok(found) if found.is_symlink() => {
                return Some(format!("could not be read: {} is a symbolic link", parent.display()));
            }
            _ => return Some(format!("is missing: there is no directory {}", parent.display())),
        }
    }
    let path = run.join(name);
    match fs::symlink_metadata(&path) {
        Err(error) if error.kind() == ErrorKind::NotFound => Some("is missing".to_owned()),
        Err(error) => Some(format!("could not be read: {error}")),
        Ok(found) if found.is_symlink() => Some("is a symbolic link".to_owned()),
        Ok(found) if !found.is_file() => Some("is no regular file".to_owned()),
        Ok(found) => problem_of_content(&path, found.len(), file, moment),
    }
}

fn problem_of_content(path: &Path, length: u64, file: &FileRecord, moment: Moment) -> Option<String> {
    let expected = file.extent.length;
    match (moment, file.kind) {
        // A behaviour may have written anything since, and a power failure may have taken that.
        (Moment::Checkpoint, Kind::Declared) => return None,
        (Moment::Checkpoint, Kind::Growing) if length >= expected => {}
        _ if length != expected => return Some(format!("has {length} bytes, and {expected} had been written")),
        _ => {}
    }
    match own_files::read(path).and_then(|file| Extent::read(file, expected)) {
        Err(error) => Some(format!("could not be read: {error}")),
        Ok(found) if found != file.extent => Some("has changed: its bytes are not those that were written".to_owned()),
        Ok(_) => None,
    }
}

/// Whether a record may have a file of this name: siloflow's own, or one of a behaviour, at the top of the directory.
fn is_name(name: &Path) -> bool {
    let mut parts = name.components();
    let is_single = matches!((parts.next(), parts.next()), (Some(Component::Normal(_)), None));
    is_own(name) || is_single && !name.as_os_str().as_encoded_bytes().starts_with(b".")
}
