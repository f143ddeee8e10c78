//! `SILOFLOW_INSTRUCTIONS` changes no bit of a run. A bad value ends the program with status 2.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use siloflow::dem::instruction_set::{InstructionSet, VARIABLE};

use crate::command_line::text;

/// Runs a short scene of frictional spheres with this value of the variable.
fn run(directory: &Path, instructions: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_siloflow"))
        .args([
            "run",
            "chute3d.ron",
            "--until",
            "0.02",
            "--set",
            "pictures=None",
            "--json",
            "--quiet",
            "--force",
            "--out",
        ])
        .arg(directory.join("run"))
        .current_dir(crate::root().join("scenes"))
        .env(VARIABLE, instructions)
        .output()
        .unwrap()
}

#[test]
fn every_instruction_set_gives_the_same_state() {
    let here = tempfile::tempdir().unwrap();
    let hash = |instructions: &str| {
        let output = run(here.path(), instructions);
        assert!(output.status.success(), "{instructions}: {}", text(&output.stderr));
        let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(summary["steps"].as_u64() > Some(100) && summary["coordination"].as_f64() > Some(0.2), "{summary}");
        summary["state_hash"].clone()
    };
    // An empty variable counts as unset.
    let usual = hash("");
    for instructions in InstructionSet::all() {
        assert_eq!(hash(instructions.name()), usual, "{}", instructions.name());
    }
}

#[test]
fn bad_value_is_reported_with_all_allowed_values() {
    let here = tempfile::tempdir().unwrap();
    let is_here = |name: &&str| InstructionSet::all().iter().any(|instructions| instructions.name() == *name);
    // An instruction set that this machine lacks is refused like an unknown word.
    let lacking: Vec<_> = ["baseline", "avx2", "avx512"].into_iter().filter(|name| !is_here(name)).collect();
    for value in [&["sse9", "AVX2", "avx2 "], &lacking[..]].concat() {
        let output = run(here.path(), value);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{value}: {message}");
        assert!(!message.contains("panicked") && message.contains("call::instructions"), "{message}");
        // The report breaks lines at any space.
        let words: Vec<_> = message.split_whitespace().collect();
        for part in [VARIABLE, "baseline,", "avx2,", "avx512"] {
            assert!(words.contains(&part), "{part}: {message}");
        }
        assert!(message.contains(value.trim()), "{message}");
        assert!(!here.path().join("run").exists(), "{value}: a file was written");
    }
}
