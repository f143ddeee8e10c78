//! Checks imports inside the crates; between crates the compiler does. A module imports only modules that stand above it in the table of
//! its crate in `ARCHITECTURE.md`, and no files of a crate import each other in a circle. A file may import what stands around it (its
//! parents), which is no part of a circle.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The crates with a table, by the heading of the table.
const CRATES: [(&str, &str); 7] = [
    ("siloflow-text", "crates/text/src"),
    ("siloflow-figures", "crates/figures/src"),
    ("siloflow-files", "crates/files/src"),
    ("siloflow-dem", "crates/dem/src"),
    ("siloflow-lattice", "crates/lattice/src"),
    ("siloflow-results", "crates/results/src"),
    ("siloflow", "src"),
];

/// The modules of a crate by path, such as `store::reorder`, each with the paths that it imports.
type Imports = BTreeMap<String, BTreeSet<String>>;

/// Returns a source without comments and without items that only tests have.
fn code(source: &str) -> String {
    let lines = source.lines().map(|line| line.split("//").next().unwrap_or_default());
    let mut code = lines.collect::<Vec<_>>().join("\n");
    while let Some(start) = code.find("#[cfg(test)]").or_else(|| code.find("#[cfg(all(test,")) {
        let end_of_item = |from: usize| {
            let mut depth = 0;
            for (at, c) in code[from..].char_indices() {
                match c {
                    '{' => depth += 1,
                    '}' if depth == 1 => return from + at + 1,
                    '}' => depth -= 1,
                    ';' if depth == 0 => return from + at + 1,
                    _ => {}
                }
            }
            code.len()
        };
        code.replace_range(start..end_of_item(start), "");
    }
    code
}

/// Adds the paths of an import, with braces expanded: `a::{b, c::d}` is `a::b` and `a::c::d`.
fn expand(prefix: &str, tree: &str, all: &mut BTreeSet<String>) {
    let Some((path, rest)) = tree.split_once('{') else {
        let path = tree.split(" as ").next().unwrap_or_default();
        all.insert(format!("{prefix}{}", path.trim()));
        return;
    };
    let prefix = format!("{prefix}{}", path.trim());
    let body = rest.rfind('}').map_or(rest, |end| &rest[..end]);
    let mut depth = 0;
    let parts = body.split(|c: char| {
        depth += match c {
            '{' => 1,
            '}' => -1,
            _ => 0,
        };
        c == ',' && depth == 0
    });
    parts.filter(|part| !part.trim().is_empty()).for_each(|part| expand(&prefix, part, all));
}

/// Returns the paths that a module imports from its own crate, without `crate::`.
fn imports(module: &str, source: &str) -> BTreeSet<String> {
    let code = code(source);
    let mut found = BTreeSet::new();
    for (at, start) in ["crate::", "super::"].into_iter().flat_map(|start| code.match_indices(start)) {
        let is_path = at > 0 && code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':' || c == '$');
        if is_path {
            continue;
        }
        let rest = &code[at..];
        let is_use = code[..at].trim_end().ends_with("use");
        let end =
            if is_use { rest.find(';') } else { rest.find(|c: char| !c.is_alphanumeric() && c != '_' && c != ':') };
        let mut written = BTreeSet::new();
        expand("", &rest[..end.unwrap_or(rest.len())].replace('\n', " "), &mut written);
        for path in written {
            let mut path = path.as_str();
            let mut parent = module;
            while let Some(rest) = path.strip_prefix("super::") {
                parent = parent.rsplit_once("::").map_or("", |(parent, _)| parent);
                path = rest;
            }
            found.insert(match path.strip_prefix("crate::") {
                Some(path) => path.to_owned(),
                None if start == "super::" && parent.is_empty() => path.to_owned(),
                None => format!("{parent}::{path}"),
            });
        }
    }
    found
}

/// Returns the modules of a crate with the modules that they import. Files of unit tests are left out.
fn of_crate(sources: &Path) -> Imports {
    let mut files = BTreeMap::new();
    collect(sources, "", &mut files);
    let read = |path: &PathBuf| fs::read_to_string(path).unwrap();
    let sources: BTreeMap<_, _> = files.iter().map(|(module, path)| (module.clone(), read(path))).collect();
    let deepest = |path: &str| {
        let ends = path.match_indices("::").map(|(end, _)| end).chain([path.len()]);
        ends.map(|end| path[..end].to_owned()).filter(|module| sources.contains_key(module)).last()
    };
    let of = |(module, source): (&String, &String)| {
        let paths = imports(module, source);
        let found = paths.iter().filter_map(|path| deepest(path)).filter(|other| other != module);
        (module.clone(), found.collect())
    };
    sources.iter().map(of).collect()
}

fn collect(directory: &Path, parent: &str, files: &mut BTreeMap<String, PathBuf>) {
    for entry in fs::read_dir(directory).unwrap().map(Result::unwrap) {
        let name = entry.file_name().into_string().unwrap();
        let own = name.strip_suffix(".rs").unwrap_or(&name).to_owned();
        let module = if parent.is_empty() { own.clone() } else { format!("{parent}::{own}") };
        if entry.path().is_dir() {
            collect(&entry.path(), &module, files);
        } else if own == "mod" {
            files.insert(parent.to_owned(), entry.path());
        } else if entry.path().extension().is_some_and(|ending| ending == "rs")
            && !["lib", "main", "tests"].contains(&&*own)
        {
            files.insert(module, entry.path());
        }
    }
}

/// Returns the modules in the first column of the table below a heading of `ARCHITECTURE.md`.
fn table(page: &str, heading: &str) -> Vec<String> {
    let rows = page.lines().skip_while(|line| *line != format!("### {heading}")).skip(1);
    let rows = rows.skip_while(|line| !line.starts_with('|')).skip(2).take_while(|line| line.starts_with('|'));
    rows.filter_map(|row| Some(row.split('|').nth(1)?.trim().trim_matches('`').to_owned())).collect()
}

/// Returns imports against the order of the table, and differences between table and crate.
fn against_the_table(table: &[String], imports: &Imports) -> Vec<String> {
    let top = |module: &str| module.split("::").next().unwrap_or_default().to_owned();
    let row = |module: &str| table.iter().position(|name| *name == top(module));
    let mut faults = Vec::new();
    for module in imports.keys().filter(|module| row(module).is_none()) {
        faults.push(format!("`{module}` is in no table"));
    }
    for name in table.iter().filter(|name| !imports.keys().any(|module| top(module) == **name)) {
        faults.push(format!("the table names `{name}`, which is no module"));
    }
    for (module, others) in imports {
        for other in others.iter().filter(|other| row(other) > row(module)) {
            faults.push(format!("`{module}` imports `{other}`, which stands below it in the table"));
        }
    }
    faults
}

/// Returns the modules that import each other in circles, beside those that a module imports from its parents.
fn circles(imports: &Imports) -> Vec<String> {
    let is_parent = |module: &str, other: &str| module.strip_prefix(other).is_some_and(|rest| rest.starts_with("::"));
    let mut left: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (module, others) in imports {
        left.insert(module, others.iter().map(|other| &**other).filter(|other| !is_parent(module, other)).collect());
    }
    // Modules without imports, and modules that nobody imports, are in no circle.
    loop {
        let imported: BTreeSet<&str> = left.values().flatten().copied().collect();
        let is_done = |(module, others): (&&str, &BTreeSet<&str>)| {
            !imported.contains(*module) || !others.iter().any(|other| left.contains_key(other))
        };
        let done: Vec<&str> = left.iter().filter(|entry| is_done(*entry)).map(|(module, _)| *module).collect();
        if done.is_empty() {
            return left.into_keys().map(str::to_owned).collect();
        }
        for module in done {
            left.remove(module);
        }
    }
}

#[test]
fn imports_follow_the_tables() {
    let page = fs::read_to_string(crate::root().join("ARCHITECTURE.md")).unwrap();
    for (name, sources) in CRATES {
        let imports = of_crate(&crate::root().join(sources));
        assert!(imports.len() > 5 && imports.values().any(|others| !others.is_empty()), "{name}: {imports:?}");
        assert_eq!(against_the_table(&table(&page, name), &imports), Vec::<String>::new(), "{name}");
    }
}

#[test]
fn files_import_each_other_in_no_circle() {
    for (name, sources) in CRATES {
        assert_eq!(circles(&of_crate(&crate::root().join(sources))), Vec::<String>::new(), "{name}");
    }
}

#[test]
fn wrong_imports_are_detected() {
    let source = "use crate::{door, rest::Rest};\n// crate::ledger\nfn f() { crate::cli::main() }\n#[cfg(test)]\nmod tests { use crate::energy; }\nuse super::grid::{Cell, size as length};\n";
    let found = imports("walls::mesh", source);
    assert_eq!(
        found.into_iter().collect::<Vec<_>>(),
        ["cli::main", "door", "rest::Rest", "walls::grid::Cell", "walls::grid::size"]
    );
    let of = |list: &[(&str, &[&str])]| -> Imports {
        list.iter()
            .map(|(module, others)| ((*module).to_owned(), others.iter().map(|other| (*other).to_owned()).collect()))
            .collect()
    };
    let table = ["a", "b"].map(str::to_owned);
    assert_eq!(against_the_table(&table, &of(&[("a", &["b"]), ("b::c", &["a"])])).len(), 1);
    assert_eq!(against_the_table(&table, &of(&[("a", &[]), ("c", &[])])).len(), 2);
    assert_eq!(circles(&of(&[("a", &["b"]), ("b", &["a::c"]), ("a::c", &["a"])])), Vec::<String>::new());
    assert_eq!(circles(&of(&[("a", &["b"]), ("b", &["c"]), ("c", &["b", "d"]), ("d", &[])])), ["b", "c"]);
}
