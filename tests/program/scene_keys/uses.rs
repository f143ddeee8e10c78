//! Finds the keys and choices that a text of RON uses, by the types of its values.

use std::collections::{BTreeMap, BTreeSet};

use siloflow_text::source::places::Places;

use super::types::{Choice, Types, Value};

/// The name of a key in reports.
pub fn key_name(of: &str, choice: Option<&str>, key: &str) -> String {
    choice.map_or_else(|| format!("{of}.{key}"), |choice| format!("{of}::{choice}.{key}"))
}

/// All keys of these types, and all choices with values.
pub fn all(types: &Types, names: &BTreeSet<String>) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for name in names {
        let of = &types[name];
        found.extend(of.keys.iter().map(|key| key_name(name, None, &key.name)));
        for choice in &of.choices {
            if !choice.values.is_empty() {
                found.insert(format!("{name}::{}", choice.name));
            }
            found.extend(choice.keys.iter().map(|key| key_name(name, Some(&choice.name), &key.name)));
        }
    }
    found
}

/// The keys and choices of a text whose root has this type.
pub fn of(types: &Types, root: &str, text: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut values = BTreeMap::from([(String::new(), Value::Typed(root.to_owned()))]);
    let mut choices = BTreeMap::<String, &Choice>::new();
    let places = Places::scan(text);
    for place in places.all() {
        let path = places.path(place);
        if !path.is_empty() {
            let end = path.rfind(['.', '[']).unwrap_or(0);
            let (parent, part) = (&path[..end], path[end..].trim_matches(['.', '[', ']']));
            let Some(value) = values.get(parent) else { continue };
            let Some(value) = inside(types, value, choices.get(parent).copied(), part, &mut found) else { continue };
            values.insert(path.clone(), value);
        }
        let Some(Value::Typed(name)) = values.get(&path) else { continue };
        let written = &text[place.value.clone()];
        let head = written.split(['(', '[', '{']).next().unwrap().trim();
        let is_this = |choice: &&Choice| choice.name == head || choice.aliases.iter().any(|alias| alias == head);
        let is_like = |choice: &&Choice| {
            choice.is_unnamed && written.starts_with('[') == matches!(choice.values[0], Value::List(_))
        };
        let of = &types[name];
        if let Some(choice) = of.choices.iter().find(is_this).or_else(|| of.choices.iter().find(is_like)) {
            found.insert(format!("{name}::{}", choice.name));
            choices.insert(path, choice);
        }
    }
    found
}

/// The type of a part of a value: of a key, an element, or an item by its number.
fn inside(
    types: &Types,
    value: &Value,
    choice: Option<&Choice>,
    part: &str,
    found: &mut BTreeSet<String>,
) -> Option<Value> {
    match value {
        Value::Plain(_) => None,
        Value::List(inner) | Value::Map(inner) => Some((**inner).clone()),
        Value::Tuple(parts) => parts.get(part.parse::<usize>().ok()?).cloned(),
        Value::Typed(name) => {
            if let Some(choice) = choice.filter(|choice| choice.is_unnamed) {
                return inside(types, &choice.values[0], None, part, found);
            }
            let of_choice = choice.iter().flat_map(|choice| &choice.keys).map(|key| (choice, key));
            let mut keys = of_choice.chain(types[name].keys.iter().map(|key| (None, key)));
            if let Some((choice, key)) =
                keys.find(|(_, key)| key.name == part || key.aliases.iter().any(|alias| alias == part))
            {
                found.insert(key_name(name, choice.map(|choice| &*choice.name), &key.name));
                return Some(key.value.clone());
            }
            // A choice of one value with keys has them in its own brackets.
            match (part.parse::<usize>(), &choice?.values[..]) {
                (Err(_), [value]) => inside(types, value, None, part, found),
                (number, values) => values.get(number.ok()?).cloned(),
            }
        }
    }
}
