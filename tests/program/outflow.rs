//! The scene key `outflow`: grains that leave one after another, so that all figures are known.

use std::fs;
use std::path::Path;
use std::process::Command;

use siloflow::prelude::*;

use crate::command_line::text;

const DOOR: &str = "2 9\n-0.1 0 0.01\n0.1 0 0.01\n-0.08 0 0.01\n-0.06 0 0.01\n-0.04 0 0.01\n-0.02 0 0.01\n0 0 0.01\n0.02 0 0.01\n\
                    0.04 0 0.01\n0.06 0 0.01\n0.08 0 0.01\n";

/// A column of forty grains falls through the door at 1 m/s, 0.07 m apart, without gravity. Species 1 begins at the height `above`, m.
/// Beside it a column falls at a quarter of that speed.
fn scene(above: f64, outflow: &str) -> String {
    let column = |low: f64, high: f64, species: u32| {
        format!(
            "(low: (-0.035, {low}), high: (0.035, {high}), spacing: 0.07, radius: Fixed(0.03), velocity: (0.0, -1.0), \
             species: {species}),"
        )
    };
    format!(
        "(gravity: (0.0, 0.0), contact: Linear(k: 1.0e4, damping: B(5.0)), mass: ArealSquare(100.0), integrator: Verlet,
        step: Fixed(1.0e-4), silo: (file: \"door.dat\", unit: Metre), door: (opens: At(0.0)), on_loss: Continue,
        walls: [Segment(from: (-1.0, 0.0), to: (-0.1, 0.0)), Segment(from: (1.0, 0.0), to: (0.1, 0.0))],
        fill: [{} {} (low: (0.465, 0.8), high: (0.535, 1.5), spacing: 0.07, radius: Fixed(0.03), velocity: (0.0, -0.25))],
        until: 2.6, pictures: None, {outflow})",
        column(0.0, above, 0),
        column(above, 2.8, 1)
    )
}

const WINDOW: &str =
    "outflow: (from: 0.28, to: 2.52, mass_flow: (axis: (0.0, 0.0), low: 0.2, high: 1.2, centre: 0.1, wall: 0.4))";

#[test]
fn a_window_after_the_door_has_the_figures_of_the_same_times() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("door.dat"), DOOR).unwrap();
    // The door opens at 0 s, so both windows are one; the velocities of the mass-flow index are sampled in them too.
    let after = WINDOW.replace("from: 0.28, to: 2.52", "from: AfterDoor(0.28), to: AfterDoor(2.52)");
    let figures = [("times", WINDOW), ("door", &after)].map(|(name, window)| {
        fs::write(here.path().join(format!("{name}.ron")), scene(1.4, window)).unwrap();
        let file = format!("{name}.ron");
        let output = crate::command_line::siloflow(here.path(), &["run", &file, "--json", "--quiet"]);
        let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        summary["outflow"].clone()
    });
    assert!(figures[0]["mass_flow_index"]["value"].is_number(), "{}", figures[0]);
    assert_eq!(figures[0], figures[1]);
}

#[test]
fn figures_of_a_steady_column_are_those_of_its_grains() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("door.dat"), DOOR).unwrap();
    // Blocks of 0.14 s begin at 0.28 s, and the window ends at 2.52 s: grains 4 to 35. Species 1 begins with block 8.
    fs::write(here.path().join("a.ron"), scene(1.4, WINDOW)).unwrap();
    let run = |arguments: &[&str]| {
        Command::new(env!("CARGO_BIN_EXE_siloflow")).args(arguments).current_dir(here.path()).output().unwrap()
    };
    let output = run(&["run", "a.ron"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let summary = fs::read_to_string(here.path().join("out/a/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let figures = &summary["outflow"];
    let number = |path: &str| figures.pointer(path).and_then(serde_json::Value::as_f64).unwrap();
    assert_eq!((number("/grains"), number("/blocks"), number("/from_s")), (32.0, 16.0, 0.28), "{figures}");
    // Two grains in each block: the interval has no width but for rounding.
    let mass = 100.0 * 0.03 * 0.03;
    for (rate, expected) in [("/rate_per_s", 1.0 / 0.07), ("/rate_kg_per_s", mass / 0.07)] {
        for end in ["/mean", "/low", "/high"] {
            assert!((number(&format!("{rate}{end}")) / expected - 1.0).abs() < 1e-12, "{figures}");
        }
    }
    // The same grains in the discharge: all have one mass.
    let discharge = |key: &str| summary["discharge"][key].as_f64().unwrap();
    assert!((discharge("rate_kg_per_s") / discharge("rate_per_s") / mass - 1.0).abs() < 1e-12, "{summary}");
    // Grain n has to go (n + 1/2) 0.07 m at 1 m/s. It is found out when it has moved up to a quarter of its radius farther, or a
    // step. The deviation of the times of 32 grains is 0.07 sqrt((32^2 - 1)/12), changed by at most that delay.
    let late = 0.25 * 0.03 + 2.0e-4;
    let delay = number("/residence_s/mean") - 20.0 * 0.07;
    assert!((0.0..late).contains(&delay), "{figures}");
    let deviation = 0.07 * ((32.0f64.powi(2) - 1.0) / 12.0).sqrt();
    assert!((number("/residence_s/deviation") - deviation).abs() < late, "{figures}");
    // Every block has one species.
    assert!((number("/segregation_index") - 1.0).abs() < 1e-12, "{figures}");
    assert!((number("/mass_flow_index/value") - 0.25).abs() < 1e-12, "{figures}");
    assert!(number("/mass_flow_index/error") < 1e-12, "{figures}");
    let schema = fs::read_to_string(crate::root().join("docs/reference/summary.schema.json")).unwrap();
    let schema: serde_json::Value = serde_json::from_str(&schema).unwrap();
    let known = &schema["properties"]["outflow"];
    let keys: std::collections::BTreeSet<_> = figures.as_object().unwrap().keys().collect();
    assert_eq!(keys, known["properties"].as_object().unwrap().keys().collect());
    assert!(known["required"].as_array().unwrap().iter().all(|key| figures.get(key.as_str().unwrap()).is_some()));
    // If the run ends in the middle of the window, only complete blocks count.
    let short = run(&["run", "a.ron", "--out", "short", "--quiet", "--set", "stop=[Out(20)]"]);
    assert!(short.status.success(), "{}", text(&short.stderr));
    let summary = fs::read_to_string(here.path().join("short/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    // The twentieth grain leaves at 19.5 spacings, 1.365 s: seven blocks are complete.
    assert_eq!(summary["outflow"]["blocks"], 7, "{summary}");
    assert_eq!(summary["outflow"]["grains"], 14, "{summary}");
}

#[test]
fn windows_and_zones_that_do_not_fit_are_refused() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("door.dat"), DOOR).unwrap();
    let refused = |text: String| load::from_text("a.ron", "a", here.path(), text, &[]).unwrap_err();
    for (from, to, code, key) in [
        ("from: 0.28", "from: 2.52", "scene::out_of_range", "outflow.to"),
        ("to: 2.52", "to: 2.61", "scene::out_of_range", "outflow.to"),
        ("low: 0.2, high: 1.2", "low: 1.2, high: 1.2", "scene::empty_box", "outflow.mass_flow.high"),
        ("centre: 0.1", "centre: 0.4", "scene::empty_box", "outflow.mass_flow.wall"),
        ("axis: (0.0, 0.0)", "axis: (0.0, 0.0, 0.0)", "scene::dimension", "outflow.mass_flow.axis"),
    ] {
        let fault = refused(scene(1.4, &WINDOW.replace(from, to)));
        assert_eq!((fault.code(), fault.scene_key()), (code, Some(key)), "{fault}");
    }
    let closed = "(gravity: (0.0, 0.0), contact: Linear(k: 1.0e4, damping: B(5.0)), step: Fixed(1.0e-4), until: 1.0, \
                  outflow: (from: 0.0, to: 0.5))";
    let fault = load::from_text("a.ron", "a", Path::new("."), closed.to_owned(), &[]).unwrap_err();
    assert_eq!((fault.code(), fault.scene_key()), ("scene::no_door", Some("outflow")), "{fault}");
}
