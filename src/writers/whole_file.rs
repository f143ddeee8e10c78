//! Writes files that are either complete or absent: the content goes to a temporary file beside the target, which is
//! then renamed.
//!
//! The temporary file is named `<name>.part`. After an error it is removed, so that a full disk gets its space back. A
//! symbolic link in place of the target is replaced, and its destination is not written. A process that is killed may
//! leave the temporary file.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

pub use crate::writers::disk::remove_if_there;
use crate::writers::disk::{self, DiskFile};

/// The name ending of temporary files.
pub const PART: &str = "part";

/// Returns the temporary file of `path`.
#[must_use]
pub fn part_of(path: &Path) -> PathBuf {
    path.with_added_extension(PART)
}

/// Writes `bytes` to the file at `path`.
///
/// # Errors
/// If the file cannot be written; a file that was there before is unchanged.
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    write_with(path, |file| file.write_all(bytes))
}

/// Writes the file at `path` by calling `content`.
///
/// # Errors
/// If `content` fails or the file cannot be written; a file that was there before is unchanged.
pub fn write_with(path: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let part = part_of(path);
    remove_if_there(&part)?;
    // `create_new` never follows a symbolic link.
    let mut file = BufWriter::new(DiskFile::create_new(&part)?);
    let written = content(&mut file).and_then(|()| file.flush());
    drop(file);
    written.and_then(|()| disk::rename(&part, path)).inspect_err(|_| {
        let _ = remove_if_there(&part);
    })
}

/// Like [`write_with`], and returns only when the file and its name are on the disk.
///
/// # Errors
/// As [`write_with`].
pub fn write_synced(path: &Path, content: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let part = part_of(path);
    remove_if_there(&part)?;
    let mut file = DiskFile::create_new(&part)?;
    let written = content(&mut file).and_then(|()| file.sync());
    drop(file);
    written.and_then(|()| disk::rename(&part, path)).inspect_err(|_| {
        let _ = remove_if_there(&part);
    })?;
    path.parent().map_or(Ok(()), disk::sync_directory)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn failed_write_leaves_the_old_file_and_no_part() {
        let here = tempfile::tempdir().unwrap();
        let path = here.path().join("state.csv");
        write(&path, b"old").unwrap();
        let failed = write_with(&path, |file| file.write_all(b"half").and(Err(io::Error::other("full"))));
        assert_eq!(failed.unwrap_err().to_string(), "full");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        write(&path, b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read_dir(here.path()).unwrap().count(), 1);
    }

    #[test]
    #[cfg(unix)]
    fn symbolic_links_are_not_followed() {
        let here = tempfile::tempdir().unwrap();
        let [precious, link] = ["precious", "state.csv"].map(|name| here.path().join(name));
        fs::write(&precious, "years").unwrap();
        for place in [link.clone(), part_of(&link)] {
            std::os::unix::fs::symlink(&precious, place).unwrap();
        }
        write(&link, b"new").unwrap();
        assert_eq!((fs::read(&precious).unwrap(), fs::read(&link).unwrap()), (b"years".to_vec(), b"new".to_vec()));
        assert!(!link.is_symlink());
    }
}
