//! The run directory: everything that a run leaves behind, and everything that is needed to repeat it.
//!
//! `scene.ron` (as resolved, with `--set` applied) and copies of the files that it names, `series.csv`, `walls.csv`,
//! `profiles.csv`, `centres.csv` and `flow.csv` where there is something to write, `frames/`, `state.csv` and
//! `summary.json`. A directory that holds an earlier run is cleared of it first; one that holds anything else is refused.
//! Copies have names of their own, `input-...`, which no result has.

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

/// The name of the copy of the file that a key of the scene names.
fn copy_name(key: &str) -> &'static str {
    if key == "silo.file" { "input-silo.dat" } else { "input-grains.csv" }
}

/// Where the scene of a run directory is.
#[must_use]
pub fn scene_of(run: &Path) -> PathBuf {
    run.join(SCENE)
}

impl RunDirectory {
    /// Makes the directory ready for a run of a scene and writes `scene.ron` and the files that it names.
    ///
    /// # Errors
    /// If it holds something else than a run, or cannot be written.
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
        directory.renew(&source.files).map_err(fault)?;
        fs::write(directory.0.join(SCENE), text).map_err(fault)?;
        Ok(directory)
    }

    /// Exchanges what an earlier run left for copies of these files, which may be its own.
    fn renew(&self, files: &[(&'static str, PathBuf)]) -> io::Result<()> {
        let whole = |key: &str| self.0.join(copy_name(key));
        let part = |key: &str| whole(key).with_extension("part");
        for (key, from) in files {
            io::copy(&mut File::open(from)?, &mut File::create(part(key))?)?;
        }
        self.clear()?;
        files.iter().try_for_each(|(key, _)| fs::rename(part(key), whole(key)))
    }

    /// Removes what an earlier run left.
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

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Where snapshots go.
    #[must_use]
    pub fn frames(&self) -> PathBuf {
        self.0.join(FRAMES)
    }

    /// Where the rows go.
    #[must_use]
    pub fn series(&self) -> PathBuf {
        self.0.join(SERIES)
    }

    /// Where the forces on flat walls go.
    #[must_use]
    pub fn walls(&self) -> PathBuf {
        self.0.join(WALLS)
    }

    /// Where profiles go.
    #[must_use]
    pub fn profiles(&self) -> PathBuf {
        self.0.join(PROFILES)
    }

    /// Where the centres of mass go.
    #[must_use]
    pub fn centres(&self) -> PathBuf {
        self.0.join(CENTRES)
    }

    /// Where the field of mean velocity goes.
    #[must_use]
    pub fn flow(&self) -> PathBuf {
        self.0.join(FLOW)
    }

    /// Writes the final state, as `write_state` puts it, and the summary.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn finish(
        &self,
        write_state: impl FnOnce(&mut dyn Write) -> io::Result<()>,
        summary: &impl Serialize,
    ) -> io::Result<()> {
        let mut state = BufWriter::new(File::create(self.0.join("state.csv"))?);
        write_state(&mut state)?;
        state.flush()?;
        let json = serde_json::to_string_pretty(summary).map_err(io::Error::other)?;
        // Under its name only when it is whole.
        let (half, whole) = (self.0.join("summary.json.part"), self.0.join("summary.json"));
        fs::write(&half, json + "\n")?;
        fs::rename(half, whole)
    }
}
