//! `hashes.txt`, the hashes of the files of a run that is over, and the seal of `summary.json`.
//!
//! A line of `hashes.txt` is the [`Fnv`] hash of a file as 16 hexadecimal digits, its length in bytes, and its path in the run
//! directory. The summary has the hash of `hashes.txt`. Its own hash, the seal, is that of its text with zeros in place of the
//! seal.

use std::fmt::Write as _;

use serde::Serialize;

use crate::fnv::Fnv;
use crate::run_files::{Extent, FileRecord, Kind, Manifest};

/// The files of the run in the summary.
#[derive(Clone, Debug, Serialize)]
pub struct SummaryFiles {
    /// Number of files in `hashes.txt`.
    pub count: usize,
    /// Their bytes.
    pub bytes: u64,
    /// Hash of `hashes.txt`.
    pub hashes: String,
    /// Hash of the summary with zeros in this place.
    pub seal: &'static str,
}

const NO_SEAL: &str = "0000000000000000";

impl SummaryFiles {
    /// Returns what the summary says about these files.
    #[must_use]
    pub fn of(manifest: &Manifest) -> Self {
        Self {
            count: manifest.files.len(),
            bytes: manifest.files.iter().map(|file| file.extent.length).sum(),
            hashes: hash_of(&text(manifest)),
            seal: NO_SEAL,
        }
    }
}

/// Returns the hash of a text, as 16 hexadecimal digits.
#[must_use]
pub fn hash_of(text: &str) -> String {
    let mut hash = Fnv::default();
    hash.update(text.as_bytes());
    format!("{:016x}", hash.value())
}

/// Returns the text of `hashes.txt`.
#[must_use]
pub fn text(manifest: &Manifest) -> String {
    let mut text = "# FNV-1a hash, bytes, file\n".to_owned();
    for FileRecord { name, extent: Extent { length, hash }, .. } in &manifest.files {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{hash:016x} {length} {name}");
    }
    text
}

/// Reads the text of `hashes.txt`; `None` if a line is no line of it.
#[must_use]
pub fn read(text: &str) -> Option<Vec<FileRecord>> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let read = |line: &str| {
        let mut parts = line.splitn(3, ' ');
        let hash = u64::from_str_radix(parts.next()?, 16).ok()?;
        let length = parts.next()?.parse().ok()?;
        Some(FileRecord { name: parts.next()?.to_owned(), kind: Kind::Whole, extent: Extent { length, hash } })
    };
    lines.map(read).collect()
}

/// The start of the seal in the text of a summary. A text value cannot hold it, because its quotation marks would be escaped.
const BEFORE_SEAL: &str = "\"seal\": \"";

/// Returns the place of the seal in the text of a summary.
fn place_of_seal(summary: &str) -> Option<std::ops::Range<usize>> {
    let start = summary.rfind(BEFORE_SEAL)? + BEFORE_SEAL.len();
    let end = start + NO_SEAL.len();
    summary.get(start..end).map(|_| start..end)
}

/// Seals the text of a summary, if it has a place for a seal.
#[must_use]
pub fn sealed(mut summary: String) -> String {
    if let Some(place) = place_of_seal(&summary) {
        let hash = hash_of(&summary);
        summary.replace_range(place, &hash);
    }
    summary
}

/// Whether the seal of a summary is that of its text; `None` without a seal.
#[must_use]
pub fn is_sealed(summary: &str) -> Option<bool> {
    let place = place_of_seal(summary)?;
    let seal = summary[place.clone()].to_owned();
    let mut open = summary.to_owned();
    open.replace_range(place, NO_SEAL);
    Some(hash_of(&open) == seal)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn manifest() -> Manifest {
        let file = |name: &str, text: &str| FileRecord {
            name: name.to_owned(),
            kind: Kind::Whole,
            extent: Extent::default().with(text.as_bytes()),
        };
        Manifest { files: vec![file("frames/00000.svg", "a"), file("two words.csv", "foobar")], damage: Vec::new() }
    }

    #[test]
    fn hashes_are_read_as_they_are_written() {
        let text = text(&manifest());
        assert!(text.contains("\n85944171f73967e8 6 two words.csv\n"), "{text}");
        assert_eq!(read(&text), Some(manifest().files));
        for broken in ["x 1 a\n", "12 a\n", "12 a b\n"] {
            assert_eq!(read(broken), None, "{broken}");
        }
    }

    #[test]
    fn a_seal_shows_every_changed_byte() {
        #[derive(Serialize)]
        struct Summary {
            way: &'static str,
            files: SummaryFiles,
        }
        let summary = Summary { way: "\"seal\": \"of another\"", files: SummaryFiles::of(&manifest()) };
        let text = sealed(serde_json::to_string_pretty(&summary).unwrap());
        assert_eq!(is_sealed(&text), Some(true), "{text}");
        for place in 0..text.len() {
            let mut changed = text.clone().into_bytes();
            changed[place] ^= 1;
            assert_ne!(is_sealed(std::str::from_utf8(&changed).unwrap()), Some(true), "byte {place}");
        }
        assert_eq!(is_sealed("{}"), None);
    }
}
