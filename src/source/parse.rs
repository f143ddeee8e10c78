//! From text to [`Scene`](crate::scene::Scene): the one parse, and its errors as faults that point at key and value.

use ron::error::{Error, SpannedError};
use ron::extensions::Extensions;
use serde::de::DeserializeOwned;

use crate::fault::Fault;
use crate::source::places::Places;

/// How scenes are read: optional keys need no `Some`, and `LatticeGas((p: ...))` no second brackets.
#[must_use]
pub fn ron_options() -> ron::Options {
    ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME | Extensions::UNWRAP_VARIANT_NEWTYPES)
}

/// Parses `text`, the content of the file `name`.
///
/// # Errors
/// If it is not RON, or not a `T`.
pub fn parse<T: DeserializeOwned>(name: &str, text: &str) -> Result<T, Fault> {
    ron_options().from_str(text).map_err(|error| explain(name, text, &error, 0))
}

/// The fault for an error that ron met in a text whose part from byte `offset` on it was given.
#[must_use]
pub fn explain(name: &str, text: &str, error: &SpannedError, offset: usize) -> Fault {
    let places = Places::scan(text);
    let start = offset + byte_of(&text[offset..], error.span.start.line, error.span.start.col);
    let end = offset + byte_of(&text[offset..], error.span.end.line, error.span.end.col);
    // The end of the span is the last character that was read; a value's own end says more.
    let last = end.saturating_sub(1).max(start);
    let place = match &error.code {
        Error::MissingStructField { .. } => places.innermost_section(last),
        _ => places.innermost(last).or_else(|| places.innermost(start)),
    };
    let here = place.map_or("", |place| &place.path);
    let (code, key, message, help) = match place.map(|place| (&text[place.value.clone()], place.value.start)) {
        // ron reads `10.5` as 10, where a whole number is wanted, and then misses a comma.
        Some((value, from)) if from < start && !value.contains(['(', '[', '{']) && misses_separator(&error.code) => (
            "scene::wrong_type",
            here.to_owned(),
            format!("`{value}` is not of the type expected here"),
            "give a value of the right type; counts are whole numbers".to_owned(),
        ),
        _ => describe(&error.code, here),
    };
    let range = place.filter(|_| code != "scene::syntax").map_or(start..end, |place| {
        let whole = if code == "scene::unknown_key" { place.entry.clone() } else { place.value.clone() };
        // Of a long section only the beginning is marked.
        let line = text[whole.clone()].find('\n').unwrap_or(whole.len());
        whole.start..whole.start + line
    });
    let fault = Fault::new(code, message).help(help).at(name, text, range);
    if key.is_empty() { fault } else { fault.key(key) }
}

fn describe(error: &Error, here: &str) -> (&'static str, String, String, String) {
    let parent = here.rsplit_once('.').map_or("", |(parent, _)| parent);
    let child = |of: &str, key: &str| if of.is_empty() { key.to_owned() } else { format!("{of}.{key}") };
    let list = |names: &[&str]| names.join(", ");
    match error {
        Error::NoSuchStructField { expected, found, .. } => {
            // ron stops behind the unknown name: the place is the entry with that name, or its parent.
            let key = if here == found || here.ends_with(&format!(".{found}")) {
                here.to_owned()
            } else {
                child(here, found)
            };
            let help = format!("the keys here are: {}", list(expected));
            ("scene::unknown_key", key, "there is no such key".to_owned(), help)
        }
        Error::MissingStructField { field, .. } => {
            let message = format!("the key `{field}` is missing");
            ("scene::missing_key", child(here, field), message, format!("add `{field}: ...` here"))
        }
        Error::DuplicateStructField { field, .. } => {
            let key = if here.ends_with(field) { here.to_owned() } else { child(parent, field) };
            ("scene::duplicate_key", key, "the key stands here twice".to_owned(), "remove one of the two".to_owned())
        }
        Error::NoSuchEnumVariant { expected, found, .. } => (
            "scene::unknown_choice",
            here.to_owned(),
            format!("there is no choice `{found}`"),
            format!("the choices here are: {}", list(expected)),
        ),
        Error::Message(text) if text.starts_with("expected") => (
            "scene::out_of_range",
            here.to_owned(),
            text.clone(),
            "give a value in that range; units are SI".to_owned(),
        ),
        Error::InvalidValueForType { expected, found } => (
            "scene::wrong_type",
            here.to_owned(),
            format!("expected {expected}, got {found}"),
            "give a value of that type".to_owned(),
        ),
        Error::ExpectedFloat
        | Error::ExpectedInteger
        | Error::ExpectedBoolean
        | Error::ExpectedString
        | Error::ExpectedArray
        | Error::ExpectedMap
        | Error::ExpectedUnit
        | Error::ExpectedOption
        | Error::ExpectedStructLike
        | Error::ExpectedNamedStructLike(_)
        | Error::ExpectedDifferentStructName { .. }
        | Error::ExpectedDifferentLength { .. }
        | Error::IntegerOutOfBounds
        | Error::InvalidIntegerDigit { .. } => {
            ("scene::wrong_type", here.to_owned(), lower(&error.to_string()), "give a value of that type".to_owned())
        }
        other => (
            "scene::syntax",
            String::new(),
            lower(&other.to_string()),
            "is a bracket, a comma or a quote missing before this place?".to_owned(),
        ),
    }
}

fn misses_separator(error: &Error) -> bool {
    matches!(
        error,
        Error::ExpectedComma | Error::ExpectedStructLikeEnd | Error::ExpectedArrayEnd | Error::ExpectedMapEnd
    )
}

fn lower(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_lowercase().collect::<String>() + letters.as_str())
}

/// The byte offset of a line and column, both from 1, columns in characters.
fn byte_of(text: &str, line: usize, column: usize) -> usize {
    let start: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let start = start.min(text.len());
    text[start..].char_indices().nth(column.saturating_sub(1)).map_or(text.len(), |(offset, _)| start + offset)
}
