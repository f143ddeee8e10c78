//! The sweep directory.
//!
//! | entry | content |
//! |---|---|
//! | `sweep.ron` | a copy of the sweep file |
//! | `runs/0003-2/` | the run directory of point 3 with seed 2 |
//! | `logs/0003-2.txt` | the messages of that run |
//! | `results.csv`, `table.csv`, `fit.csv`, `figures/` | results, as [`table`](super::table) and [`picture`](super::picture) make them |
//! | `.siloflow-sweep` | the marker; the process that changes `sweep.ron` or writes results holds a lock on it |
//!
//! A run is over if it has a summary of a regular end or of a failure. It counts only if its `scene.ron` is the scene of the sweep with the
//! settings of the run, and if the files that the scene names are the same. So runs may be copied here from other machines.
//!
//! The log of a run is its lock too. The process of the run inherits the open file, so that the lock lasts as long as the run or its
//! sweep. Two sweeps in one directory share the work.
//!
//! Limit: on a file system without locks two processes may do the same run twice. The results are the same.

use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::output::checkpoint::find;
use crate::studies::figures::summary::is_failure;
use crate::studies::sweep::{Sweep, Task};
use siloflow_files::fnv::Fnv;
use siloflow_files::marked::foreign_entry;
use siloflow_files::own_files;
use siloflow_files::run_directory::{scene_of, summary_of};
use siloflow_files::whole_file;
use siloflow_text::fault::Fault;
use siloflow_text::file::{self, BoundedFile};
use siloflow_text::source::Source;
use siloflow_text::source::keys::changes;

const MARKER: &str = ".siloflow-sweep";
const RUNS: &str = "runs";
const LOGS: &str = "logs";

/// A directory that holds a sweep.
#[derive(Debug)]
pub struct SweepDirectory {
    path: PathBuf,
}

/// The state of a run.
#[derive(Debug)]
pub enum State {
    /// There is no run.
    Missing,
    /// There is a run without an end, and whether it has a checkpoint to continue from.
    Unfinished(bool),
    /// There is a run of another scene, which differs in this key.
    Foreign(String),
    /// The run is over.
    Over(Box<Value>),
}

impl State {
    /// Whether the run failed.
    #[must_use]
    pub fn is_failure(&self) -> bool {
        matches!(self, Self::Over(summary) if summary["status"].as_str().is_some_and(is_failure))
    }
}

/// The open log of a run, with a lock on it.
#[derive(Debug)]
pub struct Log(File);

impl Log {
    /// Returns the file for the messages of the run's process.
    ///
    /// # Errors
    /// If the system has no more files.
    pub fn file(&self) -> io::Result<File> {
        self.0.try_clone()
    }
}

impl SweepDirectory {
    /// Prepares the directory of a sweep. With `replace` it may hold another sweep.
    ///
    /// # Errors
    /// * The directory holds another sweep, or something else.
    /// * It cannot be written.
    pub fn prepare(path: &Path, sweep: &Sweep, replace: bool) -> Result<Self, Fault> {
        let unwritable = |error: io::Error| {
            Fault::new("sweep::directory", format!("could not write to {}: {error}", path.display()))
                .help("is there space, and may you write there? Or give another directory with --out")
        };
        Self::refuse_content(path, sweep)?;
        let directory = Self { path: path.to_owned() };
        fs::create_dir_all(path).map_err(unwritable)?;
        // The lock makes the marker, which comes before all other content.
        let _lock = directory.lock().map_err(unwritable)?;
        for name in [RUNS, LOGS] {
            own_files::make_directory(&path.join(name)).map_err(unwritable)?;
        }
        match directory.difference(sweep)? {
            Difference::None => {}
            Difference::Other if !replace => return Err(other_sweep(path, sweep)),
            _ => whole_file::write(&path.join(sweep.copy), sweep.text.as_bytes()).map_err(unwritable)?,
        }
        Ok(directory)
    }

    /// Finds the directory of a sweep; `None` if there is nothing, or an empty directory. Nothing is changed.
    ///
    /// # Errors
    /// The directory holds another sweep, or something else.
    pub fn find(path: &Path, sweep: &Sweep) -> Result<Option<Self>, Fault> {
        Self::refuse_content(path, sweep)?;
        let directory = Self { path: path.to_owned() };
        match directory.difference(sweep)? {
            Difference::None => Ok(Some(directory)),
            Difference::Other => Err(other_sweep(path, sweep)),
            Difference::Nothing => Ok(None),
        }
    }

    /// Opens the directory of a sweep. Nothing is changed.
    ///
    /// # Errors
    /// The directory holds no sweep, or another one.
    pub fn open(path: &Path, sweep: &Sweep) -> Result<Self, Fault> {
        Self::find(path, sweep)?.ok_or_else(|| {
            Fault::new("sweep::directory", format!("{} holds no sweep", path.display()))
                .help("run the sweep first, or give its directory with --out")
        })
    }

    /// Refuses a directory with content that is no sweep.
    fn refuse_content(path: &Path, sweep: &Sweep) -> Result<(), Fault> {
        let why = match foreign_entry(path, &[MARKER, sweep.copy]) {
            Ok(None) => return Ok(()),
            Ok(Some(name)) => format!("it holds no sweep, but {}", name.display()),
            Err(error) => error.to_string(),
        };
        Err(Fault::new("sweep::directory", format!("{} cannot be the directory of a sweep: {why}", path.display()))
            .help("give another directory with --out"))
    }

    /// Compares the copy of the sweep file with a sweep. Comments and layout do not count.
    fn difference(&self, sweep: &Sweep) -> Result<Difference, Fault> {
        match own_files::read_text(&self.path.join(sweep.copy), file::SCENE_BYTES) {
            Ok(text) => {
                let [ours, theirs] =
                    [text, sweep.text.clone()].map(|text| Source::new(sweep.copy, "sweep", Path::new(""), text));
                Ok(if changes(&ours, &theirs).is_empty() { Difference::None } else { Difference::Other })
            }
            Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
                Ok(Difference::Nothing)
            }
            Err(error) => {
                let message = format!("could not read {}: {error}", self.path.join(sweep.copy).display());
                Err(Fault::new("sweep::directory", message).help("give another directory with --out"))
            }
        }
    }

    /// Waits for the lock of the directory.
    fn lock(&self) -> io::Result<File> {
        let marker = own_files::append(&self.path.join(MARKER))?;
        if let Err(error) = marker.lock() {
            tracing::warn!("could not lock {}: {error}", self.path.display());
        }
        Ok(marker)
    }

    /// Returns the path of the directory.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the directory of a run.
    #[must_use]
    pub fn run(&self, sweep: &Sweep, task: Task) -> PathBuf {
        self.path.join(RUNS).join(sweep.run_name(task))
    }

    /// Returns the fault of a run whose scene differs from that of the sweep in `key`.
    #[must_use]
    pub fn refuse(&self, sweep: &Sweep, task: Task, key: &str) -> Fault {
        let message = format!("{} is a run of another scene: `{key}` differs", self.run(sweep, task).display());
        Fault::new("sweep::other_scene", message)
            .help("the scene has changed: give another directory with --out, or run such points again with --force")
    }

    /// Returns the path of the log of a run.
    #[must_use]
    pub fn log_path(&self, sweep: &Sweep, task: Task) -> PathBuf {
        self.path.join(LOGS).join(format!("{}.txt", sweep.run_name(task)))
    }

    /// Opens and locks the log of a run; `None` if another process works on the run.
    ///
    /// # Errors
    /// If the log cannot be written.
    pub fn claim(&self, sweep: &Sweep, task: Task) -> io::Result<Option<Log>> {
        let path = self.log_path(sweep, task);
        let log = own_files::append(&path)?;
        match log.try_lock() {
            Err(TryLockError::WouldBlock) => return Ok(None),
            Err(TryLockError::Error(error)) => tracing::warn!("could not lock {}: {error}", path.display()),
            Ok(()) => {}
        }
        Ok(Some(Log(log)))
    }

    /// Examines a run.
    ///
    /// # Errors
    /// If the settings of the run do not fit the scene.
    pub fn state(&self, sweep: &Sweep, task: Task) -> Result<State, Fault> {
        let run = self.run(sweep, task);
        let Ok(text) = own_files::read_text(&scene_of(&run), file::SCENE_BYTES) else { return Ok(State::Missing) };
        let expected = sweep.expected(task)?;
        let found = Source::new(&scene_of(&run).display().to_string(), "scene", &run, text);
        if let Some(key) = differing_key(&expected, &found, &run) {
            return Ok(State::Foreign(key));
        }
        let summary = own_files::read_text(&summary_of(&run), file::RESULT_BYTES);
        let summary = summary.ok().and_then(|text| serde_json::from_str::<Value>(&text).ok());
        Ok(match summary.filter(|summary| summary["status"].as_str().is_some_and(|status| status != "interrupted")) {
            Some(summary) => State::Over(Box::new(summary)),
            None => State::Unfinished(find::latest(&run).is_ok_and(|found| !found.header().is_final)),
        })
    }

    /// Writes files of these names and contents, each complete or not at all. Other files are kept.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write(&self, files: &[(PathBuf, Vec<u8>)]) -> io::Result<()> {
        let _lock = self.lock()?;
        for (name, content) in files {
            let path = self.path.join(name);
            // The directory of the sweep itself may be a link that the user names.
            if let Some(parent) = path.parent().filter(|parent| *parent != self.path) {
                own_files::make_directory(parent)?;
            }
            whole_file::write(&path, content)?;
            #[cfg(feature = "parquet")]
            if path.extension().is_some_and(|ending| ending == "csv") {
                let target = path.with_extension("parquet");
                let part = whole_file::part_of(&target);
                whole_file::remove_if_there(&part)?;
                siloflow_results::export::parquet::convert(&path, &part)?;
                fs::rename(part, target)?;
            }
        }
        Ok(())
    }
}

/// Comparison of a sweep with the sweep of a directory.
enum Difference {
    None,
    Other,
    /// The directory holds no sweep.
    Nothing,
}

fn other_sweep(path: &Path, sweep: &Sweep) -> Fault {
    Fault::new(
        "sweep::exists",
        format!("{} holds the sweep of another file: its {} differs", path.display(), sweep.copy),
    )
    .help("give another directory with --out, or keep the runs that both have in common with --force")
}

/// Returns a key in which the scene of a run is not the expected one. A copy of a file counts as the file.
fn differing_key(expected: &Source, found: &Source, run: &Path) -> Option<String> {
    changes(expected, found).into_iter().find_map(|change| {
        let text = |value: &Option<String>| ron::from_str::<String>(value.as_deref()?).ok();
        let is_copy = match (text(&change.first), text(&change.second)) {
            (Some(from), Some(copy)) if copy.starts_with("input-") => {
                let of_sweep = BoundedFile::open(&expected.path_of(Path::new(&from)), file::GRAIN_BYTES);
                hash(of_sweep)
                    .is_some_and(|it| Some(it) == hash(own_files::bounded(&run.join(copy), file::GRAIN_BYTES)))
            }
            _ => false,
        };
        (!is_copy).then_some(change.key)
    })
}

/// Returns the hash of a file; `None` if it cannot be read.
fn hash(file: io::Result<BoundedFile>) -> Option<u64> {
    let mut hash = Fnv::default();
    hash.update_from(file.ok()?).ok()?;
    Some(hash.value())
}
