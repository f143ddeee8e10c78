//! Whether siloflow's own names in a run directory have files and directories of the right kind: no links, no pipes.
//!
//! A run directory may come from somebody else. A link in it leads to files of the user, and a pipe has no end.

use std::ffi::OsStr;
use std::fs::{self, FileType};
use std::io;
use std::path::{Path, PathBuf};

use crate::own_files;
use crate::run_directory::marker::MARKER;
use crate::run_directory::names::{is_directory, is_own};
use siloflow_text::fault::Fault;

/// How much of a run directory is examined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// The names at its top.
    Top,
    /// These, and the names in its directories.
    Whole,
}

/// Whether an entry at the top of a run directory has one of siloflow's names and is of another kind.
pub(super) fn is_odd(name: &OsStr, kind: FileType) -> bool {
    let path = Path::new(name);
    let is_expected = if is_directory(path) { kind.is_dir() } else { kind.is_file() };
    (is_own(path) || name == MARKER) && !is_expected
}

/// Refuses the run directory `run` if one of siloflow's own names there has something of another kind: a link, for example. A link to the
/// run directory itself is followed, because the caller names it. What is no directory is left to the caller.
///
/// # Errors
/// It names what is odd.
pub fn refuse_odd(run: &Path, depth: Depth) -> Result<(), Fault> {
    let Ok(Some((name, kind, expected))) = odd_entry(run, depth) else { return Ok(()) };
    let message = format!(
        "{} cannot be used: {} is {}, and siloflow makes {expected} of this name",
        run.display(),
        name.display(),
        own_files::in_words(kind)
    );
    Err(Fault::new("run::kind", message).help(
        "links, pipes and devices inside a run directory are neither read nor changed; put the file itself there",
    ))
}

/// Returns the first odd entry in the order of names: its path in the run directory, its kind, and what it should be.
fn odd_entry(run: &Path, depth: Depth) -> io::Result<Option<(PathBuf, FileType, &'static str)>> {
    let mut odd = Vec::new();
    for entry in fs::read_dir(run)? {
        let entry = entry?;
        let name = entry.file_name();
        let kind = entry.file_type()?;
        let is_directory = is_directory(Path::new(&name));
        if is_odd(&name, kind) {
            let expected = if is_directory { "a directory" } else { "a regular file" };
            odd.push((PathBuf::from(name), kind, expected));
        } else if is_directory && depth == Depth::Whole {
            for inner in own_files::entries(&entry.path())? {
                let inner = inner?;
                let path = Path::new(&name).join(inner.file_name());
                let kind = inner.file_type()?;
                if is_own(&path) && !kind.is_file() {
                    odd.push((path, kind, "a regular file"));
                }
            }
        }
    }
    odd.sort_unstable_by(|a, b| a.0.cmp(&b.0));
    Ok(odd.into_iter().next())
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    #[test]
    fn own_names_of_another_kind_are_refused_and_other_names_are_not() {
        let here = tempfile::tempdir().unwrap();
        let run = here.path().join("run");
        fs::create_dir_all(run.join("frames")).unwrap();
        fs::write(run.join("series.csv"), "").unwrap();
        fs::write(run.join("frames/00000.svg"), "").unwrap();
        // Links of the user beside the files of siloflow.
        symlink("/", run.join("root")).unwrap();
        symlink("/", run.join("frames/root")).unwrap();
        symlink("run", here.path().join("link")).unwrap();
        for path in [&run, &here.path().join("link"), &here.path().join("missing")] {
            refuse_odd(path, Depth::Whole).unwrap();
        }
        for (name, depth) in [
            ("frames.dump", Depth::Top),
            ("input-silo.dat", Depth::Top),
            ("vtk", Depth::Top),
            ("checkpoints", Depth::Top),
            ("csv.part", Depth::Top),
            ("state.csv.part", Depth::Top),
            (".siloflow", Depth::Top),
            ("frames/00001.svg", Depth::Whole),
        ] {
            symlink("/nowhere", run.join(name)).unwrap();
            let fault = refuse_odd(&run, depth).unwrap_err();
            assert!(fault.code() == "run::kind" && fault.to_string().contains(name), "{fault}");
            assert_eq!(refuse_odd(&run, Depth::Top).is_ok(), depth == Depth::Whole, "{name}");
            fs::remove_file(run.join(name)).unwrap();
        }
        fs::create_dir(run.join("walls.csv")).unwrap();
        fs::write(run.join("plots"), "").unwrap();
        assert!(refuse_odd(&run, Depth::Top).unwrap_err().to_string().contains("plots is a regular file"));
        fs::remove_file(run.join("plots")).unwrap();
        assert!(refuse_odd(&run, Depth::Top).unwrap_err().to_string().contains("walls.csv is a directory"));
    }
}
