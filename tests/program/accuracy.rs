//! `siloflow accuracy`: its table, its JSON, its files, and the arguments that it refuses.

use std::fs;

use serde_json::Value;

use crate::command_line::{siloflow, text};

#[test]
fn cases_write_tables_and_a_figure() {
    let here = tempfile::tempdir().unwrap();
    let output = siloflow(here.path(), &["accuracy", "bounce-0.5", "oblique-slip", "--quick", "--json", "--quiet"]);
    assert!(output.status.success() && output.stderr.is_empty(), "{}", text(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let schemes = report["schemes"].as_array().unwrap().len();
    let entries = report["entries"].as_array().unwrap();
    assert_eq!(entries.len(), 2 * schemes);
    let plain = &entries[0];
    assert_eq!((&plain["case"], &plain["scheme"]), (&"bounce-0.5".into(), &"Verlet".into()));
    let rows = plain["rows"].as_array().unwrap();
    // 10, 20, 50 and 100 steps, each plus pi/8.
    let steps: Vec<f64> = rows.iter().map(|row| row["steps_per_contact"].as_f64().unwrap().floor()).collect();
    assert_eq!(steps, [10.0, 20.0, 50.0, 100.0]);
    assert!(rows.iter().all(|row| (0.0..0.1).contains(&row["error"].as_f64().unwrap())), "{plain}");
    assert!(plain["prices"][0]["steps_per_contact"]["steps"].as_f64().unwrap() > 10.0, "{plain}");
    assert_eq!(plain["prices"][2]["steps_per_contact"], "not_reached");
    assert!(report["schemes"][0]["ns_per_particle_step"].as_f64().unwrap() > 0.0);
    let refused = entries.iter().find(|entry| entry["case"] == "oblique-slip" && entry["scheme"] == "ExplicitEuler");
    assert!(refused.unwrap()["not_for_this_case"].is_string());
    let out = here.path().join("out/accuracy");
    let written: Value = serde_json::from_str(&fs::read_to_string(out.join("accuracy.json")).unwrap()).unwrap();
    assert_eq!(written, report);
    let csv = fs::read_to_string(out.join("accuracy.csv")).unwrap();
    let width = csv.lines().next().unwrap().split(',').count();
    assert!(csv.lines().count() > 1 + rows.len() && csv.lines().all(|line| line.split(',').count() == width), "{csv}");
    assert!(fs::read_to_string(out.join("work-precision.svg")).unwrap().ends_with("</svg>\n"));
    assert!(fs::read(out.join("work-precision.png")).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn table_marks_unreached_errors_and_progress_goes_to_stderr() {
    let here = tempfile::tempdir().unwrap();
    let output = siloflow(here.path(), &["accuracy", "free-flight", "--quick", "--out", "there", "--threads", "2"]);
    let table = text(&output.stdout);
    assert!(output.status.success() && table.contains("free-flight: free flight"), "{table}");
    assert!(table.contains("1e-3 not reached or not run") && table.contains("written to there"), "{table}");
    assert!(text(&output.stderr).contains("free-flight, Verlet"));
    assert!(here.path().join("there/accuracy.csv").exists());
}

#[test]
fn deterministic_scene_runs_once_per_step_size() {
    let here = tempfile::tempdir().unwrap();
    let scene = crate::scene("column.ron").display().to_string();
    let arguments =
        ["accuracy", &scene, "--set", "until=0.4", "--error", "1e-3", "--seeds", "3", "--quick", "--json", "--quiet"];
    let output = siloflow(here.path(), &arguments);
    assert!(output.status.success() && output.stderr.is_empty(), "{}", text(&output.stderr));
    let study: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(study["seed_matters"], false);
    assert_eq!(study["steps"].as_array().unwrap().len(), 4);
    let overlap = |n: usize| {
        let figures = study["steps"][n]["observables"].as_array().unwrap();
        figures.iter().find(|figure| figure["name"] == "largest_overlap_ratio").unwrap().clone()
    };
    assert_eq!((&overlap(3)["standing"], &overlap(3)["difference"]), (&"finest".into(), &Value::Null));
    // First order: the difference from the step h0 is proportional to h - h0: 7 h0, 3 h0, h0. The largest overlap is
    // sampled at whole steps, which adds second order.
    let difference = |n: usize| overlap(n)["difference"].as_f64().unwrap().abs();
    assert!(difference(0) > difference(1) && difference(1) > difference(2) && difference(2) > 0.0, "{study}");
    assert!(study["recommended_step_s"].as_f64().unwrap() > 2.4e-5, "{study}");
    assert!(here.path().join("out/accuracy/column.json").exists());
}

#[test]
fn several_seeds_give_standard_errors_and_unstable_steps_are_refused() {
    let here = tempfile::tempdir().unwrap();
    let scene = crate::scene("silo1.ron").display().to_string();
    // The step is four times the assignment's 1 ms, t_c/9. It is below the limit of one contact, 3.6 ms times two is
    // not.
    let settings = ["spawner.count=20", "until=1.5", "step=Fixed(4.0e-3)"];
    let set: Vec<&str> = settings.iter().flat_map(|setting| ["--set", setting]).collect();
    let output =
        siloflow(here.path(), &[&["accuracy", &scene, "--seeds", "2", "--quick", "--json"], &set[..]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let study: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(study["steps"][0]["refused"].as_str().unwrap().contains("limit"), "{study}");
    assert_eq!(study["seed_matters"], true);
    let figures = study["steps"][3]["observables"].as_array().unwrap();
    assert!(figures.iter().all(|figure| figure["standard_error"].is_number() && figure["runs"] == 2), "{study}");
}

#[test]
fn errors_name_the_allowed_arguments() {
    let here = tempfile::tempdir().unwrap();
    let column = crate::scene("column.ron").display().to_string();
    let lattice = crate::scene("silo2d-lattice.ron").display().to_string();
    for (arguments, code, hint) in [
        (vec!["bounce-0.7"], "accuracy::unknown_case", "bounce-0.9"),
        (vec!["bed", "--seeds", "3"], "accuracy::no_scene", "scenes/silo1.ron"),
        (vec!["--error", "0", "bed"], "expected a positive number", "--error"),
        (vec![&column, "bed"], "accuracy::one_scene", "one scene"),
        (vec![&lattice], "accuracy::lattice", "a scene of grains"),
        (vec!["missing.ron"], "scene::unreadable", "missing.ron"),
    ] {
        let output = siloflow(here.path(), &[&["accuracy"], &arguments[..]].concat());
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains(code) && message.contains(hint), "{arguments:?}: {message}");
    }
    assert!(!here.path().join("out").exists());
}
