//! `siloflow validate`: wrong calls, directories of others, an interruption, and the page.

use std::fs;

use siloflow::prelude::load;
use siloflow::studies::validation::cases::CASES;

use crate::command_line::{siloflow, text};

#[test]
fn wrong_calls_change_nothing() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("file"), "").unwrap();
    fs::create_dir(here.path().join("full")).unwrap();
    fs::write(here.path().join("full/notes.txt"), "mine").unwrap();
    for (arguments, words) in [
        (vec!["anand"], "there is no case `anand`"),
        (vec!["anand-hoper"], "anand-hopper"),
        (vec!["anand-hopper", "--out", "full"], "it holds notes.txt"),
        (vec!["anand-hopper", "--out", "file"], "cannot hold a validation"),
    ] {
        let output = siloflow(here.path(), &[&["validate"], &arguments[..]].concat());
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(words), "{words} is missing in:\n{message}");
    }
    let mut names: Vec<_> = fs::read_dir(here.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["file", "full"]);
    assert_eq!(fs::read_dir(here.path().join("full")).unwrap().count(), 1);
}

#[test]
fn the_list_names_every_case_and_every_case_has_its_files() {
    let here = tempfile::tempdir().unwrap();
    let output = siloflow(here.path(), &["validate", "--list"]);
    assert!(output.status.success());
    let list = text(&output.stdout);
    for case in CASES {
        assert!(list.contains(case.name) && list.contains(case.title), "{list}");
        for sweep in case.short.iter().chain(case.full) {
            assert!(case.files.iter().any(|(name, _)| name == sweep), "{}: {sweep}", case.name);
        }
        let directory = crate::scene("validation").join(case.name);
        let mut there: Vec<_> =
            fs::read_dir(&directory).unwrap().map(|it| it.unwrap().file_name().into_string().unwrap()).collect();
        let mut carried: Vec<_> = case.files.iter().map(|(name, _)| (*name).to_owned()).collect();
        there.sort();
        carried.sort();
        assert_eq!(there, carried, "{}", case.name);
    }
    assert_eq!(fs::read_dir(here.path()).unwrap().count(), 0);
}

#[test]
fn every_sweep_of_every_case_is_valid() {
    for case in CASES {
        for sweep in case.short.iter().chain(case.full) {
            let path = crate::scene("validation").join(case.name).join(sweep);
            let sweep = siloflow::studies::sweep::Sweep::read(&path)
                .unwrap_or_else(|fault| panic!("{}: {fault}", path.display()));
            let settings = sweep.settings(sweep.tasks()[0]);
            load::any(&sweep.scene, &settings).unwrap_or_else(|fault| panic!("{}: {fault}", path.display()));
        }
    }
}

#[test]
fn a_run_that_failed_is_not_passed_over() {
    let here = tempfile::tempdir().unwrap();
    let run = here.path().join("out/validate/dosta-impact/short/runs/0001-1");
    fs::create_dir_all(&run).unwrap();
    let inputs = crate::scene("validation").join("dosta-impact");
    fs::copy(inputs.join("impact.ron"), run.join("scene.ron")).unwrap();
    fs::copy(inputs.join("short.ron"), here.path().join("out/validate/dosta-impact/short/sweep.ron")).unwrap();
    fs::write(run.join("summary.json"), r#"{"status": "failed", "failure": "test", "steps": 1}"#).unwrap();
    fs::write(run.join("series.csv"), "time_s,out\n0,0\n").unwrap();
    fs::write(here.path().join("out/validate/.siloflow-validate"), "").unwrap();
    let output = siloflow(here.path(), &["validate", "dosta-impact"]);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("run 0001-1 (seed 1) failed"), "{message}");
    assert!(!here.path().join("out/validate/dosta-impact.csv").exists());
}
