//! Bench tests of grains: shipped scenes and small ones, against closed forms.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use crate::command_line::{siloflow, text};
use siloflow_files::table::Table;

/// Runs a scene with settings and returns a table of its run.
fn table(here: &Path, scene: &Path, settings: &[&str], file: &str) -> Table {
    let name = scene.display().to_string();
    let mut arguments = vec!["run", &name, "--quiet", "--force", "--out", "out"];
    for setting in settings {
        arguments.extend(["--set", setting]);
    }
    let output = siloflow(here, &arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    Table::parse(file, &fs::read_to_string(here.join("out").join(file)).unwrap()).unwrap()
}

/// The mean of a column over the rows with this name from a time on.
fn mean(table: &Table, walls: &str, column: &str, from: f64) -> f64 {
    let times = table.numbers("time_s").unwrap();
    let names = table.texts("walls").unwrap();
    let values = table.numbers(column).unwrap();
    let mine: Vec<f64> =
        (0..times.len()).filter(|&row| names[row] == walls && times[row] >= from).map(|row| values[row]).collect();
    mine.iter().sum::<f64>() / mine.len() as f64
}

#[test]
fn a_plate_that_slides_under_a_sample_has_the_friction_of_its_contacts() {
    let here = tempfile::tempdir().unwrap();
    let scene = crate::scene("wall-friction.ron");
    let forces = table(here.path(), &scene, &["pictures=None"], "wall_groups.csv");
    // The bed sticks and slips for up to 3.6 s in 24 seeds. Then grains held by their neighbours cannot roll, so every contact with the plate slides: the ratio is the coefficient, not above it.
    let friction = -mean(&forces, "plate", "fx_n", 4.0) / -mean(&forces, "plate", "fy_n", 4.0);
    assert!((friction - 0.2).abs() < 2e-4, "{friction}");
    // Momentum: the lid holds what the plate pulls, and carries its load of 300 N.
    assert!((mean(&forces, "lid", "fx_n", 4.0) / -mean(&forces, "plate", "fx_n", 4.0) - 1.0).abs() < 1e-3);
    assert!((mean(&forces, "lid", "fy_n", 4.0) / 300.0 - 1.0).abs() < 1e-3);
}

#[test]
fn a_sphere_jumps_to_the_square_of_the_restitution() {
    let here = tempfile::tempdir().unwrap();
    for restitution in ["0.8", "0.5"] {
        let setting = format!("parameters.restitution={restitution}");
        let centres = table(here.path(), &crate::scene("drop.ron"), &[&setting, "pictures=None"], "centres.csv");
        let heights = centres.numbers("z_m").unwrap();
        let times = centres.numbers("time_s").unwrap();
        let after = (0..times.len()).filter(|&row| times[row] > 0.25).map(|row| heights[row]).fold(0.0, f64::max);
        let ratio = (after - 0.005) / (heights[0] - 0.005);
        let expected = restitution.parse::<f64>().unwrap().powi(2);
        // The step keeps the error of the velocity after an impact at 1e-3, so that of the height at 2e-3. Gravity during the impact adds
        // g t_c over the speed, 5e-4.
        assert!((ratio / expected - 1.0).abs() < 3e-3, "{restitution}: {ratio}");
    }
}

#[test]
fn a_smooth_cylinder_carries_nothing_of_the_load() {
    let here = tempfile::tempdir().unwrap();
    let settings = ["fill[0].count=100", "free_walls[0].stops=(-0.112, 0.0)", "until=1.4", "pictures=None"];
    let forces = table(here.path(), &crate::scene("compression.ron"), &settings, "wall_groups.csv");
    let floor = -mean(&forces, "floor", "fz_n", 1.33);
    let piston = mean(&forces, "piston", "fz_n", 1.33);
    // A hundred spheres of 1.8 to 2.1 mm and 2500 kg/m^3 weigh about 0.078 N; their radii are random, so within a tenth.
    assert!((piston / 10.0 - 1.0).abs() < 2e-3, "{piston}");
    assert!((floor - piston - 0.078).abs() < 0.008, "{floor} {piston}");
    assert!(mean(&forces, "side", "fz_n", 1.33).abs() < 1e-12);
}

/// Rows of smooth discs, six and five in turn, between smooth walls under a lid: every disc stands on two.
///
/// A disc stands on the two below at the angle a from the vertical, sin a = pitch/(4 R). Between two rows there are ten contacts, whose forces f carry the load,
/// 10 f cos a. A disc at the end of a long row pushes the side by f sin a for each of its contacts with other rows.
#[test]
fn ordered_discs_press_sideways_by_the_tangent_of_their_contacts() {
    let here = tempfile::tempdir().unwrap();
    let radius: f64 = 0.01;
    let pitch = 2.1 * radius;
    let sine = 0.25 * pitch / radius;
    let rise = 2.0 * radius * (1.0 - sine * sine).sqrt();
    let rows = 7u32;
    let mut grains = "id,radius,mass,x,y,vx,vy\n".to_owned();
    let mut id = 0;
    for row in 0..rows {
        let is_long = row % 2 == 0;
        for place in 0..if is_long { 6 } else { 5 } {
            id += 1;
            let x = radius + pitch * (f64::from(place) + if is_long { 0.0 } else { 0.5 });
            let height = radius + rise * f64::from(row);
            writeln!(grains, "{id},{radius},0.3,{x},{height},0,0").unwrap();
        }
    }
    fs::write(here.path().join("grains.csv"), grains).unwrap();
    let width = 5.0 * pitch + 2.0 * radius;
    let top = 2.0 * radius + rise * f64::from(rows - 1);
    let load: f64 = 60.0;
    let scene = format!(
        "(gravity: (0.0, 0.0), contact: Linear(k: 1.0e6, damping: Restitution(0.2)), step: Auto(error: 5.0e-2), until: 0.3,
        grains: (file: \"grains.csv\"), pictures: None, series: (interval: 0.02),
        walls: [Segment(from: (0.0, 0.0), to: ({width}, 0.0), name: \"floor\"), Segment(from: (0.0, -0.01), to: (0.0, 0.2), name: \"left\"),
            Segment(from: ({width}, 0.2), to: ({width}, -0.01), name: \"right\"), Segment(from: (-0.1, {top}), to: (0.3, {top}), name: \"lid\")],
        free_walls: [(walls: \"lid\", moves: Along((0.0, 1.0)), mass: 2.0, load: {}, damping: 400.0, stops: (-0.05, 0.01))])",
        -load
    );
    fs::write(here.path().join("ordered.ron"), scene).unwrap();
    let forces = table(here.path(), Path::new("ordered.ron"), &[], "wall_groups.csv");
    let tangent = sine / (1.0 - sine * sine).sqrt();
    // The first and the last of the four long rows have one such contact on a side, the others two.
    let expected = load / 10.0 * tangent * 6.0;
    for side in ["left", "right"] {
        let pushed = mean(&forces, side, "fx_n", 0.25).abs();
        // Overlaps of 1e-5 m change the angle by 1e-3.
        assert!((pushed / expected - 1.0).abs() < 5e-3, "{side}: {pushed} {expected}");
    }
    assert!((mean(&forces, "floor", "fy_n", 0.25) / -load - 1.0).abs() < 1e-3);
}
