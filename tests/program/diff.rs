//! `siloflow diff`: reports the first difference of two runs, that there is none, or why the runs cannot be compared.

use std::fs;
use std::path::Path;
use std::process::Output;

use serde_json::Value;

use crate::command_line::{siloflow, text};
use crate::scene;

fn path(name: &str) -> String {
    scene(name).display().to_string()
}

/// Runs a scene for a short time into a directory.
fn run(here: &Path, name: &str, until: &str, out: &str, settings: &[&str]) {
    let set: Vec<_> = settings.iter().flat_map(|setting| ["--set", setting]).collect();
    let file = path(name);
    let arguments = [&["run", &file, "--until", until, "--out", out, "--quiet"][..], &set].concat();
    let output = siloflow(here, &arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
}

/// Returns the exit status and the report of `--json`.
fn report(here: &Path, arguments: &[&str]) -> (Option<i32>, Value) {
    let Output { status, stdout, stderr } = siloflow(here, &[&["diff", "--json", "--quiet"], arguments].concat());
    assert!(stderr.is_empty(), "{}", text(&stderr));
    (status.code(), serde_json::from_slice(&stdout).unwrap())
}

#[test]
fn repeated_run_has_no_difference() {
    let here = tempfile::tempdir().unwrap();
    run(here.path(), "silo1.ron", "1.5", "run", &["spawner.count=12", "pictures=None"]);
    let file = path("silo1.ron");
    // The scene has another `until` and another number of grains. Their effect comes later.
    let output = siloflow(here.path(), &["diff", "run", &file, "--quiet"]);
    let words = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{words}");
    assert!(words.contains("key     spawner.count: 12 | 1000\n"), "{words}");
    for threads in ["1", "2"] {
        let output = siloflow(here.path(), &["diff", "run", "run/scene.ron", "--threads", threads, "--quiet"]);
        let words = text(&output.stdout);
        assert_eq!((output.status.code(), text(&output.stderr).as_str()), (Some(0), ""), "{words}");
        assert!(words.contains("the same to the last bit in all 1500 steps, to t = 1.5 s (time_reached)"), "{words}");
        assert!(!words.contains("key "), "{words}");
    }
    let (code, report) = report(here.path(), &["run", "run", "--until", "0.2"]);
    assert_eq!((code, &report["same"], &report["steps"]), (Some(0), &true.into(), &200.into()), "{report}");
    assert_eq!((&report["divergence"], &report["end"]), (&Value::Null, &"time_reached".into()), "{report}");
    assert_eq!(fs::read_dir(here.path()).unwrap().count(), 1, "a file was written");
}

#[test]
fn stiffer_contact_is_found_in_the_force_of_the_first_contact() {
    let here = tempfile::tempdir().unwrap();
    run(here.path(), "hard/restitution-one.ron", "0.4", "soft", &[]);
    run(here.path(), "hard/restitution-one.ron", "0.4", "hard", &["contact.k=1.1e4"]);
    let (code, report) = report(here.path(), &["soft", "hard"]);
    assert_eq!((code, &report["same"]), (Some(1), &false.into()));
    let change = &report["keys"][0];
    assert_eq!(
        (&change["key"], &change["first"], &change["second"]),
        (&"contact.k".into(), &"1.0e4".into(), &"1.1e4".into())
    );
    let divergence = &report["divergence"];
    assert_eq!((&divergence["kind"], &divergence["quantity"]), (&"particle".into(), &"force".into()), "{report}");
    let upward = |run: usize| divergence["values"][run][1].as_f64().unwrap();
    // In the first step in which the grain touches the floor, half a metre down, weight and overlap are still equal.
    let weight = 0.16 * 9.81;
    assert!(((upward(1) + weight) / (upward(0) + weight) - 1.1).abs() < 1e-12, "{report}");
    let step = divergence["step"].as_u64().unwrap();
    assert!((step as f64 * 3.7e-4 - (2.0 * 0.5 / 9.81f64).sqrt()).abs() < 3.7e-4, "{report}");
    assert_eq!(report["steps"], step);
    let output = siloflow(here.path(), &["diff", "soft", "hard", "--quiet"]);
    let words = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1));
    let particle = divergence["particle"].as_str().unwrap();
    assert!(words.contains(&format!("differ at step {step}, t = ")), "{words}");
    assert!(words.contains(&format!("the force of {particle} (N)\n  first   (")), "{words}");
}

#[test]
fn runs_are_compared_until_the_first_one_ends() {
    let here = tempfile::tempdir().unwrap();
    run(here.path(), "column.ron", "0.02", "short", &[]);
    let (code, report) = report(here.path(), &["short", &path("column.ron")]);
    assert_eq!((code, &report["steps"]), (Some(0), &200.into()), "{report}");
}

#[test]
fn lattice_gas_runs_are_compared_site_by_site() {
    let here = tempfile::tempdir().unwrap();
    run(here.path(), "parabola.ron", "20", "throw", &[]);
    run(here.path(), "parabola.ron", "20", "other", &["particles[0].velocity=8"]);
    let (code, same) = report(here.path(), &["throw", &path("parabola.ron")]);
    assert_eq!((code, &same["steps"]), (Some(0), &20.into()), "{same}");
    let (code, other) = report(here.path(), &["throw", "other"]);
    let divergence = &other["divergence"];
    assert_eq!((code, &divergence["kind"], &divergence["step"]), (Some(1), &"site".into(), &0.into()), "{other}");
    let bits = |run: usize| divergence["values"][run].as_u64().unwrap().count_ones();
    assert_eq!(bits(0) + bits(1), 2, "{other}");
    let words = text(&siloflow(here.path(), &["diff", "throw", "other"]).stdout);
    assert!(words.contains("the state of the site at (") && words.contains("\n1 site differs after"), "{words}");
}

#[test]
fn incomparable_runs_are_refused() {
    let here = tempfile::tempdir().unwrap();
    fs::create_dir(here.path().join("empty")).unwrap();
    run(here.path(), "column.ron", "0.01", "coarse", &["step=Fixed(2.0e-4)"]);
    run(here.path(), "parabola.ron", "5", "fine", &["method.spacing=0.005"]);
    let [column, bed, gas] = ["column.ron", "bed3d.ron", "parabola.ron"].map(path);
    for (arguments, code, told) in [
        (["nowhere", &column], "diff::missing", "there is no nowhere"),
        (["empty", &column], "diff::no_run", "empty is no run directory"),
        ([&column, &gas], "divergence::method", "the lattice gas"),
        ([&column, &bed], "divergence::space", "in solid space"),
        ([&column, "coarse"], "divergence::step", "0.0001 s, the other of 0.0002 s"),
        ([&gas, "fine"], "divergence::sites", "different sites"),
    ] {
        let output = siloflow(here.path(), &["diff", arguments[0], arguments[1]]);
        let message = text(&output.stderr);
        assert_eq!((output.status.code(), output.stdout.is_empty()), (Some(2), true), "{message}");
        // miette breaks lines.
        let message = message.replace("\n  │ ", " ");
        assert!(message.contains(code) && message.contains(told), "{message}");
    }
    let alone = siloflow(here.path(), &["diff", "coarse"]);
    assert_eq!(alone.status.code(), Some(2));
    let bad = siloflow(here.path(), &["diff", "coarse", "coarse", "--until", "-1"]);
    assert_eq!(bad.status.code(), Some(2));
}

#[test]
fn help_contains_an_example() {
    let help = text(&siloflow(Path::new("."), &["diff", "--help"]).stdout);
    assert!(help.contains("siloflow diff out/silo1 out/stiffer") && help.contains("1 different"), "{help}");
}
