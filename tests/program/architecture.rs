//! Checks the layers of `ARCHITECTURE.md`: every module of `src` and of the kernel is in one layer, imports follow the direction, and no
//! imports form a cycle. The crate of the automaton counts as one module.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// The sources of each crate, and the module that they belong to if the crate counts as one.
const SOURCES: [(&str, Option<&str>); 3] =
    [("src", None), ("crates/dem/src", None), ("crates/lattice/src", Some("automaton"))];

/// Returns the layer of each module from the first table of `ARCHITECTURE.md`: its number, counted from the lowest.
fn layers(page: &str) -> BTreeMap<String, usize> {
    let rows = page.lines().skip_while(|line| !line.starts_with("| layer |")).skip(2);
    let rows = rows.take_while(|line| line.starts_with('|')).enumerate();
    let modules = rows.flat_map(|(layer, row)| row.split('`').skip(1).step_by(2).map(move |name| (name, layer)));
    modules.map(|(name, layer)| (name.to_owned(), layer)).collect()
}

/// Returns a source without comments and without its unit tests, which may import any module.
fn code(source: &str) -> String {
    let lines = source.lines().take_while(|line| !line.starts_with("#[cfg(test)]"));
    lines.map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// Returns the modules that a source imports: all names after `crate::` and `siloflow_kernel::`, including names in braces, and
/// `automaton` for the crate of the automaton.
fn imports(source: &str) -> BTreeSet<String> {
    let word = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    let code = code(source);
    let code = code.replace("siloflow_automaton::", "crate::automaton::").replace("siloflow_kernel::", "crate::");
    let after = code.split("crate::").skip(1);
    let names = after.flat_map(|rest| match rest.strip_prefix('{') {
        Some(list) => list.split('}').next().unwrap_or_default().split(',').map(|name| word(name.trim())).collect(),
        None => vec![word(rest)],
    });
    names.collect()
}

/// The imports of each module, each with one file that contains it.
type Imports = BTreeMap<String, BTreeMap<String, String>>;

/// Collects the imports of the files below a directory. They belong to `module`, or to the module named by the file if
/// `module` is `None`.
fn read(directory: &Path, module: Option<&str>, all: &mut Imports) {
    for entry in fs::read_dir(directory).unwrap().map(Result::unwrap) {
        let path = entry.path();
        let name = entry.file_name().into_string().unwrap();
        let own = name.strip_suffix(".rs").unwrap_or(&name);
        let module = module.unwrap_or(own);
        if path.is_dir() {
            read(&path, Some(module), all);
        } else if !["lib", "main"].contains(&module) {
            let of_module = all.entry(module.to_owned()).or_default();
            for other in imports(&fs::read_to_string(&path).unwrap()).into_iter().filter(|other| other != module) {
                of_module.entry(other).or_insert_with(|| path.display().to_string());
            }
        }
    }
}

/// Returns all faults: modules without a layer, imports against the direction, and cycles.
fn faults(layers: &BTreeMap<String, usize>, imports: &Imports) -> Vec<String> {
    let mut faults = Vec::new();
    for module in imports.keys().filter(|module| !layers.contains_key(*module)) {
        faults.push(format!("`{module}` is in no layer of ARCHITECTURE.md"));
    }
    for module in layers.keys().filter(|module| !imports.contains_key(*module)) {
        faults.push(format!("ARCHITECTURE.md names `{module}`, which is no module"));
    }
    for (module, others) in imports {
        for (other, file) in others.iter().filter(|(other, _)| layers.get(*other) > layers.get(module)) {
            faults.push(format!("`{module}` imports `{other}` of a higher layer, in {file}"));
        }
    }
    // A module that is in no cycle can be removed once all modules that it imports are removed.
    let mut left: BTreeMap<&str, BTreeSet<&str>> =
        imports.iter().map(|(module, others)| (&**module, others.keys().map(|other| &**other).collect())).collect();
    while let Some(done) = left.iter().find(|(_, others)| !others.iter().any(|other| left.contains_key(other))) {
        let done = *done.0;
        left.remove(done);
    }
    if !left.is_empty() {
        faults.push(format!("imports form a cycle among {:?}", left.keys().collect::<Vec<_>>()));
    }
    faults
}

fn of_the_crate() -> (BTreeMap<String, usize>, Imports) {
    let mut imports = Imports::new();
    for (sources, module) in SOURCES {
        read(&crate::root().join(sources), module, &mut imports);
    }
    let page = fs::read_to_string(crate::root().join("ARCHITECTURE.md")).unwrap();
    let layers = layers(&page);
    // A name that is not a module is an item of the crate's root, such as `prelude`.
    for others in imports.values_mut() {
        others.retain(|other, _| layers.contains_key(other));
    }
    (layers, imports)
}

#[test]
fn imports_follow_the_layers() {
    let (layers, imports) = of_the_crate();
    assert!(imports.len() > 30 && imports.values().map(BTreeMap::len).sum::<usize>() > 100, "{imports:?}");
    assert_eq!(faults(&layers, &imports), Vec::<String>::new());
}

#[test]
fn wrong_import_is_detected() {
    let (layers, imports) = of_the_crate();
    let with = |module: &str, other: &str| {
        let mut imports = imports.clone();
        imports.get_mut(module).unwrap().insert(other.to_owned(), format!("src/{module}.rs"));
        faults(&layers, &imports)
    };
    let upward = with("store", "cli");
    assert!(upward.contains(&"`store` imports `cli` of a higher layer, in src/store.rs".to_owned()), "{upward:?}");
    let within = with("neighbours", "survey");
    assert!(within.len() == 1 && within[0].starts_with("imports form a cycle"), "{within:?}");
    assert_eq!(layers.get("store"), Some(&1));
    let text = "use crate::{door, rest::Rest};\n// crate::ledger\nfn f() { crate::cli::main() }\n#[cfg(test)]\nuse crate::energy;";
    assert_eq!(imports_of(text), ["cli", "door", "rest"]);
}

fn imports_of(text: &str) -> Vec<String> {
    imports(text).into_iter().collect()
}
