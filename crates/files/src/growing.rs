//! A file of a run that grows by whole pieces: rows, frames. If a piece cannot be written, the file is cut to the piece before.

use std::io::{self, Seek as _, SeekFrom, Write as _};
use std::path::Path;

use crate::disk::DiskFile;
use crate::run_files::{Extent, RunFile};
use siloflow_dem::persist::Problem;

/// An open file that grows.
#[derive(Debug)]
pub struct Growing {
    /// Name of the file, for messages. The directory may be moved during a run.
    name: String,
    file: DiskFile,
    /// Bytes of whole pieces.
    length: u64,
    /// Bytes that stand behind the last piece.
    end: &'static [u8],
    record: RunFile,
    /// Whether this process has made the file.
    is_new: bool,
}

impl Growing {
    /// Creates the empty file at `path`. `end` will stand behind its last piece.
    ///
    /// # Errors
    /// If the file exists or cannot be made.
    pub fn create(path: &Path, record: RunFile, end: &'static [u8]) -> io::Result<Self> {
        let file = DiskFile::create_new(path)?;
        record.is_cut(Extent::default(), &[]);
        Ok(Self { name: name_of(path), file, length: 0, end, record, is_new: true })
    }

    /// Opens the file at `path`, to continue it. [`Growing::restore`] says from where.
    ///
    /// # Errors
    /// If it is no regular file or cannot be written.
    pub fn reopen(path: &Path, record: RunFile, end: &'static [u8]) -> io::Result<Self> {
        let mut file = DiskFile::reopen(path)?;
        // The end may be missing: it is written anew behind the piece from which the file continues.
        let length = file.seek(SeekFrom::End(0))?;
        Ok(Self { name: name_of(path), file, length, end, record, is_new: false })
    }

    /// Opens the file at `path` if the run is continued and it is there, and else creates it.
    ///
    /// # Errors
    /// As [`Growing::create`] and [`Growing::reopen`].
    pub fn at(path: &Path, record: RunFile, end: &'static [u8], is_continued: bool) -> io::Result<Self> {
        // The resume of a run has found all files, or the caller has accepted that it goes on without this one.
        let is_there = is_continued && path.symlink_metadata().is_ok();
        if is_there { Self::reopen(path, record, end) } else { Self::create(path, record, end) }
    }

    /// Name of the file.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Bytes of whole pieces.
    #[must_use]
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Whether this process has made the file.
    #[must_use]
    pub fn is_new(&self) -> bool {
        self.is_new
    }

    /// Adds a piece.
    ///
    /// # Errors
    /// If it cannot be written; the file then ends with the piece before.
    pub fn append(&mut self, piece: &[u8]) -> io::Result<()> {
        let written = self.write(piece);
        if written.is_ok() {
            self.length += piece.len() as u64;
            self.record.has_grown(piece, self.end);
        } else {
            // A part of the piece may have been written. The run reports the first error.
            let _ = self.file.set_len(self.length);
            let _ = self.file.seek(SeekFrom::Start(self.length));
        }
        written
    }

    fn write(&mut self, piece: &[u8]) -> io::Result<()> {
        if self.end.is_empty() {
            return self.file.write_all(piece);
        }
        self.file.seek(SeekFrom::Start(self.length))?;
        self.file.write_all(&[piece, self.end].concat())
    }

    /// Removes everything beyond the first `length` bytes. A file that this process has made stays as it is: it takes the place of a
    /// damaged one.
    ///
    /// # Errors
    /// If the file is shorter, or cannot be cut.
    pub fn restore(&mut self, length: u64) -> Result<(), Problem> {
        if self.is_new {
            return Ok(());
        }
        if length > self.length {
            return Err(format!("{} has {} bytes, but {length} had been written", self.name, self.length));
        }
        self.cut(length).map_err(|error| format!("could not cut {}: {error}", self.name))
    }

    fn cut(&mut self, length: u64) -> io::Result<()> {
        let extent = match self.record.extent() {
            Some(recorded) if recorded.length == length => recorded,
            _ => {
                self.file.seek(SeekFrom::Start(0))?;
                Extent::read(self.file.file(), length)?
            }
        };
        self.file.set_len(length)?;
        self.file.seek(SeekFrom::Start(length))?;
        self.length = length;
        self.record.is_cut(extent, self.end);
        self.write(&[])
    }

    #[cfg(all(test, target_os = "linux"))]
    pub(crate) fn of(file: std::fs::File, name: &str) -> Self {
        let record = RunFile::default();
        let end = &[][..];
        Self { name: name.to_owned(), file: file.into(), length: 0, end, record, is_new: true }
    }
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::run_files::RunFiles;

    #[test]
    fn the_record_is_that_of_the_file_without_and_with_its_end() {
        let here = tempfile::tempdir().unwrap();
        for end in [&b""[..], b"</end>\n"] {
            let path = here.path().join(format!("rows{}", end.len()));
            let files = RunFiles::default();
            let name = name_of(&path);
            let mut rows = Growing::create(&path, files.file(&name), end).unwrap();
            for piece in ["a\n", "bcd\n", "e\n"] {
                rows.append(piece.as_bytes()).unwrap();
            }
            let whole = fs::read(&path).unwrap();
            assert_eq!(whole, [b"a\nbcd\ne\n", end].concat());
            assert_eq!(files.complete(here.path()).unwrap().files[0].extent, Extent::default().with(&whole));
            // A continued file is cut, and grows by the same hash; with a record of another length its start is read.
            for record in [files.clone(), RunFiles::default()] {
                let mut again = Growing::reopen(&path, record.file(&name), end).unwrap();
                again.restore(6).unwrap();
                again.append(b"fgh\n").unwrap();
                let whole = fs::read(&path).unwrap();
                assert_eq!(whole, [b"a\nbcd\nfgh\n", end].concat());
                assert_eq!(record.complete(here.path()).unwrap().files[0].extent, Extent::default().with(&whole));
            }
            let mut again = Growing::reopen(&path, files.file(&name), end).unwrap();
            let problem = again.restore(100).unwrap_err();
            assert_eq!(problem, format!("{name} has {} bytes, but 100 had been written", 10 + end.len()));
        }
    }

    #[test]
    #[cfg(unix)]
    fn a_link_is_not_continued() {
        let here = tempfile::tempdir().unwrap();
        let [precious, link] = ["precious", "rows"].map(|name| here.path().join(name));
        fs::write(&precious, "years").unwrap();
        std::os::unix::fs::symlink(&precious, &link).unwrap();
        assert!(Growing::reopen(&link, RunFile::default(), b"").is_err());
        assert_eq!(fs::read(&precious).unwrap(), b"years");
    }
}
