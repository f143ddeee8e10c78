//! The run directory: all output of a run, and all input that is needed to repeat it.
//!
//! * Input: `scene.ron`, with `--set` applied, and copies of the files that it names. The names of copies begin with
//!   `input-`, so that they cannot collide with results.
//! * Output: `series.csv`, `frames/`, `state.csv` and `summary.json`, and where the scene measures them `walls.csv`,
//!   `profiles.csv`, `centres.csv` and `flow.csv`.
//!
//! Files of an earlier run in the directory are removed first. A directory with any other content is refused.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::fault::Fault;
use crate::source::Source;
use crate::source::places;

/// A run directory.
#[derive(Clone, Debug)]
pub struct RunDirectory(PathBuf);

const SCENE: &str = "scene.ron";
const SERIES: &str = "series.csv";
const FRAMES: &str = "frames";
const WALLS: &str = "walls.csv";
const PROFILES: &str = "profiles.csv";
const CENTRES: &str = "centres.csv";
const FLOW: &str = "flow.csv";
const OWN_FILES: [&str; 10] =
    [SCENE, SERIES, WALLS, PROFILES, CENTRES, FLOW, "state.csv", "summary.json", "input-silo.dat", "input-grains.csv"];

/// Returns the name of the copy of the input file that the scene key `key` names.
fn copy_name(key: &str) -> &'static str {
    if key == "silo.file" { "input-silo.dat" } else { "input-grains.csv" }
}

/// Returns the path of the scene in a run directory.
#[must_use]
pub fn scene_of(run: &Path) -> PathBuf {
    run.join(SCENE)
}

impl RunDirectory {
    /// Creates or clears the directory for a run of a scene, and writes `scene.ron` and copies of the files that it
    /// names.
    ///
    /// # Errors
    /// If the directory is not empty and has no earlier run, or if it cannot be written.
    pub fn prepare(path: &Path, source: &Source) -> Result<Self, Fault> {
        let directory = Self(path.to_owned());
        let fault = |error: io::Error| {
            Fault::new("run::directory", format!("could not prepare the run directory {}: {error}", path.display()))
                .help("give another one with --out")
        };
        let is_empty = fs::read_dir(path).map_or(true, |mut entries| entries.next().is_none());
        let holds_a_run = [SCENE, SERIES, FRAMES].iter().all(|name| path.join(name).exists());
        if !is_empty && !holds_a_run {
            let message = format!("{} is not empty and holds no earlier run", path.display());
            return Err(
                Fault::new("run::directory", message).help("give another directory with --out, or empty this one")
            );
        }
        let mut text = source.text.clone();
        for (key, ..) in &source.files {
            text = places::set(&text, key, &format!("{:?}", copy_name(key)))?;
        }
        fs::create_dir_all(directory.frames()).map_err(fault)?;
        directory.replace_earlier_run(&source.files).map_err(fault)?;
        fs::write(directory.0.join(SCENE), text).map_err(fault)?;
        Ok(directory)
    }

    /// Replaces the files of an earlier run with copies of `files`, which may belong to the earlier run.
    fn replace_earlier_run(&self, files: &[(&'static str, PathBuf)]) -> io::Result<()> {
        let complete = |key: &str| self.0.join(copy_name(key));
        let part = |key: &str| complete(key).with_extension("part");
        for (key, from) in files {
            io::copy(&mut File::open(from)?, &mut File::create(part(key))?)?;
        }
        self.clear()?;
        files.iter().try_for_each(|(key, _)| fs::rename(part(key), complete(key)))
    }

    /// Removes the files of an earlier run.
    fn clear(&self) -> io::Result<()> {
        let ignore_missing = |result: io::Result<()>| match result {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        };
        for name in OWN_FILES {
            ignore_missing(fs::remove_file(self.0.join(name)))?;
        }
        let Ok(frames) = fs::read_dir(self.frames()) else { return Ok(()) };
        for frame in frames {
            let path = frame?.path();
            let is_picture = path.extension().is_some_and(|ending| ending == "svg" || ending == "png");
            if is_picture {
                ignore_missing(fs::remove_file(path))?;
            }
        }
        Ok(())
    }

    /// Returns the path of the directory.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Returns the path of the directory of pictures.
    #[must_use]
    pub fn frames(&self) -> PathBuf {
        self.0.join(FRAMES)
    }

    /// Returns the path of `series.csv`.
    #[must_use]
    pub fn series(&self) -> PathBuf {
        self.0.join(SERIES)
    }

    /// Returns the path of `walls.csv`.
    #[must_use]
    pub fn walls(&self) -> PathBuf {
        self.0.join(WALLS)
    }

    /// Returns the path of `profiles.csv`.
    #[must_use]
    pub fn profiles(&self) -> PathBuf {
        self.0.join(PROFILES)
    }

    /// Returns the path of `centres.csv`.
    #[must_use]
    pub fn centres(&self) -> PathBuf {
        self.0.join(CENTRES)
    }

    /// Returns the path of `flow.csv`.
    #[must_use]
    pub fn flow(&self) -> PathBuf {
        self.0.join(FLOW)
    }

    /// Writes `state.csv` by calling `write_state`, and `summary.json`.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn finish(
        &self,
        write_state: impl FnOnce(&mut dyn Write) -> io::Result<()>,
        summary: &impl Serialize,
    ) -> io::Result<()> {
        let mut state = BufWriter::new(File::create(self.0.join("state.csv"))?);
        write_state(&mut state)?;
        state.flush()?;
        let json = serde_json::to_string_pretty(summary).map_err(io::Error::other)?;
        // The summary gets its final name only when it is complete.
        let (part, complete) = (self.0.join("summary.json.part"), self.0.join("summary.json"));
        fs::write(&part, json + "\n")?;
        fs::rename(part, complete)
    }
}
