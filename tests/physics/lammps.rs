//! Comparison with another program: LAMMPS 29Sep2021, `pair_style gran/hooke`, 20 discs in a box under gravity, same
//! integration scheme.
//!
//! k_n = 1e5 N/m, gamma_n = 400 1/s on m_eff, attraction allowed, walls x = 0, x = 0.5 m and y = 0, dt = 1e-5 s. The
//! start is `tests/data/A_initial.csv`, and the frames are in `A_frames_dt1e-5.csv` (17 digits).

use std::num::NonZeroUsize;
use std::path::Path;

use siloflow::prelude::*;

use crate::{motion, state};

#[test]
fn twenty_discs_agree_with_lammps_within_a_nanometre() {
    let keys = "(gravity: (0.0, -9.81), contact: Linear(k: 1.0e5, damping: PerMass(400.0), attraction: Allowed), \
         walls: [HalfPlane(point: (0.0, 0.0), normal: (1.0, 0.0)), HalfPlane(point: (0.5, 0.0), normal: (-1.0, 0.0)), \
         HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))], integrator: Verlet, step: Fixed(1.0e-5), grains: (file: \"A_initial.csv\"), until: 0.2)";
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let loaded = load::from_text("a.ron", "a", &data, keys.to_owned(), &[]).unwrap();
    let mut simulation = Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN).unwrap();
    let frames = std::fs::read_to_string(data.join("A_frames_dt1e-5.csv")).unwrap();
    let mut compared = 0;
    for line in frames.lines().skip(1) {
        let row: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let time = row[0];
        let id = row[1] as usize;
        let x = Vector::new(row[2], row[3]);
        if time > 0.2 + 1e-9 {
            continue;
        }
        simulation.run_steps((time / 1e-5).round() as u64);
        let ours = state(&mut simulation)[id - 1].0;
        // The scheme is the same, the order of summation differs. Collisions amplify the round-off (Lyapunov) to below
        // 1e-9 m by 0.2 s.
        assert!(ours.distance(x) < 1e-9, "t = {time} s, grain {id}: {:e} m apart", ours.distance(x));
        compared += 1;
    }
    assert!(compared >= 100, "only {compared} positions compared");
}

#[test]
fn twenty_frictional_spheres_agree_with_lammps_within_a_nanometre() {
    // LAMMPS: `pair_style gran/hooke/history` and `fix wall/gran hooke/history`, with the parameters in
    // `tests/data/friction.in`. There are about a hundred contacts in 0.05 s, and most of them both stick and slide.
    let wall = |point: &str, normal: &str| format!("HalfPlane(point: {point}, normal: {normal})");
    let walls = [
        wall("(0.0, 0.0, 0.0)", "(1.0, 0.0, 0.0)"),
        wall("(0.032, 0.0, 0.0)", "(-1.0, 0.0, 0.0)"),
        wall("(0.0, 0.0, 0.0)", "(0.0, 1.0, 0.0)"),
        wall("(0.0, 0.032, 0.0)", "(0.0, -1.0, 0.0)"),
        wall("(0.0, 0.0, 0.0)", "(0.0, 0.0, 1.0)"),
    ];
    let keys = format!(
        "(space: Solid, gravity: (0.0, 0.0, -9.81), contact: Linear(k: 1.0e5, damping: PerMass(4000.0), \
         attraction: Allowed, tangential: Spring(k: 28571.428571428572, damping: PerMass(1500.0), friction: 0.5), \
         lever: Radius), walls: [{}], integrator: Verlet, step: Fixed(2.0e-6), grains: (file: \"friction_initial.csv\"), until: 0.05)",
        walls.join(", ")
    );
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let loaded = load::from_text("f.ron", "f", &data, keys, &[]).unwrap();
    let mut simulation = Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN).unwrap();
    let frames = std::fs::read_to_string(data.join("friction_frames.csv")).unwrap();
    let mut compared = 0;
    for line in frames.lines().skip(1) {
        let row: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let time = row[0];
        let id = row[1] as usize;
        let x = Solid::new(row[2], row[3], row[4]);
        simulation.run_steps((time / 2.0e-6).round() as u64);
        let ours = motion(&mut simulation)[id - 1];
        // The scheme is the same, the order of summation differs. A round-off of 7e-18 m grows 3e4 times by 0.05 s
        // (measured with a shift of 1e-14 m). A large factor covers effects that this estimate omits. A run with mu +
        // 1e-4 is 2e-4 m away.
        assert!(ours.position.distance(x) < 1e-9, "t = {time} s, grain {id}: {:e} m", ours.position.distance(x));
        compared += 1;
    }
    assert_eq!(compared, 220);
}
