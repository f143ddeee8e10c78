//! The table of a type for a page of reference: its keys and choices with values, units, defaults and meanings, all from the sources.

use std::collections::BTreeMap;

use super::comments::{Parts, agrees, parts, plain};
use super::types::{Absent, Choice, Key, Type, Types, Value};

/// Values of plain types in words.
const PLAIN: [(&str, &str); 24] = [
    ("Positive", "number > 0"),
    ("NonNegative", "number ≥ 0"),
    ("Finite", "number"),
    ("f64", "number"),
    ("Restitution", "number > 0, ≤ 1"),
    ("PoissonRatio", "number > −1, ≤ 0.5"),
    ("ImpactError", "number from 1e-9 to 0.1"),
    ("Share", "number from 0 to 1"),
    ("FiniteVector", "vector"),
    // A course of a motion is of a shift or of an angle.
    ("T", "vector or number"),
    ("bool", "`true` or `false`"),
    ("u8", "whole number"),
    ("u16", "whole number"),
    ("u32", "whole number"),
    ("u64", "whole number"),
    ("usize", "whole number"),
    ("NonZeroU8", "whole number > 0"),
    ("NonZeroU16", "whole number > 0"),
    ("NonZeroU32", "whole number > 0"),
    ("String", "text"),
    ("PathBuf", "path of a file"),
    ("RawValue", "any value"),
    ("ShapeNames", "name, or list of names"),
    ("Seeds", "list of whole numbers, or whole number"),
];

/// Plain types with a unit, unless the documentation tells that there is none.
const WITH_UNIT: [&str; 6] = ["Positive", "NonNegative", "Finite", "f64", "FiniteVector", "T"];

/// Words of a documentation whose number has no unit.
const WITHOUT_UNIT: [&str; 8] = [
    "dimensionless",
    "of any length",
    "of any non-zero length",
    "in units of",
    "of any unit",
    "in the unit of",
    "umber of",
    "probability",
];

const HEADER: &str = "value | unit | default | meaning |\n|---|---|---|---|---|\n";

/// Writes tables, and collects what is missing for them.
pub struct Tables<'a> {
    pub types: &'a Types,
    /// Heading and anchor of the table of each type.
    pub places: &'a BTreeMap<String, (String, String)>,
    pub faults: Vec<String>,
}

impl<'a> Tables<'a> {
    /// The table of a type, below a sentence about it.
    pub fn table(&mut self, name: &str) -> String {
        let Some(of) = self.types.get(name) else { panic!("there is no type {name}") };
        let about = plain(&of.doc);
        self.expect(!about.is_empty(), name, "has no documentation");
        let kind = if of.choices.is_empty() { "key" } else { "choice" };
        let mut table = format!("{about} Module `{}`.\n\n| {kind} | {HEADER}", of.module);
        for choice in &of.choices {
            table += &self.choice(name, choice);
        }
        if !of.choices.is_empty() && !of.keys.is_empty() {
            table += &row(["all of them", "", "", "", ""]);
        }
        for key in &of.keys {
            table += &self.key(name, key, if of.choices.is_empty() { "" } else { "– " });
        }
        table
    }

    fn choice(&mut self, of: &str, choice: &Choice) -> String {
        let place = format!("{of}::{}", choice.name);
        self.expect(!choice.doc.is_empty(), &place, "has no documentation");
        let Parts { text, unit, .. } = parts(&choice.doc);
        self.expect_unit(&place, choice.values.iter(), &unit, &text);
        let brackets = if choice.values.is_empty() && choice.keys.is_empty() { "" } else { "(...)" };
        let written = |name: &str| format!("`{name}{brackets}`");
        let cell = if choice.is_unnamed {
            "without a name".to_owned()
        } else {
            with_aliases(&choice.name, &choice.aliases, written)
        };
        let values: Vec<_> = choice.values.iter().map(|value| self.words(value)).collect();
        let first = row([&cell, &values.join(", "), &unit, "", &text]);
        choice.keys.iter().fold(first, |rows, key| rows + &self.key(&place, key, "– "))
    }

    fn key(&mut self, of: &str, key: &Key, indent: &str) -> String {
        let place = format!("{of}.{}", key.name);
        self.expect(!key.doc.is_empty(), &place, "has no documentation");
        let Parts { mut text, unit, default } = parts(&key.doc);
        self.expect_unit(&place, [&key.value].into_iter(), &unit, &text);
        let default = self.default(&place, key, default);
        let words = key.value.leaves().into_iter().filter_map(|it| self.words_type(it)).flat_map(|of| &of.choices);
        for choice in words.collect::<Vec<_>>() {
            self.expect(!choice.doc.is_empty(), &choice.name, "has no documentation");
            let meaning = plain(&choice.doc);
            if meaning.trim_end_matches('.') != choice.name {
                text = format!("{text} `{}`: {meaning}", choice.name);
            }
        }
        let cell = with_aliases(&key.name, &key.aliases, |name| format!("`{name}`"));
        row([&format!("{indent}{cell}"), &self.words(&key.value), &unit, &default, &text])
    }

    /// The cell of the default, which the code confirms.
    fn default(&mut self, place: &str, key: &Key, stated: Option<String>) -> String {
        match (&key.absent, stated) {
            (Absent::Fault, None) => return "*needed*".to_owned(),
            (Absent::Code(code), Some(stated)) => {
                self.expect(agrees(&stated, code), place, "states another default than the code");
                return stated;
            }
            (Absent::Nothing | Absent::OfType, Some(stated)) => return stated,
            (Absent::Nothing, None) => return "none".to_owned(),
            (Absent::OfType, None) => match &key.value {
                Value::List(_) | Value::Map(_) => return "none".to_owned(),
                Value::Plain(name) if name == "bool" => return "`false`".to_owned(),
                Value::Plain(name) if name == "String" => return "none".to_owned(),
                Value::Plain(name) if name.starts_with('u') => return "0".to_owned(),
                Value::Typed(name) if self.types[name].choices.is_empty() => return "see its keys".to_owned(),
                Value::Typed(name) => {
                    if let Some(choice) = self.types[name].choices.iter().find(|choice| choice.is_default) {
                        return format!("`{}`", choice.name);
                    }
                }
                _ => {}
            },
            (Absent::Code(code), None) if code.is_empty() || code.contains("::default()") => {
                return "see its keys".to_owned();
            }
            _ => {}
        }
        self.faults.push(format!("{place} states no default, or one although it is needed"));
        String::new()
    }

    /// A value in words, with links to the tables of types.
    fn words(&mut self, value: &Value) -> String {
        match value {
            Value::Plain(name) => {
                let words = PLAIN.iter().find(|(plain, _)| plain == name);
                self.expect(words.is_some(), name, "is a type without words");
                words.map_or(String::new(), |(_, words)| (*words).to_owned())
            }
            Value::Typed(name) => {
                if let Some(of) = self.words_type(value) {
                    return of.choices.iter().map(|choice| format!("`{}`", choice.name)).collect::<Vec<_>>().join(", ");
                }
                let place = self.places.get(name);
                self.expect(place.is_some(), name, "has no table");
                place.map_or(String::new(), |(heading, anchor)| {
                    let (first, rest) = heading.split_at(1);
                    format!("[{}{rest}](#{anchor})", first.to_lowercase())
                })
            }
            Value::List(inner) => {
                let words = self.words(inner);
                format!("list of {words}{}", if words.ends_with(char::is_alphabetic) { "s" } else { "" })
            }
            Value::Map(inner) => format!("`{{\"name\": ...}}` of {}", self.words(inner)),
            Value::Tuple(parts) => {
                format!("({})", parts.iter().map(|part| self.words(part)).collect::<Vec<_>>().join(", "))
            }
        }
    }

    /// The type of a value that is one of a few words.
    fn words_type(&self, value: &Value) -> Option<&'a Type> {
        let Value::Typed(name) = value else { return None };
        let types = self.types;
        types.get(name).filter(|of| of.is_words())
    }

    fn expect_unit<'v>(&mut self, place: &str, values: impl Iterator<Item = &'v Value>, unit: &str, text: &str) {
        let needs_unit = values
            .flat_map(Value::leaves)
            .any(|leaf| matches!(leaf, Value::Plain(name) if WITH_UNIT.contains(&&**name)));
        let has_none = WITHOUT_UNIT.iter().any(|words| text.contains(words));
        self.expect(!needs_unit || has_none || !unit.is_empty(), place, "has no unit");
    }

    fn expect(&mut self, holds: bool, place: &str, what: &str) {
        if !holds {
            self.faults.push(format!("{place} {what}"));
        }
    }
}

/// A row of a table.
fn row(cells: [&str; 5]) -> String {
    let cells = cells.map(|cell| if cell.is_empty() { " |".to_owned() } else { format!(" {cell} |") });
    format!("|{}\n", cells.concat())
}

/// A name with others that stand for it.
fn with_aliases(name: &str, aliases: &[String], written: impl Fn(&str) -> String) -> String {
    let others: Vec<_> = aliases.iter().map(|alias| written(alias)).collect();
    if others.is_empty() { written(name) } else { format!("{} (also {})", written(name), others.join(", ")) }
}
