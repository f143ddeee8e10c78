//! The watchdog in scenes whose energies are those of round-off: beds that touch exactly, in any units, without gravity.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use siloflow::prelude::*;

use crate::simulation;

/// Spheres of radius `r` m that touch on a cubic lattice with 4 places along each axis, with its corner `corner` radii from the origin.
fn lattice(here: &Path, r: f64, corner: f64) {
    let mut rows = "id,radius,mass,x,y,z,vx,vy,vz\n".to_owned();
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * r * r * r;
    for id in 0..64 {
        let at = [id / 16, id / 4 % 4, id % 4].map(|place| r * (corner + 2.0 * f64::from(place)));
        let _ = writeln!(rows, "{},{r:e},{mass:e},{:e},{:e},{:e},0,0,0", id + 1, at[0], at[1], at[2]);
    }
    fs::write(here.join("lattice.csv"), rows).unwrap();
}

/// Runs such a bed without gravity, with a contact law, and returns how it ends. The step is a fiftieth of a contact.
fn end(r: f64, corner: f64, law: &dyn Fn(f64) -> String, step: f64) -> End {
    let here = tempfile::tempdir().unwrap();
    lattice(here.path(), r, corner);
    let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * r * r * r;
    let scene = format!(
        "(space: Solid, gravity: (0.0, 0.0, 0.0), contact: {}, step: Fixed({step:e}), until: {:e},
        grains: (file: \"lattice.csv\"), watchdog: (every: 50), pictures: None, checkpoint: None)",
        law(mass),
        3000.0 * step
    );
    let loaded = load::from_text("rest.ron", "rest", here.path(), scene, &[]).unwrap_or_else(|fault| panic!("{fault}"));
    simulation(&loaded, 1).run()
}

#[test]
fn a_bed_that_touches_exactly_stays_without_gravity_in_any_units() {
    let linear = |k: f64, damping: &str| {
        let damping = damping.to_owned();
        move |_: f64| {
            format!(
                "Linear(k: {k:e}, damping: {damping}, tangential: Spring(k: {:e}, damping: OfNormal(0.5), friction: 0.4))",
                2.0 / 7.0 * k
            )
        }
    };
    // Radii of a powder, of grains and of boulders, near the origin and in the coordinates of a site.
    for (r, k) in [(1e-6, 10.0), (0.005, 1e4), (10.0, 1e9)] {
        let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * r * r * r;
        let step = 0.02 * std::f64::consts::PI * (mass / (2.0 * k)).sqrt();
        for corner in [1.0, 20.7, 3e5] {
            for damping in ["Restitution(0.5)", "PerMass(0.0)"] {
                let found = end(r, corner, &linear(k, damping), step);
                assert_eq!(found, End::TimeReached, "r = {r} m, corner at {corner} r, {damping}");
            }
        }
    }
    let hertz = |_: f64| "Hertz(restitution: 0.5), materials: [(young: 5.0e6, poisson: 0.3)]".to_owned();
    for corner in [1.0, 20.7, 3e5] {
        assert_eq!(end(0.005, corner, &hertz, 1e-5), End::TimeReached, "Hertz, corner at {corner} r");
    }
}
