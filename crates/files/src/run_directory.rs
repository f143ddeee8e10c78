//! The run directory: all output of a run, and all input that is needed to repeat it.
//!
//! * Input: `scene.ron`, with `--set` applied, and copies of the files that it names. The names of copies begin with
//!   `input-`, so that they cannot collide with results.
//! * Output: `series.csv`, `frames/`, `frames.bin`, `state.csv` and `summary.json`, and where the scene measures them `walls.csv`,
//!   `profiles.csv`, `centres.csv`, `fields.csv`, `flow.csv` and `losses.csv`.
//! * Files that behaviours declare ([`RunPath`]).
//! * `.siloflow`: the marker. The process that uses the directory holds a lock on it. It lists the files of behaviours, so that a
//!   program without these behaviours can replace the run.
//!
//! A run directory is prepared beside its place and moved there in one rename, so that it is the directory of one run at
//! every moment ([`RunDirectory::create`], [`RunDirectory::publish`]). An earlier run is replaced only if the caller
//! allows it. Files of other programs in the directory are kept.
//!
//! Limits: a file system that cannot exchange two directories atomically needs two renames. A mount point and the current
//! directory cannot be replaced.

mod examine;
mod exchange;
pub mod integrity;
mod kinds;
mod marker;
pub(crate) mod names;
mod part;
mod path;
mod results;
mod resumed;
mod stage;
mod usage;

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Serialize;

use self::examine::{Content, examine, refuse_content, resolve};
pub use self::kinds::{Depth, refuse_odd};
pub(crate) use self::marker::MARKER;
use self::marker::{Claim, Marker};
pub(crate) use self::names::is_reserved;
use self::names::{FRAMES, HASHES, LOSSES, REPORT, SCENE, STATE, SUMMARY, copy_name, is_own};
pub use self::names::{
    checkpoint_name, checkpoints_directory, checkpoints_in, frame_data_of, hash_of_input, is_drawn, is_run, movie_of,
    pictures_of, remove_incomplete_checkpoints, report_of, scene_of, summary_of, tables_of,
};
pub use self::part::PartDirectory;
pub use self::path::RunPath;
pub use self::results::{check_results, write_results};
use self::stage::Stage;
pub use self::usage::{Use, holds_run, watch};
use crate::disk::{self, DiskFile, remove_if_there};
use crate::growing::OutputPlace;
use crate::hashes::{self, SummaryFiles};
use crate::own_files;
use crate::run_directory::Guard;
use crate::run_files::{Counted, RunFiles};
use crate::whole_file::{part_of, write_synced, write_with};
use siloflow_text::fault::Fault;
use siloflow_text::source::Source;
use siloflow_text::source::places;

/// A run directory that this process has locked.
#[derive(Debug)]
pub struct RunDirectory {
    /// The directory as the caller names it.
    shown: PathBuf,
    /// The directory, absolute and without symbolic links.
    target: PathBuf,
    replace: bool,
    place: Place,
    files: RunFiles,
}

/// Where a run directory is.
#[derive(Debug)]
enum Place {
    /// Beside its target.
    Staged(Stage),
    /// At its target.
    Published(Marker),
    /// Nowhere: it could not be published.
    Gone,
}

/// Bytes that `summary.json.part` occupies from the start, so that a full disk at the end leaves space for the summary.
const SUMMARY_RESERVE: usize = 32 << 10;

impl RunDirectory {
    /// Prepares a run directory beside `path`, with `scene.ron` and copies of the files that it names. `path` itself is
    /// not changed. Dropping the value without [`RunDirectory::publish`] removes all traces of it.
    ///
    /// `replace` allows that a run at `path` is replaced.
    ///
    /// # Errors
    /// * Another process uses `path`.
    /// * `path` holds a run, and `replace` is false; or it is not empty and holds no run.
    /// * A file cannot be read or written.
    pub fn create(path: &Path, source: &Source, replace: bool) -> Result<Self, Fault> {
        let target = Self::check(path, replace)?;
        let stage = Stage::create(&target, &is_own).map_err(|error| could_not_prepare(path, &error))?;
        let files = RunFiles::default();
        files.placed_in(stage.above());
        let directory = Self::new(path, target, replace, Place::Staged(stage), files);
        let mut text = source.text.clone();
        for (key, from) in &source.files {
            text = places::set(&text, key, &format!("{:?}", copy_name(key, from)))?;
        }
        directory.fill(&text, source).map_err(|error| directory.unwritable(&error))?;
        Ok(directory)
    }

    fn new(shown: &Path, target: PathBuf, replace: bool, place: Place, files: RunFiles) -> Self {
        files.sync_also(MARKER);
        Self { shown: shown.to_owned(), target, replace, place, files }
    }

    /// Checks whether a run at `path` may begin, and returns its absolute path. Nothing is changed.
    ///
    /// # Errors
    /// As [`RunDirectory::create`], for `path`.
    pub fn check(path: &Path, replace: bool) -> Result<PathBuf, Fault> {
        let target = resolve(path)?;
        refuse_content(path, &examine(path, &target)?, replace)?;
        Ok(target)
    }

    /// Writes the files that exist before the first step.
    fn fill(&self, scene: &str, source: &Source) -> io::Result<()> {
        let now = self.now();
        disk::create_directory(&now.join(FRAMES))?;
        for (key, from) in &source.files {
            self.write_input(&copy_name(key, from), |copy| match source.text_for(key) {
                Some(text) => copy.write_all(text.as_bytes()),
                None => io::copy(&mut File::open(from)?, copy).map(|_| ()),
            })?;
        }
        self.write_input(SCENE, |file| file.write_all(scene.as_bytes()))?;
        self.reserve_summary()
    }

    fn write_input(&self, name: &str, content: impl FnOnce(&mut Counted) -> io::Result<()>) -> io::Result<()> {
        let mut file = DiskFile::create_new(&self.now().join(name))?;
        let mut counted = Counted::new(&mut file);
        content(&mut counted)?;
        self.files.file(name).is_written(counted.extent);
        Ok(())
    }

    /// Locks the directory of an earlier run, to continue it. Nothing but the marker is changed.
    ///
    /// # Errors
    /// If there is no run at `path`, another process uses it, or something in it is not of the [kind](refuse_odd) that siloflow makes.
    pub fn reopen(path: &Path) -> Result<Self, Fault> {
        let target = resolve(path)?;
        let failed = |message: String| Fault::new("run::directory", message).help("give the directory of a run");
        let unreadable = |error: io::Error| failed(format!("could not use {}: {error}", path.display()));
        refuse_odd(path, Depth::Whole)?;
        match Marker::claim(&target).map_err(unreadable)? {
            Claim::Unmarked => Err(failed(format!("{} holds no run", path.display()))),
            Claim::Held(holder) => Err(in_use(path, &holder)),
            Claim::Locked(marker) => {
                marker.sign(&marker::declared_in(&target)).map_err(unreadable)?;
                Ok(Self::new(path, target, false, Place::Published(marker), RunFiles::default()))
            }
        }
    }

    /// Moves the directory to its place, if it is not there. A run that is there is replaced. From then on a failure of the
    /// run leaves its traces in the directory.
    ///
    /// # Errors
    /// As [`RunDirectory::create`]; everything is then as before.
    pub fn publish(&mut self) -> Result<(), Fault> {
        if let Place::Published(_) = self.place {
            return Ok(());
        }
        // It may have changed since the preparation began. The lock of an old run is held until that run is gone.
        let old = examine(&self.shown, &self.target)?;
        refuse_content(&self.shown, &old, self.replace)?;
        if !matches!(old, Content::Empty) {
            // The old run goes only once the new one is on the disk.
            self.files.sync(self.now()).map_err(|error| self.unwritable(&error))?;
        }
        let Place::Staged(stage) = std::mem::replace(&mut self.place, Place::Gone) else { return Ok(()) };
        let marker = stage.publish(&is_own).map_err(|error| {
            let message = format!("could not move the run directory to {}: {error}", self.shown.display());
            Fault::new("run::directory", message)
                .help("a mount point cannot be replaced; give a directory in it with --out")
        })?;
        self.place = Place::Published(marker);
        Ok(())
    }

    /// Removes `summary.json`, `hashes.txt`, `state.csv` and `report.html` of the part that has run so far, before a reopened run continues.
    ///
    /// # Errors
    /// If a file cannot be removed, or there is no space for a summary.
    pub fn remove_results(&self) -> io::Result<()> {
        remove_if_there(&self.now().join(SUMMARY))?;
        // Without this a power failure could bring back the summary without what it speaks of.
        disk::sync_directory(self.now())?;
        [HASHES, STATE, REPORT].iter().try_for_each(|name| remove_if_there(&self.now().join(name)))?;
        self.reserve_summary()
    }

    /// Occupies the space of the summary.
    fn reserve_summary(&self) -> io::Result<()> {
        let part = part_of(&self.now().join(SUMMARY));
        remove_if_there(&part)?;
        DiskFile::create_new(&part)?.write_all(&vec![b'\n'; SUMMARY_RESERVE])
    }

    /// Returns the path of the directory, absolute and without symbolic links.
    #[must_use]
    pub fn absolute(&self) -> &Path {
        &self.target
    }

    /// Returns the path of the directory, as the caller gave it.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.shown
    }

    /// Returns the directory as it is now. It changes when the directory is published.
    #[must_use]
    pub fn current(&self) -> &Path {
        self.now()
    }

    /// The directory as it is now.
    fn now(&self) -> &Path {
        match &self.place {
            Place::Staged(stage) => &stage.path,
            Place::Published(_) | Place::Gone => &self.target,
        }
    }

    /// Returns the path of the directory of pictures. It changes when the directory is published.
    #[must_use]
    pub fn frames(&self) -> PathBuf {
        self.now().join(FRAMES)
    }

    /// Returns the path of the directory of checkpoints. It changes when the directory is published.
    #[must_use]
    pub fn checkpoints(&self) -> PathBuf {
        checkpoints_directory(self.now())
    }

    /// Records files that behaviours will write, so that a later run in this place removes them.
    ///
    /// # Errors
    /// If the marker cannot be written.
    pub fn declare(&self, files: &[String]) -> io::Result<()> {
        let marker = match &self.place {
            Place::Staged(stage) => &stage.marker,
            Place::Published(marker) => marker,
            Place::Gone => return Ok(()),
        };
        self.files.declare(files);
        if files.is_empty() { Ok(()) } else { marker.sign(files) }
    }

    /// The record of the files of the run.
    #[must_use]
    pub fn files(&self) -> &RunFiles {
        &self.files
    }

    /// Returns the resource that tells behaviours where the directory is now.
    #[must_use]
    pub fn resource(&self) -> RunPath {
        RunPath {
            now: self.now().to_owned(),
            is_resumed: matches!(self.place, Place::Published(_)),
            files: self.files.clone(),
        }
    }

    /// Returns the place of a file of rows, for example `series.csv`. It changes when the directory is published.
    #[must_use]
    pub fn rows(&self, name: &str) -> OutputPlace {
        self.resource().rows(name)
    }

    /// Returns the place of `losses.csv`. It changes when the directory is published.
    #[must_use]
    pub fn losses(&self) -> OutputPlace {
        self.rows(LOSSES)
    }

    /// Writes `state.csv` by calling `write_state`.
    ///
    /// # Errors
    /// If the file cannot be written, or if this is no longer the directory of the run.
    pub fn write_state(&self, write_state: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
        self.guard()()?;
        write_with(&self.now().join(STATE), |file| {
            let mut counted = Counted::new(file);
            write_state(&mut counted)?;
            self.files.file(STATE).is_written(counted.extent);
            Ok(())
        })
    }

    /// Brings all files of the run to the disk, and then `hashes.txt`, which has their hashes. Returns what the summary says about
    /// them.
    ///
    /// # Errors
    /// If a file cannot be brought there, or if this is no longer the directory of the run.
    pub fn write_hashes(&self) -> io::Result<SummaryFiles> {
        self.guard()()?;
        self.files.sync(self.now())?;
        let manifest = self.files.complete(self.now())?;
        write_synced(&self.now().join(HASHES), |file| file.write_all(hashes::text(&manifest).as_bytes()))?;
        Ok(SummaryFiles::of(&manifest))
    }

    /// Writes `summary.json`, into the space that is reserved for it. The directory and everything in the record are on the disk.
    ///
    /// # Errors
    /// If the file cannot be written, or if this is no longer the directory of the run.
    pub fn write_summary(&self, summary: &impl Serialize) -> io::Result<()> {
        self.guard()()?;
        let json = hashes::sealed(serde_json::to_string_pretty(summary).map_err(io::Error::other)? + "\n");
        let complete = self.now().join(SUMMARY);
        let part = part_of(&complete);
        let mut file = if own_files::is_file(&part) { DiskFile::reopen(&part) } else { DiskFile::create_new(&part) }?;
        file.write_all(json.as_bytes())?;
        file.set_len(json.len() as u64)?;
        // The summary says that the run is over, so it gets its name only when it is on the disk.
        file.sync()?;
        disk::rename(&part, &complete)?;
        disk::sync_directory(self.now())
    }

    /// The fault of a directory that cannot be written before it is published.
    #[must_use]
    pub fn unwritable(&self, error: &io::Error) -> Fault {
        could_not_prepare(&self.shown, error)
    }

    /// Returns a function that checks that no other run has taken the place of this directory.
    #[must_use]
    pub fn guard(&self) -> Guard {
        let place = match &self.place {
            Place::Staged(stage) => stage.marker.place(&stage.path),
            Place::Published(marker) => marker.place(&self.target),
            Place::Gone => None,
        };
        Arc::new(move || match &place {
            Some(place) if place.is_unchanged() => Ok(()),
            _ => Err(io::Error::other("the directory was moved or removed during the run")),
        })
    }
}

impl Drop for RunDirectory {
    /// Removes a directory that was not published.
    fn drop(&mut self) {
        if let Place::Staged(stage) = &self.place {
            stage.discard(&is_own);
        }
    }
}

fn could_not_prepare(path: &Path, error: &io::Error) -> Fault {
    Fault::new("run::directory", format!("could not prepare the run directory {}: {error}", path.display()))
        .help("nothing was changed; is there space, may you write there? Or give another directory with --out")
}

/// The fault of a directory that another process uses.
fn in_use(path: &Path, holder: &str) -> Fault {
    Fault::new("run::in_use", format!("{} is in use by {holder}", path.display()))
        .help("wait for its end, or give another directory with --out")
}

#[cfg(test)]
mod tests;
