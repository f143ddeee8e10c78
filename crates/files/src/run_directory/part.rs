//! A directory of results that is filled under another name: `vtk.part` becomes `vtk` in one rename.
//!
//! It has the marker `.siloflow` from its first moment, whose lock the process holds until the directory has its name. A process that is
//! killed leaves it. The next process with the same target removes it, if no process holds the lock and siloflow's own files are all that
//! it holds. Earlier versions wrote no marker: what has none belongs to no process.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use crate::own_files;
use crate::run_directory::exchange::exchange;
use crate::run_directory::marker::{Claim, MARKER, Marker};
use crate::run_directory::names::{completed, content_of};
use crate::whole_file::{part_of, remove_if_there};

/// How many times a directory is tried if other processes remove it before it is locked.
const ATTEMPTS: u32 = 100;

/// A directory of results in preparation. Dropping it without [`PartDirectory::publish`] removes it.
#[derive(Debug)]
pub struct PartDirectory {
    path: PathBuf,
    target: PathBuf,
    /// Whether siloflow writes a file of this name there.
    is_own: fn(&Path) -> bool,
    #[expect(dead_code, reason = "holding its lock is its purpose")]
    marker: Marker,
    is_published: bool,
}

impl PartDirectory {
    /// Makes an empty directory beside `target` for results like those of the directory `name` in a run directory: `vtk`, for example.
    ///
    /// # Errors
    /// * Another process fills it ([`ErrorKind::ResourceBusy`]).
    /// * What an earlier process left holds files that siloflow did not make.
    /// * It cannot be made.
    pub fn create(target: &Path, name: &str) -> io::Result<Self> {
        let path = part_of(target);
        let is_own = content_of(name).ok_or_else(|| io::Error::other(format!("{name} is no directory of results")))?;
        let mut attempt = 0;
        loop {
            attempt += 1;
            let made = fs::create_dir(&path).map_err(|error| (error, false));
            match made.and_then(|()| Marker::create(&path).map_err(|error| (error, true))) {
                Ok(marker) => return Ok(Self { path, target: target.to_owned(), is_own, marker, is_published: false }),
                Err((error, _)) if attempt == ATTEMPTS => return Err(error),
                Err((error, false)) if error.kind() == ErrorKind::AlreadyExists => remove_left(&path, is_own)?,
                // Another process took the new directory for one that was left.
                Err((error, true)) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::AlreadyExists) => {}
                Err((error, is_made)) => {
                    if is_made {
                        let _ = remove_if_there(&path.join(MARKER));
                        let _ = fs::remove_dir(&path);
                    }
                    return Err(error);
                }
            }
        }
    }

    /// The directory as it is now.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Gives the directory its name. With `replace` it takes the place of a directory that is there, whose own files are deleted.
    ///
    /// # Errors
    /// If something is in its place that is not replaced, or it cannot be renamed.
    pub fn publish(mut self, replace: bool) -> io::Result<()> {
        if replace && self.target.symlink_metadata().is_ok() {
            exchange(&self.path, &self.target, &self.path.with_added_extension("old"))?;
            self.is_published = true;
            remove_if_there(&self.target.join(MARKER))?;
            return remove(&self.path, self.is_own);
        }
        fs::rename(&self.path, &self.target)?;
        self.is_published = true;
        remove_if_there(&self.target.join(MARKER))
    }
}

impl Drop for PartDirectory {
    fn drop(&mut self) {
        if !self.is_published
            && let Err(error) = remove(&self.path, self.is_own)
        {
            tracing::warn!("could not remove {}: {error}", self.path.display());
        }
    }
}

/// Returns the process that fills the directory at `path`, in words; `None` if none does.
pub(super) fn writer_of(path: &Path) -> io::Result<Option<String>> {
    Ok(match Marker::claim(path)? {
        Claim::Held(holder) => Some(holder),
        Claim::Unmarked | Claim::Locked(_) => None,
    })
}

/// Removes what a killed process has left.
fn remove_left(path: &Path, is_own: fn(&Path) -> bool) -> io::Result<()> {
    if !own_files::is_directory(path) {
        return Err(io::Error::other(format!("{} is there, and is no directory", path.display())));
    }
    match Marker::claim(path)? {
        Claim::Held(holder) => {
            Err(io::Error::new(ErrorKind::ResourceBusy, format!("{holder} is writing {}", path.display())))
        }
        // The lock is held until all is gone.
        Claim::Locked(_marker) => remove(path, is_own),
        Claim::Unmarked => remove(path, is_own),
    }
}

/// Removes a directory with siloflow's own files, or a link in its place. Nothing is removed if it holds anything else.
fn remove(path: &Path, is_own: fn(&Path) -> bool) -> io::Result<()> {
    if !own_files::is_directory(path) {
        return remove_if_there(path);
    }
    let mut own = Vec::new();
    for entry in own_files::entries(path)? {
        let entry = entry?;
        let name = entry.file_name();
        if name == MARKER {
            continue;
        }
        if !entry.file_type()?.is_file() || !is_own(completed(Path::new(&name))) {
            let message = format!("{} holds {}, which siloflow did not make", path.display(), name.display());
            return Err(io::Error::other(message));
        }
        own.push(entry.path());
    }
    own.iter().try_for_each(|file| remove_if_there(file))?;
    // The marker comes last, so that no process takes a directory that is being removed for a new one.
    remove_if_there(&path.join(MARKER))?;
    fs::remove_dir(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(directory: &Path) -> Vec<String> {
        let entries = fs::read_dir(directory).unwrap();
        let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_directory_is_there_when_it_is_whole_and_else_nothing_is() {
        let here = tempfile::tempdir().unwrap();
        let target = here.path().join("vtk");
        let part = PartDirectory::create(&target, "vtk").unwrap();
        fs::write(part.path().join("grains-00000.vtp"), "").unwrap();
        assert_eq!(names(here.path()), ["vtk.part"]);
        drop(part);
        assert_eq!(names(here.path()), [""; 0]);
        let part = PartDirectory::create(&target, "vtk").unwrap();
        fs::write(part.path().join("grains-00000.vtp"), "new").unwrap();
        part.publish(false).unwrap();
        assert_eq!((names(here.path()), names(&target)), (vec!["vtk".to_owned()], vec!["grains-00000.vtp".to_owned()]));
        // A directory with the name of the target is replaced only if the caller says so.
        let again = PartDirectory::create(&target, "vtk").unwrap();
        assert!(again.publish(false).is_err());
        assert_eq!(names(here.path()), ["vtk"]);
        let again = PartDirectory::create(&target, "vtk").unwrap();
        fs::write(again.path().join("grains.pvd"), "").unwrap();
        again.publish(true).unwrap();
        assert_eq!((names(here.path()), names(&target)), (vec!["vtk".to_owned()], vec!["grains.pvd".to_owned()]));
    }

    #[test]
    fn what_a_killed_process_left_is_replaced_and_what_a_living_one_fills_is_not() {
        let here = tempfile::tempdir().unwrap();
        let target = here.path().join("csv");
        let part = here.path().join("csv.part");
        // With a marker and without one, as earlier versions left it.
        for marker in [true, false] {
            fs::create_dir(&part).unwrap();
            fs::write(part.join("grains.csv"), "half").unwrap();
            fs::write(part.join("contacts.csv.part"), "half").unwrap();
            if marker {
                fs::write(part.join(MARKER), "siloflow keeps its results here; process 1\n").unwrap();
            }
            let taken = PartDirectory::create(&target, "csv").unwrap();
            assert_eq!(names(taken.path()), [MARKER]);
        }
        let living = PartDirectory::create(&target, "csv").unwrap();
        let refused = PartDirectory::create(&target, "csv").unwrap_err();
        assert_eq!(refused.kind(), ErrorKind::ResourceBusy);
        assert!(refused.to_string().contains(&format!("process {} is writing", std::process::id())), "{refused}");
        assert_eq!(writer_of(&part).unwrap(), Some(format!("process {}", std::process::id())));
        drop(living);
        // Files of others are kept.
        fs::create_dir(&part).unwrap();
        fs::write(part.join("grains.csv"), "half").unwrap();
        fs::write(part.join("thesis.tex"), "years").unwrap();
        let refused = PartDirectory::create(&target, "csv").unwrap_err().to_string();
        assert!(refused.contains("thesis.tex"), "{refused}");
        assert_eq!(names(&part), ["grains.csv", "thesis.tex"]);
    }

    #[test]
    #[cfg(unix)]
    fn a_link_is_not_filled() {
        let here = tempfile::tempdir().unwrap();
        fs::create_dir(here.path().join("mine")).unwrap();
        fs::write(here.path().join("mine/grains.csv"), "years").unwrap();
        std::os::unix::fs::symlink("mine", here.path().join("csv.part")).unwrap();
        assert!(
            PartDirectory::create(&here.path().join("csv"), "csv").unwrap_err().to_string().contains("no directory")
        );
        assert_eq!(fs::read(here.path().join("mine/grains.csv")).unwrap(), b"years");
    }
}
