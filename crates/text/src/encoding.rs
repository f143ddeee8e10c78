//! The encoding of every text that is read: scenes, silo files, tables, grains, meshes, results.
//!
//! | text | read as |
//! |---|---|
//! | with a byte order mark of UTF-8 | UTF-8; the mark is left out |
//! | with a byte order mark of UTF-16, either order | UTF-16 |
//! | with a byte order mark of UTF-32, or every other byte zero at its start | refused |
//! | other | UTF-8 |
//!
//! Editors and spreadsheets of Windows write such marks. A text that is not what it is read as is refused with the place of the first wrong
//! byte. Texts in Latin-1 are refused so too: they say nothing about their encoding.

use std::io::{self, Read};

/// Number of bytes that are read at a time.
const CHUNK: usize = 1 << 16;

/// The byte order mark as a character.
pub const MARK: char = '\u{feff}';

/// Reads a text of one of these encodings, and gives out UTF-8 without a byte order mark.
#[derive(Debug)]
pub struct TextReader<R> {
    source: R,
    /// Known after the first bytes.
    encoding: Option<Encoding>,
    /// Bytes of the source that are not decoded yet.
    raw: Vec<u8>,
    /// Decoded text, and how much of it was given out.
    text: Vec<u8>,
    given: usize,
    is_at_end: bool,
    /// Lines, and characters in the last line, of the decoded text, from 0.
    line: usize,
    column: usize,
    /// The fault of the text, in words. Every later call returns it again.
    wrong: Option<String>,
}

#[derive(Clone, Copy, Debug)]
enum Encoding {
    Utf8,
    Utf16(fn([u8; 2]) -> u16),
}

/// Returns the text of a file's bytes.
///
/// # Errors
/// In words, with line and column.
pub fn decode(bytes: &[u8]) -> Result<String, String> {
    let mut text = String::new();
    TextReader::new(bytes).read_to_string(&mut text).map_err(|error| error.to_string())?;
    Ok(text)
}

impl<R: Read> TextReader<R> {
    /// Reads from a file or other source of bytes.
    pub fn new(source: R) -> Self {
        Self {
            source,
            encoding: None,
            raw: Vec::new(),
            text: Vec::new(),
            given: 0,
            is_at_end: false,
            line: 0,
            column: 0,
            wrong: None,
        }
    }

    /// Reads and decodes until there is text to give out, or the source ends.
    fn fill(&mut self) -> io::Result<()> {
        while self.given == self.text.len() && self.wrong.is_none() && !(self.is_at_end && self.raw.is_empty()) {
            if !self.is_at_end {
                let before = self.raw.len();
                self.raw.resize(before + CHUNK, 0);
                let read = self.source.read(&mut self.raw[before..]);
                self.raw.truncate(before + read.as_ref().copied().unwrap_or(0));
                match read {
                    Ok(count) => self.is_at_end = count == 0,
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                    Err(error) => return Err(error),
                }
            }
            if self.encoding.is_none() && self.raw.len() < 4 && !self.is_at_end {
                continue;
            }
            self.text.clear();
            self.given = 0;
            if let Err(wrong) = self.decode() {
                self.text.clear();
                self.wrong = Some(wrong);
            }
        }
        match &self.wrong {
            Some(wrong) => Err(io::Error::new(io::ErrorKind::InvalidData, wrong.clone())),
            None => Ok(()),
        }
    }

    fn decode(&mut self) -> Result<(), String> {
        let encoding = match self.encoding {
            Some(encoding) => encoding,
            None => *self.encoding.insert(recognise(&mut self.raw)?),
        };
        match encoding {
            Encoding::Utf8 => self.decode_utf8(),
            Encoding::Utf16(unit) => self.decode_utf16(unit),
        }
    }

    fn decode_utf8(&mut self) -> Result<(), String> {
        let (valid, is_wrong) = match std::str::from_utf8(&self.raw) {
            Ok(text) => (text.len(), false),
            // The rest of a character may come with the next bytes.
            Err(error) => (error.valid_up_to(), error.error_len().is_some() || self.is_at_end),
        };
        self.text.extend(self.raw.drain(..valid));
        self.count();
        match self.raw.first() {
            Some(&byte) if is_wrong => {
                // In Latin-1 and the encodings of Windows, bytes from 0xa0 on are the characters of the same number.
                let shown =
                    if byte >= 0xa0 { format!(" (in Latin-1 it is `{}`)", char::from(byte)) } else { String::new() };
                Err(self.wrong(&format!("the byte 0x{byte:02x}{shown} is not UTF-8")))
            }
            _ => Ok(()),
        }
    }

    fn decode_utf16(&mut self, unit: fn([u8; 2]) -> u16) -> Result<(), String> {
        let (pairs, rest) = self.raw.as_chunks::<2>();
        let mut units: Vec<u16> = pairs.iter().map(|pair| unit(*pair)).collect();
        let is_odd = !rest.is_empty();
        // The other half of a character may come with the next bytes.
        let is_half = units.last().is_some_and(|last| (0xd800..0xdc00).contains(last));
        if is_half && !self.is_at_end {
            units.pop();
        }
        self.raw.drain(..2 * units.len());
        for decoded in char::decode_utf16(units) {
            let Ok(character) = decoded else {
                self.count();
                return Err(self.wrong("half of a character, so this is not UTF-16"));
            };
            self.text.extend(character.encode_utf8(&mut [0; 4]).bytes());
        }
        self.count();
        if self.is_at_end && is_odd {
            return Err(self.wrong("half of a character at the end of the file, so this is not UTF-16"));
        }
        Ok(())
    }

    /// Counts lines and characters of the text that was decoded last.
    fn count(&mut self) {
        let characters = |bytes: &[u8]| bytes.iter().filter(|&&byte| byte & 0xc0 != 0x80).count();
        self.line += self.text.split(|&byte| byte == b'\n').count() - 1;
        self.column = match self.text.iter().rposition(|&byte| byte == b'\n') {
            Some(last) => characters(&self.text[last + 1..]),
            None => self.column + characters(&self.text),
        };
    }

    /// Returns a message about a fault at the present place.
    fn wrong(&self, what: &str) -> String {
        let line = self.line + 1;
        let column = self.column + 1;
        format!("line {line}, column {column}: {what}; save the file with the encoding UTF-8")
    }
}

impl<R: Read> Read for TextReader<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.fill()?;
        let rest = &self.text[self.given..];
        let count = rest.len().min(buffer.len());
        buffer[..count].copy_from_slice(&rest[..count]);
        self.given += count;
        Ok(count)
    }
}

/// Returns the encoding that the first bytes state, and removes the mark.
fn recognise(bytes: &mut Vec<u8>) -> Result<Encoding, String> {
    let refused = |what: &str| Err(format!("{what}; save the file with the encoding UTF-8"));
    match bytes[..] {
        [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => refused("the file has the encoding UTF-32"),
        [0xff, 0xfe, ..] => {
            bytes.drain(..2);
            Ok(Encoding::Utf16(u16::from_le_bytes))
        }
        [0xfe, 0xff, ..] => {
            bytes.drain(..2);
            Ok(Encoding::Utf16(u16::from_be_bytes))
        }
        [first, second, ..] if (first == 0) != (second == 0) => {
            refused("every other byte is zero, as in the encoding UTF-16 without a byte order mark")
        }
        _ => {
            while bytes.starts_with(&[0xef, 0xbb, 0xbf]) {
                bytes.drain(..3);
            }
            Ok(Encoding::Utf8)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives out one byte at a time, so that every character is divided.
    struct Slow<'a>(&'a [u8]);

    impl Read for Slow<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let Some((&first, rest)) = self.0.split_first() else { return Ok(0) };
            buffer[0] = first;
            self.0 = rest;
            Ok(1)
        }
    }

    fn both(bytes: &[u8]) -> Result<String, String> {
        let mut text = String::new();
        let slow =
            TextReader::new(Slow(bytes)).read_to_string(&mut text).map(|_| text).map_err(|error| error.to_string());
        assert_eq!(slow, decode(bytes));
        slow
    }

    #[test]
    fn a_wrong_text_is_wrong_again_when_it_is_read_on() {
        let mut reader = TextReader::new(&b"a,b\n1,\xf6\n"[..]);
        for _ in 0..3 {
            assert_eq!(reader.read(&mut [0; 8]).unwrap_err().kind(), io::ErrorKind::InvalidData);
        }
    }

    fn utf16(text: &str, bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
        text.encode_utf16().flat_map(bytes).collect()
    }

    const TEXT: &str = "a, größer\r\n√2 𝄞\n";

    #[test]
    fn every_encoding_with_a_mark_gives_the_same_text() {
        let marked = format!("\u{feff}{TEXT}");
        assert_eq!(both(TEXT.as_bytes()).unwrap(), TEXT);
        assert_eq!(both(marked.as_bytes()).unwrap(), TEXT);
        assert_eq!(both(&utf16(&marked, u16::to_le_bytes)).unwrap(), TEXT);
        assert_eq!(both(&utf16(&marked, u16::to_be_bytes)).unwrap(), TEXT);
        for empty in [&b""[..], b"\xef\xbb\xbf", b"\xff\xfe", b"\xfe\xff"] {
            assert_eq!(both(empty).unwrap(), "");
        }
        assert_eq!(both(b"x").unwrap(), "x");
        let long = TEXT.repeat(100_000);
        assert_eq!(decode(&utf16(&format!("\u{feff}{long}"), u16::to_le_bytes)).unwrap(), long);
    }

    #[test]
    fn other_encodings_are_refused_with_their_place() {
        let bad = |bytes: &[u8], words: &[&str]| {
            let message = both(bytes).unwrap_err();
            assert!(words.iter().all(|word| message.contains(word)) && message.contains("save the file"), "{message}");
        };
        bad(b"1,2\n\xc3\xa4bc gr\xf6\xdfer\n", &["line 2, column 7", "0xf6", "`ö`", "Latin-1"]);
        bad(b"caf\xe9", &["line 1, column 4", "0xe9"]);
        bad(b"ok\n\x93quoted\x94", &["line 2, column 1", "0x93 is not UTF-8"]);
        bad(&utf16(TEXT, u16::to_le_bytes), &["UTF-16 without a byte order mark"]);
        bad(&utf16(TEXT, u16::to_be_bytes), &["UTF-16 without a byte order mark"]);
        bad(b"\xff\xfe\0\0a\0\0\0", &["UTF-32"]);
        bad(b"\0\0\xfe\xff\0\0\0a", &["UTF-32"]);
        bad(b"\xff\xfea\0\n\0b", &["line 2, column 1", "at the end of the file"]);
        bad(b"\xff\xfea\0\x00\xd8b\0", &["line 1, column 2", "not UTF-16"]);
    }
}
