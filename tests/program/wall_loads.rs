//! Loads on walls: means over time, of walls of one name together, and by height.

use std::fs;
use std::path::Path;

use crate::command_line::{siloflow, text};

/// Runs a scene of the text `scene` with the grain file `grains`, and returns its directory.
fn run(here: &Path, scene: &str, grains: &str) {
    fs::write(here.join("a.ron"), scene).unwrap();
    fs::write(here.join("grains.csv"), grains).unwrap();
    let done = siloflow(here, &["run", "a.ron", "--quiet", "--out", "out"]);
    assert!(done.status.success(), "{}", text(&done.stderr));
}

/// Returns the columns of a CSV file below its header as rows of numbers; words become NaN.
fn rows(file: &Path) -> Vec<Vec<f64>> {
    let content = fs::read_to_string(file).unwrap();
    let row = |line: &str| line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
    content.lines().skip(1).map(row).collect()
}

#[test]
fn the_mean_force_is_the_change_of_momentum() {
    let here = tempfile::tempdir().unwrap();
    // The grain falls by 0.1 m in 0.143 s, bounces for about 0.02 s, and flies again at 0.2 s.
    let scene = "(gravity: (0.0, -9.81), contact: Linear(k: 1.0e3, damping: Restitution(0.8)), integrator: Verlet,
        step: Fixed(1.0e-4), until: 0.2, grains: (file: \"grains.csv\"), pictures: None, series: (interval: 0.2),
        walls: [Segment(from: (-1.0, 0.0), to: (0.0, 0.0), name: \"floor\"),
            Segment(from: (0.0, 0.0), to: (1.0, 0.0), name: \"floor\")])";
    run(here.path(), scene, "id,radius,mass,x,y,vx,vy\n1,0.02,0.05,0.3,0.12,0,0\n");
    let walls = rows(&here.path().join("out/walls.csv"));
    let groups = rows(&here.path().join("out/wall_groups.csv"));
    let state = rows(&here.path().join("out/state.csv"));
    let header = fs::read_to_string(here.path().join("out/state.csv")).unwrap();
    let column = header.lines().next().unwrap().split(',').position(|name| name == "vy").unwrap();
    // In velocity Verlet the change of momentum is the sum of forces times dt, with half weights at both ends. There the
    // grain is in flight, so the sum is exact up to rounding of 2000 numbers.
    let expected = -(0.05 * state[0][column] / 0.2 + 0.05 * 9.81);
    assert!(expected < -0.1 && state[0][column] > 0.0, "{expected}");
    let [left, right, both] = [&walls[2], &walls[3], &groups[1]];
    assert_eq!((left[3], left[4]), (0.0, 0.0));
    assert!((right[3] - expected).abs() < 1e-12, "{} {expected}", right[3]);
    assert!((both[3] - expected).abs() < 1e-12, "{} {expected}", both[3]);
    // About the left end of each segment, at x = 0 and at x = -1.
    assert!(
        (right[4] - 0.3 * expected).abs() < 1e-12 && (both[4] - 1.3 * expected).abs() < 1e-12,
        "{right:?} {both:?}"
    );
}

#[test]
fn a_disc_in_a_groove_presses_as_statics_says() {
    let here = tempfile::tempdir().unwrap();
    let scene = "(gravity: (0.0, -9.81), contact: Linear(k: 1.0e5, damping: Restitution(0.3)), step: Fixed(1.0e-5), until: 0.5,
        grains: (file: \"grains.csv\"), pictures: None,
        walls: [Segment(from: (0.0, 0.0), to: (1.0, 1.0), name: \"groove\"), Segment(from: (0.0, 0.0), to: (-1.0, 1.0), name: \"groove\")],
        wall_bands: [(walls: \"groove\", low: 0.0, high: 0.1, bins: 4, sample: 1.0e-3, from: 0.4)])";
    // The points of contact are at the height R/sqrt(2) = 0.0354 m, in the second bin.
    let height = 0.05 * 2f64.sqrt();
    run(here.path(), scene, &format!("id,radius,mass,x,y,vx,vy\n1,0.05,0.2,0,{height},0,0\n"));
    let bands = rows(&here.path().join("out/wall_bands.csv"));
    assert_eq!(bands.len(), 4);
    // Two lines of slope 1 over a height of 0.025 m.
    let length = 2.0 * 0.025 * 2f64.sqrt();
    // After 0.4 s the swing has decayed by exp(-1.2/pi w t) with w = 1000/s: far below rounding.
    let pressure = 2.0 * 0.2 * 9.81 / 2f64.sqrt() / length;
    assert!((bands[1][6] / length - 1.0).abs() < 1e-9, "{bands:?}");
    assert!((bands[1][8] / pressure - 1.0).abs() < 1e-5 && bands[1][7] == 2.0, "{bands:?} {pressure}");
    assert!([0, 2, 3].iter().all(|&bin: &usize| bands[bin][8] == 0.0) && bands[1][9] == 0.0, "{bands:?}");
}

#[test]
fn walls_and_floor_carry_the_weight_and_bands_add_up_to_the_walls() {
    let here = tempfile::tempdir().unwrap();
    let scene = "(seed: 1, gravity: (0.0, -9.81), mass: Disc(1.0e3), step: Fixed(2.0e-5), until: 2.5, integrator: Verlet,
        contact: Linear(k: 1.0e5, damping: Restitution(0.3), tangential: Spring(k: 2.857e4, damping: OfNormal(0.5), friction: 0.5)),
        fill: [(low: (-0.09, 0.0), high: (0.09, 0.6), spacing: 0.025, count: 150, radius: Uniform(0.01, 0.012), jitter: 1.0e-3)],
        pictures: None, series: (interval: 0.5),
        walls: [Segment(from: (-0.1, 0.0), to: (0.1, 0.0), name: \"floor\"), Segment(from: (-0.1, 0.0), to: (-0.1, 1.0), name: \"walls\"),
            Segment(from: (0.1, 0.0), to: (0.1, 1.0), name: \"walls\")],
        wall_bands: [(walls: \"walls\", low: 0.0, high: 1.0, bins: 10, sample: 2.0e-5, from: 2.00001)])";
    run(here.path(), scene, "");
    let groups = rows(&here.path().join("out/wall_groups.csv"));
    let state = rows(&here.path().join("out/state.csv"));
    let weight: f64 =
        9.81 * state.iter().map(|row| 1.0e3 * std::f64::consts::PI * row[radius(here.path())].powi(2)).sum::<f64>();
    let [floor, walls] = [&groups[groups.len() - 2], &groups[groups.len() - 1]];
    // The difference is the change of momentum in the last half second; the bed moves by less than 1 mm/s.
    assert!((floor[3] + walls[3] + weight).abs() < 2e-3 / 9.81 * weight, "{floor:?} {walls:?} {weight}");
    // The bed has fallen and sprung back, so friction may pull the walls either way.
    assert!(walls[3].abs() > 0.02 * weight, "friction acts: {walls:?}");
    let bands = rows(&here.path().join("out/wall_bands.csv"));
    let carried: f64 = bands.iter().map(|row| row[9] * row[6]).sum();
    // Damping forces of a bed at rest are the difference between the law here and in the force pass.
    assert!((carried + walls[3]).abs() < 1e-4 * weight, "{carried} {walls:?}");
}

/// Returns the number of the column of radii in `state.csv`.
fn radius(here: &Path) -> usize {
    let header = fs::read_to_string(here.join("out/state.csv")).unwrap();
    header.lines().next().unwrap().split(',').position(|name| name == "radius").unwrap()
}
