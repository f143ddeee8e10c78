//! The documentation: every link between pages leads somewhere, and every command that a page shows works.
//!
//! A fenced block of a page is marked by its language:
//!
//! | language | the block holds |
//! |---|---|
//! | `sh` | commands that this test runs, block after block, in a directory of its own for each page |
//! | `sh full` | commands that take long or need other programs; run with `SILOFLOW_DOCS=full`, as `.ci/full` does |
//! | `sh setup` | commands that build or install; `.ci/run` runs them, or they are stated to be optional |
//!
//! `cargo run --release --` stands for the program under test.

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
        ["README.md", "ARCHITECTURE.md", "CHANGELOG.md"].map(|page| crate::root().join(page)).into();
    collect(&crate::root().join("docs"), &mut pages);
    pages.sort();
    pages
}

/// The name that a heading has in links, as code hosts derive it.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase().replace(' ', "-");
    kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, '-' | '_')).collect()
}

/// The text without fenced blocks, and those blocks with their language.
fn split(text: &str) -> (String, Vec<(String, String)>) {
    let (mut prose, mut blocks, mut open) = (String::new(), Vec::<(String, String)>::new(), false);
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

/// Runs the commands of a page.
fn run(page: &Path, full: bool) -> Result<(), String> {
    let (_, blocks) = split(&fs::read_to_string(page).unwrap());
    let here = tempfile::tempdir().unwrap();
    for name in ["scenes", "assets", "docs", "examples"] {
        symlink(crate::root().join(name), here.path().join(name)).unwrap();
    }
    let programs = here.path().join("programs");
    fs::create_dir(&programs).unwrap();
    symlink(env!("CARGO_BIN_EXE_siloflow"), programs.join("siloflow")).unwrap();
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap_or_default());
    for (language, block) in blocks {
        match language.as_str() {
            "sh" => {}
            "sh full" if full => {}
            "sh full" | "sh setup" => continue,
            other if other.starts_with("sh") || other == "bash" || other == "console" => {
                return Err(format!("{}: a block in `{other}`: write `sh`, `sh full` or `sh setup`", page.display()));
            }
            _ => continue,
        }
        let script =
            block.replace("cargo run --release -- ", "siloflow ").replace("target/release/siloflow", "siloflow");
        let output = Command::new("sh").args(["-euc", &script]).current_dir(&here).env("PATH", &path).output().unwrap();
        if !output.status.success() {
            return Err(format!(
                "{}: exit status {:?} of\n{block}{}",
                page.display(),
                output.status.code(),
                String::from_utf8_lossy(&output.stderr)
            ));
        }
    }
    Ok(())
}

#[test]
fn every_command_of_the_documentation_works() {
    let full = std::env::var_os("SILOFLOW_DOCS").is_some_and(|which| which == "full");
    let failed: Vec<_> = pages().par_iter().filter_map(|page| run(page, full).err()).collect();
    assert!(failed.is_empty(), "{}", failed.join("\n\n"));
}

#[test]
fn anchors_are_derived_as_code_hosts_do() {
    assert_eq!(anchor(" What is `modelled`, and what not?"), "what-is-modelled-and-what-not");
}
