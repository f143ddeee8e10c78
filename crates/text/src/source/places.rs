//! Finds the byte range of each key in a RON text, and replaces a value by its key.
//!
//! A key path names a value as `spawner.radius`, `walls[1].normal`, `behaviours.shaker.amplitude`; the name of an
//! enum variant is not part of the path, so the `k` of `contact: Assignment(k: 1.0)` is `contact.k`, and a value that a
//! variant or tuple holds by position is `spawner.radius.0`. The scanner knows RON's brackets, strings and comments,
//! but no types. On text that is not RON it returns the keys that it understood.

use std::ops::Range;

use rustc_hash::FxHashMap;

use crate::fault::Fault;
use crate::safe::cut;
use crate::suggestion::closest;

/// One value of the text. Its key path is [`Places::path`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Number of the value that this one is a part of; `None` for the whole scene.
    parent: Option<usize>,
    /// The last part of the key path. Whole paths are not stored: in a long key, their length would multiply.
    segment: Segment,
    /// Hash of the key path.
    pub(super) hash: u64,
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

/// The part of a key path that leads from a value to one of its parts.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Segment {
    /// The whole scene.
    Whole,
    /// A key.
    Key(Box<str>),
    /// A value of `(...)` or `{...}` without a key, by its number: `.0`.
    Item(usize),
    /// An element of a list: `[0]`.
    Element(usize),
}

impl Segment {
    /// Returns the text that the segment adds to the path of its parent: a key has a dot before it, unless the parent is the whole scene.
    fn text(&self, parent_is_whole: bool) -> String {
        match self {
            Self::Whole => String::new(),
            Self::Key(key) => format!("{}{key}", if parent_is_whole { "" } else { "." }),
            Self::Item(number) => format!(".{number}"),
            Self::Element(number) => format!("[{number}]"),
        }
    }
}

/// The hash of an empty path.
const EMPTY_HASH: u64 = 0xcbf2_9ce4_8422_2325;

/// Continues the hash of a path (FNV-1a), so that equal paths have equal hashes.
fn hashed(start: u64, more: &str) -> u64 {
    more.bytes().fold(start, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

/// All values of a text, outer before inner.
#[derive(Clone, Debug)]
pub struct Places {
    all: Vec<Place>,
    /// Number of the first value with each hash.
    by_hash: FxHashMap<u64, usize>,
}

impl Places {
    /// Scans a RON text.
    #[must_use]
    pub fn scan(text: &str) -> Self {
        let mut scanner = Scanner { text, at: 0, depth: 0, places: Vec::new() };
        scanner.skip_attributes();
        scanner.value(None, Segment::Whole, None);
        let mut by_hash = FxHashMap::default();
        for (number, place) in scanner.places.iter().enumerate() {
            by_hash.entry(place.hash).or_insert(number);
        }
        Self { all: scanner.places, by_hash }
    }

    /// All values, in the order of the text, outer before inner.
    #[must_use]
    pub fn all(&self) -> &[Place] {
        &self.all
    }

    /// The key path of a value; empty for the whole scene.
    #[must_use]
    pub fn path(&self, place: &Place) -> String {
        let chain: Vec<&Place> = std::iter::once(place).chain(self.parents(place)).collect();
        chain.iter().rev().fold(String::new(), |path, place| {
            let segment = place.segment.text(path.is_empty());
            path + &segment
        })
    }

    /// The values around a value, from the inside out.
    pub(super) fn parents<'a>(&'a self, place: &'a Place) -> impl Iterator<Item = &'a Place> {
        std::iter::successors(place.parent, |&parent| self.all[parent].parent).map(|parent| &self.all[parent])
    }

    /// The value with this path.
    #[must_use]
    pub fn get(&self, path: &str) -> Option<&Place> {
        let place = &self.all[*self.by_hash.get(&hashed(EMPTY_HASH, path))?];
        (self.path(place) == path).then_some(place)
    }

    /// The keys of a section, and their values.
    pub(super) fn entries(&self, section: &Place) -> impl Iterator<Item = (&str, &Place)> {
        let number = self.by_hash.get(&section.hash).copied();
        self.all.iter().filter(move |place| place.parent.is_some() && place.parent == number).filter_map(|place| {
            match &place.segment {
                Segment::Key(key) => Some((&**key, place)),
                _ => None,
            }
        })
    }

    /// The value here that has the same path as `place` of another text.
    pub(super) fn same(&self, place: &Place) -> Option<&Place> {
        self.by_hash.get(&place.hash).map(|&number| &self.all[number])
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
        self.all.iter().filter(move |place| place.entry.start <= offset && offset <= place.entry.end)
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
        let whole = path.split(['.', '[']).next().unwrap_or_default();
        let keys: Vec<_> =
            places.get("").map(|scene| places.entries(scene).map(|(key, _)| key).collect()).unwrap_or_default();
        let help = match closest(whole, &keys).filter(|close| *close != whole) {
            Some(close) => format!("did you mean `{close}`?"),
            None if !keys.contains(&whole) && is_name(whole) => {
                format!(
                    "the scene has no `{whole}`: set it as a whole, `--set \"{whole}=...\"`; its keys are {}",
                    cut(&keys.join(", "), 300)
                )
            }
            None => format!("name a key that `{whole}` has in the scene, or a new key of one of its sections"),
        };
        return Err(Fault::new("call::set", format!("--set {path}={value}: the scene has no `{path}`")).help(help));
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

    fn value(&mut self, parent: Option<usize>, segment: Segment, entry_start: Option<usize>) {
        self.skip_blanks();
        let start = self.at;
        if self.enters_some() {
            // `Some(...)` is equivalent to its content.
            self.depth += 1;
            self.value(parent, segment, entry_start.or(Some(start)));
            self.depth -= 1;
            self.skip_blanks();
            self.skip(')');
            return;
        }
        let index = self.places.len();
        let entry = entry_start.unwrap_or(start);
        let hash = parent.map_or(EMPTY_HASH, |parent| {
            hashed(self.places[parent].hash, &segment.text(self.places[parent].parent.is_none()))
        });
        self.places.push(Place { parent, segment, hash, value: start..start, entry: entry..start, room: None });
        if self.is_string() {
            self.skip_string();
        } else {
            self.skip_while(|c| !c.is_whitespace() && !"()[]{},:\"/".contains(c));
            let name_end = self.at;
            self.skip_blanks();
            match self.peek() {
                Some('(') => self.fields(index, ')'),
                Some('{') if name_end == start => self.fields(index, '}'),
                Some('[') if name_end == start => self.fields(index, ']'),
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
    fn fields(&mut self, index: usize, close: char) {
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
                self.value(Some(index), Segment::Key(key.into()), Some(here));
                room = room.map(|room| Room { at: self.at, is_first: false, ..room });
            } else {
                room = None;
                let child = if close == ']' { Segment::Element(number) } else { Segment::Item(number) };
                self.value(Some(index), child, None);
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
        assert_eq!(places.path(places.innermost(TEXT.find("1.0e4").unwrap()).unwrap()), "contact.k");
        assert_eq!(places.path(places.nearest("contact.gone.deep").unwrap()), "contact");
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
        assert!(Places::scan(&text).all().len() <= 2 * DEEPEST);
    }

    #[test]
    fn a_long_key_around_many_values_takes_their_memory_once() {
        let text = format!("({}: [{}])", "k".repeat(100_000), "1,".repeat(40_000));
        let places = Places::scan(&text);
        assert_eq!(places.all().len(), 40_002);
        assert!(places.get(&format!("{}[39999]", "k".repeat(100_000))).is_some());
    }

    proptest! {
        #[test]
        fn any_text_is_scanned_to_an_end(text in "[a-z(){}\\[\\],:\"/*# \nr0-9é]{0,60}") {
            let _ = Places::scan(&text);
        }
    }
}
