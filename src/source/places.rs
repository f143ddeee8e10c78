//! Finds the byte range of each key in a RON text, and replaces a value by its key.
//!
//! A key path names a value as `spawner.radius`, `walls[1].normal`, `behaviours.shaker.amplitude`; the name of an
//! enum variant is not part of the path, so the `k` of `contact: Assignment(k: 1.0)` is `contact.k`, and a value that a
//! variant or tuple holds by position is `spawner.radius.0`. The scanner knows RON's brackets, strings and comments,
//! but no types. On text that is not RON it returns the keys that it understood.

use std::ops::Range;

use crate::fault::Fault;

/// One value of the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The key path; empty for the whole scene.
    pub path: String,
    /// The byte range of the value.
    pub value: Range<usize>,
    /// The byte range from the key, if it has one, to the end of the value.
    pub entry: Range<usize>,
    /// For `(...)` and `{...}` with keys: the offset after the last entry, where a further key can be inserted.
    room: Option<Room>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Room {
    at: usize,
    is_first: bool,
    is_map: bool,
}

/// All values of a text, outer before inner.
#[derive(Clone, Debug)]
pub struct Places(Vec<Place>);

impl Places {
    /// Scans a RON text.
    #[must_use]
    pub fn scan(text: &str) -> Self {
        let mut scanner = Scanner { text, at: 0, depth: 0, places: Vec::new() };
        scanner.skip_attributes();
        scanner.value(String::new(), None);
        Self(scanner.places)
    }

    /// All values, in the order of the text, outer before inner.
    #[must_use]
    pub fn all(&self) -> &[Place] {
        &self.0
    }

    /// The value with this path.
    #[must_use]
    pub fn get(&self, path: &str) -> Option<&Place> {
        self.0.iter().find(|place| place.path == path)
    }

    /// The value with this path, or its nearest parent that stands in the text.
    #[must_use]
    pub fn nearest(&self, path: &str) -> Option<&Place> {
        let mut path = path;
        loop {
            if let Some(place) = self.get(path) {
                return Some(place);
            }
            path = &path[..path.rfind(['.', '['])?];
        }
    }

    /// The innermost value whose entry contains this byte.
    #[must_use]
    pub fn innermost(&self, offset: usize) -> Option<&Place> {
        self.around(offset).min_by_key(|place| place.entry.len())
    }

    /// The innermost value with keys whose entry contains this byte.
    #[must_use]
    pub fn innermost_section(&self, offset: usize) -> Option<&Place> {
        self.around(offset).filter(|place| place.room.is_some()).min_by_key(|place| place.entry.len())
    }

    fn around(&self, offset: usize) -> impl Iterator<Item = &Place> {
        self.0.iter().filter(move |place| place.entry.start <= offset && offset <= place.entry.end)
    }
}

/// Replaces the value at `path` in a scene's text, or adds the key to its parent.
///
/// # Errors
/// If the text has neither the key nor its parent.
pub fn set(text: &str, path: &str, value: &str) -> Result<String, Fault> {
    let places = Places::scan(text);
    let mut changed = text.to_owned();
    if let Some(place) = places.get(path) {
        changed.replace_range(place.value.clone(), value);
        return Ok(changed);
    }
    let (parent, key) = path.rsplit_once('.').unwrap_or(("", path));
    let is_name = |key: &str| !key.is_empty() && key.chars().all(|c| c.is_alphanumeric() || c == '_');
    let Some(room) = places.get(parent).and_then(|place| place.room).filter(|_| is_name(key)) else {
        return Err(Fault::new("call::set", format!("--set {path}={value}: the scene has no `{path}`"))
            .help("name a key that the scene has, as `spawner.count`, or a new key of one of its sections"));
    };
    let comma = if room.is_first { "" } else { ", " };
    let key = if room.is_map { format!("\"{key}\"") } else { key.to_owned() };
    changed.insert_str(room.at, &format!("{comma}{key}: {value}"));
    Ok(changed)
}

/// Largest depth of nested brackets; ron itself refuses more.
const DEEPEST: usize = 128;

struct Scanner<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
    places: Vec<Place>,
}

impl Scanner<'_> {
    fn peek(&self) -> Option<char> {
        self.text[self.at..].chars().next()
    }

    fn rest(&self) -> &str {
        &self.text[self.at..]
    }

    fn skip(&mut self, c: char) -> bool {
        let found = self.peek() == Some(c);
        if found {
            self.at += c.len_utf8();
        }
        found
    }

    fn skip_while(&mut self, accepts: impl Fn(char) -> bool) {
        let length = self.rest().find(|c| !accepts(c)).unwrap_or(self.rest().len());
        self.at += length;
    }

    /// Skips blanks and comments.
    fn skip_blanks(&mut self) {
        loop {
            self.skip_while(char::is_whitespace);
            if self.rest().starts_with("//") {
                self.skip_while(|c| c != '\n');
            } else if self.rest().starts_with("/*") {
                self.skip_block_comment();
            } else {
                return;
            }
        }
    }

    fn skip_block_comment(&mut self) {
        let mut depth = 0;
        while self.at < self.text.len() {
            if self.rest().starts_with("/*") {
                depth += 1;
                self.at += 2;
            } else if self.rest().starts_with("*/") {
                depth -= 1;
                self.at += 2;
                if depth == 0 {
                    return;
                }
            } else {
                self.at += self.peek().map_or(1, char::len_utf8);
            }
        }
    }

    /// Skips `#![enable(...)]` lines at the start.
    fn skip_attributes(&mut self) {
        self.skip_blanks();
        while self.rest().starts_with("#!") {
            self.skip_while(|c| c != ']');
            self.skip(']');
            self.skip_blanks();
        }
    }

    fn skip_string(&mut self) {
        if self.skip('r') {
            let start = self.at;
            self.skip_while(|c| c == '#');
            let close = format!("\"{}", &self.text[start..self.at]);
            self.skip('"');
            self.at = self.rest().find(&close).map_or(self.text.len(), |end| self.at + end + close.len());
            return;
        }
        self.skip('"');
        while let Some(c) = self.peek() {
            self.at += c.len_utf8();
            match c {
                '\\' => self.at += self.peek().map_or(0, char::len_utf8),
                '"' => return,
                _ => {}
            }
        }
    }

    fn is_string(&self) -> bool {
        let rest = self.rest();
        rest.starts_with('"') || rest.starts_with("r\"") || rest.starts_with("r#")
    }

    fn value(&mut self, path: String, entry_start: Option<usize>) {
        self.skip_blanks();
        let start = self.at;
        if self.enters_some() {
            // `Some(...)` is equivalent to its content.
            self.depth += 1;
            self.value(path, entry_start.or(Some(start)));
            self.depth -= 1;
            self.skip_blanks();
            self.skip(')');
            return;
        }
        let index = self.places.len();
        let entry = entry_start.unwrap_or(start);
        self.places.push(Place { path: path.clone(), value: start..start, entry: entry..start, room: None });
        if self.is_string() {
            self.skip_string();
        } else {
            self.skip_while(|c| !c.is_whitespace() && !"()[]{},:\"/".contains(c));
            let name_end = self.at;
            self.skip_blanks();
            match self.peek() {
                Some('(') => self.fields(&path, index, ')'),
                Some('{') if name_end == start => self.fields(&path, index, '}'),
                Some('[') if name_end == start => self.fields(&path, index, ']'),
                _ => self.at = name_end,
            }
        }
        self.places[index].value.end = self.at;
        self.places[index].entry.end = self.at;
    }

    /// Skips `Some(`, if it stands here.
    fn enters_some(&mut self) -> bool {
        let start = self.at;
        if self.depth < DEEPEST && self.rest().starts_with("Some") {
            self.at += "Some".len();
            self.skip_blanks();
            if self.skip('(') {
                return true;
            }
        }
        self.at = start;
        false
    }

    /// Scans the content of brackets: keys and values, or values alone.
    fn fields(&mut self, path: &str, index: usize, close: char) {
        if self.depth == DEEPEST {
            self.at = self.text.len();
            return;
        }
        self.depth += 1;
        self.at += 1;
        let mut number = 0;
        let mut room = Some(Room { at: self.at, is_first: true, is_map: close == '}' });
        loop {
            self.skip_blanks();
            let here = self.at;
            if self.peek().is_none() || self.peek() == Some(close) {
                break;
            }
            if let Some(key) = self.key(close) {
                let separator = if path.is_empty() { "" } else { "." };
                self.value(format!("{path}{separator}{key}"), Some(here));
                room = room.map(|room| Room { at: self.at, is_first: false, ..room });
            } else {
                room = None;
                let child = if close == ']' { format!("{path}[{number}]") } else { format!("{path}.{number}") };
                self.value(child, None);
                number += 1;
            }
            self.skip_blanks();
            if !self.skip(',') && self.at == here {
                // Not RON: stop, to avoid an endless loop at this place.
                break;
            }
        }
        self.places[index].room = room.filter(|_| close != ']');
        self.depth -= 1;
        self.skip(close);
    }

    /// Reads a key and its colon, if they stand here.
    fn key(&mut self, close: char) -> Option<String> {
        if close == ']' {
            return None;
        }
        let start = self.at;
        let key = if self.is_string() {
            self.skip_string();
            self.text[start..self.at].trim_matches('"').to_owned()
        } else {
            self.skip_while(|c| c.is_alphanumeric() || c == '_');
            self.text[start..self.at].to_owned()
        };
        self.skip_blanks();
        if !key.is_empty() && self.skip(':') {
            return Some(key);
        }
        self.at = start;
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TEXT: &str = r#"#![enable(implicit_some)]
// a scene (not: this)
Scene(
    title: "a (b): \"c\"", /* not, /* this */ : */
    contact: Assignment(k: 1.0e4, b: 5),
    radius: Fixed(0.04),
    walls: [HalfPlane(point: (0, 1)), Disc(radius: 2)],
    behaviours: {"shaker": (hz: 3)},
    empty: (),
)
"#;

    fn value<'a>(text: &'a str, path: &str) -> &'a str {
        &text[Places::scan(text).get(path).unwrap_or_else(|| panic!("no {path}")).value.clone()]
    }

    #[test]
    fn every_key_has_its_value() {
        for (path, expected) in [
            ("title", r#""a (b): \"c\"""#),
            ("contact", "Assignment(k: 1.0e4, b: 5)"),
            ("contact.k", "1.0e4"),
            ("contact.b", "5"),
            ("radius.0", "0.04"),
            ("walls[0].point", "(0, 1)"),
            ("walls[0].point.1", "1"),
            ("walls[1].radius", "2"),
            ("behaviours.shaker.hz", "3"),
        ] {
            assert_eq!(value(TEXT, path), expected);
        }
        let places = Places::scan(TEXT);
        assert_eq!(places.innermost(TEXT.find("1.0e4").unwrap()).unwrap().path, "contact.k");
        assert_eq!(places.nearest("contact.gone.deep").unwrap().path, "contact");
    }

    #[test]
    fn setting_replaces_or_adds() {
        let changed = set(TEXT, "contact.k", "7").unwrap();
        assert_eq!(value(&changed, "contact"), "Assignment(k: 7, b: 5)");
        for path in ["new", "contact.new", "behaviours.new", "behaviours.shaker.new", "empty.new", "walls[1].new"] {
            let added = set(TEXT, path, "(1, 2)").unwrap();
            assert_eq!(value(&added, path), "(1, 2)", "{added}");
            assert_eq!(value(&added, "contact.b"), "5");
        }
        for path in ["gone.new", "walls.new", "radius.new", "contact.k.new", ""] {
            assert!(path.is_empty() || set(TEXT, path, "1").is_err(), "{path}");
        }
        let optional = set("(a: Some((b: 1)))", "a.b", "2").unwrap();
        assert_eq!(optional, "(a: Some((b: 2)))");
        let commented = set("(a: 1 // one\n)", "b", "2").unwrap();
        assert_eq!((value(&commented, "a"), value(&commented, "b")), ("1", "2"));
    }

    #[test]
    fn a_hundred_thousand_brackets_are_no_trouble() {
        let text = "(".repeat(100_000);
        assert!(Places::scan(&text).0.len() <= 2 * DEEPEST);
    }

    proptest! {
        #[test]
        fn any_text_is_scanned_to_an_end(text in "[a-z(){}\\[\\],:\"/*# \nr0-9é]{0,60}") {
            let _ = Places::scan(&text);
        }
    }
}
