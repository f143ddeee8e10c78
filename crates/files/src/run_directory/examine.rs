//! Examines the place where a run directory shall be, without changing it.

use std::env;
use std::ffi::OsString;
use std::fs;
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use crate::own_files;
use crate::run_directory::in_use;
use crate::run_directory::kinds::is_odd;
use crate::run_directory::marker::{Claim, Marker};
use crate::run_directory::names::{FRAMES, SCENE, SERIES, SUMMARY, is_directory};
use crate::run_directory::part::writer_of;
use siloflow_text::fault::Fault;

/// Content of the place where a run directory shall be.
#[derive(Debug)]
pub(super) enum Content {
    /// There is nothing, or an empty directory.
    Empty,
    /// A run.
    Run {
        /// Whether it has a summary.
        is_finished: bool,
        /// A process that writes pictures or tables of the run into it, in words.
        writer: Option<String>,
        /// The lock on it, if it has a marker.
        #[expect(dead_code, reason = "holding it is its purpose")]
        lock: Option<Marker>,
    },
    /// Something that siloflow did not make, for example this entry.
    Foreign(OsString),
}

/// Returns the absolute path of a directory, which need not exist, without symbolic links.
pub(super) fn resolve(path: &Path) -> Result<PathBuf, Fault> {
    let failed = |why: &str| {
        Fault::new("run::directory", format!("{} cannot be the directory of results: {why}", path.display()))
            .help("give another directory with --out")
    };
    let target = match fs::symlink_metadata(path) {
        Ok(_) => own_files::resolved(path).map_err(|error| failed(&error.to_string()))?,
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let name = path.file_name().ok_or_else(|| failed("it has no name"))?;
            let parent = std::path::absolute(path.parent().unwrap_or(Path::new("")).join("."));
            let parent = parent.map_err(|error| failed(&error.to_string()))?;
            // The part of the path that exists is resolved; the rest will be created.
            let existing = parent.ancestors().find_map(|part| Some((part, own_files::resolved(part).ok()?)));
            let (part, resolved) = existing.ok_or_else(|| failed("it has no parent directory"))?;
            let rest = parent.strip_prefix(part).unwrap_or(Path::new(""));
            if rest.components().any(|part| part.as_os_str() == "..") {
                return Err(failed("it leads through a directory that does not exist"));
            }
            resolved.join(rest).join(name)
        }
        Err(error) => return Err(failed(&error.to_string())),
    };
    let current = env::current_dir().and_then(|path| own_files::resolved(&path));
    if current.is_ok_and(|current| current.starts_with(&target)) {
        return Err(failed("it is or holds the current directory"));
    }
    Ok(target)
}

/// Examines the directory `target`, which messages call `shown`. A run that is there is locked.
pub(super) fn examine(shown: &Path, target: &Path) -> Result<Content, Fault> {
    let failed = |error: io::Error| {
        Fault::new("run::directory", format!("could not read {}: {error}", shown.display()))
            .help("give another directory with --out")
    };
    let entries = match fs::read_dir(target) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Content::Empty),
        entries => entries.map_err(failed)?,
    };
    let mut names = Vec::new();
    let mut odd = None;
    let mut writer = None;
    for entry in entries {
        let entry = entry.map_err(failed)?;
        let name = entry.file_name();
        let kind = entry.file_type().map_err(failed)?;
        if is_odd(&name, kind) {
            odd = Some(name.clone());
        } else if is_directory(Path::new(&name)) && writer.is_none() {
            writer = writer_of(&entry.path()).map_err(failed)?;
        }
        names.push(name);
    }
    let lock = match Marker::claim(target).map_err(failed)? {
        Claim::Held(holder) => return Err(in_use(shown, &holder)),
        Claim::Locked(marker) => Some(marker),
        Claim::Unmarked => None,
    };
    let has = |name: &str| names.iter().any(|found| found == name);
    // Earlier versions wrote no marker.
    let is_run = lock.is_some() || [SCENE, SERIES, FRAMES].into_iter().all(has);
    Ok(match (odd, names.first()) {
        (_, None) => Content::Empty,
        (Some(odd), _) => Content::Foreign(odd),
        (None, Some(first)) if !is_run => Content::Foreign(first.clone()),
        _ => Content::Run { is_finished: has(SUMMARY), writer, lock },
    })
}

/// Refuses a place that may not be used. `replace` allows that a run is replaced.
pub(super) fn refuse_content(shown: &Path, content: &Content, replace: bool) -> Result<(), Fault> {
    let path = shown;
    let shown = shown.display();
    match content {
        Content::Run { is_finished, .. } if !replace => {
            let what = if *is_finished { "a finished run" } else { "a run that was killed" };
            let help = match is_finished {
                true => "keep it and give another directory with --out DIR, or replace it with --force",
                false => {
                    "continue it with --resume DIR, keep it and give another directory with --out DIR, or replace it with \
                     --force"
                }
            };
            Err(Fault::new("run::exists", format!("{shown} holds {what}")).help(help))
        }
        Content::Run { writer: Some(writer), .. } => Err(in_use(path, writer)),
        Content::Foreign(entry) => {
            let message = format!(
                "{shown} is not empty and holds no earlier run: siloflow did not make {}",
                entry.to_string_lossy()
            );
            Err(Fault::new("run::directory", message)
                .help("give another directory with --out, or move its content away"))
        }
        _ => Ok(()),
    }
}
