//! Frames, report, exports and profiles of runs with shaped grains, and shapes that are made from a surface.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use siloflow::dem::bodies::Shape;
use siloflow::dem::particle::Species;
use siloflow::files::frames::reader::FrameReader;
use siloflow::prelude::*;

use crate::command_line::{siloflow, text};
use crate::simulation;

/// Upright rods and lying lentils that rest on a floor after a short fall, with frames.
const SCENE: &str = "(space: Solid, gravity: (0.0, 0.0, -9.81), mass: Sphere(2000.0), step: Fixed(2.0e-5), until: 0.12,
    contact: Linear(k: 2.0e4, damping: Restitution(0.4), tangential: Spring(k: 5.7e3, damping: OfNormal(0.5), friction: 0.5)),
    shapes: {\"rod\": Capsule(length: 0.03, diameter: 0.01, spheres: 4), \"lentil\": Ellipsoid(axes: (0.02, 0.02, 0.01), spheres: 9)},
    walls: [HalfSpace(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))],
    fill: [
        (low: (0.0, 0.0, 0.0), high: (0.08, 0.04, 0.04), spacing: 0.04, count: 2, shape: \"rod\", orientation: Along((0.0, 0.0, 1.0))),
        (low: (0.2, 0.0, 0.0), high: (0.28, 0.04, 0.04), spacing: 0.04, count: 2, shape: \"lentil\", orientation: Along((1.0, 1.0, 0.0)), species: 1),
    ],
    profiles: [(axis: Z, low: 0.0, high: 0.1, bins: 1, sample: 0.01, section: 0.01)],
    data_frames: (interval: 0.03, contacts: true, format: [Vtk]), pictures: (interval: 0.06, colour: Column(\"inclination\", 0.0, 1.6)))";

fn run(here: &Path) {
    fs::write(here.join("a.ron"), SCENE).unwrap();
    let output = siloflow(here, &["run", "a.ron", "--quiet", "--report"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
}

fn table(path: &Path) -> Vec<BTreeMap<String, String>> {
    csv::Reader::from_path(path).unwrap().deserialize().map(Result::unwrap).collect()
}

#[test]
fn frames_name_the_spheres_of_a_contact_and_the_inclination_of_each_grain() {
    let here = tempfile::tempdir().unwrap();
    run(here.path());
    let mut frames = FrameReader::open(&here.path().join("out/a/frames.bin")).unwrap();
    let frame = frames.by_ref().last().unwrap().unwrap();
    let grains = frame.table("grains").unwrap();
    assert_eq!(grains.rows, 2 * 4 + 2 * 9);
    let kinds = grains.particles("id", "sphere").unwrap();
    for (key, angle) in kinds.iter().zip(grains.floats("inclination").unwrap()) {
        // Rods stand. A lentil rocks on its spheres, whose valleys are about 1 mm deep on 10 mm.
        assert!(*angle < if key.id <= 2 { 1e-3 } else { 0.1 }, "{key:?} {angle}");
    }
    // A rod stands on its last or first sphere.
    let contacts = frame.table("wall_contacts").unwrap();
    let of_rods: Vec<_> =
        contacts.particles("grain", "sphere").unwrap().into_iter().filter(|key| key.id <= 2).collect();
    assert!(of_rods.len() == 2 && of_rods.iter().all(|key| [0, 3].contains(&key.sphere)), "{of_rods:?}");
    let bodies = frame.table("bodies").unwrap();
    assert_eq!(bodies.whole("shape").unwrap(), [1, 1, 0, 0], "shapes are in the order of their names");
    let mass: f64 = grains.floats("mass").unwrap().iter().sum();
    let of_bodies: f64 = bodies.floats("mass").unwrap().iter().sum();
    assert!((mass / of_bodies - 1.0).abs() < 1e-12);
}

#[test]
fn the_report_plays_shaped_grains_and_exports_have_their_bodies() {
    let here = tempfile::tempdir().unwrap();
    run(here.path());
    let report = fs::read_to_string(here.path().join("out/a/report.html")).unwrap();
    assert!(!report.contains("cannot be played") && report.contains("data-frames="), "the report has a player");
    let export = siloflow(here.path(), &["export", "out/a", "--to", "csv", "--out", "csv"]);
    assert!(export.status.success(), "{}", text(&export.stderr));
    let bodies = table(&here.path().join("csv/bodies.csv"));
    assert_eq!(bodies.len(), 5 * 4);
    let last = bodies.iter().rfind(|body| body["id"] == "2").unwrap();
    let number = |name: &str| last[name].parse::<f64>().unwrap();
    // The x axis of a rod points upwards.
    let turned = glam::DQuat::from_xyzw(number("qx"), number("qy"), number("qz"), number("qw")) * glam::DVec3::X;
    assert!((turned - glam::DVec3::Z).length() < 1e-3, "{last:?}");
    assert!((number("director_z").abs() - 1.0).abs() < 1e-6);
    let vtk = here.path().join("out/a/vtk");
    let list = fs::read_to_string(vtk.join("bodies.pvd")).unwrap();
    assert_eq!(list.matches("<DataSet").count(), 5);
    // The header is text, and bytes follow.
    let first = fs::read(vtk.join("bodies-00000.vtp")).unwrap();
    assert!(String::from_utf8_lossy(&first).contains("Name=\"director\""));
}

#[test]
fn profiles_have_the_mean_inclination_and_the_nematic_order() {
    let here = tempfile::tempdir().unwrap();
    run(here.path());
    let rows = table(&here.path().join("out/a/profiles.csv"));
    for row in &rows {
        let order: f64 = row["nematic_order"].parse().unwrap();
        let inclination: f64 = row["inclination_rad"].parse().unwrap();
        let is_of_rods = row["species"] == "0";
        assert!((order - 1.0).abs() < 0.02 && inclination < if is_of_rods { 1e-3 } else { 0.1 }, "{row:?}");
    }
    assert_eq!(rows.len(), 3, "two species and all");
}

/// A scene with a source of these keys.
fn source(space: &str, shapes: &str, fill: &str) -> String {
    let [gravity, mass] =
        if space == "Solid" { ["(0.0, 0.0, -9.81)", "Sphere(2000.0)"] } else { ["(0.0, -9.81)", "Disc(2000.0)"] };
    format!(
        "(space: {space}, gravity: {gravity}, mass: {mass}, step: Fixed(2.0e-5), until: 0.01, pictures: None,
          contact: Linear(k: 2.0e4, damping: Restitution(0.4)), shapes: {{{shapes}}}, fill: [({fill})])"
    )
}

fn loaded(text: &str) -> Result<Loaded, siloflow::text::fault::Fault> {
    load::from_text(
        "test.ron",
        "test",
        &Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fuzz/files"),
        text.to_owned(),
        &[],
    )
}

#[test]
fn a_mixture_of_shapes_has_exact_shares_and_a_species_for_each_shape() {
    let shapes = "\"rod\": Capsule(length: 0.03, diameter: 0.01, spheres: 4), \"ball\": Spheres([(at: (0.0, 0.0, 0.0), radius: 0.01)])";
    let fill = "low: (0.0, 0.0, 0.0), high: (0.5, 0.5, 0.5), place: Random, count: 40, shape: [\"rod\", \"ball\"], scale: Mixture([(1.0, 0.75), (0.5, 0.25)])";
    let scene = loaded(&source("Solid", shapes, fill)).unwrap();
    let mut run = simulation(&scene, 1);
    let world = run.world_mut();
    let mut grains = world.query_filtered::<(&Shape, &Species, &Radius), With<Grain>>();
    let mut counts = [0; 2];
    for (shape, species, radius) in grains.iter(world) {
        // Shapes are in the order of their names: the ball first.
        let is_ball = shape.0 == 0;
        assert_eq!(species.0, u8::from(is_ball));
        assert!(!is_ball || (radius.0 - 0.005).abs() < 1e-9);
        counts[usize::from(is_ball)] += 1;
    }
    assert_eq!(counts, [30, 10]);
    for (wrong, word) in [
        (fill.replace("[\"rod\", \"ball\"]", "[\"rod\", \"ball\", \"rod\"]"), "3 shapes for 2 sizes"),
        (fill.replace("[\"rod\", \"ball\"]", "[]"), "0 shapes"),
        (fill.replace("\"ball\"]", "\"bal\"]"), "no shape `bal`"),
        (fill.replace("[\"rod\", \"ball\"]", "3"), "the name of a shape, or a list"),
    ] {
        let fault = loaded(&source("Solid", shapes, &wrong)).unwrap_err();
        assert!(fault.to_string().contains(word), "{word}: {fault}");
    }
}

#[test]
fn shapes_are_made_of_ellipsoids_cuboids_meshes_polygons_and_crops() {
    let solid = "\"a\": Ellipsoid(axes: (0.01, 0.03, 0.02), spheres: 6), \"b\": Cuboid(size: (0.02, 0.02, 0.03), spheres: 13),
        \"c\": Mesh(file: \"stone.obj\", unit: Millimetre, spheres: 8), \"d\": Crop(kind: Maize), \"e\": Crop(kind: Wheat, spheres: 3)";
    let fill = "low: (0.0, 0.0, 0.0), high: (0.5, 0.5, 0.5), place: Random, count: 5, shape: \"a\"";
    let scene = loaded(&source("Solid", solid, fill)).unwrap();
    let counts: Vec<_> = scene.shapes.facts.iter().map(|facts| facts.count).collect();
    assert_eq!(counts, [6, 13, 8, 15, 3]);
    // The tetrahedron with legs of 4 mm has a volume of 4^3/6 mm^3.
    let volume = 4.0 / 3.0 * std::f64::consts::PI * scene.shapes.facts[2].equivalent_radius.powi(3);
    assert!((0.8..1.2).contains(&(volume / (64.0e-9 / 6.0))), "{volume}");
    let plane = "\"tile\": Polygon(points: [(0.0, 0.0), (0.03, 0.0), (0.03, 0.02), (0.0, 0.02)], discs: 12)";
    let fill = "low: (0.0, 0.0), high: (0.5, 0.5), place: Random, count: 5, shape: \"tile\"";
    let scene = loaded(&source("Plane", plane, fill)).unwrap();
    let area = std::f64::consts::PI * scene.shapes.facts[0].equivalent_radius.powi(2);
    assert!((0.95..1.05).contains(&(area / 6e-4)), "{area}");
    let cases = [
        ("Mesh(file: \"none.obj\", unit: Metre, spheres: 3)", "none.obj"),
        ("Mesh(file: \"walls.dat\", unit: Metre, spheres: 3)", ".stl or .obj"),
        ("Crop(kind: Barley)", "Barley"),
        ("Cuboid(size: (0.02, 0.02, 0.0), spheres: 3)", "greater than 0"),
        ("Cuboid(size: (0.02, 0.02, 0.02), spheres: 0)", "at least one sphere"),
        ("Polygon(points: [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)], discs: 3)", "shapes.it.points[0]"),
    ];
    for (shape, word) in cases {
        let fault = loaded(&source(
            "Solid",
            &format!("\"it\": {shape}"),
            "low: (0.0, 0.0, 0.0), high: (0.1, 0.1, 0.1), place: Random, count: 1, shape: \"it\"",
        ))
        .unwrap_err();
        assert!(format!("{fault} {fault:?}").contains(word), "{word}: {fault}");
    }
}

#[test]
fn only_scenes_with_shapes_colour_by_inclination() {
    let text = source(
        "Solid",
        "",
        "low: (0.0, 0.0, 0.0), high: (0.1, 0.1, 0.1), place: Random, count: 1, radius: Fixed(0.01)",
    )
    .replace("pictures: None", "pictures: (colour: Column(\"inclination\", 0.0, 1.6))");
    assert!(loaded(&text).unwrap_err().to_string().contains("no inclination"));
}
