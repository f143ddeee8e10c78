//! Parses the text of a scene, and turns parse errors into faults that point at key and value.

use std::ops::Range;

use ron::error::{Error, SpannedError};
use ron::extensions::Extensions;
use serde::de::DeserializeOwned;

use crate::fault::Fault;
use crate::safe::{LONGEST_QUOTATION, cut};
use crate::source::parameters::Resolved;
use crate::source::places::Places;
use crate::source::reference::{self, Section};
use crate::suggestion::did_you_mean;

/// RON options of scenes: optional keys need no `Some`, and `LatticeGas((p: ...))` needs no second brackets.
#[must_use]
pub fn ron_options() -> ron::Options {
    ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME | Extensions::UNWRAP_VARIANT_NEWTYPES)
}

/// Parses `text`, the content of the file `name`.
///
/// # Errors
/// If it is not RON, or not a `T`.
pub fn parse<T: DeserializeOwned>(name: &str, text: &str) -> Result<T, Fault> {
    parse_texts(Texts { name, written: text, resolved: None, reference: "" })
}

/// The text of a scene as it is written and as it is parsed. Faults show places of the written text.
#[derive(Clone, Copy)]
pub(super) struct Texts<'a> {
    /// Path of the file, for messages.
    pub name: &'a str,
    /// The scene's text.
    pub written: &'a str,
    /// The text with numbers in the place of expressions, if the scene has parameters.
    pub resolved: Option<&'a Resolved>,
    /// The page of reference for the keys.
    pub reference: &'a str,
}

impl<'a> Texts<'a> {
    /// The text to be parsed.
    pub(super) fn parsed(self) -> &'a str {
        self.resolved.map_or(self.written, |resolved| &resolved.text)
    }

    /// Points with a fault at a range of the parsed text.
    fn mark(self, fault: Fault, range: Range<usize>) -> Fault {
        let range = self.resolved.map_or(range.clone(), |resolved| resolved.written(range));
        fault.at(self.name, self.written, range)
    }
}

/// Parses the text of a scene.
pub(super) fn parse_texts<T: DeserializeOwned>(texts: Texts) -> Result<T, Fault> {
    if let Some(fault) = not_a_scene(texts) {
        return Err(fault);
    }
    ron_options()
        .from_str(texts.parsed())
        .map_err(|error| number_for_choice::<T>(texts, &error).unwrap_or_else(|| explain(texts, &error, 0)))
}

/// A fault if the text does not even begin like a RON structure: a grains file, for example.
fn not_a_scene(texts: Texts) -> Option<Fault> {
    let text = texts.parsed();
    let start = text.find(|c: char| !c.is_whitespace() && c != '\u{feff}')?;
    if text[start..].starts_with(['(', '#', '/']) || text[start..].starts_with(char::is_uppercase) {
        return None;
    }
    let end = text[start..].find('\n').map_or(text.len(), |end| start + end);
    let fault = Fault::new("scene::not_a_scene", "this is not a scene: a scene is RON text that begins with `(`");
    let help = "give a scene such as scenes/silo1.ron; a scene names its grains file by the key `grains.file`";
    Some(texts.mark(fault.help(help), start..end))
}

/// A name that no choice of any key has.
const NO_CHOICE: &str = "NoSuchChoice";

/// The fault for a number in a place where a choice is expected, such as `step: 1e-4`. The
/// choices come from a second parse, with a choice that does not exist in place of the number.
fn number_for_choice<T: DeserializeOwned>(texts: Texts, error: &SpannedError) -> Option<Fault> {
    let text = texts.parsed();
    let places = Places::scan(text);
    let place = places.innermost(byte_of(text, error.span.start.line, error.span.start.col))?;
    let number = text[place.value.clone()].trim();
    number.parse::<f64>().ok()?;
    let probe = format!("{}{NO_CHOICE}{}", &text[..place.value.start], &text[place.value.end..]);
    let Err(SpannedError { code: Error::NoSuchEnumVariant { expected, found, .. }, .. }) =
        ron_options().from_str::<T>(&probe)
    else {
        return None;
    };
    if found != NO_CHOICE {
        return None;
    }
    let help = if expected.contains(&"Fixed") {
        format!("write `Fixed({number})`")
    } else {
        format!("the choices here are: {}", expected.join(", "))
    };
    let fault = Fault::new("scene::wrong_type", format!("`{number}` is a number, and a choice is expected here"));
    Some(texts.mark(fault.help(help).key(places.path(place)), place.value.clone()))
}

/// The fault for a parse error. The parser was given the parsed text from byte `offset` on.
pub(super) fn explain(texts: Texts, error: &SpannedError, offset: usize) -> Fault {
    let text = texts.parsed();
    let places = Places::scan(text);
    let start = offset + byte_of(&text[offset..], error.span.start.line, error.span.start.col);
    let end = offset + byte_of(&text[offset..], error.span.end.line, error.span.end.col);
    // The span ends at the last character read; the end of the value is more useful.
    let last = end.saturating_sub(1).max(start);
    let place = match &error.code {
        Error::MissingStructField { .. } => places.innermost_section(last),
        _ => places.innermost(last).or_else(|| places.innermost(start)),
    };
    let here = place.map_or(String::new(), |place| places.path(place));
    let here = here.as_str();
    let (code, key, message, help) = match place.map(|place| (&text[place.value.clone()], place.value.start)) {
        // Where a whole number is expected, ron reads `10.5` as 10 and then reports a missing comma.
        Some((value, from)) if from < start && !value.contains(['(', '[', '{']) && misses_separator(&error.code) => (
            "scene::wrong_type",
            here.to_owned(),
            format!("`{value}` is not of the type expected here"),
            "give a value of the right type; counts are whole numbers".to_owned(),
        ),
        Some((value, _)) if value.starts_with("\"=") && texts.resolved.is_none() && expects_number(&error.code) => (
            "scene::wrong_type",
            here.to_owned(),
            format!("{value} is an expression, and the scene has no `parameters`"),
            "add `parameters: {}`, or named values as `parameters: {\"width\": 0.3}`".to_owned(),
        ),
        Some((section, _)) => describe(&error.code, texts.reference, Section { here, text: section, scene: text }),
        None => describe(&error.code, texts.reference, Section { here, text: "", scene: text }),
    };
    let range = place.filter(|_| code != "scene::syntax").map_or(start..end, |place| {
        let whole = if code == "scene::unknown_key" { place.entry.clone() } else { place.value.clone() };
        // Only the first line of a long section is marked.
        let line = text[whole.clone()].find('\n').unwrap_or(whole.len());
        whole.start..whole.start + line
    });
    let fault = texts.mark(Fault::new(code, message).help(help), range);
    if key.is_empty() { fault } else { fault.key(key) }
}

/// Returns code, key, message and help of an error in a section.
fn describe(error: &Error, reference: &str, section: Section) -> (&'static str, String, String, String) {
    let here = section.here;
    let parent = here.rsplit_once('.').map_or("", |(parent, _)| parent);
    let child = |of: &str, key: &str| if of.is_empty() { key.to_owned() } else { format!("{of}.{key}") };
    match error {
        Error::NoSuchStructField { expected, found, .. } => {
            // ron stops after the unknown name, so the place is the entry with that name, or its parent.
            let key = if here == found || here.ends_with(&format!(".{found}")) {
                here.to_owned()
            } else {
                child(here, found)
            };
            let help = did_you_mean("keys", found, expected);
            ("scene::unknown_key", key, "there is no such key".to_owned(), help)
        }
        Error::MissingStructField { field, .. } => {
            let message = format!("the key `{field}` is missing");
            ("scene::missing_key", child(here, field), message, reference::help(reference, field, section))
        }
        Error::DuplicateStructField { field, .. } => {
            let key = if here.ends_with(field) { here.to_owned() } else { child(parent, field) };
            ("scene::duplicate_key", key, "the key stands here twice".to_owned(), "remove one of the two".to_owned())
        }
        Error::NoSuchEnumVariant { expected, found, .. } => (
            "scene::unknown_choice",
            here.to_owned(),
            format!("there is no choice `{found}`"),
            did_you_mean("choices", found, expected),
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
            format!("expected {expected}, got {}", cut(found, LONGEST_QUOTATION)),
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
            let (message, help) = of_type(error);
            ("scene::wrong_type", here.to_owned(), message, help.to_owned())
        }
        other => (
            "scene::syntax",
            String::new(),
            lower(&other.to_string()),
            "is a bracket, a comma or a quote missing before this place?".to_owned(),
        ),
    }
}

/// Message and help for a value of another type, in words of a scene.
fn of_type(error: &Error) -> (String, &'static str) {
    let (wanted, help) = match error {
        Error::ExpectedFloat => ("a number", "write a number, such as `0.5` or `1.0e-3`, without quotes; units are SI"),
        Error::ExpectedInteger => {
            ("a whole number", "write a whole number, such as `1000`, without a point and quotes")
        }
        Error::ExpectedBoolean => ("`true` or `false`", "write one of the two, without quotes"),
        Error::ExpectedString => ("a text in quotes", "write it in double quotes: `\"...\"`"),
        Error::ExpectedArray => {
            ("a list or a vector", "write a list as `[a, b]`, and a vector as `(x, y)` or `(x, y, z)`")
        }
        Error::ExpectedMap => ("named entries", "write them as `{\"name\": value, ...}`"),
        _ => return (lower(&error.to_string()), "give a value of that type"),
    };
    (format!("expected {wanted}"), help)
}

fn expects_number(error: &Error) -> bool {
    matches!(error, Error::ExpectedFloat | Error::ExpectedInteger)
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

/// The byte offset of a line and column, both counted from 1; columns count characters.
fn byte_of(text: &str, line: usize, column: usize) -> usize {
    let start: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    let start = start.min(text.len());
    text[start..].char_indices().nth(column.saturating_sub(1)).map_or(text.len(), |(offset, _)| start + offset)
}
