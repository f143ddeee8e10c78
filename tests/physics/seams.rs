//! Seams between walls of any two kinds: with gaps, steps and overlaps of the size of rounded coordinates, a grain touches the union.

use siloflow::dem::walls::surfaces::Surfaces;
use siloflow::prelude::*;

use crate::{grain, motion, simulation, sphere};

/// Radius (m), mass (kg), stiffness (N/m), acceleration (m/s^2) and speed (m/s) of the grain that rolls.
const R: f64 = 0.005;
const MASS: f64 = 0.001;
const K: f64 = 1.0e3;
const G: f64 = 9.81;
const SPEED: f64 = 0.1;

/// Where the walls meet, m. Single precision rounds it to 0.100000001490116.
const SEAM: f64 = 0.1;

fn keys(space: &str, gravity: &str, walls: &str) -> String {
    format!(
        "space: {space}, gravity: {gravity}, contact: Linear(k: {K:?}, damping: Restitution(0.5), tangential: \
         Spring(k: 285.7, damping: OfNormal(0.5), friction: 0.4)), step: Fixed(1.0e-5), walls: [{walls}], until: 1.0e3, \
         on_loss: Continue, watchdog: (energy: None), series: (interval: 1.0e6)"
    )
}

const KINDS: [&str; 5] = ["panel", "polygon", "mesh", "annulus", "holed"];

/// A flat wall from `x0` to `x1` at the height `z`, m.
fn wall(kind: &str, [x0, x1]: [f64; 2], z: f64, directory: &std::path::Path) -> String {
    let length = x1 - x0;
    match kind {
        "panel" => {
            format!("Panel(corner: ({x0:?}, -0.1, {z:?}), along: ({length:?}, 0.0, 0.0), across: (0.0, 0.2, 0.0))")
        }
        "holed" => format!(
            "Panel(corner: ({x0:?}, -0.1, {z:?}), along: ({length:?}, 0.0, 0.0), across: (0.0, 0.2, 0.0), \
             hole: Circle(centre: ({:?}, 0.06, {z:?}), radius: 0.01))",
            0.5 * (x0 + x1)
        ),
        "polygon" => {
            format!(
                "Polygon(points: [({x0:?}, -0.1, {z:?}), ({x1:?}, -0.1, {z:?}), ({x1:?}, 0.1, {z:?}), ({x0:?}, 0.1, {z:?})])"
            )
        }
        // The rim touches the seam in one point, on the way of the grain.
        "annulus" => format!(
            "Annulus(centre: ({:?}, 0.0, {z:?}), normal: (0.0, 0.0, 1.0), outer: {:?})",
            0.5 * (x0 + x1),
            0.5 * length
        ),
        _ => {
            let file = directory.join(format!("{x0:e}-{x1:e}-{z:e}.obj"));
            let corners = format!("v {x0:e} -0.1 {z:e}\nv {x1:e} -0.1 {z:e}\nv {x1:e} 0.1 {z:e}\nv {x0:e} 0.1 {z:e}\n");
            std::fs::write(&file, format!("{corners}f 1 2 3\nf 1 3 4\n")).unwrap();
            format!("Mesh(file: {:?}, unit: Metre)", file.display().to_string())
        }
    }
}

/// Rolls a sphere over the seam of two walls and returns the largest change of its speed, relative to it, and its lowest and highest place
/// above the place of rest, m.
fn roll(walls: &str) -> [f64; 3] {
    let rest = R - MASS * G / K;
    let mut ball = sphere(1, Solid::new(SEAM - 0.002, 0.0, rest), Solid::new(SPEED, 0.0, 0.0), R, MASS);
    ball.spin = Solid::new(0.0, SPEED / R, 0.0);
    let mut run = simulation(&keys("Solid", "(0.0, 0.0, -9.81)", walls), vec![ball]);
    let mut slower = 0.0f64;
    let mut low = 0.0f64;
    let mut high = 0.0f64;
    for sample in 1..=400 {
        run.run_steps(10 * sample);
        let now = motion(&mut run)[0];
        slower = slower.max((now.velocity.x / SPEED - 1.0).abs());
        (low, high) = (low.min(now.position.z - rest), high.max(now.position.z - rest));
    }
    assert!(motion(&mut run)[0].position.x > SEAM + 0.001, "it has rolled over the seam");
    [slower, low, high]
}

#[test]
fn a_sphere_rolls_over_gaps_steps_and_overlaps_as_over_one_wall() {
    let here = tempfile::tempdir().unwrap();
    let left = -0.1;
    let right = 0.3;
    // A gap between walls (negative: an overlap) and a step, m. The last three are those of single precision and of five digits.
    for [gap, step] in
        [[0.0, 0.0], [1e-10, 0.0], [1.49e-9, 0.0], [-0.02, 0.0], [5e-6, 0.0], [1e-8, 3e-8], [-1e-8, -3e-8]]
    {
        for one in KINDS {
            for other in KINDS {
                let walls =
                    [wall(one, [left, SEAM], 0.0, here.path()), wall(other, [SEAM + gap, right], step, here.path())];
                for walls in [walls.join(", "), [walls[1].clone(), walls[0].clone()].join(", ")] {
                    let [slower, low, high] = roll(&walls);
                    // The slope beside a gap is gap/2R at most. The weight acts there for the time gap/v. A step s changes the overlap by s,
                    // and the load m g by k s, for a quarter of a period pi/2 sqrt(m/k); friction can change the speed by mu k s/m times that.
                    let width = gap.max(0.0);
                    let by_gap = G * width / (2.0 * R) * width / SPEED / SPEED;
                    let by_step = 0.4 * K * step.abs() / MASS * 1.6 * (MASS / K).sqrt() / SPEED;
                    assert!(
                        slower < 2.0 * (by_gap + by_step) + 1e-9,
                        "{one} {other} {gap:e} {step:e}: {slower:e}\n{walls}"
                    );
                    // Over the gap it sinks by gap^2/8R, and it swings by a step about the other height.
                    let sinks = width * width / (8.0 * R);
                    let swings = 2.0 * step.abs() + 1e-12;
                    assert!(
                        low > -sinks - swings && high < swings + sinks,
                        "{one} {other} {gap:e} {step:e}: {low:e} {high:e}"
                    );
                }
            }
        }
    }
}

#[test]
fn coincident_walls_of_any_two_kinds_push_once() {
    let here = tempfile::tempdir().unwrap();
    let rest = R - MASS * G / K;
    let half_space = "HalfSpace(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))".to_owned();
    let all: Vec<_> =
        KINDS.iter().map(|kind| wall(kind, [-0.1, 0.3], 0.0, here.path())).chain(std::iter::once(half_space)).collect();
    for one in &all {
        for other in &all {
            let ball = sphere(1, Solid::new(SEAM, 0.0, rest), Solid::ZERO, R, MASS);
            let mut run = simulation(&keys("Solid", "(0.0, 0.0, -9.81)", &format!("{one}, {other}")), vec![ball]);
            run.run_steps(2000);
            // At rest it overlaps by m g/k, to the rounding of its height.
            let overlap = R - motion(&mut run)[0].position.z;
            assert!((overlap * K / (MASS * G) - 1.0).abs() < 1e-9, "{one}\n{other}: {overlap:e}");
        }
    }
}

#[test]
fn a_disc_rolls_over_segments_that_nearly_meet_and_that_overlap() {
    let rest = R - MASS * G / K;
    for (gap, step) in [(0.0, 0.0), (1e-10, 0.0), (1.49e-9, 0.0), (-0.03, 0.0), (5e-6, 0.0), (1e-8, 2e-8)] {
        let right = SEAM + gap;
        let walls = format!(
            "Segment(from: (-0.1, 0.0), to: ({SEAM:?}, 0.0)), Segment(from: (0.3, {step:?}), to: ({right:?}, {step:?}))"
        );
        let mut disc = grain(1, Vector::new(SEAM - 0.002, rest), Vector::new(SPEED, 0.0), R, MASS);
        disc.spin = Solid::new(0.0, 0.0, -SPEED / R);
        let mut run = simulation(&keys("Plane", "(0.0, -9.81)", &walls), vec![disc]);
        run.run_steps(4000);
        let now = motion(&mut run)[0];
        // As above.
        let slower = (now.velocity.x / SPEED - 1.0).abs();
        let width = f64::max(gap, 0.0);
        let by_gap = G * width / (2.0 * R) * width / SPEED / SPEED;
        let by_step = 0.4 * step * 1.6 * f64::sqrt(K / MASS) / SPEED;
        assert!(slower < 2.0 * (by_gap + by_step) + 1e-9, "{gap:e}: {slower:e}");
        assert!(now.position.x > SEAM + 0.001, "it has rolled over the seam");
        assert!((now.position.y - rest).abs() < 2.0 * step + 1e-9, "{gap:e}: {:e}", now.position.y - rest);
    }
}

#[test]
fn corners_and_opposite_walls_push_twice() {
    let floor = "Panel(corner: (0.0, -0.1, 0.0), along: (0.2, 0.0, 0.0), across: (0.0, 0.2, 0.0))";
    for (other, centre) in [
        // A wall that stands on the floor, and one a nanometre beside it.
        ("Panel(corner: (0.0, -0.1, 0.0), along: (0.0, 0.0, 0.2), across: (0.0, 0.2, 0.0))", [R - 1e-5, R - 1e-5]),
        (
            "Panel(corner: (-1.0e-9, -0.1, 1.0e-9), along: (0.0, 0.0, 0.2), across: (0.0, 0.2, 0.0))",
            [R - 1e-5, R - 1e-5],
        ),
        // A lid, against which the grain is squeezed.
        ("Panel(corner: (0.0, -0.1, 0.00998), along: (0.2, 0.0, 0.0), across: (0.0, 0.2, 0.0))", [0.1, R - 1e-5]),
    ] {
        let ball = sphere(1, Solid::new(centre[0], 0.0, centre[1]), Solid::ZERO, R, MASS);
        let mut run = simulation(&keys("Solid", "(0.0, 0.0, 0.0)", &format!("{floor}, {other}")), vec![ball]);
        run.run_steps(1);
        let loads = &run.world().resource::<Surfaces<Solid>>().loads;
        // Each wall bears k times an overlap of 1e-5 m.
        let off = loads.iter().map(|load| (load.force.length() / (K * 1e-5) - 1.0).abs()).fold(0.0, f64::max);
        assert!(loads.len() == 2 && off < 1e-2, "{other}: {loads:?}");
    }
}
