//! Warnings of `check` about the start of a scene, its walls and its speeds: each has a scene that causes it, and a scene next to
//! it that does not.

use std::num::NonZeroUsize;
use std::path::Path;

use siloflow::measure::totals;
use siloflow::prelude::*;
use siloflow::scene::check;

const FLOOR: &str = "walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))]";

/// Codes of the warnings of a planar scene with these keys. Files are read from `directory`.
fn codes_in(directory: &Path, keys: &str) -> Vec<&'static str> {
    let keys = if keys.contains("step:") { keys.to_owned() } else { format!("step: Fixed(1.0e-5), {keys}") };
    let text = format!(
        "(gravity: (0.0, -9.81), contact: Linear(k: 1.0e7, damping: Restitution(0.5)), mass: Disc(100.0), until: 1.0, {keys})"
    );
    let loaded = load::from_text("a.ron", "a", directory, text, &[]).unwrap();
    check::warnings(&loaded).into_iter().map(|warning| warning.code).collect()
}

fn codes(keys: &str) -> Vec<&'static str> {
    codes_in(Path::new(""), keys)
}

fn block(low: f64, more: &str) -> String {
    format!("fill: [(low: (0.0, {low}), high: (0.3, {}), spacing: 0.1, radius: Fixed(0.05){more})]", low + 0.3)
}

fn spawner(x: f64, y: f64) -> String {
    format!("spawner: (point: ({x:?}, {y:?}), velocity: (0.0, -1.0), interval: 1.0, count: 1, radius: Fixed(0.05))")
}

#[test]
fn overlaps_at_the_start_are_found() {
    assert_eq!(codes(&format!("{FLOOR}, {}", block(0.0, ""))), [""; 0]);
    let doubled = |high: f64| {
        let fill =
            |low: f64| format!("(low: (0.0, {low}), high: (0.3, {}), spacing: 0.1, radius: Fixed(0.05))", low + 0.1);
        format!("{FLOOR}, fill: [{}, {}]", fill(0.0), fill(high))
    };
    assert_eq!(codes(&doubled(0.05)), ["check::overlaps_at_start"]);
    assert_eq!(codes(&doubled(0.1)), [""; 0]);
    // With a wall surface.
    assert_eq!(codes(&format!("{FLOOR}, {}", block(-0.03, ""))), ["check::overlaps_at_start"]);
}

/// Five discs on a line overlap each other, all ten pairs. Without drag, their fastest motion along the line is w^2 = 5 k/m, the largest
/// eigenvalue of the complete graph. The limit from each grain's four contacts is 2/sqrt(8 k/m).
#[test]
fn overlaps_at_the_start_shorten_the_stable_step() {
    let k = 1e4;
    let mass = 1.0f64;
    let scene = |dt: f64| {
        let fill = "fill: [(low: (0.0, 0.0), high: (0.5, 0.1), spacing: 0.1, radius: Fixed(0.5), count: 5)]";
        format!(
            "(contact: Linear(k: {k:?}, damping: B(0.0)), mass: ArealSquare(4.0), gravity: (0.0, 0.0), integrator: Verlet, \
             step: Fixed({dt:e}), {fill}, until: 1.0e3, rest: None, watchdog: None, pictures: None)"
        )
    };
    let limit = 2.0 / (8.0 * k / mass).sqrt();
    let is_warned = |dt: f64| {
        let loaded = load::from_text("clump.ron", "clump", Path::new(""), scene(dt), &[]).unwrap();
        check::warnings(&loaded).iter().any(|warning| warning.code == "check::unstable_start")
    };
    assert!(is_warned(1.001 * limit) && !is_warned(0.999 * limit));
    // Overlaps of 0.9, 0.8, 0.7 and 0.6 m.
    let at_start = 0.5 * k * (4.0 * 0.81 + 3.0 * 0.64 + 2.0 * 0.49 + 0.36);
    let growth = |dt: f64| {
        let loaded = load::from_text("clump.ron", "clump", Path::new(""), scene(dt), &[]).unwrap();
        let mut run = Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN).unwrap();
        run.run_steps(100);
        totals::of_world(run.world()).energy() / at_start
    };
    // From rest, Verlet keeps 1 - (w dt/2)^2 of the energy of each motion: at least 3/8 at this step. It gains energy with a step that is
    // too large.
    let stable = growth(0.999 * limit);
    let unstable = growth(1.95 * limit);
    assert!((0.375..=1.0).contains(&stable) && unstable > 1.0, "{stable} {unstable}");
}

#[test]
fn grains_inside_walls_and_doubled_wall_grains_are_found() {
    assert_eq!(codes(&format!("{FLOOR}, {}", block(-0.17, ""))), ["check::starts_in_wall"]);
    let disc = "walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0)), Disc(centre: (0.0, 0.5), radius: 0.2)]";
    assert!(codes(&format!("{disc}, {}", block(0.4, ""))).contains(&"check::starts_in_wall"));
    // A lone disc in the open is also reported as leaky.
    let once = codes(&format!("{disc}, {}", block(0.0, "")));
    assert!(!once.contains(&"check::starts_in_wall") && !once.contains(&"check::duplicate_wall_grains"), "{once:?}");
    let twice = disc.replace("Disc(", "Disc(centre: (0.0, 0.5), radius: 0.2), Disc(");
    assert!(codes(&format!("{twice}, {}", block(0.0, ""))).contains(&"check::duplicate_wall_grains"));
}

#[test]
fn release_points_outside_and_in_walls_are_found() {
    let walls = "walls: [Segment(from: (-1.0, 0.0), to: (1.0, 0.0)), Segment(from: (-1.0, 0.0), to: (-1.0, 2.0)), \
                 Segment(from: (1.0, 0.0), to: (1.0, 2.0))]";
    let at = |x: f64, y: f64| codes(&format!("{walls}, {}", spawner(x, y)));
    assert_eq!((at(0.0, 1.0), at(0.0, 3.0)), (vec![], vec![]));
    for (x, y) in [(1.5, 1.0), (0.0, -1.0)] {
        assert!(at(x, y).contains(&"check::release_outside"), "{:?}", at(x, y));
    }
    assert!(at(0.97, 1.0).contains(&"check::no_room_to_release"));
}

#[test]
fn doors_narrower_than_a_grain_are_found() {
    let here = tempfile::tempdir().unwrap();
    let check = |half: f64| {
        let file = format!("2 1\n-{half} 0 0.05\n{half} 0 0.05\n0 0 0.02\n");
        std::fs::write(here.path().join("door.dat"), file).unwrap();
        let keys = "silo: (file: \"door.dat\", unit: Metre), door: (opens: At(0.5)), cull: (below: -1.0)";
        codes_in(here.path(), &format!("{keys}, {}", spawner(0.0, 0.5)))
    };
    assert!(check(0.09).contains(&"check::narrow_door") && !check(0.11).contains(&"check::narrow_door"));
}

#[test]
fn speeds_that_pass_a_wall_or_a_grain_in_one_step_are_found() {
    let bullets = |speed: f64| format!("step: Fixed(1.0e-4), {}", block(0.0, &format!(", velocity: ({speed:?}, 0.0)")));
    let code = "check::fast_grains";
    assert!(codes(&bullets(600.0)).contains(&code) && !codes(&bullets(100.0)).contains(&code));
    let wall = |speed: f64| format!("walls: [Segment(from: (9.0, 0.0), to: (9.0, 1.0))], {}", bullets(speed));
    assert!(codes(&wall(600.0)).contains(&code) && !codes(&wall(100.0)).contains(&code));
}

#[test]
fn grains_that_can_fall_for_ever_are_found() {
    let code = "check::falls_for_ever";
    let with =
        |walls: &str, more: &str| codes(&format!("walls: [{walls}], {more}, {}", block(1.0, ""))).contains(&code);
    let plane = |normal: &str| format!("HalfPlane(point: (0.0, 0.0), normal: {normal})");
    let slope = plane("(1.0, 1.0)");
    let none = "cull: None";
    assert!(!with(&plane("(0.0, 1.0)"), none), "a floor holds");
    assert!(with(&plane("(1.0, 0.0)"), none) && with(&slope, none), "a wall and a slope do not");
    assert!(!with(&format!("{slope}, {}", plane("(-1.0, 1.0)")), none), "two slopes hold");
    assert!(with(&format!("{slope}, {}", plane("(-1.0, -1.1)")), none), "unless they are open below");
    assert!(!with(&slope, "cull: (below: -1.0)") && !with(&plane("(1.0, 0.0)"), "periodic: (y: (-5.0, 5.0))"));
    let segments = "Segment(from: (-1.0, 0.0), to: (1.0, 0.0)), Segment(from: (-1.0, 0.0), to: (-1.0, 2.0)), \
                    Segment(from: (1.0, 0.0), to: (1.0, 2.0))";
    assert!(!with(segments, none));
    assert!(with("Segment(from: (-1.0, 0.0), to: (0.1, 0.0))", none));
    assert!(!codes(&block(1.0, "")).contains(&code), "without walls grains are meant to fly");
}

#[test]
fn a_run_that_would_write_very_much_is_named() {
    let text = |until: &str| {
        format!(
            "(gravity: (0.0, -9.81), contact: Linear(k: 1.0e7, damping: Restitution(0.5)), mass: Disc(100.0), until: {until}, \
             step: Fixed(1.0e-5), {FLOOR}, {})",
            block(0.0, "")
        )
    };
    let code = |until: &str| {
        let loaded = load::from_text("a.ron", "a", Path::new(""), text(until), &[]).unwrap();
        check::warnings(&loaded).into_iter().any(|warning| warning.code == "check::much_output")
    };
    assert!(!code("1.0e3") && code("1.0e9"));
}

/// Codes of the warnings of a solid scene with these walls, whose files are read from `directory`.
fn codes_of_walls(directory: &Path, walls: &str) -> Vec<&'static str> {
    let text = format!(
        "(space: Solid, gravity: (0.0, 0.0, -9.81), contact: Linear(k: 1.0e7, damping: Restitution(0.5)), step: Fixed(1.0e-5),
        until: 1.0, walls: [{walls}])"
    );
    let loaded = load::from_text("a.ron", "a", directory, text, &[]).unwrap();
    check::warnings(&loaded).into_iter().map(|warning| warning.code).collect()
}

#[test]
fn walls_that_overlap_in_one_plane_are_no_fault() {
    // A grain touches their union, so that no pair of kinds needs a warning.
    let here = tempfile::tempdir().unwrap();
    std::fs::write(here.path().join("a.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n").unwrap();
    let kinds = [
        "Panel(corner: (0.9, 0.0, 0.0), along: (1.0, 0.0, 0.0), across: (0.0, 1.0, 0.0))",
        "Polygon(points: [(0.5, 0.5, 0.0), (1.5, 0.5, 0.0), (0.5, 1.5, 0.0)])",
        "Mesh(file: \"a.obj\", unit: Metre)",
        "Annulus(centre: (0.5, 0.5, 0.0), normal: (0.0, 0.0, 1.0), outer: 0.5)",
    ];
    for one in kinds {
        for other in kinds {
            assert_eq!(codes_of_walls(here.path(), &format!("{one}, {other}")), [""; 0], "{one}\n{other}");
        }
    }
}

#[test]
fn a_mesh_in_another_unit_than_stated_is_found() {
    let here = tempfile::tempdir().unwrap();
    // A floor of 0.5 m, with grains of 5 mm, in a file in mm and one in m.
    for (size, unit, is_right) in
        [(500.0, "Millimetre", true), (500.0, "Metre", false), (0.5, "Metre", true), (0.5, "Millimetre", false)]
    {
        let mesh = format!("v 0 0 0\nv {size} 0 0\nv {size} {size} 0\nv 0 {size} 0\nf 1 2 3 4\n");
        std::fs::write(here.path().join("a.obj"), mesh).unwrap();
        let walls = format!("Mesh(file: \"a.obj\", unit: {unit})");
        let fill = "mass: Sphere(2500.0), cull: (below: -1.0), fill: [(low: (0.1, 0.1, 0.1), high: (0.2, 0.2, 0.2), spacing: 0.05, radius: Fixed(0.0025))]";
        let text = format!(
            "(space: Solid, gravity: (0.0, 0.0, -9.81), contact: Linear(k: 1.0e4, damping: Restitution(0.5)), step: Fixed(1.0e-6), until: 1.0,
            walls: [{walls}], {fill})"
        );
        let loaded = load::from_text("a.ron", "a", here.path(), text, &[]).unwrap();
        let is_warned = check::warnings(&loaded).iter().any(|warning| warning.code == "check::mesh_size");
        assert_eq!(is_warned, !is_right, "{size} {unit}");
    }
}

#[test]
fn faults_of_meshes_are_found() {
    let here = tempfile::tempdir().unwrap();
    let mesh = |text: &str| {
        std::fs::write(here.path().join("a.obj"), text).unwrap();
        codes_of_walls(here.path(), "Mesh(file: \"a.obj\", unit: Metre)")
    };
    let corners = "v 0 0 0\nv 2 0 0\nv 1 2 0\nv 1 0 0\nv 1 -1 0\nv 1 0.01 0\n";
    assert_eq!(mesh(&format!("{corners}f 1 2 3\nf 1 2 5\n")), [""; 0]);
    assert_eq!(mesh(&format!("{corners}f 1 2 3\nf 1 4 5\nf 4 2 5\n")), ["check::t_junctions"]);
    assert_eq!(mesh(&format!("{corners}f 1 2 6\n")), ["check::slivers"]);
    assert_eq!(mesh(&format!("{corners}f 1 2 3\nf 1 4 3\n")), ["check::t_junctions", "check::overlapping_triangles"]);
}

#[test]
fn a_wall_that_passes_a_grain_in_one_step_is_found() {
    let keys = |speed: f64| {
        format!(
            "walls: [Segment(from: (-1.0, 0.0), to: (1.0, 0.0), name: \"floor\")], cull: (below: -1.0),
            motions: [(walls: \"floor\", translate: Oscillate(amplitude: (0.0, 0.1), frequency: {speed:?}))], {}",
            block(0.0, "")
        )
    };
    // The largest speed is 2 pi 0.1 m times the frequency; the radius is 0.05 m, and a step 1e-5 s.
    assert!(!codes(&keys(10.0)).contains(&"check::fast_grains"));
    assert!(codes(&keys(1.0e4)).contains(&"check::fast_grains"));
}
