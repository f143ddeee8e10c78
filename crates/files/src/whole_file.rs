//! Writes files that are either complete or absent: the content goes to a temporary file beside the target, which is
//! then renamed.
//!
//! The temporary file is named `<name>.part`. After an error it is removed, so that a full disk gets its space back. A
//! symbolic link in place of the target is replaced, and its destination is not written. A process that is killed may
//! leave the temporary file. A process holds a lock on its temporary file, so that no other one takes it away.

use std::fs::{self, File, TryLockError};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

pub use crate::disk::remove_if_there;
use crate::disk::{self, DiskFile};
use crate::own_files::{self, file_number};

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
    let mut file = BufWriter::new(create_part(&part)?);
    let written = content(&mut file).and_then(|()| file.flush());
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
    let mut file = create_part(&part)?;
    let written = content(&mut file).and_then(|()| file.sync());
    written.and_then(|()| disk::rename(&part, path)).inspect_err(|_| {
        let _ = remove_if_there(&part);
    })?;
    path.parent().map_or(Ok(()), disk::sync_directory)
}

/// How many times a temporary file is tried if other processes remove it before it is locked.
const ATTEMPTS: u32 = 100;

/// Creates and locks a temporary file. One that a killed process left is removed, and so is a link in its place. The lock lasts until the
/// file is closed, which is after it has its name.
///
/// # Errors
/// If another process writes it ([`ErrorKind::ResourceBusy`]), or it cannot be created.
fn create_part(part: &Path) -> io::Result<DiskFile> {
    let busy = || io::Error::new(ErrorKind::ResourceBusy, format!("another process is writing {}", part.display()));
    for _ in 0..ATTEMPTS {
        // `create_new` never follows a symbolic link.
        match DiskFile::create_new(part) {
            // A file system without locks has no processes that hold one.
            Ok(file)
                if !matches!(file.file().try_lock(), Err(TryLockError::WouldBlock)) && is_at(file.file(), part) =>
            {
                return Ok(file);
            }
            Err(error) if error.kind() != ErrorKind::AlreadyExists => return Err(error),
            // Another process took the new file for one that was left.
            Ok(_) => continue,
            Err(_) => {}
        }
        match own_files::change(part) {
            Ok(left) if matches!(left.try_lock(), Err(TryLockError::WouldBlock)) => return Err(busy()),
            // It has got its name since.
            Ok(left) if !is_at(&left, part) => {}
            _ => remove_if_there(part)?,
        }
    }
    Err(busy())
}

/// Whether `path` is the name of an open file.
fn is_at(file: &File, path: &Path) -> bool {
    let open = file.metadata();
    let named = fs::symlink_metadata(path);
    open.is_ok_and(|open| named.is_ok_and(|named| file_number(&open) == file_number(&named)))
}

#[cfg(test)]
mod tests {
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
    fn a_part_that_was_left_is_replaced_and_one_that_is_being_written_is_not() {
        let here = tempfile::tempdir().unwrap();
        let path = here.path().join("frames.xyz");
        fs::write(part_of(&path), "half of a killed process").unwrap();
        write(&path, b"whole").unwrap();
        let written = write_with(&path, |file| {
            file.write_all(b"first")?;
            let refused = write(&path, b"second").unwrap_err();
            assert!(
                refused.kind() == ErrorKind::ResourceBusy && refused.to_string().contains("frames.xyz.part"),
                "{refused}"
            );
            Ok(())
        });
        written.unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"first");
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
