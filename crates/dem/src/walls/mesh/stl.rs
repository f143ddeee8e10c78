//! STL files.
//!
//! A binary file has a header of 80 bytes, the number of triangles, and 50 bytes for each. It may begin like an ASCII file, with `solid`; its length tells
//! them apart. Bytes after the last triangle are ignored.
//!
//! An ASCII file is read word by word: keywords in any case, with or without names, blank lines anywhere, several solids, `endloop` or `end loop`,
//! exponents with `E` or `D`. Whatever stands between `facet` and `outer loop` is not read, because normals are not used; some programs
//! write `nan` there.

use std::str::SplitWhitespace;

use super::{Found, MOST_TRIANGLES, text, too_many, without_d};
use crate::space::Solid;

const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// Reads an STL file.
pub(super) fn read(bytes: &[u8]) -> Result<Found, String> {
    let announced = bytes.get(80..HEADER).and_then(|bytes| bytes.try_into().ok()).map(u32::from_le_bytes);
    let length = |count: u32| HEADER as u64 + TRIANGLE as u64 * u64::from(count);
    match announced {
        Some(count) if length(count) == bytes.len() as u64 => read_binary(bytes, count),
        Some(count) if !is_text(bytes) => read_binary(bytes, count),
        _ => read_ascii(&text(bytes)?),
    }
}

/// Whether the bytes may be a text. A binary file has bytes that are zero: a number such as 0 or 0.5 has some.
fn is_text(bytes: &[u8]) -> bool {
    let has_mark = bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]);
    has_mark || !bytes.contains(&0)
}

fn read_binary(bytes: &[u8], count: u32) -> Result<Found, String> {
    let (triangles, rest) = bytes.get(HEADER..).unwrap_or_default().as_chunks::<TRIANGLE>();
    let count = count as usize;
    if count > triangles.len() {
        return Err(format!(
            "the header announces {count} triangles, and the file ends in triangle {}; is it a complete binary STL file?",
            triangles.len() + 1
        ));
    }
    if count == 0 && !triangles.is_empty() {
        return Err(format!(
            "the header announces no triangle, and {} bytes follow; is it a complete binary STL file?",
            TRIANGLE * triangles.len() + rest.len()
        ));
    }
    if count > MOST_TRIANGLES {
        return Err(too_many());
    }
    let number = |bytes: &[u8; 4]| f64::from(f32::from_le_bytes(*bytes));
    let mut found = Found::default();
    for triangle in &triangles[..count] {
        // The normal comes first, and two bytes without a meaning last.
        let (numbers, _) = triangle[12..48].as_chunks::<4>();
        let corner = |n: usize| Solid::new(number(&numbers[n]), number(&numbers[n + 1]), number(&numbers[n + 2]));
        found.add([corner(0), corner(3), corner(6)], 0)?;
    }
    Ok(found)
}

/// The words of a text.
struct Words<'a> {
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    rest: SplitWhitespace<'a>,
    /// The number of the line of the last word, from 1.
    line: usize,
}

impl<'a> Words<'a> {
    fn next(&mut self) -> Option<&'a str> {
        loop {
            if let Some(word) = self.rest.next() {
                return Some(word);
            }
            let (number, line) = self.lines.next()?;
            (self.line, self.rest) = (number + 1, line.split_whitespace());
        }
    }

    fn skip_line(&mut self) {
        self.rest = "".split_whitespace();
    }

    /// Takes a word, or two words of which the first is `end`: both `endloop` and `end loop`.
    fn expect(&mut self, expected: &str) -> Result<(), String> {
        let found = self.next();
        let whole = found.is_some_and(|word| word.eq_ignore_ascii_case(expected));
        let (first, second) = expected.split_at(if expected.starts_with("end") { 3 } else { expected.len() });
        let in_parts = || found.is_some_and(|word| word.eq_ignore_ascii_case(first)) && !second.is_empty();
        if whole || (in_parts() && self.next().is_some_and(|word| word.eq_ignore_ascii_case(second))) {
            return Ok(());
        }
        Err(self.wrong(expected, found))
    }

    fn wrong(&self, expected: &str, found: Option<&str>) -> String {
        let found = found.map_or("the end of the file".to_owned(), |word| format!("`{word}`"));
        format!("line {}: `{expected}` should stand here, not {found}", self.line)
    }
}

fn read_ascii(text: &str) -> Result<Found, String> {
    let mut words = Words { lines: text.lines().enumerate(), rest: "".split_whitespace(), line: 1 };
    let mut found = Found::default();
    let mut is_inside = false;
    while let Some(word) = words.next() {
        match word.to_ascii_lowercase().as_str() {
            // The rest of the line is a name.
            "solid" => {
                words.skip_line();
                is_inside = true;
            }
            "facet" if is_inside => facet(&mut words, &mut found)?,
            "endsolid" if is_inside => {
                words.skip_line();
                is_inside = false;
            }
            "end" if is_inside && words.next().is_some_and(|word| word.eq_ignore_ascii_case("solid")) => {
                words.skip_line();
                is_inside = false;
            }
            // Some programs give a solid or a facet a colour.
            "color" | "colour" if is_inside => words.skip_line(),
            _ if is_inside => return Err(words.wrong("facet` or `endsolid", Some(word))),
            _ => return Err(format!("not an STL file: {}", words.wrong("solid", Some(word)))),
        }
    }
    if is_inside {
        return Err(words.wrong("endsolid", None));
    }
    if found.triangles.is_empty() && text.trim().is_empty() {
        return Err("not an STL file: it is empty".to_owned());
    }
    Ok(found)
}

/// Reads a triangle behind the word `facet`.
fn facet(words: &mut Words<'_>, found: &mut Found) -> Result<(), String> {
    let line = words.line;
    let number = found.triangles.len() + 1;
    let bad = |message: String| format!("triangle {number}: {message}");
    loop {
        match words.next() {
            Some(word) if word.eq_ignore_ascii_case("outer") => break,
            Some(word)
                if !["vertex", "facet", "endfacet", "endloop", "end", "endsolid"].contains(&&*word.to_lowercase()) => {}
            word => return Err(bad(words.wrong("outer loop", word))),
        }
    }
    words.expect("loop").map_err(bad)?;
    let mut corners = [Solid::ZERO; 3];
    for corner in &mut corners {
        words.expect("vertex").map_err(bad)?;
        for axis in 0..3 {
            corner[axis] = coordinate(words).map_err(bad)?;
        }
    }
    words.expect("endloop").map_err(|message| bad(format!("{message}; a facet has three corners")))?;
    words.expect("endfacet").map_err(bad)?;
    found.add(corners, line)
}

fn coordinate(words: &mut Words<'_>) -> Result<f64, String> {
    let word = words.next().unwrap_or("the end of the file");
    match without_d(word).parse::<f32>() {
        Ok(number) if number.is_finite() => Ok(f64::from(number)),
        _ => Err(format!("line {}: a finite number such as -1.5e-3 should stand here, not `{word}`", words.line)),
    }
}
