//! The file of a checkpoint.
//!
//! | part | content |
//! |---|---|
//! | 8 bytes | `SILOFLOW` |
//! | an LZ4 frame | the [`Header`], then every [`Section`] of the state, each part with its length in front |
//! | 8 bytes | the [`Fnv`] hash of everything before |
//!
//! Header and sections are encoded by postcard: little-endian, every bit of a float kept. A file is hashed whole before any of it
//! is used, so a file that is cut short or has a wrong bit is refused. The hash protects from accidents, not from somebody who wrote the
//! file on purpose: its parts are unpacked one after the other, up to the bytes that the scene can need.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Cursor, Read, Seek, SeekFrom, Write};
use std::path::Path;

use lz4_flex::frame::{BlockMode, BlockSize, FrameDecoder, FrameEncoder, FrameInfo};
use serde::{Deserialize, Serialize};

use siloflow_dem::persist::{Problem, Section, decode, encode};
use siloflow_files::fnv::Fnv;
use siloflow_files::own_files;
use siloflow_files::run_files::Manifest;

const MAGIC: &[u8; 8] = b"SILOFLOW";

/// Version of the format.
pub const FORMAT: u32 = 13;

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

fn damaged(what: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what.into())
}

/// Most bytes of a header, which names every file of the run.
const MOST_HEADER: u64 = 1 << 26;

/// Most bytes of the name of a section.
const MOST_NAME: u64 = 1 << 20;

/// A checkpoint whose hash is right and whose header has been read, but not its state.
#[derive(Debug)]
pub struct Packed<R = File> {
    /// Facts about it.
    pub header: Header,
    /// Bytes of the file.
    pub length: u64,
    file: R,
}

/// Opens the checkpoint at `path`, which may be no link.
///
/// # Errors
/// If it cannot be read, is cut short, or has a wrong bit.
pub fn open(path: &Path) -> io::Result<Packed> {
    Packed::of(own_files::read(path)?)
}

/// Reads a checkpoint from its bytes, however much memory its state takes.
///
/// # Errors
/// As [`open`].
pub fn read_from(bytes: &[u8]) -> io::Result<Checkpoint> {
    Packed::of(Cursor::new(bytes))?.unpack(u64::MAX)
}

impl<R: Read + Seek> Packed<R> {
    /// Checks the hash of a file, and reads the header.
    ///
    /// # Errors
    /// As [`open`].
    pub fn of(mut file: R) -> io::Result<Self> {
        let cut = || damaged("it is cut short");
        let length = file.seek(SeekFrom::End(0))?;
        let before = length.checked_sub(8).ok_or_else(cut)?;
        file.rewind()?;
        let mut magic = [0; MAGIC.len()];
        let mut expected = [0; 8];
        file.read_exact(&mut magic).map_err(|_| cut())?;
        if magic != *MAGIC || before < MAGIC.len() as u64 {
            return Err(damaged("it is no checkpoint"));
        }
        let mut hash = Fnv::default();
        hash.update(&magic);
        hash.update_from(file.by_ref().take(before - MAGIC.len() as u64))?;
        file.read_exact(&mut expected)?;
        if hash.value() != u64::from_le_bytes(expected) {
            return Err(damaged("it is cut short, or a part of it has changed"));
        }
        let mut packed = Parts::of(&mut file, length, u64::MAX)?;
        let header = packed.next(MOST_HEADER)?.ok_or_else(|| damaged("it has no header"))?;
        if let Ok(((format, version), _)) = postcard::take_from_bytes::<(u32, String)>(&header)
            && format != FORMAT
        {
            return Err(io::Error::new(io::ErrorKind::InvalidData, OtherFormat { format, version }));
        }
        let header = decode(&header).map_err(|problem| damaged(format!("its header is unknown: {problem}")))?;
        Ok(Self { header, length, file })
    }

    /// Unpacks the state, which may take `most` bytes.
    ///
    /// # Errors
    /// If it takes more, or is none.
    pub fn unpack(mut self, most: u64) -> io::Result<Checkpoint> {
        let mut parts = Parts::of(&mut self.file, self.length, most)?;
        parts.next(MOST_HEADER)?;
        let mut sections = Vec::new();
        while let Some(name) = parts.next(MOST_NAME)? {
            let name = String::from_utf8(name).map_err(|_| damaged("the name of a part is no text"))?;
            let bytes = parts.next(u64::MAX)?.ok_or_else(|| damaged("its last part is cut short"))?;
            sections.push((name, bytes));
        }
        Ok(Checkpoint { header: self.header, sections })
    }
}

/// The parts of the content.
struct Parts<R: Read> {
    content: FrameDecoder<BufReader<R>>,
    most: u64,
    /// Bytes that may still be unpacked.
    left: u64,
}

impl<'a, R: Read + Seek> Parts<io::Take<&'a mut R>> {
    /// Starts with the first part of a file of `length` bytes.
    fn of(file: &'a mut R, length: u64, most: u64) -> io::Result<Self> {
        file.seek(SeekFrom::Start(MAGIC.len() as u64))?;
        let frame = file.take(length.saturating_sub(8 + MAGIC.len() as u64));
        Ok(Self { content: FrameDecoder::new(BufReader::new(frame)), most, left: most })
    }
}

impl<R: Read> Parts<R> {
    /// Returns the next part; `None` at the end. Its length is compared with the limits before memory is taken for it.
    fn next(&mut self, longest: u64) -> io::Result<Option<Vec<u8>>> {
        let length = self.take(8)?;
        if length.is_empty() {
            return Ok(None);
        }
        let length = length.try_into().map(u64::from_le_bytes).map_err(|_| damaged("its last part is cut short"))?;
        if length > longest {
            return Err(damaged(format!(
                "a part of {length} bytes is longer than {longest} bytes, the most of its kind"
            )));
        }
        self.left = self.left.checked_sub(length).ok_or_else(|| {
            damaged(format!("its state is larger than the {} bytes that its scene can need", self.most))
        })?;
        let part = self.take(length)?;
        if part.len() as u64 == length { Ok(Some(part)) } else { Err(damaged("its last part is cut short")) }
    }

    /// Unpacks the next `length` bytes, or those that are left. Memory grows with what is there, not with what is declared.
    fn take(&mut self, length: u64) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.content.by_ref().take(length).read_to_end(&mut bytes).map_err(|error| damaged(error.to_string()))?;
        Ok(bytes)
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
    fn a_state_that_is_larger_than_its_scene_can_need_is_refused_before_it_is_unpacked() {
        let header = read_from(&example()).unwrap().header;
        let mut bytes = Vec::new();
        write(&mut bytes, &header, &[("a".to_owned(), vec![0; 1 << 24])]).unwrap();
        assert!(bytes.len() < 1 << 18, "{}", bytes.len());
        let unpack = |most: u64| Packed::of(Cursor::new(&bytes)).unwrap().unpack(most);
        assert!(unpack(1 << 25).is_ok());
        let problem = unpack(1 << 20).unwrap_err().to_string();
        assert!(problem.contains("larger than the 1048576 bytes"), "{problem}");
        assert_eq!(Packed::of(Cursor::new(&bytes)).unwrap().header, header);
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
