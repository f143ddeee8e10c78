//! The tables of keys in pages of reference: every key of every type that a file of a user is made of, as its source documents it.
//!
//! A table stands between the lines `<!-- keys: Spawner -->` and `<!-- end -->`, where the first names the type, below a heading to which other tables
//! link. This command writes the tables anew:
//!
//! ```sh
//! SILOFLOW_RENEW_TABLES=1 cargo test --release --test program scene_keys
//! ```
//!
//! Every key, and every choice with values, stands in a shipped file or in an example of a page. Examples are blocks in `ron`, with blank lines between
//! several; the program reads them.

mod attributes;
mod comments;
mod sources;
mod tables;
mod types;
mod uses;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use siloflow::lattice_silo::scene::LatticeScene;
use siloflow::scene::Scene;
use siloflow::studies::study::plan::StudyPlan;
use siloflow::studies::sweep::plan::SweepPlan;
use siloflow_text::fault::Fault;
use siloflow_text::source::Source;
use siloflow_text::source::places::Places;

use self::tables::Tables;
use self::types::{Types, Value};

const RENEW: &str = "SILOFLOW_RENEW_TABLES";

const SCENES: &str = "docs/reference/scene-file.md";
const SWEEPS: &str = "docs/reference/sweep-file.md";

/// A kind of files.
struct Root {
    /// The page with its keys.
    page: &'static str,
    /// The type of a file.
    name: &'static str,
    /// A text that tells its files from those of the kinds below.
    sign: &'static str,
    /// Reads a file.
    read: fn(&str) -> Result<(), Fault>,
}

const ROOTS: [Root; 4] = [
    Root {
        page: SCENES,
        name: "lattice_silo::scene::LatticeScene",
        sign: "method: LatticeGas(",
        read: read::<LatticeScene>,
    },
    Root { page: SCENES, name: "studies::study::plan::StudyPlan", sign: "variants: [", read: read::<StudyPlan> },
    Root { page: SWEEPS, name: "studies::sweep::plan::SweepPlan", sign: "figures: [", read: read::<SweepPlan> },
    Root { page: SCENES, name: "scene::Scene", sign: "", read: read_grains },
];

fn read<T: DeserializeOwned>(text: &str) -> Result<(), Fault> {
    Source::new("an example", "example", Path::new(""), text.to_owned()).parse::<T>(&[]).map(drop)
}

/// Reads keys of a scene of grains, with the keys that every such scene needs.
fn read_grains(text: &str) -> Result<(), Fault> {
    let needed = [
        ("gravity", "(0.0, -9.81)"),
        ("contact", "Assignment(k: 1.0e5, b: 1.0)"),
        ("step", "Fixed(1.0e-4)"),
        ("until", "1.0"),
    ];
    let places = Places::scan(text);
    let missing = needed.iter().filter(|(key, _)| places.get(key).is_none());
    let missing: Vec<_> = missing.map(|(key, value)| format!("{key}: {value}, ")).collect();
    read::<Scene>(&text.replacen('(', &format!("({}", missing.concat()), 1))
}

/// The types with tables in a page: those that its files may hold.
fn reachable(types: &Types, page: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let roots = ROOTS.iter().filter(|root| root.page == page);
    let mut next: Vec<String> = roots.map(|root| root.name.to_owned()).collect();
    while let Some(name) = next.pop() {
        if found.insert(name.clone()) {
            next.extend(types[&name].leaves().filter_map(|leaf| match leaf {
                Value::Typed(inner) => Some(inner.clone()),
                _ => None,
            }));
        }
    }
    found.retain(|name| !types[name].is_words());
    found
}

/// A piece of a page: text that ends with a mark, then a table of this type.
struct Piece<'a> {
    before: &'a str,
    name: &'a String,
}

/// Returns the pieces of a page with tables of these types, and the rest.
fn pieces<'a>(types: &'a BTreeSet<String>, text: &'a str) -> (Vec<Piece<'a>>, &'a str) {
    let mut pieces = Vec::new();
    let mut rest = text;
    while let Some((_, after)) = rest.split_once("<!-- keys: ") {
        let (short, after) = after.split_once(" -->\n").expect("the end of the mark");
        let end = format!("::{short}");
        let mut names: Vec<_> = types.iter().filter(|name| *name == short || name.ends_with(&end)).collect();
        // A whole name may be the end of another one.
        if types.contains(short) {
            names.retain(|name| *name == short);
        }
        assert!(names.len() == 1, "the mark {short} stands for {names:?}");
        pieces.push(Piece { before: &rest[..rest.len() - after.len()], name: names[0] });
        rest = &after[after.find("<!-- end -->").expect("the second mark")..];
    }
    (pieces, rest)
}

/// Returns the last heading of a text and its anchor.
fn heading(text: &str) -> (String, String) {
    let line = text.lines().rev().find(|line| line.starts_with('#')).expect("a heading above each table");
    let heading = line.trim_start_matches('#').trim();
    (heading.to_owned(), crate::docs::anchor(heading))
}

/// Returns a page with new tables, and what is missing.
fn renewed(types: &Types, page: &str, text: &str) -> (String, Vec<String>) {
    let wanted = reachable(types, page);
    let (pieces, rest) = pieces(&wanted, text);
    let places: BTreeMap<_, _> = pieces.iter().map(|piece| (piece.name.clone(), heading(piece.before))).collect();
    let mut tables = Tables { types, places: &places, faults: Vec::new() };
    let new: Vec<_> = pieces.iter().map(|piece| format!("{}{}", piece.before, tables.table(piece.name))).collect();
    let mut faults = tables.faults;
    faults.extend(wanted.iter().filter(|name| !places.contains_key(*name)).map(|name| format!("{name} has no table")));
    faults.sort();
    faults.dedup();
    (new.concat() + rest, faults)
}

#[test]
fn pages_have_every_key_as_its_source_documents_it() {
    let types = sources::read(crate::root());
    for page in [SCENES, SWEEPS] {
        let path = crate::root().join(page);
        let text = fs::read_to_string(&path).unwrap();
        let (new, faults) = renewed(&types, page, &text);
        assert!(faults.is_empty(), "{page}:\n{}", faults.join("\n"));
        if std::env::var_os(RENEW).is_some() {
            fs::write(&path, new).unwrap();
        } else if let Some((found, wanted)) = text.lines().zip(new.lines()).find(|(found, wanted)| found != wanted) {
            panic!("{page} has\n{found}\nin place of\n{wanted}\n{RENEW}=1 renews the tables");
        } else {
            assert_eq!(text, new, "{RENEW}=1 renews the tables");
        }
    }
}

/// The shipped files below a folder, without those with faults.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let inside = |path: PathBuf| if path.is_dir() && !path.ends_with("bad") { files(&path) } else { vec![path] };
    entries.flat_map(inside).filter(|path| path.extension().is_some_and(|ending| ending == "ron")).collect()
}

/// The examples of the pages, each in brackets.
fn examples() -> Vec<String> {
    let blocks =
        [SCENES, SWEEPS].map(|page| crate::docs::split(&fs::read_to_string(crate::root().join(page)).unwrap()).1);
    let blocks = blocks.iter().flatten().filter(|(language, _)| language == "ron");
    let examples = blocks.flat_map(|(_, block)| block.trim().split("\n\n"));
    examples.map(|text| if text.starts_with("(\n") { text.to_owned() } else { format!("(\n{text}\n)") }).collect()
}

fn root_of(text: &str) -> &'static Root {
    ROOTS.iter().find(|root| text.contains(root.sign)).unwrap()
}

#[test]
fn every_key_has_an_example() {
    let types = sources::read(crate::root());
    let names: BTreeSet<_> = [SCENES, SWEEPS].iter().flat_map(|page| reachable(&types, page)).collect();
    let mut without = uses::all(&types, &names);
    let shipped = files(&crate::root().join("scenes")).into_iter().map(|path| fs::read_to_string(path).unwrap());
    for text in shipped.chain(examples()) {
        for used in uses::of(&types, root_of(&text).name, &text) {
            without.remove(&used);
        }
    }
    let without: Vec<_> = without.into_iter().collect();
    assert!(without.is_empty(), "no shipped file and no example of a page has\n{}", without.join("\n"));
}

#[test]
fn the_program_reads_every_example() {
    for text in examples() {
        (root_of(&text).read)(&text).unwrap_or_else(|fault| panic!("{text}\n{fault}"));
    }
}
