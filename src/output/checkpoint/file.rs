//! The file of a checkpoint.
//!
//! | part | content |
//! |---|---|
//! | 8 bytes | `SILOFLOW` |
//! | an LZ4 frame | the [`Header`], then every [`Section`] of the state, each part with its length in front |
//! | 8 bytes | the [`Fnv`] hash of everything before |
//!
//! Header and sections are encoded by postcard: little-endian, every bit of a float kept. A file is read whole before any of it
//! is used, so a file that is cut short or has a wrong bit is refused.

use std::io::{self, BufWriter, Read as _, Write};
use std::path::Path;

use lz4_flex::frame::{BlockMode, BlockSize, FrameDecoder, FrameEncoder, FrameInfo};
use serde::{Deserialize, Serialize};

use crate::persist::{Problem, Section, decode, encode};
use crate::writers::fnv::Fnv;
use crate::writers::run_files::Manifest;

const MAGIC: &[u8; 8] = b"SILOFLOW";

/// Version of the format.
pub const FORMAT: u32 = 7;

/// Facts about a checkpoint that are read before its state.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct Header {
    /// [`FORMAT`] of the program that wrote it.
    pub format: u32,
    /// Version of that program.
    pub version: String,
    /// Hash of that program's file; 0 if it could not be read, and in a final checkpoint.
    pub program: u64,
    /// Hash of the scene and of the files that it names.
    pub input: u64,
    /// Name of the scene.
    pub scene: String,
    /// Number of completed steps.
    pub steps: u64,
    /// Simulated time, s; in the lattice gas, steps.
    pub time: f64,
    /// Whether it is the state at the regular end of a run.
    pub is_final: bool,
    /// The files of the run, all of them on the disk before the checkpoint.
    pub files: Manifest,
}

/// Why a checkpoint cannot be read that is whole.
#[derive(Debug, thiserror::Error)]
#[error("siloflow {version} with format {format} wrote it; this program reads format {FORMAT}")]
pub struct OtherFormat {
    /// Its format.
    pub format: u32,
    /// Version of the program that wrote it.
    pub version: String,
}

/// A checkpoint that has been read.
#[derive(Debug)]
pub struct Checkpoint {
    /// Facts about it.
    pub header: Header,
    /// The state.
    pub sections: Vec<Section>,
}

/// Writes a checkpoint.
///
/// # Errors
/// If it cannot be written.
pub fn write(file: &mut dyn Write, header: &Header, sections: &[Section]) -> io::Result<()> {
    write_each(file, header, |keep| sections.iter().try_for_each(|(name, bytes)| keep(name, bytes.clone())))
}

/// As [`write`], with one section in memory at a time. `save` calls its argument with the name and the bytes of each section.
///
/// # Errors
/// If it cannot be written, or if `save` fails.
pub(super) fn write_each(
    file: &mut dyn Write,
    header: &Header,
    save: impl FnOnce(&mut dyn FnMut(&str, Vec<u8>) -> Result<(), Problem>) -> Result<(), Problem>,
) -> io::Result<()> {
    let mut file = Hashing { file: BufWriter::new(file), hash: Fnv::default() };
    file.write_all(MAGIC)?;
    let info = FrameInfo::new().block_mode(BlockMode::Linked).block_size(BlockSize::Max1MB);
    let mut frame = FrameEncoder::with_frame_info(info, file);
    write_part(&mut frame, &encode(header).map_err(io::Error::other)?)?;
    let mut written = Ok(());
    let saved = save(&mut |name, bytes| {
        written = write_part(&mut frame, name.as_bytes()).and_then(|()| write_part(&mut frame, &bytes));
        written.as_ref().copied().map_err(ToString::to_string)
    });
    // The error of the file says more than its words.
    written?;
    saved.map_err(io::Error::other)?;
    let Hashing { mut file, hash } = frame.finish()?;
    file.write_all(&hash.value().to_le_bytes())?;
    file.flush()
}

fn write_part(file: &mut impl Write, bytes: &[u8]) -> io::Result<()> {
    file.write_all(&(bytes.len() as u64).to_le_bytes())?;
    file.write_all(bytes)
}

/// Hashes all bytes on their way to a file.
struct Hashing<W> {
    file: W,
    hash: Fnv,
}

impl<W: Write> Write for Hashing<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.hash.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Reads the checkpoint at `path`.
///
/// # Errors
/// If it cannot be read, is cut short, or has a wrong bit.
pub fn read(path: &Path) -> io::Result<Checkpoint> {
    read_from(&std::fs::read(path)?)
}

/// Reads a checkpoint from its bytes.
///
/// # Errors
/// As [`read`].
pub fn read_from(bytes: &[u8]) -> io::Result<Checkpoint> {
    let damaged = |what: &str| io::Error::new(io::ErrorKind::InvalidData, what.to_owned());
    let (before, expected) = bytes.split_last_chunk::<8>().ok_or_else(|| damaged("it is cut short"))?;
    let frame = before.strip_prefix(MAGIC).ok_or_else(|| damaged("it is no checkpoint"))?;
    let mut hash = Fnv::default();
    hash.update(before);
    if hash.value() != u64::from_le_bytes(*expected) {
        return Err(damaged("it is cut short, or a part of it has changed"));
    }
    let mut content = Vec::new();
    FrameDecoder::new(frame).read_to_end(&mut content).map_err(|error| damaged(&error.to_string()))?;
    let mut parts = Parts(&content);
    let header = parts.next().ok_or_else(|| damaged("it has no header"))?;
    if let Ok(((format, version), _)) = postcard::take_from_bytes::<(u32, String)>(header)
        && format != FORMAT
    {
        return Err(io::Error::new(io::ErrorKind::InvalidData, OtherFormat { format, version }));
    }
    let header: Header = decode(header).map_err(|problem| damaged(&format!("its header is unknown: {problem}")))?;
    let mut sections = Vec::new();
    while let Some(name) = parts.next() {
        let name = std::str::from_utf8(name).map_err(|_| damaged("the name of a part is no text"))?;
        let bytes = parts.next().ok_or_else(|| damaged("its last part is cut short"))?;
        sections.push((name.to_owned(), bytes.to_vec()));
    }
    if !parts.0.is_empty() {
        return Err(damaged("its last part is cut short"));
    }
    Ok(Checkpoint { header, sections })
}

/// The parts of the content.
struct Parts<'a>(&'a [u8]);

impl<'a> Iterator for Parts<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let (length, rest) = self.0.split_first_chunk::<8>()?;
        let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
        let (part, rest) = rest.split_at_checked(length)?;
        self.0 = rest;
        Some(part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> Vec<u8> {
        let header = Header {
            format: FORMAT,
            version: "0.1.0".to_owned(),
            program: 1,
            input: 2,
            scene: "silo1".to_owned(),
            steps: 3,
            time: 0.25,
            is_final: false,
            files: Manifest::default(),
        };
        let mut bytes = Vec::new();
        let sections = [("a".to_owned(), vec![1, 2, 3]), ("b".to_owned(), Vec::new()), ("c".to_owned(), vec![0; 1000])];
        write(&mut bytes, &header, &sections).unwrap();
        bytes
    }

    #[test]
    fn it_is_read_as_it_was_written() {
        let Checkpoint { header, sections } = read_from(&example()).unwrap();
        assert_eq!((header.scene.as_str(), header.steps), ("silo1", 3));
        assert_eq!(
            sections.iter().map(|(name, bytes)| (name.as_str(), bytes.len())).collect::<Vec<_>>(),
            [("a", 3), ("b", 0), ("c", 1000)]
        );
    }

    #[test]
    fn every_cut_and_every_wrong_bit_is_refused() {
        let whole = example();
        for length in 0..whole.len() {
            assert!(read_from(&whole[..length]).is_err(), "cut to {length} of {} bytes", whole.len());
        }
        for bit in 0..8 * whole.len() {
            let mut wrong = whole.clone();
            wrong[bit / 8] ^= 1 << (bit % 8);
            assert!(read_from(&wrong).is_err(), "bit {bit}");
        }
        assert!(read_from(&[&whole[..], b"more"].concat()).is_err());
    }
}
