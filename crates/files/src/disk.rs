//! The operations that change files and directories of a run. All writing into a run directory goes through this module, so that an
//! [observer](observe) sees it: a test works out from that what a power failure at any moment leaves.
//!
//! Without a sync the operating system decides which changes reach the disk, and when: a file may be there without its content, and of two names
//! the later one may survive. [`DiskFile::sync`] brings the content of a file to the disk, [`sync_directory`] the names in a
//! directory.

use std::fs::{self, File};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::OnceLock;

use crate::own_files;

/// An operation that has been carried out.
#[derive(Clone, Copy, Debug)]
pub enum Operation<'a> {
    /// A new file.
    Create(&'a Path, &'a File),
    /// A new directory.
    CreateDirectory(&'a Path),
    /// Bytes in a file.
    Write {
        /// The file.
        file: &'a File,
        /// Place of the first byte.
        place: u64,
        /// The bytes.
        bytes: &'a [u8],
    },
    /// A new length of a file.
    Cut(&'a File, u64),
    /// The content of a file is on the disk.
    Sync(&'a File),
    /// The names in a directory are on the disk.
    SyncDirectory(&'a Path),
    /// Another name, the second one.
    Rename(&'a Path, &'a Path),
    /// Exchanged names.
    Exchange(&'a Path, &'a Path),
    /// A second name of the first one.
    Link(&'a Path, &'a Path),
    /// A file or directory that is gone.
    Remove(&'a Path),
}

static OBSERVER: OnceLock<fn(Operation)> = OnceLock::new();

/// Calls `observer` after each operation of this process from now on. A later observer is not taken.
pub fn observe(observer: fn(Operation)) {
    let _ = OBSERVER.set(observer);
}

fn done(operation: Operation) {
    if let Some(observer) = OBSERVER.get() {
        observer(operation);
    }
}

/// A file that is open for writing.
#[derive(Debug)]
pub struct DiskFile(File);

impl DiskFile {
    /// Creates the file at `path`. A symbolic link is never followed.
    ///
    /// # Errors
    /// If there is something at `path`, or the file cannot be made.
    pub fn create_new(path: &Path) -> io::Result<Self> {
        let file = File::options().read(true).write(true).create_new(true).open(path)?;
        done(Operation::Create(path, &file));
        Ok(Self(file))
    }

    /// Opens the file at `path` to write into it. A symbolic link is not followed, and nothing is waited for.
    ///
    /// # Errors
    /// If it is no regular file or cannot be written.
    pub fn reopen(path: &Path) -> io::Result<Self> {
        own_files::change(path).map(Self)
    }

    /// The file, to be read or locked.
    #[must_use]
    pub fn file(&self) -> &File {
        &self.0
    }

    /// Cuts the file, or extends it by zeros.
    ///
    /// # Errors
    /// If its length cannot be changed.
    pub fn set_len(&self, length: u64) -> io::Result<()> {
        self.0.set_len(length)?;
        done(Operation::Cut(&self.0, length));
        Ok(())
    }

    /// Replaces the content. A process that is killed may leave a part of it.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn rewrite(&self, bytes: &[u8]) -> io::Result<()> {
        self.set_len(0)?;
        let mut file = &self.0;
        file.rewind()?;
        file.write_all(bytes)?;
        done(Operation::Write { file: &self.0, place: 0, bytes });
        Ok(())
    }

    /// Returns once the content is on the disk.
    ///
    /// # Errors
    /// If it cannot be brought there.
    pub fn sync(&self) -> io::Result<()> {
        self.0.sync_all()?;
        done(Operation::Sync(&self.0));
        Ok(())
    }
}

impl From<File> for DiskFile {
    fn from(file: File) -> Self {
        Self(file)
    }
}

impl Write for DiskFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.0.write(bytes)?;
        if let Some(observer) = OBSERVER.get() {
            let place = self.0.stream_position().unwrap_or(0).saturating_sub(written as u64);
            observer(Operation::Write { file: &self.0, place, bytes: &bytes[..written] });
        }
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

impl Seek for DiskFile {
    fn seek(&mut self, place: SeekFrom) -> io::Result<u64> {
        self.0.seek(place)
    }
}

/// Returns once the content of the file at `path` is on the disk.
///
/// # Errors
/// If it is no regular file, or cannot be brought there.
pub fn sync_file(path: &Path) -> io::Result<()> {
    // Some systems sync only what is open for writing.
    if cfg!(unix) { DiskFile(own_files::read(path)?).sync() } else { DiskFile::reopen(path)?.sync() }
}

/// Returns once the names in a directory are on the disk. Where the system cannot do that for directories, it does nothing.
///
/// # Errors
/// If they cannot be brought there.
pub fn sync_directory(path: &Path) -> io::Result<()> {
    if cfg!(unix) {
        match File::open(path)?.sync_all() {
            Err(error) if !matches!(error.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) => {
                return Err(error);
            }
            _ => {}
        }
        done(Operation::SyncDirectory(path));
    }
    Ok(())
}

/// Creates a directory.
///
/// # Errors
/// If there is something at `path`, or it cannot be made.
pub fn create_directory(path: &Path) -> io::Result<()> {
    fs::create_dir(path)?;
    done(Operation::CreateDirectory(path));
    Ok(())
}

/// Gives a file or directory another name. A file that has the name is replaced.
///
/// # Errors
/// If that is not possible.
pub fn rename(from: &Path, to: &Path) -> io::Result<()> {
    fs::rename(from, to)?;
    done(Operation::Rename(from, to));
    Ok(())
}

/// Removes a file or a symbolic link, if there is one.
///
/// # Errors
/// If it cannot be removed.
pub fn remove_if_there(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
        removed => removed?,
    }
    done(Operation::Remove(path));
    Ok(())
}

/// Removes an empty directory.
///
/// # Errors
/// If it is not empty or cannot be removed.
pub fn remove_directory(path: &Path) -> io::Result<()> {
    fs::remove_dir(path)?;
    done(Operation::Remove(path));
    Ok(())
}

/// Gives a file a second name.
///
/// # Errors
/// If the file system has no such names, or `to` is taken.
pub fn link(from: &Path, to: &Path) -> io::Result<()> {
    fs::hard_link(from, to)?;
    done(Operation::Link(from, to));
    Ok(())
}

/// Exchanges two files or directories at once.
///
/// # Errors
/// `Unsupported` or `InvalidInput` where the system cannot do that; other errors as for [`rename`].
pub fn exchange(a: &Path, b: &Path) -> io::Result<()> {
    exchange_at_once(a, b)?;
    done(Operation::Exchange(a, b));
    Ok(())
}

#[cfg(any(target_os = "linux", target_os = "android", target_vendor = "apple"))]
fn exchange_at_once(a: &Path, b: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    Ok(renameat_with(CWD, a, CWD, b, RenameFlags::EXCHANGE)?)
}

#[cfg(not(any(target_os = "linux", target_os = "android", target_vendor = "apple")))]
fn exchange_at_once(_: &Path, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}
