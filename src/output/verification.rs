//! Checks a run directory against what the run has recorded about its files.
//!
//! | run | held against |
//! |---|---|
//! | with a summary | `hashes.txt`, whose hash the summary has; the summary has its own |
//! | interrupted without one, or going on | the latest checkpoint: all files up to it |
//! | of a version without such records | the hashes inside `frames.bin` and checkpoints |
//!
//! Every checkpoint has its own hash. Files that the record lacks are not examined: a user may add files, and `render`, `plot`,
//! `report` and `export` do.
//!
//! Limits: the hashes find accidents and no forgery. A checkpoint that was deleted is not missed, nor is the summary of a run without
//! a final checkpoint.

use std::fs;
use std::io::{self, ErrorKind};
use std::path::Path;

use serde::Serialize;
use serde_json::Value;

use crate::output::checkpoint::file::{self, Header, OtherFormat};
use siloflow_files::frames::reader::FrameReader;
use siloflow_files::hashes;
use siloflow_files::own_files;
use siloflow_files::run_directory::integrity::{Moment, problem};
use siloflow_files::run_directory::names::{CHECKPOINTS, FRAME_DATA, HASHES, SUMMARY};
use siloflow_files::run_directory::{
    MARKER, Use, checkpoints_directory, checkpoints_in, frame_data_of, holds_run, watch,
};
use siloflow_files::run_files::FileRecord;
use siloflow_text::fault::Fault;
use siloflow_text::file::RESULT_BYTES;

/// The state of a run directory.
#[derive(Debug, Serialize)]
pub struct Verification {
    /// The `status` of the summary; `running`, or `killed` without a summary.
    pub status: String,
    /// Number of files that were held against a hash.
    pub files: usize,
    /// Their bytes.
    pub bytes: u64,
    /// The damaged files.
    pub damage: Vec<Finding>,
    /// Files that could not be checked, and other things to know.
    pub notes: Vec<String>,
}

/// A file that is not as the run left it.
#[derive(Debug, Serialize)]
pub struct Finding {
    /// Path in the run directory.
    pub file: String,
    /// The damage, in words.
    pub what: String,
}

/// The entries of a summary that are needed, as far as they can be read.
#[derive(Default)]
struct Told {
    /// Hash of `hashes.txt`.
    hashes: Option<String>,
}

/// Checks whether there is a run at `path`.
///
/// # Errors
/// If there is none.
pub fn check(path: &Path) -> Result<(), Fault> {
    let shown = path.display();
    let fault = |message: String| Fault::new("verify::no_run", message).help("give the directories of runs");
    match fs::metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => Err(fault(format!("there is no run {shown}"))),
        Err(error) => Err(fault(format!("could not read {shown}: {error}"))),
        Ok(found) if !found.is_dir() => Err(fault(format!("{shown} is no directory"))),
        Ok(_) if !holds_run(path) => Err(fault(format!("{shown} holds no run"))),
        Ok(_) => Ok(()),
    }
}

/// Checks the run at `path`. Nothing is changed.
///
/// # Errors
/// If there is no run, or the directory cannot be read.
pub fn verify(path: &Path) -> Result<Verification, Fault> {
    check(path)?;
    let unreadable = |error: io::Error| {
        Fault::new("verify::unreadable", format!("could not read {}: {error}", path.display()))
            .help("give a directory that you may read")
    };
    let mut found =
        Verification { status: "killed".to_owned(), files: 0, bytes: 0, damage: Vec::new(), notes: Vec::new() };
    // While the lock is held, no process begins to change the run.
    let usage = watch(path).unwrap_or_else(|error| {
        found.damaged(MARKER, format!("could not be read: {error}"));
        Use::Free(None)
    });
    if let Use::Held(holder) = &usage {
        found.note(format!("{holder} uses the run: it was checked up to its latest checkpoint"));
        "running".clone_into(&mut found.status);
    }
    let is_running = matches!(usage, Use::Held(_));
    let latest = found.checkpoints(path, is_running).map_err(unreadable)?;
    let told = if is_running { None } else { found.summary(path) };
    if told.is_none() && latest.as_ref().is_some_and(|latest| latest.is_final) {
        found.damaged(SUMMARY, "is missing: the run is over");
    }
    let listed = told.as_ref().and_then(|told| found.hashes(path, told));
    match (listed, latest, told) {
        (Some(files), _, _) => found.files(path, &files, Moment::End),
        (None, Some(latest), _) => {
            found.files(path, &latest.files.files, Moment::Checkpoint);
            found.note("files were checked up to the latest checkpoint".to_owned());
        }
        (None, None, told) => {
            found.frames(path);
            found.note(match told {
                Some(_) => "the run has no hashes, as an earlier version writes it: only `frames.bin` and checkpoints, which have \
                            hashes of their own, and the form of the summary were checked",
                None => "there is neither a summary nor a checkpoint that could be used: nothing says what the files should be",
            }
            .to_owned());
        }
    }
    found.damage.sort_by(|a, b| a.file.cmp(&b.file));
    Ok(found)
}

impl Verification {
    fn note(&mut self, note: String) {
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    fn damaged(&mut self, file: impl Into<String>, what: impl Into<String>) {
        self.damage.push(Finding { file: file.into(), what: what.into() });
    }

    /// Checks the checkpoints, and returns the header of the latest one that is whole.
    fn checkpoints(&mut self, run: &Path, is_running: bool) -> io::Result<Option<Header>> {
        let directory = checkpoints_directory(run);
        match fs::symlink_metadata(&directory) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            Ok(found) if !found.is_dir() => {
                self.damaged(CHECKPOINTS, "is no directory");
                return Ok(None);
            }
            _ => {}
        }
        let mut latest = None;
        for path in checkpoints_in(&directory)? {
            let name = format!("{CHECKPOINTS}/{}", path.file_name().unwrap_or_default().display());
            match file::open(&path) {
                Ok(packed) => {
                    self.files += 1;
                    self.bytes += fs::metadata(&path).map_or(0, |found| found.len());
                    latest.get_or_insert(packed.header);
                }
                // A run that goes on removes earlier ones.
                Err(error) if is_running && error.kind() == ErrorKind::NotFound => {}
                Err(error) => match error.get_ref().and_then(|inner| inner.downcast_ref::<OtherFormat>()) {
                    Some(other) => self.note(format!("{name}: {other}; of it only its own hash was checked")),
                    None => self.damaged(name, error.to_string()),
                },
            }
        }
        Ok(latest)
    }

    /// Checks the summary; `None` if there is none.
    fn summary(&mut self, run: &Path) -> Option<Told> {
        let text = match read_text(run, SUMMARY) {
            Err(error) if error.kind() == ErrorKind::NotFound => return None,
            Err(error) => {
                self.damaged(SUMMARY, format!("could not be read: {error}"));
                "unknown".clone_into(&mut self.status);
                return Some(Told::default());
            }
            Ok(text) => text,
        };
        let json: Value = serde_json::from_str(&text).unwrap_or_default();
        let words = |pointer: &str| json.pointer(pointer).and_then(Value::as_str).map(str::to_owned);
        match (json.is_object(), hashes::is_sealed(&text), json.get("files")) {
            (false, ..) => self.damaged(SUMMARY, "is no summary: it is cut short or has changed"),
            (true, Some(false), _) | (true, None, Some(Value::Object(_))) => {
                self.damaged(SUMMARY, "has changed: its hash is not that of its text");
            }
            (true, Some(true), _) => {
                self.files += 1;
                self.bytes += text.len() as u64;
            }
            _ => {}
        }
        for damaged in json["damaged"].as_array().into_iter().flatten() {
            let [file, what] = ["file", "what"].map(|key| damaged[key].as_str().unwrap_or("?"));
            self.note(format!("the run was continued after step {} without {file}, which {what}", damaged["steps"]));
        }
        self.status = words("/status").unwrap_or_else(|| "unknown".to_owned());
        Some(Told { hashes: words("/files/hashes") })
    }

    /// Checks `hashes.txt` and returns its lines; `None` if there is none or it cannot be trusted.
    fn hashes(&mut self, run: &Path, told: &Told) -> Option<Vec<FileRecord>> {
        match (read_text(run, HASHES), &told.hashes) {
            (Err(error), None) if error.kind() == ErrorKind::NotFound => None,
            (Err(error), _) => {
                let is_missing = error.kind() == ErrorKind::NotFound;
                self.damaged(
                    HASHES,
                    if is_missing { "is missing".to_owned() } else { format!("could not be read: {error}") },
                );
                None
            }
            (Ok(text), Some(hash)) if hashes::hash_of(&text) != *hash => {
                self.damaged(HASHES, "has changed: its hash is not the one in the summary");
                None
            }
            (Ok(text), _) => {
                let files = hashes::read(&text);
                if files.is_none() {
                    self.damaged(HASHES, "is no list of hashes");
                }
                files
            }
        }
    }

    /// Holds files against a record of them.
    fn files(&mut self, run: &Path, files: &[FileRecord], moment: Moment) {
        for file in files {
            self.files += 1;
            self.bytes += file.extent.length;
            if let Some(what) = problem(run, file, moment) {
                self.damaged(file.name.clone(), what);
            }
        }
    }

    /// Reads all frames of a run without a record.
    fn frames(&mut self, run: &Path) {
        let read = FrameReader::open(&frame_data_of(run))
            .and_then(|mut frames| frames.try_for_each(|frame| frame.map(|_| ())));
        match read {
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            Err(error) => self.damaged(FRAME_DATA, error.to_string()),
            Ok(()) => self.files += 1,
        }
    }
}

/// Reads a text file of a run. Links are not followed.
fn read_text(run: &Path, name: &str) -> io::Result<String> {
    // A wrong byte shows in the hash.
    own_files::read_bytes(&run.join(name), RESULT_BYTES).map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
}
