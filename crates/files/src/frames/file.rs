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

use std::io::{self, Write as _};
use std::path::Path;

use lz4_flex::frame::{BlockMode, BlockSize, FrameEncoder, FrameInfo};

use super::{Frame, Header, codec};
use crate::fnv::Fnv;
use crate::growing::Growing;
use crate::growing::OutputPlace;

pub(super) const MAGIC: &[u8; 8] = b"SILOFRAM";

/// An open `frames.bin`, to which frames are added.
#[derive(Debug)]
pub struct FrameFile {
    /// The file, up to its last whole record.
    pub(super) file: Growing,
}

impl FrameFile {
    /// Creates the file with its header, or opens it if the run is continued.
    ///
    /// # Errors
    /// If the file cannot be written, or a new one exists.
    pub fn at(place: &OutputPlace, header: &Header) -> io::Result<Self> {
        let mut frames = Self { file: Growing::at(&place.path, place.record(), b"", place.is_continued)? };
        if frames.file.is_new() {
            let start = [&MAGIC[..], &record(&codec::encode_header(header)?)?].concat();
            frames.file.append(&start)?;
        }
        Ok(frames)
    }

    /// Creates the file at `path` with its header.
    ///
    /// # Errors
    /// If the file exists or cannot be written.
    pub fn create(path: &Path, header: &Header) -> io::Result<Self> {
        Self::at(&OutputPlace { path: path.to_owned(), ..OutputPlace::default() }, header)
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// If it cannot be written; the file then ends with the frame before.
    pub fn add(&mut self, frame: &Frame) -> io::Result<()> {
        self.file.append(&record(&codec::encode_frame(frame)?)?)
    }
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
