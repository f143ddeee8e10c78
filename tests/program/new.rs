//! `siloflow new` and `siloflow scenes`.

use std::fs;

use crate::command_line::{siloflow, text};

#[test]
fn a_new_scene_passes_the_check_without_a_warning_and_runs() {
    let here = tempfile::tempdir().unwrap();
    let output = siloflow(here.path(), &["new", "bin"]);
    assert!(
        output.status.success() && text(&output.stdout).contains("siloflow run bin.ron"),
        "{}",
        text(&output.stderr)
    );
    let output = siloflow(here.path(), &["check", "bin.ron"]);
    let said = format!("{}{}", text(&output.stdout), text(&output.stderr));
    assert!(output.status.success() && said.contains("no warnings"), "{said}");
    let run = ["run", "bin.ron", "--quiet", "--set", "feed[0].total=Grains(20)", "--set", "feed[0].rate=Grains(200.0)"];
    let output = siloflow(here.path(), &run);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let summary: serde_json::Value =
        serde_json::from_slice(&fs::read(here.path().join("out/bin/summary.json")).unwrap()).unwrap();
    assert_eq!((summary["status"].as_str(), summary["grains"]["out"].as_u64()), (Some("empty"), Some(20)), "{summary}");
}

#[test]
fn every_shipped_scene_is_listed_and_a_copy_runs_elsewhere() {
    let here = tempfile::tempdir().unwrap();
    let listed = siloflow(here.path(), &["scenes"]);
    let listed = text(&listed.stdout);
    assert!(listed.contains("silo1 ") && listed.contains("siloflow new"), "{listed}");
    let output = siloflow(here.path(), &["new", "mine.ron", "--from", "silo1"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(here.path().join("mine.dat").is_file());
    let output = siloflow(here.path(), &["run", "mine.ron", "--quiet", "--until", "0.1"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn wrong_calls_of_new_are_refused_and_leave_nothing() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("there.ron"), "mine").unwrap();
    fs::write(here.path().join("copy.dat"), "mine").unwrap();
    for (arguments, words) in [
        (vec!["there"], "there.ron exists"),
        (vec!["copy", "--from", "silo1"], "copy.dat exists"),
        (vec!["x", "--from", "silo-1"], "did you mean `silo1`?"),
        (vec!["x", "--from", "qqq"], "the scenes here are: silo1, "),
        (vec!["no/where/x"], "does its directory exist"),
        (vec![".."], "no name of a scene"),
        (vec![".ron"], "no name of a scene"),
    ] {
        let output = siloflow(here.path(), &[&["new"], &arguments[..]].concat());
        let said = text(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains(words), "{arguments:?}: {said}");
    }
    let mut names: Vec<_> = fs::read_dir(here.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["copy.dat", "there.ron"]);
}
