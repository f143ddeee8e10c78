//! The operations that change files and directories of a run. All writing into a run directory goes through this module, so that a
//! test can record it and work out what a power failure at any moment leaves (`recorder`, which only tests have).
//!
//! Without a sync the operating system decides which changes reach the disk, and when: a file may be there without its content, and of two names
//! the later one may survive. [`DiskFile::sync`] brings the content of a file to the disk, [`sync_directory`] the names in a
//! directory.

use std::fs::{self, File};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;

use crate::own_files;

#[cfg(test)]
#[cfg(target_os = "linux")]
pub(crate) mod recorder;

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
        #[cfg(all(test, target_os = "linux"))]
        recorder::created(path, &file);
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
        #[cfg(all(test, target_os = "linux"))]
        recorder::cut(&self.0, length);
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
        #[cfg(all(test, target_os = "linux"))]
        recorder::wrote(&self.0, 0, bytes);
        Ok(())
    }

    /// Returns once the content is on the disk.
    ///
    /// # Errors
    /// If it cannot be brought there.
    pub fn sync(&self) -> io::Result<()> {
        self.0.sync_all()?;
        #[cfg(all(test, target_os = "linux"))]
        recorder::synced(&self.0);
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
        #[cfg(all(test, target_os = "linux"))]
        let place = self.0.stream_position().unwrap_or(0);
        let written = self.0.write(bytes)?;
        #[cfg(all(test, target_os = "linux"))]
        recorder::wrote(&self.0, place, &bytes[..written]);
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
        #[cfg(all(test, target_os = "linux"))]
        recorder::synced_directory(path);
    }
    Ok(())
}

/// Creates a directory.
///
/// # Errors
/// If there is something at `path`, or it cannot be made.
pub fn create_directory(path: &Path) -> io::Result<()> {
    fs::create_dir(path)?;
    #[cfg(all(test, target_os = "linux"))]
    recorder::created_directory(path);
    Ok(())
}

/// Gives a file or directory another name. A file that has the name is replaced.
///
/// # Errors
/// If that is not possible.
pub fn rename(from: &Path, to: &Path) -> io::Result<()> {
    fs::rename(from, to)?;
    #[cfg(all(test, target_os = "linux"))]
    recorder::renamed(from, to);
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
    #[cfg(all(test, target_os = "linux"))]
    recorder::removed(path);
    Ok(())
}

/// Removes an empty directory.
///
/// # Errors
/// If it is not empty or cannot be removed.
pub fn remove_directory(path: &Path) -> io::Result<()> {
    fs::remove_dir(path)?;
    #[cfg(all(test, target_os = "linux"))]
    recorder::removed(path);
    Ok(())
}

/// Gives a file a second name.
///
/// # Errors
/// If the file system has no such names, or `to` is taken.
pub fn link(from: &Path, to: &Path) -> io::Result<()> {
    fs::hard_link(from, to)?;
    #[cfg(all(test, target_os = "linux"))]
    recorder::linked(from, to);
    Ok(())
}

/// Exchanges two files or directories at once.
///
/// # Errors
/// `Unsupported` or `InvalidInput` where the system cannot do that; other errors as for [`rename`].
pub fn exchange(a: &Path, b: &Path) -> io::Result<()> {
    exchange_at_once(a, b)?;
    #[cfg(all(test, target_os = "linux"))]
    recorder::exchanged(a, b);
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
