//! The record of the files that a run has written: length and hash of each, and whether it is on the disk.
//!
//! Writers add what they write. A checkpoint and the summary first bring everything in the record to the disk
//! ([`RunFiles::sync`]), and then take the record along ([`Manifest`]), so that a resume and `siloflow verify` find files that have
//! changed.
//!
//! | kind | recorded | a later moment of the run may have |
//! |---|---|---|
//! | whole | the file | no other content |
//! | growing | the part that was written so far | more behind it |
//! | declared | that it is there; its hash at the end of the run | any other content: a behaviour writes it as it likes |
//!
//! A file that grows is hashed as it grows. The hash is [`Fnv`], which finds accidents and no forgery.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::disk;
use crate::fnv::Fnv;
use crate::own_files;

/// Length and hash of a file or of its first part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct Extent {
    /// Number of bytes.
    pub length: u64,
    /// [`Fnv`] hash of them.
    pub hash: u64,
}

impl Default for Extent {
    fn default() -> Self {
        Self { length: 0, hash: Fnv::default().value() }
    }
}

impl Extent {
    /// Adds bytes behind.
    #[must_use]
    pub fn with(self, bytes: &[u8]) -> Self {
        let mut hash = Fnv::continued(self.hash);
        hash.update(bytes);
        Self { length: self.length + bytes.len() as u64, hash: hash.value() }
    }

    /// Returns the extent of the first `length` bytes of a file, or of all if it is shorter.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn read(file: impl Read, length: u64) -> io::Result<Self> {
        let mut extent = Self::default();
        let mut file = file.take(length);
        let mut buffer = vec![0; 1 << 16];
        loop {
            match file.read(&mut buffer) {
                Ok(0) => return Ok(extent),
                Ok(length) => extent = extent.with(&buffer[..length]),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }
}

/// Hashes all bytes on their way to a file.
pub struct Counted<'a> {
    file: &'a mut dyn Write,
    /// Length and hash of the bytes so far.
    pub extent: Extent,
}

impl<'a> Counted<'a> {
    /// Returns a writer to `file`.
    pub fn new(file: &'a mut dyn Write) -> Self {
        Self { file, extent: Extent::default() }
    }
}

impl Write for Counted<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.extent = self.extent.with(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// How a file changes during a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Kind {
    /// It is written once.
    Whole,
    /// It gets more bytes behind those that it has.
    Growing,
    /// A behaviour writes it in ways of its own.
    Declared,
}

/// A file of a run at one moment.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct FileRecord {
    /// Path in the run directory, with `/` between its parts.
    pub name: String,
    /// How it changes.
    pub kind: Kind,
    /// Length and hash of the bytes that the run had written.
    pub extent: Extent,
}

/// A file without which a run was continued.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Damage {
    /// Path in the run directory.
    pub file: String,
    /// The damage, in words.
    pub what: String,
    /// Number of steps after which the run was continued: what the file had from before is missing.
    pub steps: u64,
}

/// The files of a run at one moment.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Manifest {
    /// The files, by name.
    pub files: Vec<FileRecord>,
    /// Files without which the run was continued.
    pub damage: Vec<Damage>,
}

/// A file in the record.
#[derive(Clone, Copy, Debug)]
struct Entry {
    kind: Kind,
    extent: Extent,
    /// Bytes that always stand behind the rest of a growing file.
    end: &'static [u8],
    is_synced: bool,
}

#[derive(Debug, Default)]
struct Record {
    files: BTreeMap<String, Entry>,
    damage: Vec<Damage>,
    /// Files that behaviours write.
    declared: Vec<String>,
    /// Files that are synced and not hashed.
    others: Vec<String>,
    /// Directories above the run directory whose names are not on the disk yet.
    above: Vec<PathBuf>,
}

/// The record of the files of a run. Its clones are one record.
#[derive(Resource, Clone, Debug, Default)]
pub struct RunFiles(Arc<Mutex<Record>>);

impl RunFiles {
    fn lock(&self) -> MutexGuard<'_, Record> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns a handle to one file.
    #[must_use]
    pub fn file(&self, name: impl Into<String>) -> RunFile {
        RunFile { files: self.clone(), name: name.into() }
    }

    /// Records files that behaviours write.
    pub(crate) fn declare(&self, names: &[String]) {
        self.lock().declared.extend_from_slice(names);
    }

    /// Syncs one more file, which is not recorded.
    pub(crate) fn sync_also(&self, name: &str) {
        self.lock().others.push(name.to_owned());
    }

    /// Records directories that must be synced once, because they have got the name of the run directory or of one above it.
    pub(crate) fn placed_in(&self, above: Vec<PathBuf>) {
        self.lock().above = above;
    }

    /// Returns the files without which the run was continued.
    #[must_use]
    pub fn damage(&self) -> Vec<Damage> {
        self.lock().damage.clone()
    }

    /// Whether the run was continued without some of its files.
    #[must_use]
    pub fn has_damage(&self) -> bool {
        !self.lock().damage.is_empty()
    }

    /// Continues the record of an earlier process. All its files are on the disk.
    pub(crate) fn continue_from(&self, manifest: Manifest) {
        let mut record = self.lock();
        record.damage = manifest.damage;
        record.files = manifest
            .files
            .into_iter()
            .filter(|file| file.kind != Kind::Declared)
            .map(|FileRecord { name, kind, extent }| (name, Entry { kind, extent, end: &[], is_synced: true }))
            .collect();
    }

    /// Brings everything in the record and its names to the disk. `run` is the run directory.
    ///
    /// # Errors
    /// If a file cannot be synced; the error names it.
    pub fn sync(&self, run: &Path) -> io::Result<()> {
        // The files are written by no thread now, so the lock is free again soon.
        let mut record = self.lock();
        let Record { files, declared, others, above, .. } = &mut *record;
        let failed = |path: &Path, error: io::Error| {
            io::Error::new(error.kind(), format!("could not sync {}: {error}", path.display()))
        };
        let mut directories = BTreeSet::from([run.to_owned()]);
        for (name, entry) in files.iter_mut().filter(|(_, entry)| !entry.is_synced) {
            let path = run.join(name);
            match disk::sync_file(&path) {
                // The run need not fail for it. The record keeps the file, so a resume and `verify` say that it is missing.
                Err(error) if error.kind() == io::ErrorKind::NotFound => {
                    tracing::warn!("{name} is missing: another program has removed it");
                    entry.is_synced = true;
                    continue;
                }
                synced => synced.map_err(|error| failed(Path::new(name), error))?,
            }
            directories.extend(path.parent().map(Path::to_owned));
            entry.is_synced = true;
        }
        for name in declared.iter().chain(others.iter()).filter(|name| !files.contains_key(*name)) {
            match disk::sync_file(&run.join(name)) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(failed(Path::new(name), error)),
                _ => {}
            }
        }
        let all = directories.iter().chain(above.iter());
        all.into_iter().try_for_each(|path| disk::sync_directory(path).map_err(|error| failed(path, error)))?;
        above.clear();
        Ok(())
    }

    /// Returns the files as they are between two steps.
    #[must_use]
    pub fn manifest(&self, run: &Path) -> Manifest {
        let record = self.lock();
        let recorded = record.files.iter().map(|(name, entry)| FileRecord {
            name: name.clone(),
            kind: entry.kind,
            extent: entry.extent,
        });
        let declared = record.declared.iter().filter(|name| !record.files.contains_key(*name)).filter_map(|name| {
            let length = std::fs::symlink_metadata(run.join(name)).ok()?.len();
            let extent = Extent { length, ..Extent::default() };
            Some(FileRecord { name: name.clone(), kind: Kind::Declared, extent })
        });
        Manifest { files: recorded.chain(declared).collect(), damage: record.damage.clone() }
    }

    /// Returns the files as they are after the last step, each to its end.
    ///
    /// # Errors
    /// If a file of a behaviour cannot be read.
    pub fn complete(&self, run: &Path) -> io::Result<Manifest> {
        let mut manifest = self.manifest(run);
        let record = self.lock();
        for file in &mut manifest.files {
            file.extent = match record.files.get(&file.name) {
                Some(entry) => entry.extent.with(entry.end),
                None => Extent::read(own_files::read(&run.join(&file.name))?, u64::MAX)?,
            };
        }
        Ok(manifest)
    }
}

/// A file in the record of a run.
#[derive(Clone, Debug, Default)]
pub struct RunFile {
    files: RunFiles,
    name: String,
}

impl RunFile {
    /// Records that the file has been written as a whole.
    pub fn is_written(&self, extent: Extent) {
        let entry = Entry { kind: Kind::Whole, extent, end: &[], is_synced: false };
        self.files.lock().files.insert(self.name.clone(), entry);
    }

    /// Records that the file has got these bytes, before `end` which is always its end.
    pub fn has_grown(&self, bytes: &[u8], end: &'static [u8]) {
        let mut record = self.files.lock();
        let new = Entry { kind: Kind::Growing, extent: Extent::default(), end, is_synced: false };
        let entry = record.files.entry(self.name.clone()).or_insert(new);
        *entry = Entry { kind: Kind::Growing, extent: entry.extent.with(bytes), end, is_synced: false };
    }

    /// Records that the file has been cut to this extent.
    pub fn is_cut(&self, extent: Extent, end: &'static [u8]) {
        let entry = Entry { kind: Kind::Growing, extent, end, is_synced: false };
        self.files.lock().files.insert(self.name.clone(), entry);
    }

    /// Records that the file has been removed.
    pub fn is_removed(&self) {
        self.files.lock().files.remove(&self.name);
    }

    /// Returns what the record holds of the file.
    #[must_use]
    pub fn extent(&self) -> Option<Extent> {
        self.files.lock().files.get(&self.name).map(|entry| entry.extent)
    }
}
