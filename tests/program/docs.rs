//! The documentation: every link between pages leads somewhere, and every command that a page shows works.
//!
//! A fenced block of a page is marked by its language:
//!
//! | language | the block holds |
//! |---|---|
//! | `sh` | commands that this test runs, block after block, in a directory of its own for each page |
//! | `sh full` | commands that take minutes; run with `SILOFLOW_DOCS=full`, as `.ci/full` does |
//! | `sh full NAME ...` | the same, where these programs are installed |
//! | `text` after `sh` | what these commands print |
//! | `sh setup` | commands that build or install; `.ci/run` runs the important ones |
//! | `sh manual` | measurements of many minutes, or with programs that have to be built first; run by hand |
//!
//! Calls of the program in blocks that are not run must at least be calls that the program understands.
//!
//! `cargo run --release --` stands for the program under test. The test compares the output that pages show ([`transcripts`]) and figures in prose and
//! tables ([`values`]).

mod transcripts;
mod values;

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

use rayon::prelude::*;

/// All pages: paths from the root of the package.
fn pages() -> Vec<PathBuf> {
    fn collect(directory: &Path, pages: &mut Vec<PathBuf>) {
        for path in fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                collect(&path, pages);
            } else if path.extension().is_some_and(|ending| ending == "md") {
                pages.push(path);
            }
        }
    }
    let mut pages: Vec<_> =
        ["README.md", "ARCHITECTURE.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "python/README.md"]
            .map(|page| crate::root().join(page))
            .into();
    collect(&crate::root().join("docs"), &mut pages);
    pages.sort();
    pages
}

/// The name that a heading has in links, as code hosts derive it.
pub fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase().replace(' ', "-");
    kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, '-' | '_')).collect()
}

/// The text without fenced blocks, and those blocks with their language.
pub fn split(text: &str) -> (String, Vec<(String, String)>) {
    let mut prose = String::new();
    let mut blocks = Vec::<(String, String)>::new();
    let mut open = false;
    for line in text.lines() {
        if let Some(language) = line.trim_start().strip_prefix("```") {
            open = !open;
            if open {
                blocks.push((language.trim().to_owned(), String::new()));
            }
        } else if open {
            let (_, block) = blocks.last_mut().unwrap();
            *block += line;
            *block += "\n";
        } else {
            prose += line;
            prose += "\n";
        }
    }
    (prose, blocks)
}

fn anchors(page: &Path) -> BTreeSet<String> {
    let (prose, _) = split(&fs::read_to_string(page).unwrap());
    let headings = prose.lines().filter(|line| line.starts_with('#'));
    headings.map(|line| anchor(line.trim_start_matches('#'))).collect()
}

#[test]
fn every_link_between_pages_leads_somewhere() {
    let mut broken = Vec::new();
    for page in pages() {
        let (prose, _) = split(&fs::read_to_string(&page).unwrap());
        for rest in prose.split("](").skip(1) {
            let link = rest.split([')', ' ']).next().unwrap();
            if link.starts_with("http") || link.is_empty() {
                continue;
            }
            let (file, heading) = link.split_once('#').map_or((link, None), |(file, heading)| (file, Some(heading)));
            let target = if file.is_empty() { page.clone() } else { page.parent().unwrap().join(file) };
            let is_there = target.exists() && heading.is_none_or(|heading| anchors(&target).contains(heading));
            if !is_there {
                broken.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// The site has the pages of its summary (docs/site/build.py stops for the same reason, but is not run for every change).
#[test]
fn the_site_has_every_page_of_the_documentation() {
    let summary = fs::read_to_string(crate::root().join("docs/site/SUMMARY.md")).unwrap();
    let docs = crate::root().join("docs");
    let of_docs = pages().into_iter().filter_map(|page| Some(page.strip_prefix(&docs).ok()?.to_owned()));
    let without: Vec<_> = of_docs
        .filter(|page| !page.starts_with("site") && !summary.contains(&format!("](../{})", page.display())))
        .collect();
    assert!(without.is_empty(), "docs/site/SUMMARY.md has no line for {without:?}");
}

/// The commands of a block, with the program under test in place of a build of the package. Packages in `examples` find siloflow from their true place.
fn as_siloflow(block: &str) -> String {
    let examples = format!("--manifest-path {}/examples/", crate::root().display());
    block
        .replace("cargo run --release -- ", "siloflow ")
        .replace("target/release/siloflow", "siloflow")
        .replace("--manifest-path examples/", &examples)
}

/// The words of a call; what stands in single quotes is part of one.
fn words(call: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut is_quoted = false;
    for c in call.chars() {
        match c {
            '\'' => is_quoted = !is_quoted,
            c if c.is_whitespace() && !is_quoted => words.push(String::new()),
            c => words.last_mut().unwrap().push(c),
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Whether the program understands the calls that stand on lines of their own.
fn understood(block: &str) -> Result<(), String> {
    for line in as_siloflow(block).lines() {
        let call = line.split(" #").next().unwrap_or(line).split(" > ").next().unwrap_or(line).trim();
        let Some(arguments) = call.strip_prefix("siloflow ").filter(|rest| !rest.contains(['$', '|', '\\', ';']))
        else {
            continue;
        };
        // These two exist with the feature `shell` alone.
        if cfg!(not(feature = "shell")) && ["completions ", "man "].iter().any(|command| arguments.starts_with(command))
        {
            continue;
        }
        // The help is printed only if all arguments before it are right.
        let arguments = words(arguments);
        let output = Command::new(env!("CARGO_BIN_EXE_siloflow")).args(arguments).arg("--help").output().unwrap();
        if !output.status.success() {
            return Err(format!("`{call}` is not understood: {}", String::from_utf8_lossy(&output.stderr)));
        }
    }
    Ok(())
}

/// Whether a program is on the path. `.ci/full` tells which ones are missing.
fn is_installed(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|directory| directory.join(program).is_file())
}

/// Whether runs have the bits for which the pages were made.
const HAS_KNOWN_BITS: bool = cfg!(all(target_os = "linux", target_arch = "x86_64"));

/// Runs the commands of a page, and compares what it shows of their output.
fn run(page: &Path, full: bool) -> Result<(), String> {
    let text = fs::read_to_string(page).unwrap();
    let mut renewed = text.clone();
    let mut wrong = Vec::new();
    let mut printed: Option<String> = None;
    let mut has_left_out = false;
    let (_, blocks) = split(&text);
    let here = tempfile::tempdir().unwrap();
    for name in ["scenes", "assets", "examples"] {
        symlink(crate::root().join(name), here.path().join(name)).unwrap();
    }
    // A copy, because some commands write figures of the documentation.
    let copied = Command::new("cp").arg("-r").args([crate::root().join("docs"), here.path().join("docs")]).status();
    assert!(copied.unwrap().success());
    let programs = here.path().join("programs");
    fs::create_dir(&programs).unwrap();
    symlink(env!("CARGO_BIN_EXE_siloflow"), programs.join("siloflow")).unwrap();
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap_or_default());
    for (language, block) in blocks {
        match language.split_whitespace().collect::<Vec<_>>()[..] {
            ["sh"] => {}
            ["sh", "full", ref programs @ ..] if full && programs.iter().all(|program| is_installed(program)) => {}
            ["text"] => {
                if let Some(output) = printed.as_ref().filter(|_| HAS_KNOWN_BITS) {
                    if is_renewed() {
                        let new = transcripts::renewed(&block, output);
                        renewed = renewed.replace(&block, &new.map_err(|why| format!("{}: {why}", page.display()))?);
                    } else {
                        wrong.extend(transcripts::compare(&block, output).err());
                    }
                }
                continue;
            }
            ["sh", "setup"] => {
                understood(&block).map_err(|why| format!("{}: {why}", page.display()))?;
                continue;
            }
            ["sh", "full", ..] | ["sh", "manual"] => {
                printed = None;
                has_left_out = true;
                understood(&block).map_err(|why| format!("{}: {why}", page.display()))?;
                continue;
            }
            [other, ..] if other.starts_with("sh") || other == "bash" || other == "console" => {
                return Err(format!(
                    "{}: a block in `{language}`: write `sh`, `sh full`, `sh setup` or `sh manual`",
                    page.display()
                ));
            }
            _ => {
                printed = None;
                continue;
            }
        }
        let script = format!("exec 2>&1\n{}", as_siloflow(&block));
        let output = Command::new("sh").args(["-euc", &script]).current_dir(&here).env("PATH", &path).output().unwrap();
        let shown = transcripts::without_progress(&String::from_utf8_lossy(&output.stdout));
        if !output.status.success() {
            return Err(format!("{}: exit status {:?} of\n{block}{shown}", page.display(), output.status.code()));
        }
        printed = Some(shown);
    }
    if HAS_KNOWN_BITS {
        let found = values::values(&renewed, here.path(), crate::root(), !has_left_out);
        let (text, differing) = found.map_err(|why| format!("{}: {why}", page.display()))?;
        renewed = text;
        wrong.extend(differing);
    }
    if is_renewed() && renewed != text {
        fs::write(page, renewed).unwrap();
        return Ok(());
    }
    if wrong.is_empty() || is_renewed() { Ok(()) } else { Err(format!("{}: {}", page.display(), wrong.join("\n"))) }
}

/// Whether pages are rewritten.
fn is_renewed() -> bool {
    std::env::var_os("SILOFLOW_RENEW_PAGES").is_some()
}

#[test]
fn every_command_of_the_documentation_works() {
    let full = std::env::var_os("SILOFLOW_DOCS").is_some_and(|which| which == "full");
    // Of a single page, if its name is given.
    let only = std::env::var("SILOFLOW_PAGE").unwrap_or_default();
    let pages: Vec<_> = pages().into_iter().filter(|page| page.display().to_string().contains(&only)).collect();
    let failed: Vec<_> = pages.par_iter().filter_map(|page| run(page, full).err()).collect();
    assert!(failed.is_empty(), "{}", failed.join("\n\n"));
}

#[test]
fn anchors_are_derived_as_code_hosts_do() {
    assert_eq!(anchor(" What is `modelled`, and what not?"), "what-is-modelled-and-what-not");
}

/// Checks that a value has the properties that its schema lists, and no others.
fn fits(schema: &serde_json::Value, value: &serde_json::Value, path: &str) {
    if let (Some(properties), Some(object)) = (schema["properties"].as_object(), value.as_object()) {
        for key in schema["required"].as_array().unwrap() {
            assert!(object.contains_key(key.as_str().unwrap()), "{path}: `{key}` is missing");
        }
        for (key, inner) in object {
            let known = properties.get(key).unwrap_or_else(|| panic!("{path}: `{key}` is not in the schema"));
            fits(known, inner, &format!("{path}.{key}"));
        }
    }
    for inner in value.as_array().into_iter().flatten() {
        fits(&schema["items"], inner, &format!("{path}[]"));
    }
}

#[test]
fn summaries_fit_the_schema() {
    let page = crate::root().join("docs/reference/summary.schema.json");
    let schema: serde_json::Value = serde_json::from_str(&fs::read_to_string(page).unwrap()).unwrap();
    let here = tempfile::tempdir().unwrap();
    let discharge = ["--set", "spawner.count=12", "--set", "pictures=None"];
    let lossy = ["--set", "spawner.count=3", "--set", "pictures=None", "--until", "20"];
    let without_balance = ["--set", "spawner.count=3", "--set", "energy_balance=false", "--until", "0.5"];
    let frictional = ["--set", "fill[0].count=50", "--set", "pictures=None", "--until", "0.01"];
    for (scene, more) in [
        ("silo1.ron", &discharge[..]),
        ("silo1-literal.ron", &lossy),
        ("silo1.ron", &without_balance),
        ("silo3d.ron", &frictional),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_siloflow"))
            .arg("run")
            .arg(crate::scene(scene))
            .args(more)
            .args(["--json", "--quiet", "--force", "--out", "run"])
            .current_dir(&here)
            .output()
            .unwrap();
        let summary = serde_json::from_slice(&output.stdout).unwrap();
        fits(&schema, &summary, scene);
    }
}
