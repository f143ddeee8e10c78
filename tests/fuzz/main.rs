//! Fuzz targets: every text that a user can give either is accepted or causes a fault that can be shown. No text may cause a panic.
//!
//! | target | input |
//! |---|---|
//! | `scene` | a scene of either method; an accepted one that is small does three steps |
//! | `silo` | a silo file: the text, and its characters as bytes of a text in any encoding |
//! | `grains` | a grain file |
//! | `mesh` | a mesh: the text as an OBJ and as an STL file, and its characters as the bytes of both; with an accepted one, spheres do three steps |
//! | `setting` | the two sides of `--set PATH=VALUE` |
//! | `picture` | an SVG document for `render` |
//! | `checkpoint` | a saved state and the file of one, with bytes changed, cut or repeated; a state that is not refused does three steps; it has no corpus, because a checkpoint belongs to the version that wrote it: its seeds are states of scenes with walls, doors, meshes and feeds, and of a gas |
//!
//! `corpus/TARGET` holds the inputs from which mutants are made, among them every input that once failed. A test runs all of
//! them unchanged. bolero makes the mutants: under `cargo test` a short run of random ones, and as many as wanted by
//!
//! ```sh
//! BOLERO_RANDOM_ITERATIONS=10000 BOLERO_RANDOM_TEST_TIME_MS=3600000 cargo test --test fuzz
//! ```
//!
//! `cargo bolero test scene` (cargo-bolero, on a nightly toolchain) runs the same target under libFuzzer, guided by coverage. An
//! input that fails is printed as text: keep it in the corpus. A new target is one function in `targets.rs`, one line in
//! [`TARGETS`], one test below, and a directory of the corpus.

#![allow(missing_docs, clippy::unwrap_used, reason = "tests")]

mod checkpoint;
mod edit;
mod small_scene;
mod targets;

use std::fs;
use std::path::{Path, PathBuf};

use bolero::check;

use crate::checkpoint::Change;
use crate::edit::{Edit, edited};

/// A target and its name, which is the name of its directory in the corpus.
type Target = (&'static str, fn(&str));

const TARGETS: [Target; 6] = [
    ("scene", targets::scene),
    ("silo", targets::silo),
    ("grains", targets::grains),
    ("mesh", targets::mesh),
    ("setting", targets::setting),
    ("picture", targets::picture),
];

fn directory(target: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/corpus").join(target)
}

/// The kept inputs of a target, by their names.
fn kept(target: &str) -> Vec<String> {
    let entries = fs::read_dir(directory(target)).unwrap();
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let texts: Vec<_> =
        paths.iter().map(|path| String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned()).collect();
    assert!(!texts.is_empty(), "{target} has a corpus");
    texts
}

/// Feeds a target with mutants of its corpus.
fn mutants(name: &str, target: fn(&str)) {
    let seeds = kept(name);
    check!().with_type::<(u8, Vec<Edit>)>().with_max_len(200).with_shrink_time(std::time::Duration::ZERO).for_each(
        |(seed, edits)| {
            let text = edited(&seeds[usize::from(*seed) % seeds.len()], &edits[..edits.len().min(6)]);
            if let Err(panic) = std::panic::catch_unwind(|| target(&text)) {
                eprintln!("{name} fails for this input:\n{text}\n");
                std::panic::resume_unwind(panic);
            }
        },
    );
}

#[test]
fn kept_inputs_cause_no_panic() {
    for (name, target) in TARGETS {
        for text in kept(name) {
            target(&text);
        }
    }
}

#[test]
fn scene() {
    mutants("scene", targets::scene);
}

#[test]
fn silo() {
    mutants("silo", targets::silo);
}

#[test]
fn grains() {
    mutants("grains", targets::grains);
}

#[test]
fn mesh() {
    mutants("mesh", targets::mesh);
}

#[test]
fn setting() {
    mutants("setting", targets::setting);
}

#[test]
fn picture() {
    mutants("picture", targets::picture);
}

#[test]
fn checkpoint() {
    let seeds = checkpoint::seeds();
    check!()
        .with_type::<(u8, u8, Vec<Change>)>()
        .with_max_len(200)
        .with_shrink_time(std::time::Duration::ZERO)
        .for_each(|(seed, part, changes)| {
            checkpoint::target(&seeds[usize::from(*seed) % seeds.len()], *part, &changes[..changes.len().min(4)]);
        });
}
