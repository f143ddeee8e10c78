//! The types that the files of users are made of: keys, choices, their documentation, whether they are needed.
//!
//! A type is named by its module and its name, `grains::fill::Fill`; names of crates are left out.

use std::collections::BTreeMap;

/// The kind of the value of a key.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A type of Rust, or a number or vector of `values`.
    Plain(String),
    /// A type with keys or choices, by its full name.
    Typed(String),
    List(Box<Value>),
    Map(Box<Value>),
    Tuple(Vec<Value>),
}

impl Value {
    /// The types inside.
    pub fn leaves(&self) -> Vec<&Self> {
        match self {
            Self::Plain(_) | Self::Typed(_) => vec![self],
            Self::List(inner) | Self::Map(inner) => inner.leaves(),
            Self::Tuple(parts) => parts.iter().flat_map(Self::leaves).collect(),
        }
    }
}

/// The value of a key that is left out.
#[derive(Clone, Debug, PartialEq)]
pub enum Absent {
    /// The key is needed.
    Fault,
    /// No value.
    Nothing,
    /// The default of its type.
    OfType,
    /// The value of this code.
    Code(String),
}

#[derive(Clone, Debug)]
pub struct Key {
    pub name: String,
    pub aliases: Vec<String>,
    pub doc: String,
    pub value: Value,
    pub absent: Absent,
}

/// A variant of an enum.
#[derive(Clone, Debug)]
pub struct Choice {
    pub name: String,
    pub aliases: Vec<String>,
    pub doc: String,
    pub is_unnamed: bool,
    pub is_default: bool,
    /// Values in brackets without keys.
    pub values: Vec<Value>,
    pub keys: Vec<Key>,
}

/// A struct has keys, an enum has choices. A wall has both: keys that walls of all shapes have.
#[derive(Clone, Debug, Default)]
pub struct Type {
    pub module: String,
    pub doc: String,
    pub choices: Vec<Choice>,
    pub keys: Vec<Key>,
}

impl Type {
    /// Whether the type is a list of words.
    pub fn is_words(&self) -> bool {
        self.keys.is_empty() && self.choices.iter().all(|choice| choice.values.is_empty() && choice.keys.is_empty())
    }

    /// The types of all keys and choices.
    pub fn leaves(&self) -> impl Iterator<Item = &Value> {
        let keys = self.choices.iter().flat_map(|choice| &choice.keys).chain(&self.keys);
        keys.map(|key| &key.value).chain(self.choices.iter().flat_map(|choice| &choice.values)).flat_map(Value::leaves)
    }
}

/// All types by their full names.
pub type Types = BTreeMap<String, Type>;
