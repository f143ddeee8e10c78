//! Lists the keys in which the texts of two scenes differ. `1e4` and `10000.0` count as different; comments and layout
//! do not.

use rustc_hash::FxHashSet;
use serde::Serialize;

use crate::source::Source;
use crate::source::places::Place;

/// A key with different values, as the texts spell them. A value is `None` if the text lacks the key.
#[derive(Debug, PartialEq, Eq, Serialize)]
pub struct Change {
    /// Path of the key.
    pub key: String,
    /// Value in the first text.
    pub first: Option<String>,
    /// Value in the second text.
    pub second: Option<String>,
}

/// The keys with different values: in the order of the first text, then keys of the second text alone. Keys within a
/// listed key are not listed.
#[must_use]
pub fn changes(first: &Source, second: &Source) -> Vec<Change> {
    let mut changes: Vec<Change> = Vec::new();
    // Hashes of the listed paths.
    let mut listed = FxHashSet::default();
    let [ours, theirs] = [first, second].map(|source| &source.places);
    let text = |source: &Source, place: Option<&Place>| place.map(|place| source.text_of(place).to_owned());
    let both = ours.all().iter().map(|place| (ours, place, [Some(place), theirs.same(place)]));
    let only_in_second = theirs.all().iter().filter(|place| ours.same(place).is_none());
    for (places, place, pair) in both.chain(only_in_second.map(|place| (theirs, place, [None, Some(place)]))) {
        let is_whole = places.parents(place).next().is_none();
        let values = [text(first, pair[0]), text(second, pair[1])];
        let is_same = values[0].as_deref().map(head) == values[1].as_deref().map(head);
        if is_whole || is_same || places.parents(place).any(|parent| listed.contains(&parent.hash)) {
            continue;
        }
        listed.insert(place.hash);
        let [first, second] = values.map(|value| value.as_deref().map(on_one_line));
        changes.push(Change { key: places.path(place), first, second });
    }
    changes
}

/// The part of a value outside of its inner keys: the whole of a number or a string, else the name before the bracket.
fn head(value: &str) -> &str {
    let is_text = value.starts_with('"') || value.starts_with("r\"") || value.starts_with("r#");
    let end = if is_text { None } else { value.find(['(', '[', '{', '/']) };
    value[..end.unwrap_or(value.len())].trim()
}

/// A value on one line, without comments.
fn on_one_line(value: &str) -> String {
    let lines =
        value.lines().map(|line| if value.contains('\n') { line.split("//").next().unwrap_or(line) } else { line });
    lines.flat_map(str::split_whitespace).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn keys_that_differ_are_listed_once() {
        let source = |text: &str| Source::new("a.ron", "a", Path::new(""), text.to_owned());
        let first = source(
            "(k: 1.0, /* ( */ law: B(5.0), walls: [Disc(r: 1), Disc(r: 2)], step: Fixed( // s\n 1e-3), title: \"a(b\")",
        );
        let second =
            source("(k: 1.0, law: Restitution(5.0), walls: [Disc(r: 1), Disc(r: 3)], title: \"a(c\", seed: 1)");
        let found: Vec<_> = changes(&first, &second).into_iter().map(|c| (c.key, c.first, c.second)).collect();
        let text = |text: &str| Some(text.to_owned());
        assert_eq!(
            found,
            [
                ("law".to_owned(), text("B(5.0)"), text("Restitution(5.0)")),
                ("walls[1].r".to_owned(), text("2"), text("3")),
                ("step".to_owned(), text("Fixed( 1e-3)"), None),
                ("title".to_owned(), text("\"a(b\""), text("\"a(c\"")),
                ("seed".to_owned(), None, text("1")),
            ]
        );
        assert_eq!(changes(&first, &first), []);
    }
}
