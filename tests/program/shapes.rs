//! Grains with shapes in scenes: the keys and their errors, every source, files that pass from one run to another, behaviours.

use std::fs;
use std::path::Path;

use siloflow::dem::bodies::{Orientation, Shape};
use siloflow::dem::particle::Fixed;
use siloflow::dem::space::{Rotor as _, Solid};
use siloflow::energy::EnergyFlows;
use siloflow::prelude::*;

use crate::command_line::{siloflow, text};
use crate::simulation;

/// A scene in solid space with these keys.
fn solid(keys: &str) -> String {
    format!(
        "(space: Solid, gravity: (0.0, 0.0, -9.81),
          contact: Linear(k: 2.0e4, damping: Restitution(0.4), tangential: Spring(k: 5.7e3, damping: OfNormal(0.5), friction: 0.5)),
          mass: Sphere(2000.0), step: Fixed(2.0e-5), pictures: None,
          walls: [HalfSpace(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))],
          shapes: {{ \"rod\": Capsule(length: 0.03, diameter: 0.01, spheres: 4), \"rice\": Ellipsoid(axes: (0.03, 0.01, 0.01), spheres: 5) }},
          {keys})"
    )
}

fn loaded(text: &str) -> Loaded {
    load::from_text("test.ron", "test", Path::new(""), text.to_owned(), &[])
        .unwrap_or_else(|fault| panic!("{fault}\n{text}"))
}

#[test]
fn wrong_keys_are_refused_with_their_place_and_the_reason() {
    let fill = "low: (0.0, 0.0, 0.02), high: (0.2, 0.2, 0.2), place: Random, count: 5";
    let cases = [
        (format!("fill: [({fill}, shape: \"rise\")]"), "scene::shape", "did you mean `rice`"),
        (format!("fill: [({fill})]"), "scene::missing_key", "radius"),
        (
            format!("fill: [({fill}, radius: Fixed(0.01), scale: Fixed(2.0))]"),
            "scene::shape",
            "belongs to grains with a `shape`",
        ),
        (
            format!("fill: [({fill}, shape: \"rod\", radius: Fixed(0.01), scale: Fixed(2.0))]"),
            "scene::shape",
            "both give the size",
        ),
        (
            format!("fill: [({fill}, shape: \"rod\", orientation: Along((0.0, 0.0, 0.0)))]"),
            "scene::zero_direction",
            "no length",
        ),
        (
            format!("fill: [({fill}, shape: \"rod\", orientation: Along((1.0, 0.0)))]"),
            "scene::dimension",
            "expected 3 numbers",
        ),
        (format!("inertia: Sphere, fill: [({fill}, shape: \"rod\")]"), "scene::shape", "follow from the shapes"),
        (format!("integrator: ExplicitEuler, fill: [({fill}, shape: \"rod\")]"), "scene::shape", "do not turn"),
        (
            format!("periodic: (x: (0.0, 0.05)), fill: [({fill}, shape: \"rod\")]"),
            "scene::box_too_small",
            "could touch another twice",
        ),
    ];
    for (keys, code, word) in cases {
        let text = solid(&format!("until: 0.1, {keys}"));
        let fault = load::from_text("test.ron", "test", Path::new(""), text, &[]).unwrap_err();
        assert_eq!(fault.code(), code, "{keys}: {fault}");
        assert!(format!("{fault:?}{fault}").contains(word), "{keys}: {fault:?}");
    }
}

#[test]
fn wrong_shapes_are_refused_with_the_reason() {
    let cases = [
        ("Spheres([])", "no sphere"),
        ("Spheres([(at: (0.0, 0.0, 0.0), radius: 0.01), (at: (0.05, 0.0, 0.0), radius: 0.01)])", "not connected"),
        ("Spheres([(at: (0.0, 0.0, 0.0), radius: 0.01), (at: (0.001, 0.0, 0.0), radius: 0.005)])", "lies inside"),
        ("Capsule(length: 0.1, diameter: 0.01, spheres: 3)", "do not reach"),
        ("Capsule(length: 0.01, diameter: 0.02, spheres: 3)", "at least as long"),
        ("Ellipsoid(axes: (0.01, 0.05, 0.01), spheres: 2)", "do not reach"),
        ("Discs([(at: (0.0, 0.0, 0.0), radius: 0.01)])", "Plane"),
    ];
    for (shape, word) in cases {
        let text = format!(
            "(space: Solid, gravity: (0.0, 0.0, -9.81), contact: Linear(k: 1.0e4, damping: Restitution(0.5)), step: Fixed(1.0e-5), until: 1.0,
              shapes: {{\"it\": {shape}}})"
        );
        let fault = load::from_text("test.ron", "test", Path::new(""), text, &[]).unwrap_err();
        assert!(fault.to_string().contains(word), "{shape}: {fault}");
    }
}

/// Counts the grains of a shape, and the others.
fn counts(run: &mut Simulation) -> [usize; 2] {
    let world = run.world_mut();
    let shaped = world.query_filtered::<(), (With<Grain>, With<Shape>, With<Orientation<Solid>>)>().iter(world).count();
    let others = world.query_filtered::<(), (With<Grain>, Without<Shape>)>().iter(world).count();
    [shaped, others]
}

#[test]
fn every_source_releases_shaped_grains_without_overlap() {
    let region = "Box(low: (-0.05, -0.05, 0.1), high: (0.05, 0.05, 0.1))";
    let cases = [
        ("fill: [(low: (-0.1, -0.1, 0.02), high: (0.1, 0.1, 0.1), place: Random, count: 20, shape: \"rice\", scale: Uniform(0.8, 1.2))]".to_owned(), [20, 0]),
        ("fill: [(low: (-0.1, -0.1, 0.02), high: (0.1, 0.1, 0.1), spacing: 0.04, shape: \"rod\", orientation: Along((0.0, 1.0, 1.0)))]".to_owned(), [50, 0]),
        ("spawner: (point: (0.0, 0.0, 0.1), velocity: (0.0, 0.0, -1.0), interval: 0.05, count: 5, shape: \"rod\")".to_owned(), [5, 0]),
        (
            format!(
                "feed: [(region: {region}, rate: Grains(200.0), total: Grains(20), velocity: (0.0, 0.0, -1.0), shape: \"rice\", spin: 5.0),
                        (region: {region}, rate: Grains(100.0), total: Grains(10), velocity: (0.0, 0.0, -1.0), radius: Fixed(0.005))]"
            ),
            [20, 10],
        ),
    ];
    for (keys, wanted) in cases {
        let loaded = loaded(&solid(&format!("until: 0.4, {keys}")));
        let mut run = simulation(&loaded, 1);
        run.run();
        assert_eq!(counts(&mut run), wanted, "{keys}");
        let flows = run.world().resource::<EnergyFlows>();
        // All energy comes from heights and speeds: an overlap at a release would add to the error of the balance. An impact has an
        // error of (w0 dt)^2/6 of what it dissipates; at the end of a grain of rice w0 = (2e4 N/m/(0.5 3e-3 kg/3))^(1/2) = 6300 1/s.
        let error = siloflow::measure::totals::of_world(run.world()).energy() - flows.expected();
        assert!(error.abs() < (6300.0_f64 * 2e-5).powi(2) / 6.0 * flows.dissipated, "{keys}: {error} of {flows:?}");
    }
}

#[test]
fn a_run_goes_on_from_another_one_with_its_orientations_and_contacts() {
    let here = tempfile::tempdir().unwrap();
    let text_of = |until: f64| {
        solid(&format!(
            "until: {until:?}, integrator: Verlet, series: (interval: 0.01),
             fill: [(low: (0.0, 0.0, 0.0), high: (0.1, 0.1, 0.12), place: Random, count: 20, shape: \"rice\")]"
        ))
        .replace("damping: Restitution(0.4)", "damping: B(0.0)")
        .replace("damping: OfNormal(0.5)", "damping: B(0.0)")
        .replace(
            "normal: (0.0, 0.0, 1.0))]",
            "normal: (0.0, 0.0, 1.0)), HalfSpace(point: (0.0, 0.0, 0.0), normal: (1.0, 0.0, 0.0))]",
        )
    };
    fs::write(here.path().join("whole.ron"), text_of(0.22)).unwrap();
    fs::write(here.path().join("half.ron"), text_of(0.11)).unwrap();
    for arguments in [
        &["run", "whole.ron", "--quiet"][..],
        &["run", "half.ron", "--quiet"],
        &["run", "half.ron", "--from", "out/half", "--out", "out/rest", "--quiet"],
    ] {
        let output = siloflow(here.path(), arguments);
        assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    }
    let contacts = fs::read_to_string(here.path().join("out/rest/input-contacts.csv"));
    let contacts = contacts.unwrap_or_else(|error| {
        panic!("{error}: {:?}", fs::read_dir(here.path().join("out/rest")).unwrap().collect::<Vec<_>>())
    });
    assert!(
        contacts.lines().next().unwrap().ends_with("sphere,partner_sphere") && contacts.lines().count() > 1,
        "{contacts}"
    );
    let positions = |run: &str| {
        let mut reader = csv::Reader::from_path(here.path().join("out").join(run).join("state.csv")).unwrap();
        let rows = reader
            .records()
            .map(|record| (3..6).map(|column| record.as_ref().unwrap()[column].parse().unwrap()).collect::<Vec<f64>>());
        rows.collect::<Vec<_>>()
    };
    for (whole, rest) in positions("whole").iter().zip(positions("rest")) {
        let apart: f64 = whole.iter().zip(&rest).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        // Without dashpots positions, orientations, velocities and springs determine all that follows. Rounding is amplified in contacts.
        assert!(apart < 1e-9, "{whole:?} {rest:?}");
    }
}

#[test]
fn behaviours_turn_fix_and_remove_shaped_grains() {
    let keys = "until: 0.05, on_loss: Continue, fill: [(low: (0.0, 0.0, 0.1), high: (0.1, 0.1, 0.14), spacing: 0.04, shape: \"rod\", orientation: Along((1.0, 0.0, 0.0)))]";
    let mut run = simulation(&loaded(&solid(keys)), 1);
    run.run_steps(100);
    let world = run.world_mut();
    let grains: Vec<_> = world.query_filtered::<Entity, With<Grain>>().iter(world).collect();
    assert_eq!(grains.len(), 4);
    world.despawn(grains[0]);
    world.entity_mut(grains[1]).insert(Fixed);
    let turned = glam::DQuat::from_rotation_z(0.5);
    *world.get_mut::<Orientation<Solid>>(grains[2]).unwrap() = Orientation(turned);
    let held = world.get::<Position<Solid>>(grains[1]).unwrap().0;
    run.run();
    let world = run.world_mut();
    assert_eq!(world.get::<Position<Solid>>(grains[1]).unwrap().0, held);
    let fallen = world.get::<Position<Solid>>(grains[3]).unwrap().0.z;
    // Free fall for 0.05 s.
    assert!((held.z - fallen - (0.5 * 9.81 * (0.05f64.powi(2) - 0.002f64.powi(2)))).abs() < 1e-4, "{held} {fallen}");
    let axis = world.get::<Orientation<Solid>>(grains[2]).unwrap().0.turn(Solid::X);
    assert!((axis - turned * Solid::X).length() < 1e-12, "{axis}");
    assert_eq!(world.query_filtered::<(), With<Grain>>().iter(world).count(), 3);
}

#[test]
fn explain_tells_what_a_shape_is() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("a.ron"), solid("until: 0.1")).unwrap();
    let output = siloflow(here.path(), &["explain", "a.ron"]);
    let said = text(&output.stdout);
    for word in
        ["shape rice: 5 spheres", "diameter of equal volume", "principal moments of inertia", "the surface is within"]
    {
        assert!(said.contains(word), "{word}: {said}");
    }
    let spawner =
        "spawner: (point: (0.0, 0.0, 0.1), velocity: (0.0, 0.0, -1.0), interval: 0.1, count: 2, shape: \"rice\")";
    fs::write(here.path().join("later.ron"), solid(&format!("until: 0.1, {spawner}"))).unwrap();
    let refused = siloflow(here.path(), &["export", "later.ron", "--to", "lammps"]);
    assert!(!refused.status.success() && text(&refused.stderr).contains("released later"), "{}", text(&refused.stderr));
}
