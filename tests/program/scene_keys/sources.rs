//! Reads types from the sources of the repository with `syn`.

use std::fs;
use std::path::Path;

use syn::{Field, Fields, Item, UseTree, Variant};

use super::attributes::{doc, is_read, serde};
use super::types::{Absent, Choice, Key, Type, Types, Value};

/// Sources of the crates whose types are read.
const SOURCES: [&str; 5] = ["src", "crates/dem/src", "crates/figures/src", "crates/lattice/src", "crates/results/src"];

/// A type without `derive(Deserialize)` that reads itself in the form in which it is written.
const READS_ITSELF: &str = "Moment";

/// A choice of that type whose name is not written.
const UNNAMED: &str = "At";

/// Reads the types of the repository.
pub fn read(root: &Path) -> Types {
    let mut sources = Vec::new();
    for folder in SOURCES {
        collect(&root.join(folder), "", &mut sources);
    }
    let names: Vec<_> = sources.iter().flat_map(Source::names).collect();
    let mut types: Types = sources.iter().flat_map(|source| source.types(&names)).collect();
    // A wall is one value with the keys of its shape and those of every wall.
    let shapes = types.remove("walls::config::shape::WallShape").unwrap();
    let wall = types.get_mut("walls::config::Wall").unwrap();
    wall.choices = shapes.choices;
    wall.keys.retain(|key| key.name != "shape");
    types
}

fn collect(folder: &Path, module: &str, sources: &mut Vec<Source>) {
    for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let name = path.file_stem().unwrap().to_string_lossy();
        let module = if name == "mod" { module.to_owned() } else { format!("{module}::{name}") };
        if path.is_dir() {
            collect(&path, &module, sources);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            let file = syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            sources.push(Source { module: module.trim_start_matches(':').to_owned(), text, items: file.items });
        }
    }
}

/// A source file.
struct Source {
    module: String,
    text: String,
    items: Vec<Item>,
}

impl Source {
    /// The full names of the types of the file that serde reads.
    fn names(&self) -> Vec<String> {
        let names = self.items.iter().filter_map(|item| match item {
            Item::Struct(it) if is_read(&it.attrs) => Some(&it.ident),
            Item::Enum(it) if is_read(&it.attrs) || it.ident == READS_ITSELF => Some(&it.ident),
            _ => None,
        });
        names.map(|name| format!("{}::{name}", self.module)).collect()
    }

    fn types(&self, names: &[String]) -> Vec<(String, Type)> {
        let mut types = Vec::new();
        let mut add = |name: String, doc: String, choices: Vec<Choice>, keys: Vec<Key>| {
            types.push((format!("{}::{name}", self.module), Type { module: self.module.clone(), doc, choices, keys }));
        };
        for item in &self.items {
            match item {
                Item::Struct(it) if is_read(&it.attrs) => {
                    let settings = serde(&it.attrs);
                    let code = self.code(&format!("\nimpl Default for {} ", it.ident));
                    let absent = match (settings.contains_key("default"), settings.contains_key("from")) {
                        (true, _) if !code.is_empty() => Some(Absent::Code(code)),
                        (is_default, is_converted) => (is_default || is_converted).then_some(Absent::OfType),
                    };
                    add(
                        it.ident.to_string(),
                        doc(&it.attrs),
                        Vec::new(),
                        self.keys(names, &it.fields, absent.as_ref()),
                    );
                }
                Item::Enum(it) if is_read(&it.attrs) || it.ident == READS_ITSELF => {
                    let is_untagged = serde(&it.attrs).contains_key("untagged");
                    let mut choices: Vec<_> = it.variants.iter().map(|variant| self.choice(names, variant)).collect();
                    for choice in &mut choices {
                        choice.is_unnamed = is_untagged || it.ident == READS_ITSELF && choice.name == UNNAMED;
                    }
                    add(it.ident.to_string(), doc(&it.attrs), choices, Vec::new());
                }
                Item::Macro(it) if it.mac.path.is_ident("wall_shapes") => {
                    let variants = it.mac.parse_body_with(variants).unwrap();
                    let choices = variants.iter().map(|variant| self.choice(names, variant)).collect();
                    add("WallShape".to_owned(), String::new(), choices, Vec::new());
                }
                _ => {}
            }
        }
        types
    }

    fn choice(&self, names: &[String], variant: &Variant) -> Choice {
        let settings = serde(&variant.attrs);
        let has_names = matches!(variant.fields, Fields::Named(_));
        Choice {
            name: settings.get("rename").and_then(|it| it.first().cloned()).unwrap_or(variant.ident.to_string()),
            aliases: settings.get("alias").cloned().unwrap_or_default(),
            doc: doc(&variant.attrs),
            is_unnamed: false,
            is_default: variant.attrs.iter().any(|attribute| attribute.path().is_ident("default")),
            values: variant.fields.iter().filter(|_| !has_names).map(|field| self.value(names, &field.ty)).collect(),
            keys: if has_names { self.keys(names, &variant.fields, None) } else { Vec::new() },
        }
    }

    /// The keys of a struct or variant, whose defaults may stand in one place.
    fn keys(&self, names: &[String], fields: &Fields, absent: Option<&Absent>) -> Vec<Key> {
        let is_key = |field: &&Field| field.ident.is_some() && !serde(&field.attrs).contains_key("skip");
        let key = |field: &Field| {
            let settings = serde(&field.attrs);
            let name = settings.get("rename").and_then(|it| it.first().cloned());
            let is_option =
                matches!(&field.ty, syn::Type::Path(it) if it.path.segments.last().unwrap().ident == "Option");
            let function = settings.get("default").and_then(|it| it.first());
            Key {
                name: name.unwrap_or(field.ident.as_ref().unwrap().to_string()),
                aliases: settings.get("alias").cloned().unwrap_or_default(),
                doc: doc(&field.attrs),
                value: self.value(names, &field.ty),
                absent: match (function, absent) {
                    (Some(function), _) => Absent::Code(self.code(&format!("\nfn {function}("))),
                    (None, Some(Absent::Code(code))) if is_option && is_none(code, field) => Absent::Nothing,
                    (None, Some(Absent::Code(code))) => Absent::Code(code.clone()),
                    _ if is_option => Absent::Nothing,
                    _ if absent.is_some() || settings.contains_key("default") => Absent::OfType,
                    _ => Absent::Fault,
                },
            }
        };
        fields.iter().filter(is_key).map(key).collect()
    }

    /// The code of an item of the file, with the constants of the file; empty if it is elsewhere.
    fn code(&self, start: &str) -> String {
        let Some((_, rest)) = self.text.split_once(start) else { return String::new() };
        let constants = self.text.split("const ").skip(1).filter_map(|rest| rest.split(';').next());
        let lines = rest.lines().take_while(|line| *line != "}");
        constants.chain(lines).collect::<Vec<_>>().join("\n")
    }

    fn value(&self, names: &[String], ty: &syn::Type) -> Value {
        if let syn::Type::Tuple(tuple) = ty {
            return Value::Tuple(tuple.elems.iter().map(|part| self.value(names, part)).collect());
        }
        let syn::Type::Path(path) = ty else { return Value::Plain("another".to_owned()) };
        let last = path.path.segments.last().unwrap();
        let name = last.ident.to_string();
        let inner = match &last.arguments {
            syn::PathArguments::AngleBracketed(arguments) => match arguments.args.last() {
                Some(syn::GenericArgument::Type(inner)) => Some(self.value(names, inner)),
                _ => None,
            },
            _ => None,
        };
        match (&*name, inner) {
            ("Option" | "Box", Some(inner)) => inner,
            ("Vec", Some(inner)) => Value::List(Box::new(inner)),
            ("BTreeMap", Some(inner)) => Value::Map(Box::new(inner)),
            _ => self.full_name(names, &name).map_or(Value::Plain(name), Value::Typed),
        }
    }

    /// The full name of a type that the file names, if serde reads it.
    fn full_name(&self, names: &[String], name: &str) -> Option<String> {
        let end = format!("::{name}");
        let found: Vec<_> = names.iter().filter(|full| full.ends_with(&end)).collect();
        let own = format!("{}{end}", self.module);
        if found.contains(&&own) {
            return Some(own);
        }
        if found.len() < 2 {
            return found.first().map(|full| (*full).clone());
        }
        let imported = self.items.iter().find_map(|item| match item {
            Item::Use(it) => imported(&it.tree, name),
            _ => None,
        });
        // The first part is the name of a crate.
        let imported = imported.and_then(|path| Some(path.split_once("::")?.1.to_owned()));
        Some(imported.unwrap_or_else(|| panic!("{}: several types have the name {name}", self.module)))
    }
}

/// The path of a name that a `use` brings into a file.
fn imported(tree: &UseTree, name: &str) -> Option<String> {
    match tree {
        UseTree::Path(path) => imported(&path.tree, name).map(|rest| format!("{}::{rest}", path.ident)),
        UseTree::Group(group) => group.items.iter().find_map(|tree| imported(tree, name)),
        UseTree::Name(it) => (it.ident == name).then(|| name.to_owned()),
        _ => None,
    }
}

/// Whether the code of a default leaves a field out.
fn is_none(code: &str, field: &Field) -> bool {
    field.ident.as_ref().is_some_and(|name| code.contains(&format!("{name}: None")))
}

/// Parses variants without commas between them.
fn variants(input: syn::parse::ParseStream) -> syn::Result<Vec<Variant>> {
    let mut variants = Vec::new();
    while !input.is_empty() {
        variants.push(input.parse()?);
    }
    Ok(variants)
}
