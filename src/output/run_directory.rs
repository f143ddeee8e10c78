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
mod marker;
mod path;
mod results;
mod stage;

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Serialize;

use self::examine::{examine, refuse_content, resolve};
use self::marker::{Claim, Marker};
pub use self::path::RunPath;
pub use self::results::{check_results, write_results};
use self::stage::Stage;
use crate::fault::Fault;
use crate::source::Source;
use crate::source::places;
use crate::writers::fnv::Fnv;
use crate::writers::frame_writer::Guard;
use crate::writers::rows::RowsPlace;
use crate::writers::whole_file::{PART, part_of, remove_if_there, write_with};

/// A run directory that this process has locked.
#[derive(Debug)]
pub struct RunDirectory {
    /// The directory as the caller names it.
    shown: PathBuf,
    /// The directory, absolute and without symbolic links.
    target: PathBuf,
    replace: bool,
    place: Place,
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

const SCENE: &str = "scene.ron";
const SERIES: &str = "series.csv";
const FRAMES: &str = "frames";
const FRAME_DATA: &str = "frames.bin";
const VTK: &str = "vtk";
/// Pictures and a movie of `siloflow render`.
const PICTURES: &str = "pictures";
const MOVIE: &str = "movie.png";
/// Figures of `siloflow plot`.
const PLOTS: &str = "plots";
const CHECKPOINTS: &str = "checkpoints";
const CHECKPOINT_ENDING: &str = "checkpoint";
const WALLS: &str = "walls.csv";
const WALL_GROUPS: &str = "wall_groups.csv";
const WALL_BANDS: &str = "wall_bands.csv";
const PROFILES: &str = "profiles.csv";
const CENTRES: &str = "centres.csv";
const FIELDS: &str = "fields.csv";
const FLOW: &str = "flow.csv";
const LOSSES: &str = "losses.csv";
const STATE: &str = "state.csv";
const SUMMARY: &str = "summary.json";
const REPORT: &str = "report.html";
/// Names of all files that a run writes at the top of its directory.
const OWN_FILES: [&str; 16] = [
    MOVIE,
    SERIES,
    FRAME_DATA,
    "frames.xyz",
    "frames.dump",
    WALLS,
    WALL_GROUPS,
    WALL_BANDS,
    PROFILES,
    CENTRES,
    FIELDS,
    FLOW,
    LOSSES,
    STATE,
    SUMMARY,
    REPORT,
];

/// Names of the files that hold the input of a run, without those of meshes and motions.
const INPUT_FILES: [&str; 4] = [SCENE, "input-silo.dat", "input-grains.csv", "input-contacts.csv"];
const MESH_START: &str = "input-wall-";
const TABLE_START: &str = "input-motion-";

/// Bytes that `summary.json.part` occupies from the start, so that a full disk at the end leaves space for the summary.
const SUMMARY_RESERVE: usize = 32 << 10;

/// Returns the name of the copy of the input file `from` that the scene key `key` names.
fn copy_name(key: &str, from: &Path) -> String {
    let name = match key {
        "silo.file" => "input-silo.dat",
        "grains.contacts" => "input-contacts.csv",
        "grains.file" => "input-grains.csv",
        _ if key.starts_with("motions") => {
            // The table of a motion: `motions[3].rotate.by.file`.
            let number: String = key.chars().filter(char::is_ascii_digit).collect();
            let course = if key.contains("rotate") { "rotate" } else { "translate" };
            return format!("{TABLE_START}{number}-{course}.csv");
        }
        _ => {
            // The mesh of a wall: `walls[3].file`.
            let number: String = key.chars().filter(char::is_ascii_digit).collect();
            let ending = from.extension().unwrap_or_default().to_ascii_lowercase();
            return format!("{MESH_START}{number}.{}", ending.display());
        }
    };
    name.to_owned()
}

/// Whether a file of this name at the top of a run directory holds input.
fn is_input(name: &str) -> bool {
    let is_numbered = |rest: &str, endings: &[&str]| {
        let number = endings.iter().find_map(|ending| rest.strip_suffix(ending));
        number.is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
    };
    INPUT_FILES.contains(&name)
        || name.strip_prefix(MESH_START).is_some_and(|rest| is_numbered(rest, &[".stl", ".obj"]))
        || name.strip_prefix(TABLE_START).is_some_and(|rest| is_numbered(rest, &["-translate.csv", "-rotate.csv"]))
}

/// Returns the path of the scene in a run directory.
#[must_use]
pub fn scene_of(run: &Path) -> PathBuf {
    run.join(SCENE)
}

/// Returns the hash of the scene in a run directory and of the copies of the files that it names.
///
/// # Errors
/// If a file cannot be read.
pub fn hash_of_input(run: &Path) -> io::Result<u64> {
    let mut names = Vec::new();
    for entry in fs::read_dir(run)? {
        names.extend(entry?.file_name().into_string().ok().filter(|name| is_input(name)));
    }
    names.sort_unstable();
    let mut hash = Fnv::default();
    for name in names {
        hash.update(name.as_bytes());
        hash.update_from(File::open(run.join(name))?)?;
    }
    Ok(hash.value())
}

/// Returns the path of the frames of data in a run directory.
#[must_use]
pub fn frame_data_of(run: &Path) -> PathBuf {
    run.join(FRAME_DATA)
}

/// Returns the path of the report in a run directory.
#[must_use]
pub fn report_of(run: &Path) -> PathBuf {
    run.join(REPORT)
}

/// Returns the names, without ending, of siloflow's CSV files in a run directory, and their paths.
#[must_use]
pub fn tables_of(run: &Path) -> Vec<(&'static str, PathBuf)> {
    let names = OWN_FILES.iter().filter_map(|name| Some((name.strip_suffix(".csv")?, run.join(name))));
    names.filter(|(_, path)| path.is_file()).collect()
}

/// Returns the directory of the checkpoints in a run directory.
#[must_use]
pub fn checkpoints_directory(run: &Path) -> PathBuf {
    run.join(CHECKPOINTS)
}

/// Returns the name of the checkpoint after a number of steps. Names sort in the order of steps.
#[must_use]
pub fn checkpoint_name(steps: u64) -> String {
    format!("{steps:016}.{CHECKPOINT_ENDING}")
}

/// Whether a checkpoint may have this name.
fn is_checkpoint(name: &Path) -> bool {
    let number = name.file_stem().unwrap_or_default().as_encoded_bytes();
    name.extension().is_some_and(|ending| ending == CHECKPOINT_ENDING)
        && number.len() >= 16
        && number.iter().all(u8::is_ascii_digit)
}

/// Returns the checkpoints in a directory, the latest first. Links and other files are left out.
///
/// # Errors
/// If the directory cannot be read; a missing one is empty.
pub fn checkpoints_in(directory: &Path) -> io::Result<Vec<PathBuf>> {
    let entries = match fs::read_dir(directory) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries?,
    };
    let mut paths = Vec::new();
    for entry in entries {
        let entry = entry?;
        if entry.file_type()?.is_file() && is_checkpoint(Path::new(&entry.file_name())) {
            paths.push(entry.path());
        }
    }
    paths.sort_unstable_by(|a, b| b.cmp(a));
    Ok(paths)
}

/// Removes checkpoints that a killed process has left incomplete.
///
/// # Errors
/// If the directory cannot be read, or a file cannot be removed.
pub fn remove_incomplete_checkpoints(directory: &Path) -> io::Result<()> {
    for entry in fs::read_dir(directory)? {
        let path = entry?.path();
        let is_part = path.extension().is_some_and(|ending| ending == PART);
        if is_part && is_checkpoint(Path::new(path.file_stem().unwrap_or_default())) {
            remove_if_there(&path)?;
        }
    }
    Ok(())
}

/// Whether siloflow writes a file of this name in the directory `vtk`.
fn is_vtk(name: &Path) -> bool {
    let name = name.to_str().unwrap_or_default();
    let (kind, rest) = name.split_once(['-', '.']).unwrap_or_default();
    let number = rest.strip_suffix(".vtp").unwrap_or_default();
    let is_frame = number.len() >= 5 && number.bytes().all(|byte| byte.is_ascii_digit());
    ["grains", "contacts", "walls"].contains(&kind) && (is_frame || rest == "pvd")
}

/// Whether a file of this name in `plots` is a figure: named after a column, as SVG or PNG.
fn is_plot(name: &Path) -> bool {
    let name = name.to_str().unwrap_or_default();
    let stem = name.strip_suffix(".svg").or(name.strip_suffix(".png")).unwrap_or_default();
    !stem.is_empty() && stem.bytes().all(|byte| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'_')
}

/// Whether a file of this name in `pictures` is a picture of a time: `t_01.50.png`.
fn is_picture(name: &Path) -> bool {
    let time = name.to_str().and_then(|name| name.strip_prefix("t_")?.strip_suffix(".png")).unwrap_or_default();
    !time.is_empty() && time.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.')
}

/// Returns the directory of pictures that are drawn after a run.
#[must_use]
pub fn pictures_of(run: &Path) -> PathBuf {
    run.join(PICTURES)
}

/// Returns the path of a run's movie.
#[must_use]
pub fn movie_of(run: &Path) -> PathBuf {
    run.join(MOVIE)
}

/// Whether `path` is a picture file, or a directory with pictures of times and nothing else.
#[must_use]
pub fn is_drawn(path: &Path) -> bool {
    let Ok(entries) = fs::read_dir(path) else {
        let is_picture = path.extension().is_some_and(|ending| ["png", "svg", "apng"].iter().any(|own| ending == *own));
        return is_picture && !path.is_dir();
    };
    let mut entries = entries;
    entries.all(|entry| entry.is_ok_and(|entry| is_picture(Path::new(&entry.file_name()))))
}

/// Directories of results whose files have names of one pattern.
const DIRECTORIES: [(&str, fn(&Path) -> bool); 6] = [
    (CHECKPOINTS, is_checkpoint),
    (VTK, is_vtk),
    (PLOTS, is_plot),
    (PICTURES, is_picture),
    ("csv", |name| is_exported_table(name, "csv")),
    ("parquet", |name| is_exported_table(name, "parquet")),
];

/// Whether `siloflow export` writes a table of this name, with this ending.
fn is_exported_table(name: &Path, ending: &str) -> bool {
    let stem = name.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
    let is_of_frames = ["grains", "contacts", "wall_contacts"].contains(&stem);
    let is_of_run = ending == "parquet" && OWN_FILES.iter().any(|own| own.strip_suffix(".csv") == Some(stem));
    name.extension().is_some_and(|found| found == ending) && (is_of_frames || is_of_run)
}

/// Whether siloflow writes a file or directory of this path in a run directory.
fn is_own(path: &Path) -> bool {
    let complete = path.with_extension("");
    let complete = if path.extension().is_some_and(|ending| ending == PART) { &*complete } else { path };
    match complete.strip_prefix(FRAMES) {
        Ok(picture) if picture == Path::new("") => complete == path,
        Ok(picture) => {
            let number = picture.file_stem().unwrap_or_default().as_encoded_bytes();
            let is_picture = picture.extension().is_some_and(|ending| ending == "svg" || ending == "png");
            is_picture
                && picture.components().count() == 1
                && number.len() >= 5
                && number.iter().all(u8::is_ascii_digit)
        }
        Err(_) => {
            let inside =
                DIRECTORIES.iter().find_map(|(name, is_file)| Some((complete.strip_prefix(name).ok()?, is_file)));
            match inside {
                Some((inside, _)) if inside == Path::new("") => complete == path,
                Some((inside, is_file)) => inside.components().count() == 1 && is_file(inside),
                None => complete.to_str().is_some_and(|name| OWN_FILES.contains(&name) || is_input(name)),
            }
        }
    }
}

/// Whether a behaviour may not have a file of this name at the top of a run directory.
pub(crate) fn is_reserved(name: &str) -> bool {
    is_own(Path::new(name)) || name.ends_with(&format!(".{PART}"))
}

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
        let directory = Self { shown: path.to_owned(), target, replace, place: Place::Staged(stage) };
        let mut text = source.text.clone();
        for (key, from) in &source.files {
            text = places::set(&text, key, &format!("{:?}", copy_name(key, from)))?;
        }
        directory.fill(&text, source).map_err(|error| directory.unwritable(&error))?;
        Ok(directory)
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
        fs::create_dir(now.join(FRAMES))?;
        for (key, from) in &source.files {
            let mut copy = File::create_new(now.join(copy_name(key, from)))?;
            match source.text_for(key) {
                Some(text) => copy.write_all(text.as_bytes())?,
                None => io::copy(&mut File::open(from)?, &mut copy).map(|_| ())?,
            }
        }
        fs::write(now.join(SCENE), scene)?;
        self.reserve_summary()
    }

    /// Locks the directory of an earlier run, to continue it. Nothing but the marker is changed.
    ///
    /// # Errors
    /// If there is no run at `path`, or another process uses it.
    pub fn reopen(path: &Path) -> Result<Self, Fault> {
        let target = resolve(path)?;
        let failed = |message: String| Fault::new("run::directory", message).help("give the directory of a run");
        let unreadable = |error: io::Error| failed(format!("could not use {}: {error}", path.display()));
        match Marker::claim(&target).map_err(unreadable)? {
            Claim::Unmarked => Err(failed(format!("{} holds no run", path.display()))),
            Claim::Held(holder) => Err(in_use(path, &holder)),
            Claim::Locked(marker) => {
                marker.sign(&marker::declared_in(&target)).map_err(unreadable)?;
                Ok(Self { shown: path.to_owned(), target, replace: false, place: Place::Published(marker) })
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
        let Place::Staged(stage) = std::mem::replace(&mut self.place, Place::Gone) else { return Ok(()) };
        let marker = stage.publish(&is_own).map_err(|error| {
            let message = format!("could not move the run directory to {}: {error}", self.shown.display());
            Fault::new("run::directory", message)
                .help("a mount point cannot be replaced; give a directory in it with --out")
        })?;
        self.place = Place::Published(marker);
        Ok(())
    }

    /// Removes `state.csv`, `summary.json` and `report.html` of the part that has run so far, before a reopened run continues.
    ///
    /// # Errors
    /// If a file cannot be removed, or there is no space for a summary.
    pub fn remove_results(&self) -> io::Result<()> {
        remove_if_there(&self.now().join(SUMMARY))?;
        remove_if_there(&self.now().join(STATE))?;
        remove_if_there(&self.now().join(REPORT))?;
        self.reserve_summary()
    }

    /// Occupies the space of the summary.
    fn reserve_summary(&self) -> io::Result<()> {
        let part = part_of(&self.now().join(SUMMARY));
        remove_if_there(&part)?;
        File::create_new(part)?.write_all(&vec![b'\n'; SUMMARY_RESERVE])
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
        if files.is_empty() { Ok(()) } else { marker.sign(files) }
    }

    /// Returns the resource that tells behaviours where the directory is now.
    #[must_use]
    pub fn resource(&self) -> RunPath {
        RunPath { now: self.now().to_owned(), is_resumed: matches!(self.place, Place::Published(_)) }
    }

    /// Returns the place of a file of rows.
    fn rows(&self, name: &str) -> RowsPlace {
        RowsPlace { path: self.now().join(name), is_continued: matches!(self.place, Place::Published(_)) }
    }

    /// Returns the place of `series.csv`. It changes when the directory is published.
    #[must_use]
    pub fn series(&self) -> RowsPlace {
        self.rows(SERIES)
    }

    /// Returns the place of `frames.bin`. It changes when the directory is published.
    #[must_use]
    pub fn frame_data(&self) -> RowsPlace {
        self.rows(FRAME_DATA)
    }

    /// Returns the place of `walls.csv`. It changes when the directory is published.
    #[must_use]
    pub fn walls(&self) -> RowsPlace {
        self.rows(WALLS)
    }

    /// Returns the place of `wall_groups.csv`. It changes when the directory is published.
    #[must_use]
    pub fn wall_groups(&self) -> RowsPlace {
        self.rows(WALL_GROUPS)
    }

    /// Returns the place of `wall_bands.csv`. It changes when the directory is published.
    #[must_use]
    pub fn wall_bands(&self) -> RowsPlace {
        self.rows(WALL_BANDS)
    }

    /// Returns the place of `profiles.csv`. It changes when the directory is published.
    #[must_use]
    pub fn profiles(&self) -> RowsPlace {
        self.rows(PROFILES)
    }

    /// Returns the place of `centres.csv`. It changes when the directory is published.
    #[must_use]
    pub fn centres(&self) -> RowsPlace {
        self.rows(CENTRES)
    }

    /// Returns the place of `fields.csv`. It changes when the directory is published.
    #[must_use]
    pub fn fields(&self) -> RowsPlace {
        self.rows(FIELDS)
    }

    /// Returns the place of `flow.csv`. It changes when the directory is published.
    #[must_use]
    pub fn flow(&self) -> RowsPlace {
        self.rows(FLOW)
    }

    /// Returns the path of `losses.csv`. It changes when the directory is published.
    #[must_use]
    pub fn losses(&self) -> PathBuf {
        self.now().join(LOSSES)
    }

    /// Writes `state.csv` by calling `write_state`.
    ///
    /// # Errors
    /// If the file cannot be written, or if this is no longer the directory of the run.
    pub fn write_state(&self, write_state: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
        self.guard()()?;
        write_with(&self.now().join(STATE), write_state)
    }

    /// Writes `summary.json`, into the space that is reserved for it.
    ///
    /// # Errors
    /// If the file cannot be written, or if this is no longer the directory of the run.
    pub fn write_summary(&self, summary: &impl Serialize) -> io::Result<()> {
        self.guard()()?;
        let json = serde_json::to_string_pretty(summary).map_err(io::Error::other)? + "\n";
        let complete = self.now().join(SUMMARY);
        let part = part_of(&complete);
        let mut file = OpenOptions::new().write(true).create(true).truncate(false).open(&part)?;
        file.write_all(json.as_bytes())?;
        file.set_len(json.len() as u64)?;
        // The summary says that the run is over, so it gets its name only when it is on the disk.
        file.sync_all()?;
        fs::rename(part, complete)
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
