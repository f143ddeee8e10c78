//! The scene key `fields` and the file `fields.csv`.

use std::fs;
use std::path::Path;
use std::process::Command;

use siloflow::prelude::*;

use crate::command_line::text;

fn scene(space: &str, fields: &str) -> String {
    let (zero, walls) = match space {
        "Plane" => ("0.0, -9.81", "HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))"),
        _ => ("0.0, 0.0, -9.81", "HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))"),
    };
    let (low, high) =
        if space == "Plane" { ("(0.0, 0.0)", "(0.4, 0.2)") } else { ("(0.0, 0.0, 0.0)", "(0.4, 0.1, 0.1)") };
    format!(
        "(space: {space}, gravity: ({zero}), contact: Linear(k: 1.0e4, damping: Restitution(0.5)), mass: Sphere(1000.0),
        step: Fixed(1.0e-4), walls: [{walls}], pictures: None, until: 0.05,
        fill: [(low: {low}, high: {high}, spacing: 0.041, radius: Mixture([(0.02, 0.5), (0.015, 0.5)]))],
        fields: [{fields}])"
    )
}

#[test]
fn a_run_writes_the_means_of_each_window() {
    let here = tempfile::tempdir().unwrap();
    let fields =
        "(grid: XY(low: (0.0, 0.0), high: (0.4, 0.2), cells: (2, 3)), sample: 0.001, from: 0.01, average: 0.02),
                  (grid: XY(low: (0.0, 0.0), high: (0.4, 0.9), cells: (1, 2)), kernel: Gaussian(0.03), sample: 0.01)";
    fs::write(here.path().join("a.ron"), scene("Plane", fields)).unwrap();
    let output =
        Command::new(env!("CARGO_BIN_EXE_siloflow")).args(["run", "a.ron"]).current_dir(here.path()).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let csv = fs::read_to_string(here.path().join("out/a/fields.csv")).unwrap();
    let mut lines = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    assert_eq!(header[..7], ["field", "from_s", "to_s", "samples", "block_s", "x1_m", "x2_m"]);
    assert_eq!(header[7..9], ["solid_fraction", "solid_fraction_error"]);
    let rows: Vec<_> = lines.collect();
    assert!(rows.iter().all(|row| row.len() == header.len()));
    let of = |field: &str, name: &str| -> Vec<Option<f64>> {
        let column = header.iter().position(|column| *column == name).unwrap();
        rows.iter().filter(|row| row[0] == field).map(|row| row[column].parse().ok()).collect()
    };
    // Two windows of twenty samples, and one of the last two samples at 0.05 s and its end. Six cells each.
    let samples = of("1", "samples");
    assert_eq!((samples.len(), samples[0], samples[6], samples[12]), (18, Some(20.0), Some(20.0), Some(1.0)));
    // A time is a product of steps and step.
    let [from, to] = ["from_s", "to_s"].map(|name| of("1", name)[6].unwrap());
    assert!((from - 0.03).abs() < 1e-15 && (to - 0.049).abs() < 1e-15, "{from} {to}");
    // Sixteen samples are eight blocks of two.
    assert_eq!(of("1", "block_s")[0], Some(0.002));
    assert!(of("1", "density_error")[..12].iter().all(Option::is_some));
    assert!(of("1", "density_error")[12..].iter().all(Option::is_none));
    // Free fall from rest at 9.81 m/s^2, in rows that touch nothing: the mean of the window is that at its middle time.
    let v = of("1", "v2")[4].unwrap();
    let error = of("1", "v2_error")[4].unwrap();
    assert!((v + 9.81 * 0.0195).abs() < 1e-3 && error > 0.0, "{v} {error}");
    // Shares of the species add up to the whole.
    let first = of("1", "share_0")[0].unwrap();
    let second = of("1", "share_1")[0].unwrap();
    assert!((first + second - 1.0).abs() < 1e-12 && first > 0.1 && second > 0.1, "{first} {second}");
    // The upper half of the second grid is empty up to 6 s of the kernel, and has no velocity.
    assert_eq!((of("2", "density")[1], of("2", "v1")[1]), (Some(0.0), None));
    // A scene without fields has no such system or file.
    fs::write(here.path().join("b.ron"), scene("Plane", "")).unwrap();
    let explain = |name: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_siloflow"))
            .args(["explain", name])
            .current_dir(here.path())
            .output()
            .unwrap();
        text(&output.stdout)
    };
    assert!(explain("a.ron").contains("a field in fields.csv, sampled every 0.001 s"));
    assert!(!explain("b.ron").contains("fields"));
}

#[test]
fn grids_that_do_not_fit_are_refused() {
    let xz = "low: (0.0, 0.0), high: (1.0, 1.0), cells: (2, 2)";
    for (space, grid, code, key) in [
        ("Plane", format!("grid: XZ({xz})"), "scene::dimension", "fields[0].grid"),
        ("Solid", format!("grid: XY({xz})"), "scene::dimension", "fields[0].grid"),
        ("Solid", format!("grid: XZ({xz})"), "scene::missing_key", "fields[0].grid"),
        ("Solid", format!("grid: XZ({xz}, y: (0.2, 0.1))"), "scene::empty_box", "fields[0].grid"),
        ("Plane", format!("grid: XY({})", xz.replace("1.0, 1.0", "1.0, 0.0")), "scene::empty_box", "fields[0].grid"),
        (
            "Plane",
            format!("grid: XY({})", xz.replace("(2, 2)", "(2, 0)")),
            "scene::out_of_range",
            "fields[0].grid.cells",
        ),
        (
            "Plane",
            format!("grid: XY({})", xz.replace("(2, 2)", "(9000, 9000)")),
            "scene::out_of_range",
            "fields[0].grid.cells",
        ),
        (
            "Solid",
            "grid: RZ(radius: 1.0, low: 0.0, high: 1.0, cells: (2, 2)), kernel: Gaussian(0.1)".to_owned(),
            "scene::out_of_range",
            "fields[0].kernel",
        ),
    ] {
        let text = scene(space, &format!("({grid}, sample: 0.01)"));
        let fault = load::from_text("a.ron", "a", Path::new("."), text, &[]).unwrap_err();
        assert_eq!((fault.code(), fault.scene_key()), (code, Some(key)), "{fault}");
    }
    let good = format!("(grid: XY({xz}), sample: 1.0e-6)");
    let fault = load::from_text("a.ron", "a", Path::new("."), scene("Plane", &good), &[]).unwrap_err();
    assert_eq!(fault.scene_key(), Some("fields[0].sample"), "{fault}");
}
