//! A directory that is prepared beside its target and moved into place when it is complete.
//!
//! The stage of `out/silo1` is `out/.silo1.siloflow-<process>`, with a marker and a lock from its first moment. Moving it
//! into place is one rename, so the target is the old directory or the new one and never a part of both. The old
//! directory then has the name of the stage, and siloflow's own files in it are deleted. Files of other programs are
//! kept (and files that behaviours have declared are deleted): regular files are hard-linked into the new directory before the exchange, everything else is moved after it.
//!
//! A process that is killed may leave a stage. The next process with the same target removes it, if it carries a marker
//! and no process holds its lock. The next process also moves files of other programs that are left in it to the target.

use std::collections::HashSet;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use crate::disk::{self, remove_if_there};
#[cfg(unix)]
use crate::own_files::file_number;
use crate::run_directory::exchange::{exchange, recover};
use crate::run_directory::marker::{Claim, MARKER, Marker, declared_in, process};
use crate::whole_file::PART;

/// Whether siloflow writes a file or directory of this path in a directory. The path counts from the directory.
pub(super) type IsOwn<'a> = &'a (dyn Fn(&Path) -> bool + Send + Sync);

/// A directory in preparation.
#[derive(Debug)]
pub(super) struct Stage {
    /// Where the directory is now.
    pub path: PathBuf,
    /// The marker.
    pub marker: Marker,
    target: PathBuf,
    /// Directories that were created to hold the stage, the innermost first.
    created: Vec<PathBuf>,
}

/// How many times a stage is tried if other processes remove it before it is locked.
const ATTEMPTS: u32 = 100;

impl Stage {
    /// Creates a stage for the directory `target`, an absolute path, and removes stages that killed processes left.
    pub(super) fn create(target: &Path, is_own: IsOwn) -> io::Result<Self> {
        let (Some(parent), Some(name)) = (target.parent(), target.file_name()) else {
            return Err(io::Error::other("it has no parent directory"));
        };
        let created: Vec<_> = parent.ancestors().take_while(|path| !path.exists()).map(Path::to_owned).collect();
        created.iter().rev().try_for_each(|path| make_directory(path))?;
        remove_stale(parent, target, is_own)?;
        let mut attempt = 0;
        loop {
            attempt += 1;
            let path = parent.join(stage_name(name, &format!("{}-{attempt}", process())));
            match disk::create_directory(&path).and_then(|()| Marker::create(&path)) {
                Ok(marker) => return Ok(Self { path, marker, target: target.to_owned(), created }),
                // Another process took the new directory for a remainder.
                Err(error)
                    if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::AlreadyExists) && attempt < ATTEMPTS => {
                }
                Err(error) => {
                    let _ = remove_if_there(&path.join(MARKER));
                    let _ = disk::remove_directory(&path);
                    remove_empty(&created);
                    return Err(error);
                }
            }
        }
    }

    /// Returns the directories that have got a new name, that of the run directory or of one above it.
    pub(super) fn above(&self) -> Vec<PathBuf> {
        let new = std::iter::once(&self.target).chain(&self.created);
        new.filter_map(|path| path.parent().map(Path::to_owned)).collect()
    }

    /// Moves the directory into place and deletes siloflow's own files of the directory that was there before. The caller
    /// holds the lock of that directory.
    pub(super) fn publish(self, is_own: IsOwn) -> io::Result<Marker> {
        self.move_into_place(is_own).inspect_err(|_| self.discard(is_own))?;
        Ok(self.marker)
    }

    fn move_into_place(&self, is_own: IsOwn) -> io::Result<()> {
        match fs::symlink_metadata(&self.target) {
            Err(error) if error.kind() == ErrorKind::NotFound => return disk::rename(&self.path, &self.target),
            found => copy_permissions(&found?, &self.path)?,
        }
        if fs::read_dir(&self.target)?.next().is_none() {
            // The rename replaces an empty directory, and fails if the directory is no longer empty.
            return disk::rename(&self.path, &self.target);
        }
        self.replace(is_own)
    }

    /// Exchanges the stage with the directory that is there, and empties the old directory.
    fn replace(&self, is_own: IsOwn) -> io::Result<()> {
        let declared = declared(&[&self.target, &self.path]);
        for entry in fs::read_dir(&self.target)? {
            let name = entry?.file_name();
            let old = self.target.join(&name);
            let new = self.path.join(&name);
            let is_file = fs::symlink_metadata(&old)?.is_file();
            if is_file && !is_own(Path::new(&name)) && !declared.contains(&name) && name != MARKER {
                // Without hard links the file is moved after the exchange.
                let _ = disk::link(&old, &new);
            }
        }
        exchange(&self.path, &self.target, &aside(&self.path))?;
        // The old files go only once the exchange is on the disk.
        let parent = self.target.parent().unwrap_or(Path::new("/"));
        let removed = disk::sync_directory(parent).and_then(|()| remove(&self.path, &self.target, is_own));
        if let Err(error) = removed {
            tracing::warn!("could not remove all of the earlier run, now in {}: {error}", self.path.display());
        }
        Ok(())
    }

    /// Removes the stage.
    pub(super) fn discard(&self, is_own: IsOwn) {
        if let Err(error) = remove(&self.path, &self.target, is_own) {
            tracing::warn!("could not remove {}: {error}", self.path.display());
        }
        remove_empty(&self.created);
    }
}

/// Gives a directory the permissions of another, where the system has permissions.
fn copy_permissions(of: &fs::Metadata, to: &Path) -> io::Result<()> {
    match fs::set_permissions(to, of.permissions()) {
        Err(error) if error.kind() == ErrorKind::Unsupported => Ok(()),
        done => done,
    }
}

/// Makes a directory, unless another process has made it.
fn make_directory(path: &Path) -> io::Result<()> {
    match disk::create_directory(path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists && path.is_dir() => Ok(()),
        made => made,
    }
}

fn stage_name(name: &OsStr, end: &str) -> PathBuf {
    let mut stage = std::ffi::OsString::from(".");
    stage.push(name);
    stage.push(".siloflow-");
    stage.push(end);
    stage.into()
}

/// Name of the old directory during an exchange in several steps.
fn aside(stage: &Path) -> PathBuf {
    stage.with_added_extension("old")
}

/// Removes stages of `target` that killed processes left.
fn remove_stale(parent: &Path, target: &Path, is_own: IsOwn) -> io::Result<()> {
    let prefix = stage_name(target.file_name().unwrap_or_default(), "");
    let prefix = prefix.as_os_str().as_encoded_bytes();
    for entry in fs::read_dir(parent)? {
        let entry = entry?;
        if !entry.file_name().as_encoded_bytes().starts_with(prefix) || !entry.file_type()?.is_dir() {
            continue;
        }
        let path = entry.path();
        // The marker of an emptied or just created directory is missing.
        let Ok(claim) = Marker::claim(&path) else { continue };
        let removed = match claim {
            Claim::Held(_) => Ok(()),
            Claim::Unmarked => {
                let _ = disk::remove_directory(&path);
                Ok(())
            }
            Claim::Locked(_) if path.extension().is_some_and(|ending| ending == "old") && !target.exists() => {
                recover(target, &path)
            }
            Claim::Locked(_) => remove(&path, target, is_own),
        };
        if let Err(error) = removed {
            tracing::warn!("could not remove {}, which a killed run left: {error}", path.display());
        }
    }
    Ok(())
}

/// Deletes siloflow's own files in `old`, moves everything else to `new`, and removes `old` if it is empty then.
fn remove(old: &Path, new: &Path, is_own: IsOwn) -> io::Result<()> {
    empty(old, new, Path::new(""), (is_own, &declared(&[old, new])))?;
    let is_empty = fs::read_dir(old)?.all(|entry| entry.is_ok_and(|entry| entry.file_name() == MARKER));
    if !is_empty {
        return Err(io::Error::other("it holds files that siloflow did not write"));
    }
    remove_if_there(&old.join(MARKER))?;
    disk::remove_directory(old)
}

/// Returns the names of the files that the behaviours of runs in these directories have declared, and of their temporary files.
fn declared(directories: &[&Path]) -> HashSet<OsString> {
    let names = directories.iter().flat_map(|directory| declared_in(directory));
    names.flat_map(|name| [OsString::from(format!("{name}.{PART}")), name.into()]).collect()
}

/// Empties the part `inside` of the directory `old`, except for the marker.
fn empty(old: &Path, new: &Path, inside: &Path, own: (IsOwn, &HashSet<OsString>)) -> io::Result<()> {
    let (is_own, declared) = own;
    for entry in fs::read_dir(old.join(inside))? {
        let entry = entry?;
        let path = inside.join(entry.file_name());
        let kind = entry.file_type()?;
        if path == Path::new(MARKER) {
            continue;
        }
        let is_own_file = is_own(&path) || declared.contains(path.as_os_str());
        if kind.is_dir() && is_own(&path) {
            empty(old, new, &path, own)?;
            // A directory that still holds other files stays.
            let _ = disk::remove_directory(&old.join(&path));
        } else if kind.is_file() && (is_own_file || is_same_file(&old.join(&path), &new.join(&path))) {
            remove_if_there(&old.join(&path))?;
        } else if new.is_dir() && fs::symlink_metadata(new.join(&path)).is_err() {
            // The new run may have no directory of this name.
            fs::create_dir_all(new.join(inside))?;
            disk::rename(&old.join(&path), &new.join(&path))?;
        }
    }
    Ok(())
}

#[cfg(unix)]
fn is_same_file(a: &Path, b: &Path) -> bool {
    let number = |path: &Path| fs::symlink_metadata(path).ok().map(|found| file_number(&found));
    number(a).is_some_and(|a| number(b) == Some(a))
}

#[cfg(not(unix))]
fn is_same_file(_: &Path, _: &Path) -> bool {
    false
}

/// Removes these directories, the innermost first, up to one that is not empty.
fn remove_empty(directories: &[PathBuf]) {
    let _ = directories.iter().try_for_each(|path| disk::remove_directory(path));
}
