//! Reads `frames.bin` frame by frame, up to the last whole one. A run that still goes on, or was killed, can be read.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

use lz4_flex::frame::FrameDecoder;

use super::codec::damaged;
use super::file::MAGIC;
use super::{Frame, Header, check, codec};
use crate::fnv::Fnv;
use crate::own_files;

/// The limit for frames of a run whose scene cannot be loaded: those of about a million grains.
pub const OF_UNKNOWN_SCENE: u64 = 256 << 20;

/// Most bytes of a record that [`FrameReader::open`] unpacks: a frame of the largest scene.
const LARGEST: u64 = 8 << 30;

/// Most bytes that LZ4 adds to content that it cannot compress: a 255th of it, and those of a frame.
const fn packed(most: u64) -> u64 {
    most.saturating_add(most / 255).saturating_add(1 << 16)
}

/// An iterator over the frames of a file.
#[derive(Debug)]
pub struct FrameReader<R = BufReader<File>> {
    /// The header of the file.
    pub header: Header,
    file: R,
    /// Bytes that have not been read.
    left: u64,
    /// Most bytes of an unpacked record.
    most: u64,
    /// Whether there is nothing more to read.
    is_over: bool,
}

impl FrameReader {
    /// Opens the file at `path` and reads its header. A link is refused. A record may take any memory up to 8 GiB, however short the file
    /// is; [`FrameReader::open_within`] is for files from elsewhere.
    ///
    /// # Errors
    /// If the file cannot be read, is no file of frames, or is of a later format.
    pub fn open(path: &Path) -> io::Result<Self> {
        Self::open_within(path, LARGEST)
    }

    /// As [`FrameReader::open`], and refuses a record that would take more than `most` bytes
    /// ([`OF_UNKNOWN_SCENE`], if nothing is known about the run).
    ///
    /// # Errors
    /// As [`FrameReader::open`].
    pub fn open_within(path: &Path, most: u64) -> io::Result<Self> {
        let file = own_files::read(path)?;
        let length = file.metadata()?.len();
        Self::within(BufReader::new(file), length, most)
    }
}

impl<R: Read> FrameReader<R> {
    /// Reads the header of a file of `length` bytes.
    ///
    /// # Errors
    /// As [`FrameReader::open`].
    pub fn new(file: R, length: u64) -> io::Result<Self> {
        Self::within(file, length, LARGEST)
    }

    /// As [`FrameReader::new`], and refuses a record that would take more than `most` bytes.
    ///
    /// # Errors
    /// As [`FrameReader::open`].
    pub fn within(mut file: R, length: u64, most: u64) -> io::Result<Self> {
        let mut magic = [0; MAGIC.len()];
        let is_frames = file.read_exact(&mut magic).is_ok() && magic == *MAGIC;
        if !is_frames {
            return Err(damaged("it is no file of frames"));
        }
        let mut left = length.saturating_sub(MAGIC.len() as u64);
        let packed = record(&mut file, &mut left, most)?.ok_or_else(|| damaged("its header is cut short"))?;
        let mut content = Vec::new();
        let unpacked = FrameDecoder::new(&packed[..]).take(most.saturating_add(1)).read_to_end(&mut content);
        unpacked.map_err(|error| damaged(error.to_string()))?;
        if content.len() as u64 > most {
            return Err(codec::too_large("its header", most));
        }
        let header = codec::decode_header(&content)?;
        check::header(&header)?;
        Ok(Self { header, file, left, most, is_over: false })
    }
}

impl<R: Read> Iterator for FrameReader<R> {
    type Item = io::Result<Frame>;

    fn next(&mut self) -> Option<io::Result<Frame>> {
        if self.is_over {
            return None;
        }
        let most = self.most;
        let decode = |packed: Vec<u8>| {
            let frame = codec::decode_frame(FrameDecoder::new(&packed[..]), most)?;
            check::frame(&self.header, &frame).map(|()| frame)
        };
        let frame =
            record(&mut self.file, &mut self.left, most).and_then(|packed| packed.map(decode).transpose()).transpose();
        self.is_over = !matches!(frame, Some(Ok(_)));
        frame
    }
}

/// Reads the compressed content of the next record, which unpacks to at most `most` bytes, from a file with `left` bytes; `None` at its end,
/// or if the record is not whole.
fn record(file: &mut impl Read, left: &mut u64, most: u64) -> io::Result<Option<Vec<u8>>> {
    let Some(rest) = left.checked_sub(16) else { return Ok(None) };
    let mut number = [0; 8];
    file.read_exact(&mut number)?;
    let length = u64::from_le_bytes(number);
    let Some(rest) = rest.checked_sub(length) else { return Ok(None) };
    *left = rest;
    if length > self::packed(most) {
        return Err(codec::too_large("a record", most));
    }
    let mut packed = Vec::new();
    file.by_ref().take(length).read_to_end(&mut packed)?;
    file.read_exact(&mut number)?;
    let mut hash = Fnv::default();
    hash.update(&packed);
    if hash.value() != u64::from_le_bytes(number) {
        return Err(damaged("a part of it has changed"));
    }
    Ok(Some(packed))
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::file::FrameFile;
    use super::super::{Column, FORMAT, RegisteredColumn, Table, Values};
    use super::*;
    use crate::frames::scale::{Palette, Scale};

    pub fn header() -> Header {
        Header {
            format: FORMAT,
            version: "0.1.0".to_owned(),
            scene: "silo1".to_owned(),
            title: String::new(),
            dimension: 2,
            species: vec![("R = 0.02 m".to_owned(), [1, 2, 3])],
            periodic: [None, Some((0.0, 1.0)), None],
            domain: [[0.0; 3], [1.0; 3]],
            walls: Vec::new(),
            columns: Vec::new(),
        }
    }

    fn frame(step: u8) -> Frame {
        let values = Values::F64(vec![f64::from(step); 10]);
        let column = Column { name: "radius".to_owned(), unit: "m".to_owned(), components: 1, values };
        let table = Table { name: "grains".to_owned(), rows: 10, columns: vec![column] };
        Frame { step: step.into(), tables: vec![table], ..Frame::default() }
    }

    fn bytes() -> Vec<u8> {
        let here = tempfile::tempdir().unwrap();
        let path = here.path().join("frames.bin");
        let mut file = FrameFile::create(&path, &header()).unwrap();
        (1..=3).for_each(|step| file.add(&frame(step)).unwrap());
        std::fs::read(path).unwrap()
    }

    fn read(bytes: &[u8]) -> io::Result<(Header, Vec<Frame>)> {
        let reader = FrameReader::new(bytes, bytes.len() as u64)?;
        Ok((reader.header.clone(), reader.collect::<io::Result<_>>()?))
    }

    #[test]
    fn frames_are_read_as_they_were_written() {
        assert_eq!(read(&bytes()).unwrap(), (header(), vec![frame(1), frame(2), frame(3)]));
    }

    #[test]
    fn format_1_is_read_and_later_formats_are_named() {
        // Format 1 ended before the list of registered columns.
        let mut bytes = codec::encode_header(&Header { format: 1, ..header() }).unwrap();
        assert_eq!(bytes.pop(), Some(0));
        assert_eq!(codec::decode_header(&bytes).unwrap(), Header { format: 1, ..header() });
        let later = codec::encode_header(&Header { format: FORMAT + 1, ..header() }).unwrap();
        let error = codec::decode_header(&[&later[..], b"more"].concat()).unwrap_err().to_string();
        assert!(error.contains(&format!("its format is {}", FORMAT + 1)), "{error}");
        let scale = Some(Scale { from: 300.0, to: 400.0, palette: Palette::BlueRed });
        let [name, unit, label, behaviour] = ["temperature", "K", "heat of a grain", "conduction"].map(str::to_owned);
        let with_column =
            Header { columns: vec![RegisteredColumn { name, unit, label, behaviour, scale }], ..header() };
        assert_eq!(codec::decode_header(&codec::encode_header(&with_column).unwrap()).unwrap(), with_column);
    }

    #[test]
    fn a_file_that_is_cut_anywhere_has_all_whole_frames() {
        let whole = bytes();
        let mut found = Vec::new();
        for length in 0..=whole.len() {
            match read(&whole[..length]) {
                Ok((_, frames)) => found.push(frames.len()),
                Err(_) => assert!(found.is_empty(), "cut to {length}"),
            }
        }
        found.dedup();
        assert_eq!(found, [0, 1, 2, 3]);
    }

    #[test]
    fn a_wrong_bit_anywhere_is_an_error_or_hides_frames() {
        let whole = bytes();
        for place in 0..whole.len() {
            let mut wrong = whole.clone();
            // Another bit in each byte: the decoder takes a megabyte for each trial.
            wrong[place] ^= 1 << (place % 8);
            let read = read(&wrong);
            assert!(read.as_ref().is_err() || read.unwrap().1.len() < 3, "byte {place}");
        }
    }
}
