//! The scene key `slopes`: grains on an inclined wall, so that the angle is known.

use std::f64::consts::FRAC_PI_4;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::command_line::{siloflow, text};
use siloflow_files::table::Table;

const ANGLE: f64 = 20.0;

/// Discs of radius 0.1 m on a wall that falls by 20 degrees to the right, a little pressed into it, and one in flight above them. Without gravity
/// none has moved at the start.
fn run(here: &Path, space: &str, more: &str) -> (Value, Table) {
    let angle = ANGLE.to_radians();
    let is_solid = space == "Solid";
    let mut grains = if is_solid { "id,radius,mass,x,y,z,vx,vy,vz\n" } else { "id,radius,mass,x,y,vx,vy\n" }.to_owned();
    let mut add = |id: u32, along: f64, above: f64| {
        let x = along * angle.cos() + above * angle.sin();
        let height = above * angle.cos() - along * angle.sin();
        let place = if is_solid { format!("{x},0.0,{height},0,0,0") } else { format!("{x},{height},0,0") };
        writeln!(grains, "{id},0.1,1.0,{place}").unwrap();
    };
    (1..=20).for_each(|id| add(id, 0.3 * f64::from(id), 0.0999));
    add(21, 2.0, 1.0);
    fs::write(here.join("grains.csv"), grains).unwrap();
    let (low, high, normal, right, zero) = if is_solid {
        (
            "(-9.0, -9.0, -9.0)",
            "(9.0, 9.0, 9.0)",
            format!("({}, 0.0, {})", angle.sin(), angle.cos()),
            "(1.0, 0.0, 0.0)",
            "(0.0, 0.0, 0.0)",
        )
    } else {
        ("(-9.0, -9.0)", "(9.0, 9.0)", format!("({}, {})", angle.sin(), angle.cos()), "(1.0, 0.0)", "(0.0, 0.0)")
    };
    let scene = format!(
        "(space: {space}, gravity: {zero}, contact: Linear(k: 1.0e4, damping: Restitution(0.5)), step: Fixed(1.0e-4), until: 1.0e-3,
        walls: [HalfPlane(point: {zero}, normal: {normal})], grains: (file: \"grains.csv\"), series: (interval: 5.0e-4), pictures: None,
        slopes: [
            (name: \"right\", falls: Along({right}), low: {low}, high: {high}, from: 0.0),
            (name: \"out\", falls: Outwards({zero}), low: {low}, high: {high}, heights: (0.25, 0.75), cell: 0.25),
            (name: \"in\", falls: Inwards({zero}), low: {low}, high: {high}),
            (name: \"nothing\", falls: Along({right}), low: (8.0, {}), high: {high}),
        ], {more})",
        if is_solid { "8.0, 8.0" } else { "8.0" }
    );
    fs::write(here.join("bank.ron"), scene).unwrap();
    let output = siloflow(here, &["run", "bank.ron", "--json", "--quiet", "--force"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let table = Table::parse("slopes.csv", &fs::read_to_string(here.join("out/bank/slopes.csv")).unwrap()).unwrap();
    (serde_json::from_slice(&output.stdout).unwrap(), table)
}

#[test]
fn a_bank_has_its_angle_in_the_plane_and_in_space() {
    for space in ["Plane", "Solid"] {
        let here = tempfile::tempdir().unwrap();
        let (summary, table) = run(here.path(), space, "");
        let angles = table.numbers("angle_deg").unwrap();
        assert_eq!(angles.len(), 3 * 4, "three times");
        // All grains that touch the wall lie on a line. With two mean diameters or 0.25 m some cells have several, of which the highest counts.
        assert!((angles[0] - ANGLE).abs() < 1e-9 && (angles[1] - ANGLE).abs() < 1e-9, "{angles:?}");
        assert!((angles[2] + ANGLE).abs() < 1e-9 && angles[3].is_nan(), "{angles:?}");
        let points = table.numbers("points").unwrap();
        assert!(points[0] >= 10.0 && points[1] <= 11.0 && points[3] == 0.0, "{points:?}");
        let of = |number: usize, key: &str| summary["slopes"][number][key].clone();
        // The first window holds all three rows, the others begin with the end of the run. The wall has pushed all grains alike.
        assert_eq!((of(0, "rows"), of(1, "rows"), of(3, "rows")), (3.into(), 1.into(), 0.into()));
        assert!((of(0, "angle_deg").as_f64().unwrap() - ANGLE).abs() < 1e-6, "{summary}");
        assert!(of(3, "angle_deg").is_null() && of(1, "deviation_deg").is_null());
    }
}

#[test]
fn both_spheres_of_a_grain_count_if_one_touches() {
    let here = tempfile::tempdir().unwrap();
    // Dumbbells on a level floor, each leaning on it with its lower disc: their upper discs are the surface.
    let mut grains = "id,shape,scale,mass,angle,x,y,vx,vy\n".to_owned();
    for id in 1..=8 {
        let height = 0.0999 + 0.05 * 0.5_f64.sqrt();
        let x = 0.5 * f64::from(id) + 0.25;
        writeln!(grains, "{id},pair,1.0,0.05,{FRAC_PI_4},{x},{height},0,0").unwrap();
    }
    fs::write(here.path().join("pairs.csv"), grains).unwrap();
    let scene = "(gravity: (0.0, 0.0), contact: Linear(k: 1.0e4, damping: Restitution(0.5)), step: Fixed(1.0e-5), until: 1.0e-4, mass: Disc(1.0),
        shapes: {\"pair\": Discs([(at: (-0.05, 0.0), radius: 0.1), (at: (0.05, 0.0), radius: 0.1)])},
        walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))], grains: (file: \"pairs.csv\"), series: (interval: 1.0), pictures: None,
        slopes: [(name: \"top\", falls: Along((1.0, 0.0)), low: (-9.0, -9.0), high: (9.0, 9.0), cell: 0.5)])";
    fs::write(here.path().join("pairs.ron"), scene).unwrap();
    let output = siloflow(here.path(), &["run", "pairs.ron", "--quiet"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let table =
        Table::parse("slopes.csv", &fs::read_to_string(here.path().join("out/pairs/slopes.csv")).unwrap()).unwrap();
    let top = 0.0999 + 0.1 * 0.5_f64.sqrt() + 0.1;
    assert!((table.numbers("height_m").unwrap()[0] - top).abs() < 1e-9, "{:?}", table.numbers("height_m"));
    assert!(table.numbers("angle_deg").unwrap()[0].abs() < 1e-9);
}
