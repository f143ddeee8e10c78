//! Long runs: memory over a million grains, many particle-steps, many pictures. `.ci/full` runs them; one of them takes up to a
//! minute.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use serde_json::Value;

use crate::command_line::{siloflow, text};

/// A grain is released in every step. It falls through the open door, and is removed below it.
const DRAIN: &str = r#"(
    gravity: (0.0, -9.81), contact: Linear(k: 10.0, damping: B(0.0)), mass: Disc(20.0), integrator: Verlet,
    step: Fixed(1.0e-3), silo: (file: "door.dat", unit: Metre), door: (opens: At(0.0)), cull: (below: -0.05),
    spawner: (point: (0.0, 0.02), jitter: (0.03, 0.0), velocity: (0.0, -5.0), interval: 1.0e-3, count: 1000000,
        radius: Fixed(0.001)),
    on_loss: Continue, energy_balance: false, until: 2000.0, series: (interval: 10.0), pictures: None,
)"#;

fn write_scene(directory: &Path) {
    fs::write(directory.join("drain.ron"), DRAIN).unwrap();
    fs::write(directory.join("door.dat"), "2 2\n-0.06 0 0.01\n0.06 0 0.01\n-0.02 0 0.01\n0.02 0 0.01\n").unwrap();
}

fn summary(run: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(run.join("summary.json")).unwrap()).unwrap()
}

/// Runs the scene. Returns pairs of released grains and resident memory, kB.
fn memory_curve(directory: &Path, more: &[&str]) -> Vec<(u32, u64)> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_siloflow"));
    command.args(["run", "drain.ron", "--quiet", "--force", "--out", "run"]).args(more).current_dir(directory);
    let mut run = command.stderr(Stdio::null()).spawn().unwrap();
    let mut curve = Vec::new();
    while run.try_wait().unwrap().is_none() {
        let status = fs::read_to_string(format!("/proc/{}/status", run.id())).unwrap_or_default();
        let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:")?.trim().strip_suffix("kB"));
        let series = fs::read_to_string(directory.join("run/series.csv")).unwrap_or_default();
        let released = series.lines().next_back().and_then(|row| row.split(',').nth(1)?.parse().ok());
        if let (Some(resident), Some(released)) = (resident, released) {
            curve.push((released, resident.trim().parse().unwrap()));
        }
        sleep(Duration::from_millis(20));
    }
    curve
}

#[test]
#[cfg(target_os = "linux")]
#[ignore = "a million grains"]
fn memory_does_not_grow_with_the_grains_that_have_left() {
    for (more, departed) in [(&[][..], "out"), (&["--set", "silo=None", "--set", "door=None"], "lost")] {
        let here = tempfile::tempdir().unwrap();
        write_scene(here.path());
        let curve = memory_curve(here.path(), more);
        let summary = summary(&here.path().join("run"));
        assert_eq!((&summary["grains"][departed], &summary["grains"]["inside"]), (&1_000_000.into(), &0.into()));
        // After the last grains the final checkpoint is written, which takes memory for a moment.
        let largest = |range: std::ops::Range<u32>| {
            let part = curve.iter().filter(|(released, _)| range.contains(released));
            part.map(|(_, resident)| *resident).max().unwrap()
        };
        let first = largest(0..100_000);
        let later = largest(100_000..950_000);
        eprintln!("{departed}: {first} kB in the first tenth, {later} kB later");
        assert!(later as f64 <= 1.1 * first as f64, "{first} kB, then {later} kB");
    }
}

#[test]
#[ignore = "1e8 particle-steps"]
fn a_hundred_million_particle_steps_pass() {
    let here = tempfile::tempdir().unwrap();
    let silo = crate::scene("silo1.ron").display().to_string();
    let settings = ["spawner.interval=0.04", "pictures=None", "door=(opens: Never)", "until=150.0"];
    let set: Vec<_> = settings.iter().flat_map(|setting| ["--set", setting]).collect();
    let output = siloflow(here.path(), &[&["run", &silo, "--quiet", "--out", "run"], &set[..]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let summary = summary(&here.path().join("run"));
    assert!(summary["performance"]["particle_steps"].as_u64().unwrap() > 100_000_000, "{summary}");
    assert!(summary["energy"]["balance_error"].as_f64().unwrap().is_finite());
}

#[test]
#[ignore = "ten thousand pictures"]
fn ten_thousand_pictures_pass() {
    let here = tempfile::tempdir().unwrap();
    let fall = crate::scene("free-fall.ron").display().to_string();
    let settings = ["step=Fixed(1.0e-4)", "pictures.interval=1.0e-4", "pictures.width=50.0", "pictures.png=true"];
    let set: Vec<_> = settings.iter().flat_map(|setting| ["--set", setting]).collect();
    let output = siloflow(here.path(), &[&["run", &fall, "--quiet", "--out", "run"], &set[..]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let frames = here.path().join("run/frames");
    assert_eq!(fs::read_dir(&frames).unwrap().count(), 2 * 10_001);
    assert!(fs::read_to_string(frames.join("10000.svg")).unwrap().ends_with("</svg>\n"));
    assert!(fs::read(frames.join("10000.png")).unwrap().ends_with(b"IEND\xae\x42\x60\x82"));
}

#[test]
fn the_summary_lists_a_hundred_losses_and_a_file_lists_all() {
    let here = tempfile::tempdir().unwrap();
    write_scene(here.path());
    let run = |count: u32| {
        let count = format!("spawner.count={count}");
        let set = ["--set", "silo=None", "--set", "door=None", "--set", &count, "--set", "series.interval=0.05"];
        let arguments = [&["run", "drain.ron", "--quiet", "--force", "--out", "run"], &set[..]].concat();
        assert_eq!(siloflow(here.path(), &arguments).status.code(), Some(1));
        summary(&here.path().join("run"))
    };
    let file = here.path().join("run/losses.csv");
    let few = run(100);
    assert_eq!((&few["grains"]["lost"], few["losses"].as_array().unwrap().len()), (&100.into(), 100));
    assert!(!file.exists());
    let many = run(250);
    assert_eq!((&many["grains"]["lost"], many["losses"].as_array().unwrap().len()), (&250.into(), 100));
    assert_eq!(many["losses"], few["losses"]);
    let rows = fs::read_to_string(file).unwrap();
    let grains: Vec<_> =
        rows.lines().skip(1).map(|row| row.split(',').next().unwrap().parse::<u32>().unwrap()).collect();
    assert!(grains.len() == 250 && grains.is_sorted(), "{grains:?}");
    assert!(rows.starts_with("grain,step,time_s,x_m,y_m,nearest_wall_grain,way\n"));
}

/// Elastic spheres without friction in a closed vessel of 192 triangles: they never come to rest, and meet its seams, its tip and its slivers
/// for a million steps.
#[test]
#[ignore = "a million steps"]
fn a_closed_mesh_loses_no_grain_in_a_million_steps() {
    let here = tempfile::tempdir().unwrap();
    let scene = crate::scene("hard/facets.ron").display().to_string();
    let elastic = "contact=Linear(k: 1.0e4, damping: Restitution(1.0))";
    let more = ["--set", elastic, "--set", "pictures=None", "--set", "series=(interval: 0.5)", "--until", "20.0"];
    let output = siloflow(here.path(), &[&["run", &scene, "--quiet", "--out", "run"], &more[..]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let summary = summary(&here.path().join("run"));
    assert_eq!((&summary["grains"]["inside"], &summary["grains"]["lost"]), (&110.into(), &0.into()));
    assert!(summary["performance"]["particle_steps"].as_u64().unwrap() >= 110 * 1_000_000);
    // The grains never rest: 0.07 kg have fallen by some 3 cm.
    let mut series = csv::Reader::from_path(here.path().join("run/series.csv")).unwrap();
    let column = series.headers().unwrap().iter().position(|name| name == "kinetic_j").unwrap();
    let kinetic: Vec<f64> = series.records().map(|row| row.unwrap()[column].parse().unwrap()).collect();
    assert!(kinetic.len() == 41 && kinetic[1..].iter().all(|energy| *energy > 1e-3), "{kinetic:?}");
}
