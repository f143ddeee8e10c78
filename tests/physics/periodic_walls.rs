//! Walls at the sides of a periodic box: a grain that passes a side meets the image of the wall beyond, as if the wall stood there.

use siloflow::dem::walls::surfaces::Surfaces;
use siloflow::prelude::*;

use crate::{Motion, grain, motion, simulation, sphere};

const R: f64 = 0.005;
const MASS: f64 = 0.001;
const STEP: f64 = 2.0e-5;
/// Side of the box, m.
const BOX: f64 = 0.1;

/// A key that stands for open sides.
const OPEN: &str = "cull: (below: -1.0)";

fn keys(space: &str, more: &str, walls: &str) -> String {
    let gravity = if space == "Solid" { "(0.0, 0.0, -9.81)" } else { "(0.0, -9.81)" };
    format!(
        "space: {space}, gravity: {gravity}, contact: Linear(k: 1.0e4, damping: Restitution(0.5), tangential: \
         Spring(k: 2.857e3, damping: OfNormal(0.5), friction: 0.3)), step: Fixed({STEP:?}), walls: [{walls}], until: 10.0, \
         on_loss: Continue, watchdog: (energy: None), series: (interval: 1.0e6), {more}"
    )
}

/// The largest distance between motions of a grain in a periodic box and in open space, up to whole boxes on these axes, m; and
/// between its spins, in radii per second, m/s.
fn apart(periodic: Motion, open: Motion, axes: &[usize]) -> [f64; 2] {
    let mut between = periodic.position - open.position;
    for &axis in axes {
        between[axis] -= BOX * (between[axis] / BOX).round();
    }
    [between.length(), (periodic.spin - open.spin).length() * R]
}

#[test]
fn a_grain_that_passes_a_side_goes_on_as_in_open_space() {
    let side = "periodic: (x: (0.0, 0.1), y: (0.0, 0.1))";
    // Each wall reaches beyond a side; the grain starts inside and passes it on the wall.
    let from = Solid::new(0.085, 0.05, 0.00499);
    let along = Solid::new(0.3, 0.0, 0.0);
    let diagonal = (Solid::new(0.09, 0.09, 0.00499), Solid::new(0.2, 0.2, 0.0));
    for (wall, (x, v)) in [
        ("Panel(corner: (0.06, 0.01, 0.0), along: (0.09, 0.0, 0.0), across: (0.0, 0.08, 0.0))", (from, along)),
        (
            "Polygon(points: [(0.06, 0.01, 0.0), (0.15, 0.01, 0.0), (0.15, 0.09, 0.0), (0.06, 0.09, 0.0)])",
            (from, along),
        ),
        ("Annulus(centre: (0.1, 0.05, 0.0), normal: (0.0, 0.0, 1.0), outer: 0.04)", (from, along)),
        (
            "Panel(corner: (0.06, 0.01, 0.0), along: (0.09, 0.0, 0.0), across: (0.0, 0.08, 0.0), hole: Circle(centre: (0.13, 0.05, 0.0), radius: 0.01))",
            (from, along),
        ),
        ("Sphere(centre: (0.1, 0.05, -0.2), radius: 0.2, name: \"bump\")", (from, along)),
        ("Cylinder(from: (0.1, 0.0, -0.2), to: (0.1, 0.1, -0.2), radius: 0.2)", (from, along)),
        ("Panel(corner: (0.05, 0.05, 0.0), along: (0.1, 0.0, 0.0), across: (0.0, 0.1, 0.0))", diagonal),
        ("Polygon(points: [(0.05, 0.05, 0.0), (0.15, 0.05, 0.0), (0.15, 0.15, 0.0), (0.05, 0.15, 0.0)])", diagonal),
        // Wider than the box, so that its images overlap it.
        (
            "Panel(corner: (-0.13, 0.01, 0.0), along: (0.4, 0.0, 0.0), across: (0.0, 0.08, 0.0), name: \"wide\")",
            (from, along),
        ),
        (
            "Polygon(points: [(-0.13, 0.01, 0.0), (0.35, 0.01, 0.0), (0.35, 0.09, 0.0), (-0.13, 0.09, 0.0)])",
            (from, along),
        ),
    ] {
        let [mut periodic, mut open] =
            [side, OPEN].map(|side| simulation(&keys("Solid", side, wall), vec![sphere(1, x, v, R, MASS)]));
        let mut slid = 0.0f64;
        for sample in 1..=60 {
            periodic.run_steps(100 * sample);
            open.run_steps(100 * sample);
            let [here, there] = [&mut periodic, &mut open].map(|run| motion(run)[0]);
            // Rounding of the passage, about 1e-17 m, and of contacts, which damp it.
            let apart = apart(here, there, &[0, 1]);
            assert!(apart[0] < 1e-11 && apart[1] < 1e-9, "{wall}: {apart:?}");
            slid = slid.max(there.position.x);
        }
        assert!(slid > 0.104, "it has passed the side: {slid}");
    }
}

#[test]
fn a_disc_passes_a_side_on_a_segment() {
    let wall = "Segment(from: (0.06, 0.0), to: (0.15, 0.0))";
    let disc = || vec![grain(1, Vector::new(0.085, 0.00499), Vector::new(0.3, 0.0), R, MASS)];
    let [mut periodic, mut open] =
        ["periodic: (x: (0.0, 0.1))", OPEN].map(|side| simulation(&keys("Plane", side, wall), disc()));
    periodic.run_steps(6000);
    open.run_steps(6000);
    let [here, there] = [&mut periodic, &mut open].map(|run| motion(run)[0]);
    let apart = apart(here, there, &[0]);
    assert!(there.position.x > 0.104 && apart[0] < 1e-11 && apart[1] < 1e-9, "{apart:?}");
}

#[test]
fn a_wall_that_moves_carries_grains_on_its_images() {
    // A table that shakes and a drum plate that turns about the periodic axis.
    for motions in [
        "translate: Oscillate(amplitude: (0.002, 0.0, 0.001), frequency: 8.0)",
        "rotate: (about: (0.1, 0.05, 0.0), axis: (1.0, 0.0, 0.0), by: Oscillate(amplitude: 0.05, frequency: 4.0))",
    ] {
        let wall =
            "Panel(corner: (0.06, 0.01, 0.0), along: (0.09, 0.0, 0.0), across: (0.0, 0.08, 0.0), name: \"table\")";
        let ball = || vec![sphere(1, Solid::new(0.092, 0.05, 0.00499), Solid::new(0.15, 0.0, 0.0), R, MASS)];
        let [mut periodic, mut open] = ["periodic: (x: (0.0, 0.1))", OPEN].map(|side| {
            let more = format!("{side}, motions: [(walls: \"table\", {motions})]");
            simulation(&keys("Solid", &more, wall), ball())
        });
        periodic.run_steps(6000);
        open.run_steps(6000);
        let [here, there] = [&mut periodic, &mut open].map(|run| motion(run)[0]);
        let apart = apart(here, there, &[0]);
        assert!(there.position.x > 0.102 && apart[0] < 1e-10 && apart[1] < 1e-8, "{motions}: {apart:?} {there:?}");
        let loads = [&periodic, &open].map(|run| run.world().resource::<Surfaces<Solid>>().loads.clone());
        assert_eq!(loads.each_ref().map(Vec::len), [1, 1]);
        assert!((loads[0][0].force - loads[1][0].force).length() < 1e-6, "{loads:?}");
        // The images turn about the axis too, so that torques about the axis are those of the wall.
        assert!((loads[0][0].torque - loads[1][0].torque).length() < 1e-7, "{loads:?}");
    }
}

#[test]
fn a_wall_just_inside_a_side_is_met_by_a_grain_that_comes_through_the_side() {
    // The wall has no image that a grain reaches, but a list of near walls from before the passage lacks it.
    let wall = "Panel(corner: (0.0062, 0.0, -0.1), along: (0.0, 0.1, 0.0), across: (0.0, 0.0, 0.2))";
    let ball = vec![sphere(1, Solid::new(0.0999, 0.05, 0.0), Solid::new(0.5, 0.0, 0.0), R, MASS)];
    let mut run = simulation(&keys("Solid", "periodic: (x: (0.0, 0.1), y: (0.0, 0.1))", wall), ball);
    run.run_steps(500);
    assert!(motion(&mut run)[0].velocity.x < 0.0, "it bounces off");
}

#[test]
fn walls_that_are_the_same_in_all_images_have_none() {
    let count = |wall: &str| {
        let ball = vec![sphere(1, Solid::new(0.05, 0.05, 0.02), Solid::ZERO, R, MASS)];
        let run = simulation(&keys("Solid", "periodic: (x: (0.0, 0.1), y: (0.0, 0.1))", wall), ball);
        run.world().resource::<Surfaces<Solid>>().all.len()
    };
    for wall in [
        "HalfSpace(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))",
        "HalfSpace(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0), velocity: (0.1, 0.0, 0.0))",
        "Panel(corner: (0.0, 0.0, 0.0), along: (0.1, 0.0, 0.0), across: (0.0, 0.1, 0.0))",
        "Panel(corner: (-0.1, -0.1, 0.0), along: (0.3, 0.0, 0.0), across: (0.0, 0.3, 0.0))",
        "Panel(corner: (0.03, 0.03, 0.0), along: (0.04, 0.0, 0.0), across: (0.0, 0.04, 0.0))",
        "Cylinder(from: (0.05, 0.0, 0.0), to: (0.05, 0.1, 0.0), radius: 0.01)",
    ] {
        assert_eq!(count(wall), 1, "{wall}");
    }
    // Images beyond one side, at both sides, and round a corner.
    assert_eq!(count("Panel(corner: (0.05, 0.03, 0.0), along: (0.07, 0.0, 0.0), across: (0.0, 0.04, 0.0))"), 2);
    assert_eq!(count("Panel(corner: (0.002, 0.03, 0.0), along: (0.096, 0.0, 0.0), across: (0.0, 0.04, 0.0))"), 3);
    assert_eq!(count("Panel(corner: (0.09, 0.09, 0.0), along: (0.02, 0.0, 0.0), across: (0.0, 0.02, 0.0))"), 4);
}

#[test]
fn walls_without_images_are_refused() {
    let refused = |more: &str, wall: &str| {
        let grains = "fill: [(low: (0.04, 0.04, 0.02), high: (0.06, 0.06, 0.04), spacing: 0.02, radius: Fixed(0.005))], mass: Sphere(2000.0)";
        let text = format!("({}, {grains}, pictures: None)", keys("Solid", more, wall));
        load::from_text("p.ron", "p", std::path::Path::new(""), text, &[]).err().map(|fault| fault.to_string())
    };
    let side = "periodic: (x: (0.0, 0.1), y: (0.0, 0.1))";
    let paddle =
        "Panel(corner: (0.04, 0.04, 0.0), along: (0.058, 0.0, 0.0), across: (0.0, 0.02, 0.0), name: \"paddle\")";
    let turns = |axis: &str| {
        format!(
            "{side}, motions: [(walls: \"paddle\", rotate: (about: (0.05, 0.05, 0.0), axis: {axis}, by: Steady(2.0)))]"
        )
    };
    let said = refused(&turns("(0.0, 0.0, 1.0)"), paddle).expect("refused");
    assert!(said.contains("turn"), "{said}");
    assert_eq!(refused(&turns("(0.0, 0.0, 1.0)"), &paddle.replace("0.058", "0.02")), None);
    let said = refused(side, "HalfSpace(point: (0.0, 0.0, 0.0), normal: (0.1, 0.0, 1.0))").expect("refused");
    assert!(said.contains("periodic axis x"), "{said}");
    assert_eq!(
        refused("periodic: (y: (0.0, 0.1))", "HalfSpace(point: (0.0, 0.0, 0.0), normal: (0.1, 0.0, 1.0))"),
        None
    );
    let endless = "Panel(corner: (-1.0e6, 0.04, 0.0), along: (2.0e6, 0.0, 100.0), across: (0.0, 0.02, 0.0))";
    assert!(refused(side, endless).expect("refused").contains("images"));
}
