//! Adding records to `frames.bin`.
//!
//! | part | content |
//! |---|---|
//! | 8 bytes | `SILOFRAM` |
//! | records | the header, then one for each frame |
//!
//! | part of a record | content |
//! |---|---|
//! | 8 bytes | length of the next part |
//! | an LZ4 frame | the content |
//! | 8 bytes | the [`Fnv`] hash of the LZ4 frame |
//!
//! A record is written at once. If the disk is full, the file is cut to its last whole record. A killed process may leave a part
//! of a record at the end.

use std::fs::File;
use std::io::{self, Seek as _, SeekFrom, Write as _};
use std::path::Path;

use lz4_flex::frame::{BlockMode, BlockSize, FrameEncoder, FrameInfo};

use super::{Frame, Header, codec};
use crate::own_files;
use crate::persist::Problem;
use crate::writers::fnv::Fnv;
use crate::writers::rows::RowsPlace;

pub(super) const MAGIC: &[u8; 8] = b"SILOFRAM";

/// An open `frames.bin`, to which frames are added.
#[derive(Debug)]
pub struct FrameFile {
    /// Name of the file in the run directory, for messages. The directory may be moved during a run.
    pub(super) name: String,
    pub(super) file: File,
    /// Bytes of whole records.
    pub(super) length: u64,
}

impl FrameFile {
    /// Creates the file with its header, or opens it if the run is continued.
    ///
    /// # Errors
    /// If the file cannot be written, or a new one exists.
    pub fn at(place: &RowsPlace, header: &Header) -> io::Result<Self> {
        if place.is_continued { Self::reopen(&place.path) } else { Self::create(&place.path, header) }
    }

    /// Creates the file at `path` with its header.
    ///
    /// # Errors
    /// If the file exists or cannot be written.
    pub fn create(path: &Path, header: &Header) -> io::Result<Self> {
        // `create_new` never follows a symbolic link.
        let mut frames = Self { name: name_of(path), file: File::create_new(path)?, length: 0 };
        let mut bytes = MAGIC.to_vec();
        bytes.extend(record(&codec::encode_header(header)?)?);
        frames.write(&bytes)?;
        Ok(frames)
    }

    fn reopen(path: &Path) -> io::Result<Self> {
        let mut file = own_files::change(path)?;
        let length = file.seek(SeekFrom::End(0))?;
        Ok(Self { name: name_of(path), file, length })
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// If it cannot be written; the file then ends with the frame before.
    pub fn add(&mut self, frame: &Frame) -> io::Result<()> {
        self.write(&record(&codec::encode_frame(frame)?)?)
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        let written = self.file.write_all(bytes);
        if written.is_ok() {
            self.length += bytes.len() as u64;
        } else {
            // A part of the record may have been written. The run reports the first error.
            let _ = self.file.set_len(self.length);
            let _ = self.file.seek(SeekFrom::Start(self.length));
        }
        written
    }

    /// Returns the bytes of all records so far, once they are on the disk.
    pub(super) fn saved(&self) -> Result<u64, Problem> {
        self.file.sync_data().map_err(|error| format!("could not sync {}: {error}", self.name))?;
        Ok(self.length)
    }

    /// Removes all records beyond the first `length` bytes.
    pub(super) fn restore(&mut self, length: u64) -> Result<(), Problem> {
        if length > self.length {
            return Err(format!("{} has {} bytes, but {length} had been written", self.name, self.length));
        }
        let cut = self.file.set_len(length).and_then(|()| self.file.seek(SeekFrom::Start(length)));
        cut.map_err(|error| format!("could not cut {}: {error}", self.name))?;
        self.length = length;
        Ok(())
    }
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Returns the bytes of a record.
fn record(content: &[u8]) -> io::Result<Vec<u8>> {
    let info = FrameInfo::new().block_size(BlockSize::Max1MB).block_mode(BlockMode::Independent);
    let mut packed = FrameEncoder::with_frame_info(info, Vec::new());
    packed.write_all(content)?;
    let packed = packed.finish()?;
    let mut hash = Fnv::default();
    hash.update(&packed);
    let length = (packed.len() as u64).to_le_bytes();
    Ok([&length[..], &packed, &hash.value().to_le_bytes()].concat())
}
