//! Reads the files of a scene: regular files only, up to a stated number of bytes.
//!
//! A device or a pipe may have no end, and a pipe may wait for ever. A path that a user or a scene names may be a symbolic link, which
//! is followed. In siloflow's own directories none is: `own_files` in the crate `siloflow-files` reads the files there.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

use crate::encoding::TextReader;

/// Most bytes of a scene. The values of such a text take at most about 300 MB.
pub const SCENE_BYTES: u64 = 4 << 20;

/// Most bytes of a silo file: over a million discs.
pub const SILO_BYTES: u64 = 64 << 20;

/// Most bytes of a grain file: over ten million grains.
pub const GRAIN_BYTES: u64 = 4 << 30;

/// Most bytes of a mesh: over a million triangles of a binary STL file.
pub const MESH_BYTES: u64 = 512 << 20;

/// Most bytes of the table of a motion.
pub const TABLE_BYTES: u64 = 64 << 20;

/// Most bytes of a result that another command reads: a picture, a summary, a table.
pub const RESULT_BYTES: u64 = 64 << 20;

/// An open regular file that holds no more than a number of bytes.
#[derive(Debug)]
pub struct BoundedFile {
    file: File,
    most: u64,
    left: u64,
}

impl BoundedFile {
    /// Opens the regular file at `path`, which may hold at most `most` bytes.
    ///
    /// # Errors
    /// If it cannot be opened, is not a regular file, or is larger.
    pub fn open(path: &Path, most: u64) -> io::Result<Self> {
        // Before opening, which waits if this is a pipe without a writer.
        check(&fs::metadata(path)?, most)?;
        Self::of(File::open(path)?, most)
    }

    /// Takes an open file, which may hold at most `most` bytes.
    ///
    /// # Errors
    /// If it is not a regular file, or is larger.
    pub fn of(file: File, most: u64) -> io::Result<Self> {
        check(&file.metadata()?, most)?;
        Ok(Self { file, most, left: most })
    }
}

impl Read for BoundedFile {
    /// A file may grow while it is read, and some files of the system do not tell their size.
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(buffer)?;
        self.left = self.left.checked_sub(count as u64).ok_or_else(|| too_large(self.most))?;
        Ok(count)
    }
}

/// Reads the regular file at `path`, of at most `most` bytes.
///
/// # Errors
/// As [`BoundedFile::open`].
pub fn read_bytes(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    BoundedFile::open(path, most)?.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Opens the regular file at `path`, of at most `most` bytes, as a text in one of the known [encodings](crate::encoding).
///
/// # Errors
/// As [`BoundedFile::open`]. Reading fails if the text is in another encoding.
pub fn open_text(path: &Path, most: u64) -> io::Result<TextReader<BoundedFile>> {
    BoundedFile::open(path, most).map(TextReader::new)
}

/// Reads the regular file at `path` as text of at most `most` bytes.
///
/// # Errors
/// As [`open_text`].
pub fn read_text(path: &Path, most: u64) -> io::Result<String> {
    let mut text = String::new();
    open_text(path, most)?.read_to_string(&mut text)?;
    Ok(text)
}

/// Returns what to do about a file that could not be read: `usual`, unless its encoding is the cause.
#[must_use]
pub fn remedy<'a>(error: &io::Error, usual: &'a str) -> &'a str {
    match error.kind() {
        io::ErrorKind::InvalidData => {
            "texts are UTF-8, or UTF-16 with a byte order mark; editors offer the encoding when they save"
        }
        _ => usual,
    }
}

fn check(file: &fs::Metadata, most: u64) -> io::Result<()> {
    if file.is_dir() {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a directory"));
    }
    if !file.is_file() {
        return Err(io::Error::other("it is not a regular file, but a device, a pipe or a socket"));
    }
    if file.len() > most { Err(too_large(most)) } else { Ok(()) }
}

fn too_large(most: u64) -> io::Error {
    io::Error::new(io::ErrorKind::FileTooLarge, format!("it is larger than the limit of {} MiB", most >> 20))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_within_the_limit_are_read() {
        let here = tempfile::tempdir().unwrap();
        let path = here.path().join("a.ron");
        fs::write(&path, "12345").unwrap();
        assert_eq!(read_text(&path, 5).unwrap(), "12345");
        assert!(read_text(&path, 4).unwrap_err().to_string().contains("larger than the limit"));
        assert!(read_text(here.path(), 5).unwrap_err().to_string().contains("directory"));
        fs::write(&path, b"\xef\xbb\xbfa\xf6").unwrap();
        let error = read_text(&path, 5).unwrap_err();
        assert!(error.to_string().contains("line 1, column 2") && remedy(&error, "find it").contains("UTF-8"));
        assert_eq!(remedy(&read_text(Path::new("nothing"), 5).unwrap_err(), "find it"), "find it");
        fs::write(&path, "12345").unwrap();
        let mut growing = BoundedFile { file: File::open(&path).unwrap(), most: 4, left: 4 };
        assert_eq!(growing.read_to_string(&mut String::new()).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
    }

    #[cfg(unix)]
    #[test]
    fn devices_and_pipes_are_refused_at_once() {
        let here = tempfile::tempdir().unwrap();
        let pipe = here.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for path in [Path::new("/dev/zero"), &pipe] {
            assert!(read_text(path, 5).unwrap_err().to_string().contains("not a regular file"));
        }
    }
}
