//! Fixed grains with shapes: a `fill` with `shape` and `fixed: true`. Each is a set of fixed spheres, which carry grains, hold places, open as a
//! door and move as a wall.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use siloflow::dem::walls::surfaces::Surfaces;
use siloflow::grains::fill::FixedGrain;
use siloflow::lammps;
use siloflow::prelude::*;

use crate::command_line::{siloflow, text};
use crate::{hash, simulation};

const FRICTION: &str = "contact: Linear(k: 1.0e5, damping: Restitution(0.4), tangential: Spring(k: 2.9e4, damping: OfNormal(0.5), friction: 0.5))";

/// A scene of the plane with these keys.
fn plane(keys: &str) -> String {
    format!(
        "(gravity: (0.0, -9.81), {FRICTION}, mass: Disc(1000.0), step: Fixed(1.0e-4), pictures: None,
          shapes: {{ \"rod\": Capsule(length: 0.2, diameter: 0.05, discs: 7), \"pair\": Capsule(length: 0.09, diameter: 0.06, discs: 2) }},
          {keys})"
    )
}

/// A scene of solid space with these keys.
fn solid(keys: &str) -> String {
    format!(
        "(space: Solid, gravity: (0.0, 0.0, -9.81), {FRICTION}, mass: Sphere(2000.0), step: Fixed(2.0e-5), pictures: None,
          shapes: {{ \"rod\": Capsule(length: 0.04, diameter: 0.03, spheres: 2), \"rice\": Ellipsoid(axes: (0.03, 0.01, 0.01), spheres: 5) }},
          {keys})"
    )
}

fn read(text: &str) -> Result<Loaded, siloflow::text::fault::Fault> {
    load::from_text("a.ron", "a", Path::new(""), text.to_owned(), &[])
}

fn loaded(text: &str) -> Loaded {
    read(text).unwrap_or_else(|fault| panic!("{fault}\n{text}"))
}

/// The spheres as entries of `walls`, with all digits.
fn written_out(spheres: &[FixedGrain], space: &str) -> String {
    spheres.iter().fold(String::new(), |mut walls, sphere| {
        let FixedGrain { position: Solid { x, y, z }, radius, .. } = sphere;
        let centre = if space == "Plane" { format!("({x:?}, {y:?})") } else { format!("({x:?}, {y:?}, {z:?})") };
        let _ = write!(walls, "Disc(centre: {centre}, radius: {radius:?}), ");
        walls
    })
}

#[test]
fn a_fixed_grain_with_a_shape_is_its_spheres_to_the_last_bit() {
    let of_plane = |fixed: &str, walls: &str| {
        plane(&format!(
            "until: 0.4, periodic: (x: (-0.3, 0.3)), walls: [{walls} HalfPlane(point: (0.0, -0.2), normal: (0.0, 1.0))],
             fill: [(low: (-0.2, 0.2), high: (0.2, 0.4), spacing: 0.1, radius: Fixed(0.03)),
                    (low: (-0.2, 0.5), high: (0.2, 0.6), spacing: 0.1, shape: \"pair\", orientation: Along((1.0, 2.0))), {fixed}]"
        ))
    };
    let of_solid = |fixed: &str, walls: &str| {
        solid(&format!(
            "until: 0.2, walls: [{walls} HalfSpace(point: (0.0, 0.0, -0.1), normal: (0.0, 0.0, 1.0))],
             fill: [(low: (-0.05, -0.05, 0.05), high: (0.05, 0.05, 0.1), spacing: 0.025, radius: Fixed(0.01)),
                    (low: (-0.05, -0.05, 0.1), high: (0.05, 0.05, 0.15), spacing: 0.04, shape: \"rice\", orientation: Along((1.0, 2.0, 1.0))), {fixed}]"
        ))
    };
    let scenes: [(&str, &dyn Fn(&str, &str) -> String, &str, usize); 2] = [
        // One of the three crosses the side of the periodic box.
        (
            "Plane",
            &of_plane,
            "(low: (-0.3, 0.0), high: (0.3, 0.2), spacing: 0.2, shape: \"rod\", scale: Fixed(0.9), fixed: true)",
            21,
        ),
        (
            "Solid",
            &of_solid,
            "(low: (-0.05, -0.05, 0.0), high: (0.05, 0.05, 0.05), spacing: 0.05, shape: \"rod\", scale: Fixed(1.2), fixed: true)",
            8,
        ),
    ];
    for (space, scene, fixed, count) in scenes {
        let bodies = loaded(&scene(fixed, ""));
        assert_eq!(bodies.fixed.len(), count, "{space}");
        let spheres = loaded(&scene("", &written_out(&bodies.fixed, space)));
        assert!(spheres.fixed.is_empty() && bodies.grains == spheres.grains, "{space}");
        let run = |loaded: &Loaded| {
            let mut run = simulation(loaded, 1);
            run.run();
            (hash(&mut run), run.world().resource::<Ledger>().released)
        };
        let [with, without] = [run(&bodies), run(&spheres)];
        assert_eq!(with, without, "{space}");
        // The bodies are in the way.
        let empty = run(&loaded(&scene("", "")));
        assert!(empty.0 != with.0 && empty.1 == with.1, "{space}: fixed grains are not counted as released");
    }
}

/// The height of a grain of radius `radius` (m) over the centres of `count` fixed spheres of radius `other` (m), each at the distance `aside`
/// (m) from its vertical, whose springs of 1e5 N/m carry its weight, N.
fn height(weight: f64, radius: f64, other: f64, aside: f64, count: f64) -> f64 {
    let mut overlap = 0.0;
    for _ in 0..100 {
        let distance: f64 = radius + other - overlap;
        let cosine = (distance * distance - aside * aside).sqrt() / distance;
        overlap = weight / (count * 1e5 * cosine);
    }
    ((radius + other - overlap).powi(2) - aside * aside).sqrt()
}

#[test]
fn a_grain_rests_in_the_valleys_of_fixed_bodies_at_the_height_of_the_closed_form() {
    let of_plane = plane(
        "until: 6.0, fill: [(low: (-0.1, -0.1), high: (0.1, 0.1), spacing: 0.2, shape: \"pair\", orientation: Along((1.0, 0.0)), fixed: true),
            (low: (-0.038, 0.03), high: (0.042, 0.11), spacing: 0.08, radius: Fixed(0.04))]",
    );
    let of_solid = solid(
        "until: 3.0, fill: [(low: (-0.1, -0.1, -0.1), high: (0.1, 0.1, 0.1), spacing: 0.2, shape: \"tripod\", orientation: Along((1.0, 0.0, 0.0)), fixed: true),
            (low: (-0.019, -0.0195, 0.0155), high: (0.021, 0.0205, 0.0555), spacing: 0.04, radius: Fixed(0.02))]",
    )
    .replace(
        "shapes: {",
        "shapes: { \"tripod\": Spheres([(at: (0.02, 0.0, 0.0), radius: 0.02), (at: (-0.01, 0.017320508075688773, 0.0), radius: 0.02),
            (at: (-0.01, -0.017320508075688773, 0.0), radius: 0.02)]),",
    );
    for text in [of_plane, of_solid] {
        let scene = loaded(&text.replace("friction: 0.5", "friction: 0.0"));
        let middle = scene.fixed.iter().map(|sphere| sphere.position).sum::<Solid>() / scene.fixed.len() as f64;
        let aside = scene.fixed.iter().map(|sphere| (sphere.position - middle).length());
        assert!(aside.clone().all(|a| (a - aside.clone().next().unwrap()).abs() < 1e-12));
        let (aside, count) = (aside.clone().next().unwrap(), scene.fixed.len() as f64);
        let grain = scene.grains[0];
        let expected = height(grain.mass * 9.81, grain.radius, scene.fixed[0].radius, aside, count);
        let mut run = simulation(&scene, 1);
        run.run();
        let world = run.world_mut();
        let place = match scene.scene.space {
            Dimension::Plane => world.query_filtered::<&Position, With<Grain>>().single(world).unwrap().0.extend(0.0),
            Dimension::Solid => world.query_filtered::<&Position<Solid>, With<Grain>>().single(world).unwrap().0,
        };
        let from = place - middle;
        let [up, sideways] = match scene.scene.space {
            Dimension::Plane => [from.y, from.x.abs()],
            Dimension::Solid => [from.z, from.truncate().length()],
        };
        // Without friction the slowest motion is sideways, from 2 mm: in the plane it decays as exp(-3.6 t/s).
        assert!((up - expected).abs() < 1e-9 && sideways < 1e-9, "{up} {expected} {sideways}");
        let lowest = height(0.0, grain.radius, scene.fixed[0].radius, aside, count);
        assert!(lowest - expected > 1e-6, "the weight makes a difference that the bound sees: {lowest} {expected}");
    }
}

#[test]
fn places_at_random_see_every_sphere_of_a_fixed_body_and_orientations_follow_the_seed() {
    let keys = "until: 0.1, fill: [(low: (0.0, 0.0, 0.0), high: (0.1, 0.1, 0.1), spacing: 0.05, jitter: 0.005, shape: \"rice\", scale: Fixed(1.5), fixed: true),
        (low: (0.0, 0.0, 0.0), high: (0.1, 0.1, 0.1), place: Random, count: 300, radius: Fixed(0.004))]";
    let scene = loaded(&solid(keys));
    assert_eq!((scene.fixed.len(), scene.grains.len()), (8 * 5, 300));
    let bodies: Vec<_> = scene.fixed.chunks(5).collect();
    let mut inside = 0;
    for grain in &scene.grains {
        for body in &bodies {
            let centre = body.iter().map(|sphere| sphere.position).sum::<Solid>() / 5.0;
            let reach =
                body.iter().map(|sphere| (sphere.position - centre).length() + sphere.radius).fold(0.0, f64::max);
            inside += u32::from((grain.position - centre).length() < reach);
            for sphere in *body {
                let gap = (grain.position - sphere.position).length() - grain.radius - sphere.radius;
                assert!(gap > -1e-15, "{gap}");
            }
        }
    }
    // A body holds the places of its spheres, not that of a ball round it.
    assert!(inside > 20, "{inside}");
    let axis = |body: &[FixedGrain]| (body[4].position - body[0].position).normalize();
    assert!(axis(bodies[0]).dot(axis(bodies[1])).abs() < 0.999);
    assert_eq!(loaded(&solid(keys)).fixed, scene.fixed);
    assert_ne!(loaded(&solid(&format!("seed: 7, {keys}"))).fixed, scene.fixed);
}

/// Runs to these times (s), and returns the numbers of grains out and lost at each.
fn out_at(loaded: &Loaded, dt: f64, times: &[f64]) -> Vec<(u32, u32)> {
    let mut run = simulation(loaded, 1);
    let mut after = |time: &f64| {
        run.run_steps((time / dt).round() as u64);
        let ledger = run.world().resource::<Ledger>();
        (ledger.out(), ledger.lost())
    };
    times.iter().map(&mut after).collect()
}

#[test]
fn a_door_of_shaped_bodies_opens_at_its_time_and_every_grain_is_out() {
    let of_plane = |gate: &str, door: &str| {
        plane(&format!(
            "until: 2.0, cull: (below: -1.0), {door},
             walls: [Segment(from: (0.0, 0.5), to: (0.0, -0.05)), Segment(from: (0.6, 0.5), to: (0.6, -0.05))],
             fill: [(low: (0.0, -0.1), high: (0.6, 0.05), spacing: 0.15, shape: \"rod\", orientation: Along((1.0, 0.0)), fixed: true, {gate}),
                    (low: (0.0, 0.05), high: (0.6, 0.35), spacing: 0.1, radius: Fixed(0.03)),
                    (low: (0.0, 0.35), high: (0.6, 0.5), spacing: 0.15, shape: \"pair\")]"
        ))
    };
    let of_solid = solid(
        "until: 1.0, cull: (below: -0.5), door: (opens: At(0.2)),
         walls: [HalfSpace(point: (0.0, 0.0, 0.0), normal: (1.0, 0.0, 0.0)), HalfSpace(point: (0.2, 0.0, 0.0), normal: (-1.0, 0.0, 0.0)),
             HalfSpace(point: (0.0, 0.0, 0.0), normal: (0.0, 1.0, 0.0)), HalfSpace(point: (0.0, 0.2, 0.0), normal: (0.0, -1.0, 0.0))],
         fill: [(low: (0.0, 0.0, -0.025), high: (0.2, 0.2, 0.0), spacing: 0.025, shape: \"rod\", orientation: Along((1.0, 0.0, 0.0)), fixed: true, door: true),
                (low: (0.0, 0.0, 0.02), high: (0.2, 0.2, 0.06), spacing: 0.04, radius: Fixed(0.012)),
                (low: (0.0, 0.0, 0.06), high: (0.2, 0.2, 0.12), spacing: 0.06, shape: \"rice\")]",
    );
    let scenes = [
        (of_plane("door: true", "door: (opens: At(0.3))"), 1e-4, 4 * 7, 18 + 4),
        (
            of_plane(
                "name: \"gate\"",
                "doors: [(walls: \"gate\", opens: At(0.3), how: Move(by: (0.7, 0.0), speed: 2.0))]",
            ),
            1e-4,
            4 * 7,
            18 + 4,
        ),
        (of_solid, 2e-5, 64 * 2, 25 + 9),
    ];
    for (text, dt, spheres, grains) in scenes {
        let scene = loaded(&text);
        let of_fills = scene.walls_of_fills.len();
        assert_eq!((scene.fixed.len(), of_fills, scene.grains.len()), (0, spheres, grains as usize), "{text}");
        let opening = if dt == 1e-4 { 0.3 } else { 0.2 };
        assert_eq!(out_at(&scene, dt, &[opening, scene.scene.until.get()]), [(0, 0), (grains, 0)], "{text}");
        // The door is as wide as all its spheres together, and each of them narrower than a grain.
        let warned: Vec<_> = siloflow::scene::check::warnings(&scene).iter().map(|warning| warning.code).collect();
        assert!(!warned.contains(&"check::narrow_door") && !warned.contains(&"check::gap_in_door"), "{warned:?}");
        // Farther apart, the bodies of the door leave gaps.
        let farther = [
            ("low: (0.0, -0.1), high: (0.6, 0.05), spacing: 0.15", "low: (0.0, -0.2), high: (0.6, 0.1), spacing: 0.3"),
            (
                "low: (0.0, 0.0, -0.025), high: (0.2, 0.2, 0.0), spacing: 0.025",
                "low: (0.0, 0.0, -0.05), high: (0.2, 0.2, 0.0), spacing: 0.05",
            ),
        ];
        let (near, far) = farther.into_iter().find(|(near, _)| text.contains(near)).unwrap();
        let gaps = siloflow::scene::check::warnings(&loaded(&text.replace(near, far)));
        assert!(gaps.iter().any(|warning| warning.code == "check::gap_in_door"), "{gaps:?}");
    }
}

#[test]
fn a_motion_turns_a_fixed_body_with_a_name_as_one() {
    let scene = loaded(&plane(
        "until: 0.5, walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))],
         motions: [(walls: \"paddle\", rotate: (about: (0.0, 0.2), by: Steady(6.0)))],
         fill: [(low: (-0.1, 0.03), high: (0.1, 0.23), spacing: 0.2, shape: \"rod\", orientation: Along((0.0, 1.0)), fixed: true, name: \"paddle\"),
                (low: (0.03, 0.0), high: (0.11, 0.08), spacing: 0.08, radius: Fixed(0.03))]",
    ));
    let mut run = simulation(&scene, 1);
    let places = |run: &Simulation| -> Vec<_> {
        run.world().resource::<Surfaces>().all[1..].iter().map(|wall| wall.surface.shape().reference()).collect()
    };
    run.run_steps(0);
    let before = places(&run);
    run.run();
    let about = Vector::new(0.0, 0.2);
    for (from, to) in before.iter().zip(places(&run)) {
        let turned = about + Vector::from_angle(3.0).rotate(from - about);
        assert!((to - turned).length() < 1e-12, "{from} {to} {turned}");
    }
    // The paddle turns anticlockwise, so its lower end has pushed the grain to the right.
    let world = run.world_mut();
    let (x, v) = world.query_filtered::<(&Position, &Velocity), With<Grain>>().single(world).unwrap();
    assert!(x.0.x > 0.15 && v.0.x > 0.1, "{x:?} {v:?}");
}

#[test]
fn a_run_from_another_one_keeps_the_places_of_fixed_bodies() {
    let here = tempfile::tempdir().unwrap();
    let scene = plane(
        "integrator: Verlet, periodic: (x: (0.0, 1.0)), until: 0.05, seed: 3,
         fill: [(low: (0.0, 0.3), high: (1.0, 0.7), spacing: 0.2, shape: \"pair\", scale: Uniform(0.8, 1.0)),
            (low: (0.0, 0.0), high: (1.0, 0.2), spacing: 0.2, shape: [\"rod\", \"pair\"], scale: Mixture([(0.9, 0.5), (1.1, 0.5)]), jitter: 0.01, fixed: true),
            (low: (0.0, -0.2), high: (1.0, 0.0), spacing: 0.2, shape: \"rod\", scale: Fixed(0.8), orientation: Along((1.0, 0.0)), fixed: true, name: \"floor\")]",
    );
    fs::write(here.path().join("a.ron"), scene).unwrap();
    for arguments in [
        &["run", "a.ron", "--quiet", "--out", "first"][..],
        &["run", "a.ron", "--quiet", "--from", "first", "--out", "next"],
        &["run", "next/scene.ron", "--quiet", "--from", "next", "--out", "third"],
    ] {
        let output = siloflow(here.path(), arguments);
        assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    }
    let loaded = |run: &str| load::load(&here.path().join(run).join("scene.ron"), &[]).unwrap();
    let [first, next, third] = ["first", "next", "third"].map(loaded);
    // Of the five, three or two are rods.
    let count = first.fixed.len();
    assert!((count == 2 * 7 + 3 * 2 || count == 3 * 7 + 2 * 2) && first.scene.walls.len() == 5 * 7, "{count}");
    for later in [next, third] {
        assert_eq!((later.grains.len(), later.fixed), (10, first.fixed.clone()));
        assert_eq!(later.scene.walls, first.scene.walls);
    }
}

#[test]
fn keys_that_have_no_meaning_are_refused_with_the_reason() {
    let body = "low: (0.0, 0.0, 0.0), high: (0.1, 0.1, 0.1), spacing: 0.05, shape: \"rod\"";
    let cases = [
        (format!("fill: [({body}, name: \"a\")]"), "scene::fixed_grains", "fill[0].name", "only fixed grains"),
        (format!("fill: [({body}, door: true)]"), "scene::fixed_grains", "fill[0].door", "only fixed grains"),
        (
            format!("fill: [({body}, fixed: true, door: true, velocity: (0.1, 0.0, 0.0))]"),
            "scene::fixed_grains",
            "fill[0].velocity",
            "no velocity of their own",
        ),
        (format!("fill: [({body}, fixed: true, name: \"a,b\")]"), "scene::wall_name", "fill[0].name", "no name of a wall"),
        (
            "fill: [(low: (0.0, 0.0, 0.0), high: (0.1, 0.1, 0.1), place: Random, count: 3, shape: \"rod\", fixed: true)]".to_owned(),
            "scene::no_lattice",
            "fill[0].fixed",
            "lattice",
        ),
        (
            "fill: [(low: (0.0, 0.0, 0.0), high: (1.0, 1.0, 0.2), spacing: 0.001, count: 3000000, shape: \"rice\", fixed: true)]".to_owned(),
            "scene::out_of_range",
            "fill[0].count",
            "more than 10000000 grains",
        ),
        (
            "fill: [(low: (0.0, 0.0, 0.0), high: (1.0, 1.0, 0.2), spacing: 0.02, count: 10100, shape: \"rod\", fixed: true, door: true)]".to_owned(),
            "scene::out_of_range",
            "fill",
            "20200 walls and wall grains are more",
        ),
        (
            format!(
                "periodic: (x: (0.0, 0.2)), motions: [(walls: \"a\", rotate: (about: (0.0, 0.0, 0.0), axis: (0.0, 0.0, 1.0), by: Steady(1.0)))],
                 fill: [({body}, fixed: true, name: \"a\"), (low: (0.0, 0.0, 0.2), high: (0.1, 0.1, 0.3), spacing: 0.1, radius: Fixed(0.01))]"
            ),
            "scene::wall_at_side",
            "fill[0]",
            "periodic",
        ),
        (
            format!("fill: [({body}, fixed: true, name: \"a\")], doors: [(walls: \"b\", opens: Never)]"),
            "scene::no_such_wall",
            "doors[0].walls",
            "names here are: a",
        ),
    ];
    for (keys, code, key, word) in cases {
        let fault = read(&solid(&format!("until: 0.1, {keys}"))).unwrap_err();
        assert_eq!((fault.code(), fault.scene_key()), (code, Some(key)), "{keys}: {fault}");
        assert!(format!("{fault:?}{fault}").contains(word), "{keys}: {fault:?}");
    }
}

#[test]
fn check_and_lammps_count_the_spheres_of_fixed_bodies() {
    let fill = |name: &str| {
        solid(&format!(
            "until: 0.1, walls: [HalfSpace(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))],
             fill: [(low: (0.0, 0.0, 0.0), high: (0.1, 0.1, 0.05), spacing: 0.05, shape: \"rice\", fixed: true{name}),
                    (low: (0.0, 0.0, 0.1), high: (0.1, 0.1, 0.15), spacing: 0.05, radius: Fixed(0.01))]"
        ))
    };
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("a.ron"), fill("")).unwrap();
    let said = text(&siloflow(here.path(), &["check", "a.ron"]).stdout);
    assert!(
        said.contains("4 grains, 20 wall grains of `fill`") && said.contains("4 grains, each sphere of which"),
        "{said}"
    );
    let export = lammps::export(&loaded(&fill(""))).unwrap();
    assert!(export.data.contains("24 atoms") && export.bodies.is_none(), "{}", export.data);
    let fault = lammps::export(&loaded(&fill(", name: \"a\""))).err().unwrap();
    assert_eq!((fault.code(), fault.scene_key()), ("lammps::unmapped", Some("fill[0]")), "{fault}");
}
