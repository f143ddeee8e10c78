//! `siloflow compare`, and the field of mean velocity that it needs.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::command_line::{siloflow, text};

/// Writes a scene with a hundred grains in the assignment's silo; the door opens after half a second.
fn write_scene(here: &Path) {
    let silo = crate::root().join("assets/silo1.dat").display().to_string();
    let scene = format!(
        "(gravity: (0.0, -9.81), contact: Linear(k: 1.0e4, damping: Restitution(0.5)), mass: ArealSquare(100.0), \
         step: Fixed(5.0e-4), silo: (file: {silo:?}, unit: Centimetre), \
         fill: [(low: (-0.5, 0.9), high: (0.5, 1.9), spacing: 0.1, radius: Fixed(0.04), agitation: (0.5, 0.5))], \
         door: (opens: At(0.5)), cull: (below: -0.5), until: 20.0, pictures: None, \
         flow: (cell: 0.2, from: 0.05, to: 0.9, sample: 0.01))"
    );
    fs::write(here.join("small.ron"), scene).unwrap();
}

fn rows(path: &Path) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(path).unwrap();
    text.lines().skip(1).map(|line| line.split(',').map(|number| number.parse().unwrap()).collect()).collect()
}

#[test]
fn flow_field_is_sampled_in_cells_and_points_down() {
    let here = tempfile::tempdir().unwrap();
    write_scene(here.path());
    let explained = text(&siloflow(here.path(), &["explain", "small.ron"]).stdout);
    assert!(explained.contains("cells of 0.2 m, every 0.01 s while 5 to 90 % are out, in flow.csv"), "{explained}");
    assert!(siloflow(here.path(), &["run", "small.ron", "--quiet"]).status.success());
    let flow = here.path().join("out/small/flow.csv");
    assert!(fs::read_to_string(&flow).unwrap().starts_with("x_m,y_m,samples,count,vx_m_per_s,vy_m_per_s\n"));
    let cells = rows(&flow);
    assert!(cells.is_sorted_by_key(|cell| (cell[1], cell[0])) && cells.len() > 10);
    // The mean over the window lies between the numbers of grains inside at its ends, 95 and 10.
    let inside: f64 = cells.iter().map(|cell| cell[3]).sum();
    assert!((10.0..=95.0).contains(&inside), "{inside}");
    let down: f64 = cells.iter().map(|cell| cell[3] * cell[5]).sum();
    assert!(down < 0.0, "{down}");
    // Grains that are out do not count. The centre of a grain is out at y = 0, and a cell is 0.2 m.
    assert!(cells.iter().all(|cell| cell[1] > -0.2 && cell[2] == cells[0][2]), "{cells:?}");
    // A run without the key removes the file.
    siloflow(here.path(), &["run", "small.ron", "--quiet", "--set", "flow=None", "--until", "0.1", "--force"]);
    assert!(!flow.exists());
    // A scene is run again only into a directory without a run.
    let refused = siloflow(here.path(), &["compare", "small.ron", "small.ron", "--quiet"]);
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn compare_runs_a_scene_first_and_compares_two_seeds() {
    let here = tempfile::tempdir().unwrap();
    write_scene(here.path());
    siloflow(here.path(), &["run", "small.ron", "--quiet", "--seed", "2", "--out", "seed2"]);
    let output = siloflow(here.path(), &["compare", "small.ron", "seed2/", "--looks", "5", "--json", "--quiet"]);
    assert!(output.status.success() && output.stderr.is_empty(), "{}", text(&output.stderr));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let row = |n: usize, key: &str| report["rows"][n][key].as_f64().unwrap();
    assert_eq!((row(0, "field_rms"), row(0, "discharge_difference"), row(0, "wall_ratio")), (0.0, 0.0, 1.0));
    assert!((row(0, "field_correlation") - 1.0).abs() < 1e-12);
    assert!(
        row(1, "field_rms") > 0.0 && row(1, "field_correlation") > 0.5 && row(1, "common_cells") > 10.0,
        "{report}"
    );
    assert!((0.0..0.5).contains(&row(1, "discharge_difference")) && row(1, "wall_s") > 0.0, "{report}");
    assert_eq!((&report["rows"][0]["run"], &report["rows"][1]["run"]), (&"small".into(), &"seed2".into()));
    let out = here.path().join("out/compare");
    assert_eq!(fs::read_to_string(out.join("compare.csv")).unwrap().lines().count(), 3);
    for name in ["fields", "discharge", "cost"] {
        assert!(fs::read_to_string(out.join(format!("{name}.svg"))).unwrap().ends_with("</svg>\n"));
        assert!(fs::read(out.join(format!("{name}.png"))).unwrap().starts_with(b"\x89PNG"));
    }
    let table = siloflow(here.path(), &["compare", "out/small", "seed2", "out/small", "--out", "elsewhere"]);
    assert_eq!(text(&table.stdout).lines().filter(|line| line.contains(" m/s ")).count(), 3, "{}", text(&table.stdout));
    assert!(here.path().join("elsewhere/fields.png").exists());
}

#[test]
fn incomparable_arguments_are_refused_before_any_run() {
    let here = tempfile::tempdir().unwrap();
    write_scene(here.path());
    siloflow(here.path(), &["run", "small.ron", "--quiet", "--out", "run"]);
    siloflow(here.path(), &["run", "small.ron", "--quiet", "--set", "flow=None", "--until", "0.1", "--out", "no-flow"]);
    siloflow(here.path(), &["run", "small.ron", "--quiet", "--set", "flow.cell=0.25", "--out", "coarse"]);
    siloflow(here.path(), &["run", "small.ron", "--quiet", "--until", "0.51", "--out", "short"]);
    fs::create_dir(here.path().join("empty")).unwrap();
    let fall = crate::scene("free-fall.ron").display().to_string();
    for (arguments, code, hint) in [
        (vec!["small.ron", "no-flow"], "results::unreadable", "`flow: (cell: 0.05"),
        (vec!["run", "nowhere"], "compare::no_run", "give run directories"),
        (vec!["small.ron", "empty"], "compare::no_summary", "has this one ended?"),
        (vec!["run", "coarse"], "compare::field", "0.2 and 0.25 m"),
        (vec!["run", "short"], "compare::no_flow", "did the run"),
        (vec!["run", &fall], "compare::no_flow", "flow: (cell: 0.05"),
        (vec!["small.ron", "small.ron"], "compare::same_directory", "one by one"),
        (vec!["small.ron", "missing.ron"], "scene::unreadable", "missing.ron"),
        (vec!["run"], "required", "OTHERS"),
    ] {
        let output = siloflow(here.path(), &[&["compare"], &arguments[..]].concat());
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.contains(code) && message.contains(hint), "{arguments:?}: {message}");
    }
    assert!(!here.path().join("out").exists(), "a file was written");
    // The directory of the second scene has a run, so the first scene is not run.
    fs::copy(here.path().join("small.ron"), here.path().join("second.ron")).unwrap();
    siloflow(here.path(), &["run", "second.ron", "--quiet", "--until", "0.1"]);
    let output = siloflow(here.path(), &["compare", "small.ron", "second.ron"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("--force") && !here.path().join("out/small").exists());
}
