//! `siloflow export SCENE --to lammps`: what it writes, what it refuses, and that LAMMPS computes the forces of siloflow from it. Tests
//! that need LAMMPS say so and end where `lmp` is not installed (Debian: `apt-get install lammps openmpi-bin`).

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use siloflow::dem::walls::surface_wall::SurfaceWall;
use siloflow::grains::file::GrainRow;
use siloflow::grains::fill::FixedGrain;
use siloflow::lammps;
use siloflow::prelude::*;

use crate::command_line::{siloflow, text};

/// Whether LAMMPS is installed. Says so if it is not.
fn has_lammps() -> bool {
    let found = Command::new("lmp").arg("-h").output().is_ok_and(|output| output.status.success());
    if !found {
        eprintln!("LAMMPS (lmp) is not installed: its part of this test is left out");
    }
    found
}

/// Runs LAMMPS in `here` on some ranks.
fn lmp(here: &Path, ranks: usize, arguments: &[&str]) -> Output {
    let mut command = if ranks == 1 { Command::new("lmp") } else { Command::new("mpirun") };
    if ranks > 1 {
        command.args(["--oversubscribe", "-np", &ranks.to_string(), "lmp"]);
        command.env("OMPI_ALLOW_RUN_AS_ROOT", "1").env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
    }
    let output = command.args(["-in", lammps::SCRIPT]).args(arguments).current_dir(here).env("OMP_NUM_THREADS", "1");
    let output = output.output().unwrap();
    assert!(output.status.success(), "{}{}", text(&output.stdout), text(&output.stderr));
    output
}

/// Writes the input of LAMMPS for a scene.
fn write(loaded: &Loaded, here: &Path) {
    let export = lammps::export(loaded).unwrap_or_else(|fault| panic!("{fault}"));
    fs::write(here.join(lammps::SCRIPT), export.script).unwrap();
    fs::write(here.join(lammps::DATA), export.data).unwrap();
    if let Some(bodies) = export.bodies {
        fs::write(here.join(lammps::BODIES), bodies).unwrap();
    }
}

/// Force and torque of each grain at step 0, by LAMMPS.
fn theirs(here: &Path, ranks: usize) -> BTreeMap<u32, [f64; 6]> {
    lmp(here, ranks, &["-log", "none", "-var", "forces", "yes"]);
    let dump = fs::read_to_string(here.join("forces.dump")).unwrap();
    let rows = dump.lines().skip(9).map(|line| {
        let mut cells = line.split_whitespace();
        let id = cells.next().unwrap().parse().unwrap();
        let mut row = [0.0; 6];
        row.iter_mut().zip(cells).for_each(|(place, cell)| *place = cell.parse().unwrap());
        (id, row)
    });
    rows.collect()
}

/// Force and torque of each grain at step 0, by LAMMPS, in a scene with grains of several spheres: the sums over the spheres of a body, about its centre.
fn theirs_of_bodies(loaded: &Loaded, here: &Path) -> BTreeMap<u32, [f64; 6]> {
    lmp(here, 1, &["-log", "none", "-var", "forces", "yes"]);
    let dump = fs::read_to_string(here.join("forces.dump")).unwrap();
    let centres: BTreeMap<u32, Solid> = loaded.grains.iter().map(|grain| (grain.id.number(), grain.position)).collect();
    let mut sums: BTreeMap<u32, [f64; 6]> = BTreeMap::new();
    for line in dump.lines().skip(9) {
        let cells: Vec<f64> = line.split_whitespace().map(|cell| cell.parse().unwrap()).collect();
        let body = if cells[1] > 0.0 { cells[1] as u32 } else { cells[0] as u32 };
        let [place, force, torque] = [2, 5, 8].map(|from| Solid::from_slice(&cells[from..]));
        let torque = torque + (place - centres[&body]).cross(force);
        let sum = sums.entry(body).or_default();
        sum.iter_mut().zip(force.to_array().into_iter().chain(torque.to_array())).for_each(|(sum, x)| *sum += x);
    }
    sums
}

/// The same by siloflow.
fn ours(loaded: &Loaded) -> BTreeMap<u32, [f64; 6]> {
    let mut simulation = crate::simulation(loaded, 1);
    simulation.step();
    if loaded.scene.space == Dimension::Plane { rows::<Plane>(&mut simulation) } else { rows::<Solid>(&mut simulation) }
}

fn rows<V: Space>(simulation: &mut Simulation) -> BTreeMap<u32, [f64; 6]> {
    let world = simulation.world_mut();
    let mut query = world.query_filtered::<(&GrainId, &Force<V>, Option<&Torque<V::Spin>>), With<Grain>>();
    let rows = query.iter(world).map(|(id, force, torque)| {
        let force = force.0.spread();
        let torque = torque.map_or(Solid::ZERO, |torque| torque.0.spread());
        (id.number(), [force.x, force.y, force.z, torque.x, torque.y, torque.z])
    });
    rows.collect()
}

/// Uniform numbers from 0 to 1.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// Grains of 6 to 8 cm in a box of 0.6 m, so dense that most touch several others. They move and turn.
fn grains(solid: bool, spins: bool, count: usize, masses: bool, species: usize) -> String {
    let mut draw = Draw(7);
    let mut file = "id,radius,mass,x,y,z,vx,vy,vz,species,wx,wy,wz\n".to_owned();
    let mut places: Vec<[f64; 3]> = Vec::new();
    for id in 1..=count {
        let radius = draw.between(0.03, 0.04);
        let mass = if masses { draw.between(0.1, 0.3) } else { 0.2 };
        let mut place = [0.0; 3].map(|_| draw.between(0.03, 0.57));
        let mut velocity = [0.0; 3].map(|_| draw.between(-0.4, 0.4));
        let mut spin = [0.0; 3].map(|_| if spins { draw.between(-9.0, 9.0) } else { 0.0 });
        if !solid {
            (place[2], velocity[2], spin[0], spin[1]) = (0.0, 0.0, 0.0, 0.0);
        }
        let apart = |other: &[f64; 3]| (0..3).map(|axis| (other[axis] - place[axis]).powi(2)).sum::<f64>().sqrt();
        if places.iter().any(|other| apart(other) < NEAREST) {
            continue;
        }
        places.push(place);
        let _ = write!(file, "{id},{radius},{mass}");
        for x in place.iter().chain(&velocity) {
            let _ = write!(file, ",{x}");
        }
        let _ = writeln!(file, ",{},{},{},{}", id % species, spin[0], spin[1], spin[2]);
    }
    file
}

/// A scene of such grains. There is no gravity, so that a force is that of contacts alone.
fn scene(here: &Path, space: &str, contact: &str, walls: &str, more: &str, masses: bool, species: usize) -> Loaded {
    let solid = space == "Solid";
    let spins = contact.contains("tangential");
    let count = if solid { 400 } else { 120 };
    let grains = grains(solid, spins, count, masses, species);
    fs::write(here.join("grains.csv"), &grains).unwrap();
    let gravity = if solid { "(0.0, 0.0, 0.0)" } else { "(0.0, 0.0)" };
    let gravity = if more.starts_with("gravity") { String::new() } else { format!("gravity: {gravity}, ") };
    let scene = format!(
        "(space: {space}, {gravity}contact: {contact}, walls: [{walls}], grains: (file: \"grains.csv\"), \
         integrator: Verlet, step: Fixed(1.0e-5), until: 1.0, pictures: None, watchdog: None, {more})"
    );
    let load = || {
        load::from_text("test.ron", "test", here, scene.clone(), &[]).unwrap_or_else(|fault| panic!("{fault}: {scene}"))
    };
    // Grains whose centre is nearer than NEAREST to a wall are left out.
    let loaded = load();
    let is_clear = |grain: &GrainRow| {
        let walls = loaded.surfaces::<Solid>();
        walls.iter().all(|wall| wall.surface.distance(grain.position) > NEAREST)
    };
    let kept: Vec<_> = if solid {
        loaded.grains.iter().map(is_clear).collect()
    } else {
        let walls = loaded.surfaces::<Plane>();
        let distance = |grain: &GrainRow, wall: &SurfaceWall<Plane>| wall.surface.distance(grain.position.truncate());
        loaded.grains.iter().map(|grain| walls.iter().all(|wall| distance(grain, wall) > NEAREST)).collect()
    };
    let mut rows = grains.lines();
    let header = rows.next().unwrap();
    let rows: Vec<_> = rows.zip(kept).filter(|(_, kept)| *kept).map(|(row, _)| row).collect();
    fs::write(here.join("grains.csv"), format!("{header}\n{}\n", rows.join("\n"))).unwrap();
    load()
}

/// Smallest distance of centres from walls and of each other, m.
const NEAREST: f64 = 0.01;

/// Asserts that forces, and if wanted torques, of two programs are equal to round-off.
///
/// Places of up to 1 m round at 1.1e-16 m. Overlaps are differences of such places, so a force k delta of stiffness k (N/m) carries some
/// 1e-16 k for each of its up to 20 contacts. The direction of a normal is off by 1e-16 m over the distance, at least [`NEAREST`].
fn assert_equal(what: &str, ours: &BTreeMap<u32, [f64; 6]>, theirs: &BTreeMap<u32, [f64; 6]>, k: f64, torques: bool) {
    assert_eq!(ours.len(), theirs.len(), "{what}");
    let largest = ours.values().flatten().fold(0.0, |largest: f64, x| largest.max(x.abs()));
    let bound = 20.0 * f64::EPSILON * (k + largest / NEAREST);
    let mut worst = 0.0f64;
    for (id, ours) in ours {
        let theirs = &theirs[id];
        for column in 0..if torques { 6 } else { 3 } {
            let off = (ours[column] - theirs[column]).abs();
            worst = worst.max(off);
            assert!(off <= bound, "{what}: grain {id}, column {column}: {ours:?} {theirs:?}, bound {bound:e}");
        }
    }
    let touched = ours.values().filter(|row| row[0] != 0.0).count();
    eprintln!(
        "{what}: {touched} of {} grains touched, largest force {largest:.3e} N, worst difference {worst:.1e} N",
        ours.len()
    );
    assert!(2 * touched > ours.len(), "{what}: most grains must have contacts");
}

/// Walls of every flat kind, which do not meet.
const FLAT: &str =
    "HalfPlane(point: (-0.02, 0.0), normal: (1.0, 0.1)), HalfPlane(point: (0.0, 0.0), normal: (0.0, 2.0)),
    Segment(from: (0.1, 0.3), to: (0.3, 0.55)), Segment(from: (0.4, 0.2), to: (0.55, 0.2))";
const FLAT_SOLID: &str = "HalfPlane(point: (-0.02, 0.0, 0.0), normal: (1.0, 0.1, 0.05)),
    Panel(corner: (0.1, 0.1, 0.05), along: (0.3, 0.0, 0.0), across: (0.0, 0.2, 0.0)),
    Panel(corner: (0.1, 0.3, 0.3), along: (0.2, 0.0, 0.1), across: (0.0, 0.25, 0.0)),
    Panel(corner: (0.4, 0.4, 0.2), along: (0.1, 0.05, 0.2), across: (0.1, -0.2, 0.0)),
    Segment(from: (0.3, 0.1, 0.4), to: (0.5, 0.2, 0.55)), Sphere(centre: (0.2, 0.2, 0.5), radius: 0.05)";
const ROUND: &str = "Cylinder(from: (0.3, 0.3, 0.3), to: (0.3, 0.3, 0.55), radius: 0.25),
    Cone(from: (0.3, 0.3, 0.2), to: (0.3, 0.3, 0.05), radii: (0.25, 0.08)),
    Annulus(centre: (0.3, 0.3, 0.25), normal: (0.0, 0.0, 1.0), outer: 0.12)";

/// Laws with their stiffness, N/m, whether torques are equal too, and whether curved walls may have them. Friction with a spring is below
/// its cap: in step 0 every spring is empty, and there LAMMPS gives a sliding contact no friction, siloflow the cap.
const LAWS: [(&str, f64, bool, bool); 12] = [
    ("Assignment(k: 1.0e4, b: 8.0)", 1e4, true, true),
    ("Linear(k: 1.0e4, damping: B(8.0))", 1e4, true, true),
    ("Linear(k: 1.0e4, damping: PerMass(60.0), attraction: Allowed)", 1e4, true, true),
    ("Linear(k: 1.0e4, damping: Restitution(0.4))", 1e4, true, true),
    ("Linear(k: 1.0e4, damping: Restitution(1.0), attraction: Allowed)", 1e4, true, true),
    (
        "Linear(k: 1.0e4, damping: PerMass(60.0), tangential: Spring(k: 3.0e3, damping: PerMass(30.0), friction: 999.0))",
        1e4,
        true,
        true,
    ),
    (
        "Linear(k: 1.0e4, damping: PerMass(60.0), attraction: Allowed, tangential: Dashpot(damping: OfNormal(0.5), friction: 0.3))",
        1e4,
        true,
        true,
    ),
    ("Linear(k: 1.0e4, damping: B(8.0), tangential: Dashpot(damping: B(3.0), friction: 0.5))", 1e4, false, true),
    (
        "Linear(k: 1.0e4, damping: Restitution(0.3), attraction: Allowed,
          tangential: Spring(k: 3.0e3, damping: OfNormal(0.7), friction: 999.0), rolling: (k: 1.0e3, damping: B(0.1), friction: 0.1))",
        1e4,
        false,
        false,
    ),
    ("Hertz(restitution: 0.6)", 1e5, true, false),
    ("Hertz(restitution: 0.3, attraction: Allowed, tangential: Mindlin(friction: 999.0))", 1e5, false, false),
    (
        "Hertz(restitution: 0.9, tangential: Mindlin(friction: 999.0), rolling: (k: 1.0e3, damping: B(0.1), friction: 0.1))",
        1e5,
        false,
        false,
    ),
];

const MATERIAL: &str = "materials: [(young: 1.0e6, poisson: 0.25)],";

#[test]
fn forces_of_step_zero_are_equal_to_round_off_for_every_law_and_wall() {
    if !has_lammps() {
        return;
    }
    for (contact, k, torques, curved) in LAWS {
        for (space, walls) in [("Plane", FLAT), ("Solid", FLAT_SOLID), ("Solid", ROUND)] {
            if walls == ROUND && !curved {
                continue;
            }
            let here = tempfile::tempdir().unwrap();
            let more = if contact.starts_with("Hertz") { MATERIAL } else { "" };
            let loaded = scene(here.path(), space, contact, walls, more, true, 1);
            write(&loaded, here.path());
            let what = format!("{space} {contact}");
            assert_equal(&what, &ours(&loaded), &theirs(here.path(), 1), k, torques);
        }
    }
}

/// Three spheres with three different moments of inertia, as large as the grains of [`grains`].
const BEAN: &str = "shapes: {\"bean\": Spheres([(at: (0.0, 0.0, 0.0), radius: 0.027), (at: (0.016, 0.006, 0.004), radius: 0.021), \
     (at: (-0.013, 0.01, -0.006), radius: 0.022)])},";

/// Gives every other grain of `grains.csv` the shape `bean` and an orientation, and reads the scene anew.
fn shaped(loaded: &Loaded, here: &Path) -> Loaded {
    let mut draw = Draw(11);
    let file = fs::read_to_string(here.join("grains.csv")).unwrap();
    let mut rows = file.lines();
    let mut text = format!("{},shape,qw,qx,qy,qz\n", rows.next().unwrap());
    for (number, row) in rows.enumerate() {
        let rotor = [0.0; 4].map(|_| draw.between(-1.0, 1.0));
        let shape = if number % 2 == 0 { "bean" } else { "" };
        let [w, x, y, z] = if number % 2 == 0 { rotor.map(|x| x.to_string()) } else { [const { String::new() }; 4] };
        let _ = writeln!(text, "{row},{shape},{w},{x},{y},{z}");
    }
    fs::write(here.join("grains.csv"), text).unwrap();
    let scene = loaded.source.text.replacen("(space: Solid,", &format!("(space: Solid, {BEAN}"), 1);
    load::from_text("test.ron", "test", here, scene.clone(), &[]).unwrap_or_else(|fault| panic!("{fault}: {scene}"))
}

#[test]
fn forces_and_torques_of_bodies_at_step_zero_are_equal_to_round_off() {
    if !has_lammps() {
        return;
    }
    // Torques of `pair granular` take another arm, as the export says.
    for (contact, k, torques, _) in LAWS {
        let here = tempfile::tempdir().unwrap();
        let more = if contact.starts_with("Hertz") { MATERIAL } else { "" };
        let loaded = scene(here.path(), "Solid", contact, FLAT_SOLID, more, true, 1);
        let loaded = shaped(&loaded, here.path());
        if contact.starts_with("Assignment") {
            let fault = lammps::export(&loaded).unwrap_err();
            assert!(fault.to_string().contains("turns bodies"), "{fault}");
            continue;
        }
        assert!(loaded.grains.iter().filter(|grain| grain.posture.is_some()).count() > 100);
        write(&loaded, here.path());
        assert_equal(
            &format!("bodies, {contact}"),
            &ours(&loaded),
            &theirs_of_bodies(&loaded, here.path()),
            k,
            torques,
        );
    }
}

/// One grain presses on a round wall. siloflow's contact radius follows from the mean curvature c of the wall as seen by the grain: 1/(1/r + c). LAMMPS takes
/// r 2R/(2R - r) within a cylinder and at a cone, and r outside a cylinder. Hertz's forces differ by the square root of the ratio, to the round-off of an overlap of 1 mm.
#[test]
fn hertz_at_round_walls_differs_by_the_contact_radius_that_the_export_names() {
    if !has_lammps() {
        return;
    }
    let cylinder = "Cylinder(from: (0.3, 0.3, 0.1), to: (0.3, 0.3, 0.55), radius: 0.25)";
    let cone = "Cone(from: (0.3, 0.3, 0.1), to: (0.3, 0.3, 0.3), radii: (0.05, 0.25))";
    let radius_of = |curvature: f64| 1.0 / (1.0 / 0.03 + curvature);
    // The point of the cone at the height 0.2 has the radius 0.15; its normal is (-1, 0, 1)/sqrt(2).
    let depth = 0.029 / 2.0f64.sqrt();
    let within = radius_of(-1.0 / 0.5);
    let of_cone = radius_of(-1.0 / (0.3 * 2.0f64.sqrt()));
    let cases = [
        (cylinder, 0.55 - 0.029, 0.3, within, within),
        (cylinder, 0.55 + 0.029, 0.3, radius_of(1.0 / 0.5), 0.03),
        (cone, 0.45 - depth, 0.2 + depth, of_cone, radius_of(-1.0 / 0.3)),
    ];
    for (wall, x, z, ours_takes, theirs_takes) in cases {
        let here = tempfile::tempdir().unwrap();
        let text = format!(
            "(space: Solid, gravity: (0.0, 0.0, 0.0), contact: Hertz(restitution: 0.6), walls: [{wall}], grains: (file: \"grains.csv\"), \
             integrator: Verlet, step: Fixed(1.0e-5), until: 1.0, pictures: None, {MATERIAL})"
        );
        let row = format!("id,radius,mass,x,y,z,vx,vy,vz\n1,0.03,0.2,{x},0.3,{z},0,0,0\n");
        fs::write(here.path().join("grains.csv"), row).unwrap();
        let loaded = load::from_text("test.ron", "test", here.path(), text, &[]).unwrap();
        let export = lammps::export(&loaded).unwrap();
        assert!(export.script.contains("the contact radius of a cylinder"), "{}", export.script);
        write(&loaded, here.path());
        let ours = ours(&loaded)[&1];
        let theirs = theirs(here.path(), 1)[&1];
        let ratio = (theirs_takes / ours_takes).sqrt();
        for column in 0..3 {
            let off = (theirs[column] - ratio * ours[column]).abs();
            // F is k delta^1.5, and five operations round the overlap of 1 mm at 1.1e-16 m: 1.5 * 5 * 1.1e-13 is 4e3 eps.
            assert!(off <= 4e3 * f64::EPSILON * ours[0].abs(), "{wall}: {ours:?} {theirs:?}, expected ratio {ratio}");
        }
    }
}

/// Positions, velocities and spins at the end of a run of LAMMPS, from its data file.
fn state_of_lammps(here: &Path) -> BTreeMap<u32, [f64; 9]> {
    let file = fs::read_to_string(here.join("final.data")).unwrap();
    let mut state = BTreeMap::new();
    let mut section = "";
    for line in file.lines() {
        let cells: Vec<_> = line.split_whitespace().collect();
        if let Some(name) = cells.first().filter(|name| name.starts_with(char::is_alphabetic)) {
            section = if *name == "Atoms" {
                "Atoms"
            } else if *name == "Velocities" {
                "Velocities"
            } else {
                ""
            };
        } else if !section.is_empty() && cells.len() >= 7 {
            let numbers: Vec<f64> = cells.iter().map(|cell| cell.parse().unwrap()).collect();
            let row: &mut [f64; 9] = state.entry(numbers[0] as u32).or_default();
            match section {
                "Atoms" => row[..3].copy_from_slice(&numbers[4..7]),
                _ => row[3..].copy_from_slice(&numbers[1..7]),
            }
        }
    }
    state
}

/// Differences of each grain from a state of LAMMPS: of its position (m), and of its velocity and of its spin times 3 cm (m/s).
fn differences<V: Space>(simulation: &mut Simulation, theirs: &BTreeMap<u32, [f64; 9]>) -> BTreeMap<u32, [f64; 2]> {
    let world = simulation.world_mut();
    let mut query = world.query_filtered::<(&GrainId, &Position<V>, &Velocity<V>, &Spin<V::Spin>), With<Grain>>();
    let rows = query.iter(world).map(|(id, position, velocity, spin)| {
        let ours = [position.0.spread(), velocity.0.spread(), spin.0.spread()];
        let theirs = theirs[&id.number()].as_chunks::<3>().0;
        let [x, v, w] = [0, 1, 2].map(|vector| (ours[vector] - Solid::from(theirs[vector])).length());
        (id.number(), [x, v.max(0.03 * w)])
    });
    rows.collect()
}

/// Steps of the comparison of motions. Rounding grows by some factor of 2 in each contact time of 440 steps.
const STEPS: u64 = 200;

#[test]
fn motion_with_springs_is_equal_to_round_off_with_the_classic_law() {
    if !has_lammps() {
        return;
    }
    let here = tempfile::tempdir().unwrap();
    let contact = "Linear(k: 1.0e4, damping: PerMass(60.0),
        tangential: Spring(k: 3.0e3, damping: PerMass(30.0), friction: 0.4))";
    let walls = "HalfPlane(point: (0.0, 0.0), normal: (0.1, 1.0)), HalfPlane(point: (0.0, 0.0), normal: (1.0, 0.0)),
        Disc(centre: (0.4, 0.3), radius: 0.05)";
    let end = format!("until: {:e}", 1e-5 * STEPS as f64);
    let loaded = scene(here.path(), "Plane", contact, walls, "gravity: (0.0, -9.81)", true, 1);
    let grains = fs::read_to_string(here.path().join("grains.csv")).unwrap();
    // Grains start at rest, so that no contact slides in step 0, and their springs load and slide on the way.
    let still: Vec<_> = grains
        .lines()
        .skip(1)
        .map(|line| line.split(',').take(6).collect::<Vec<_>>().join(",") + ",0,0,0,0,0,0,0")
        .collect();
    fs::write(here.path().join("grains.csv"), format!("{}\n{}\n", grains.lines().next().unwrap(), still.join("\n")))
        .unwrap();
    let source = loaded.source.text.replace("until: 1.0", &end);
    let loaded = load::from_text("test.ron", "test", here.path(), source, &[]).unwrap();
    write(&loaded, here.path());
    lmp(here.path(), 1, &["-log", "none"]);
    let theirs = state_of_lammps(here.path());
    let mut simulation = crate::simulation(&loaded, 1);
    simulation.run_steps(STEPS + 1);
    let differences = differences::<Plane>(&mut simulation, &theirs);
    let worst = differences.values().fold([0.0f64; 2], |worst, off| [worst[0].max(off[0]), worst[1].max(off[1])]);
    eprintln!("after {STEPS} steps: positions differ by up to {:.1e} m, velocities by {:.1e} m/s", worst[0], worst[1]);
    // Forces round at 5e-12 N, so that 200 steps of 1e-5 s give 0.1 kg a velocity of 1e-13 m/s; the data file has 17 digits.
    assert!(worst[0] < 1e-13 && worst[1] < 1e-11, "{worst:?}");
}

/// Runs [`STEPS`] steps of a scene with grains (rows after `id,radius,mass`, each with the speed at the start), and returns the difference of each from LAMMPS. Each
/// grain meets one wall after some steps, so that the velocity of walls in step 0, zero in LAMMPS, does not matter.
fn differences_at_walls(grains: &[([f64; 6], f64)], walls: &str, more: &str) -> BTreeMap<u32, [f64; 2]> {
    let here = tempfile::tempdir().unwrap();
    let mut file = "id,radius,mass,x,y,z,vx,vy,vz\n".to_owned();
    for (id, (row, _)) in (1..).zip(grains) {
        let _ = writeln!(file, "{id},0.03,0.2,{}", row.map(|number| number.to_string()).join(","));
    }
    fs::write(here.path().join("grains.csv"), file).unwrap();
    let scene = format!(
        "(space: Solid, gravity: (0.0, 0.0, 0.0), integrator: Verlet, step: Fixed(1.0e-5), until: {:e}, pictures: None,
          contact: Linear(k: 1.0e4, damping: PerMass(60.0), tangential: Spring(k: 3.0e3, damping: PerMass(30.0), friction: 0.4)),
          grains: (file: \"grains.csv\"), walls: [{walls}], {more})",
        1e-5 * STEPS as f64,
    );
    let loaded = load::from_text("test.ron", "test", here.path(), scene, &[]).unwrap_or_else(|fault| panic!("{fault}"));
    write(&loaded, here.path());
    lmp(here.path(), 1, &["-log", "none"]);
    let theirs = state_of_lammps(here.path());
    let speeds: Vec<_> = theirs.values().map(|row| Solid::from_slice(&row[3..6]).length()).collect();
    // 1 N for 1 ms gives 0.2 kg 5 mm/s.
    let has_acted = speeds.iter().zip(grains).all(|(speed, (_, start))| (speed - start).abs() > 5e-3);
    assert!(speeds.len() == grains.len() && has_acted, "{speeds:?}");
    let mut simulation = crate::simulation(&loaded, 1);
    simulation.run_steps(STEPS + 1);
    let found = differences::<Solid>(&mut simulation, &theirs);
    eprintln!("{found:?}");
    found
}

/// A panel of 20 cm, 0.3 m high.
fn panel(x: f64, name: &str) -> String {
    format!("Panel(corner: ({x:?}, -0.1, 0.3), along: (0.2, 0.0, 0.0), across: (0.0, 0.2, 0.0), name: \"{name}\"),")
}

#[test]
fn walls_that_move_push_and_drag_grains_in_lammps_as_in_siloflow() {
    if !has_lammps() {
        return;
    }
    let grains = [
        ([0.0, 0.0, 0.0301, 0.0, 0.0, -1.0], 1.0),
        ([1.1699, 0.0, 0.4, 1.0, 0.0, 0.0], 1.0),
        ([2.1, 0.0, 0.3302, 0.0, 0.0, 0.0], 0.0),
        ([3.1, 0.0, 0.3301, 0.0, 0.0, 0.0], 0.0),
        ([4.1, 0.0, 0.3322, 0.0, 0.0, -1.0], 1.0),
        ([5.1, 0.0, 0.3302, 0.0, 0.0, 0.0], 0.0),
    ];
    let panels = [(2.0, "lift"), (3.0, "paddle"), (4.0, "stop"), (5.0, "shaker")].map(|(x, name)| panel(x, name));
    let walls = "HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0), velocity: (0.5, -0.2, 0.0)),
        Cylinder(from: (1.0, 0.0, 0.6), to: (1.0, 0.0, 0.2), radius: 0.2, spin: 4.0),";
    let motions = "motions: [
        (walls: \"lift\", translate: Steady((0.2, 0.0, 1.0)), from: 1.0e-4),
        (walls: \"paddle\", rotate: (about: (3.0, 0.0, 0.3), axis: (0.0, 2.0, 0.0), by: Steady(-5.0))),
        (walls: \"stop\", translate: Steady((0.0, 0.0, 1.0)), until: 1.0e-3),
        (walls: \"shaker\", translate: Oscillate(amplitude: (0.0, 0.0, 1.0e-3), frequency: 50.0, phase: 0.2))]";
    for (grain, [position, velocity]) in differences_at_walls(&grains, &format!("{walls}{}", panels.concat()), motions)
    {
        // Positions of walls round at 1e-16 m, so their velocity over a step of 1e-5 s at 1e-11 m/s, and the drag of 60/s acts for 2e-3 s. The
        // mean velocity of the shaker over a step is late by half a step: a w^2 dt/2 = 5e-4 m/s.
        let [far, fast] = if grain == 6 { [1e-7, 60.0 * 5e-4 * 2e-3] } else { [1e-13, 1e-11] };
        assert!(position < far && velocity < fast, "grain {grain}: {position:e} m, {velocity:e} m/s");
    }
}

#[test]
fn a_half_plane_that_turns_pushes_a_grain_in_lammps_as_in_siloflow() {
    if !has_lammps() {
        return;
    }
    let floor = "HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0), name: \"floor\"),";
    let turn =
        "motions: [(walls: \"floor\", rotate: (about: (-0.1, 0.0, 0.0), axis: (0.0, 2.0, 0.0), by: Steady(-5.0)))]";
    let found = differences_at_walls(&[([0.1, 0.0, 0.0302, 0.0, 0.0, 0.0], 0.0)], floor, turn);
    // As for walls that move.
    assert!(found[&1][0] < 1e-13 && found[&1][1] < 1e-11, "{found:?}");
}

#[test]
fn a_door_that_moves_drags_a_grain_in_lammps_as_in_siloflow() {
    if !has_lammps() {
        return;
    }
    // With a schedule the door turns round on its way.
    for opens in ["At(5.0e-4)", "Schedule([(4.0e-4, 7.0e-4), (9.0e-4, 1.5e-3)])"] {
        let gate = format!("doors: [(walls: \"gate\", opens: {opens}, how: Move(by: (0.0, 4.0e-3, 0.0), speed: 2.0))]");
        let found = differences_at_walls(&[([0.1, 0.0, 0.3302, 0.0, 0.0, -1.0], 1.0)], &panel(0.0, "gate"), &gate);
        // LAMMPS begins a new run when the door opens, and computes forces once more, with the velocity of the end of the step. The drag of
        // 60/s and an acceleration below 100 m/s^2 give 60 * 100 * dt^2/4 = 1.5e-7 m/s; the drag along the door doubles it at most.
        assert!(found[&1][0] < 3e-7 * 1.6e-3 && found[&1][1] < 3e-7, "{opens}: {found:?}");
    }
}

#[test]
fn laws_of_species_pairs_and_materials_of_walls_keep_their_forces() {
    if !has_lammps() {
        return;
    }
    let here = tempfile::tempdir().unwrap();
    let wall = "HalfPlane(point: (0.0, 0.0), normal: (1.0, 0.0), species: 1), HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))";
    let more = "pairs: [(species: (0, 1), contact: Linear(k: 2.0e4, damping: B(3.0)))],";
    let loaded = scene(here.path(), "Plane", "Linear(k: 1.0e4, damping: PerMass(60.0))", wall, more, true, 2);
    write(&loaded, here.path());
    assert_equal("pairs", &ours(&loaded), &theirs(here.path(), 1), 2e4, true);
    let here = tempfile::tempdir().unwrap();
    let more = "materials: [(young: 1.0e6, poisson: 0.25), (young: 4.0e6, poisson: 0.1)],";
    let contact = "Hertz(restitution: 0.5, tangential: Mindlin(friction: 999.0))";
    let loaded = scene(here.path(), "Plane", contact, wall, more, true, 2);
    write(&loaded, here.path());
    assert_equal("materials", &ours(&loaded), &theirs(here.path(), 1), 4e5, false);
}

#[test]
fn forces_of_step_zero_are_equal_on_one_two_and_four_ranks() {
    if !has_lammps() {
        return;
    }
    let here = tempfile::tempdir().unwrap();
    let (contact, k, torques, _) = LAWS[5];
    let periodic = "periodic: (x: (0.0, 0.6)),";
    let walls = "HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0)),
        Panel(corner: (0.1, 0.3, 0.3), along: (0.2, 0.0, 0.1), across: (0.0, 0.25, 0.0))";
    let loaded = scene(here.path(), "Solid", contact, walls, periodic, true, 1);
    write(&loaded, here.path());
    let ours = ours(&loaded);
    for ranks in [1, 2, 4] {
        assert_equal(&format!("{ranks} ranks"), &ours, &theirs(here.path(), ranks), k, torques);
    }
}

#[test]
fn what_does_not_map_is_refused_with_its_key_and_nothing_is_written() {
    let solid = |contact: &str, walls: &str| (contact.to_owned(), walls.to_owned(), String::new());
    let plane = "HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))";
    let linear = "Linear(k: 1.0e4, damping: PerMass(60.0))";
    let spring = |lever: &str, damping: &str| {
        format!(
            "Linear(k: 1.0e4, damping: PerMass(60.0), tangential: Spring(k: 3.0e3, damping: {damping}, friction: 0.5), lever: {lever})"
        )
    };
    let more = |key: &str| (linear.to_owned(), plane.to_owned(), key.to_owned());
    let cases = [
        (solid(&spring("ContactPoint", "B(0.0)"), plane), "contact.Linear.lever", "arms"),
        (solid(&spring("Radius", "B(3.0)"), plane), "contact.Linear.tangential.damping", "different kinds"),
        (solid("Linear(k: 1.0e4, damping: Restitution(0.01))", plane), "contact.Linear.damping", "tsuji"),
        (
            solid(
                "Linear(k: 1.0e4, damping: B(1.0), tangential: Spring(k: 3.0e3, damping: B(0.0), friction: 0.5),
                  rolling: (k: 1.0e3, damping: PerMass(1.0), friction: 0.1))",
                plane,
            ),
            "contact.Linear.rolling.damping",
            "masses differ",
        ),
        (
            solid(linear, "Polygon(points: [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)])"),
            "walls[0]",
            "July 2026",
        ),
        (
            solid(linear, "Annulus(centre: (0.3, 0.3, 0.0), normal: (0.0, 0.0, 1.0), inner: 0.1, outer: 0.3)"),
            "walls[0]",
            "flat ring",
        ),
        (
            solid(linear, "Panel(corner: (0.0, 0.0, 0.0), along: (0.6, 0.0, 0.0), across: (0.0, 0.6, 0.0), hole: Circle(centre: (0.3, 0.3, 0.0), radius: 0.1))"),
            "walls[0]",
            "wall with a hole",
        ),
        (solid(linear, "SphericalZone(centre: (0.3, 0.3, 0.3), radius: 0.3)"), "walls[0]", "part of a sphere"),
        (
            solid(linear, &format!("{plane}, Cylinder(from: (0.3, 0.3, 0.0), to: (0.4, 0.3, 0.6), radius: 0.3)")),
            "walls[1]",
            "along x, y or z",
        ),
        (
            (
                linear.to_owned(),
                "Panel(corner: (0.1, 0.3, 0.3), along: (0.2, 0.0, 0.1), across: (0.0, 0.25, 0.0), name: \"paddle\")".to_owned(),
                "motions: [(walls: \"paddle\", rotate: (about: (0.1, 0.3, 0.3), axis: (0.0, 1.0, 0.0), by: Steady(1.0)))],"
                    .to_owned(),
            ),
            "walls[0]",
            "one rotation",
        ),
        (
            more(
                "mass: Sphere(1000.0), feed: [(region: Box(low: (0.0, 0.0, 2.0), high: (1.0, 1.0, 2.0)), rate: Grains(1.0), \
                  total: Grains(3), radius: Fixed(0.03), velocity: (0.0, 0.0, 0.0))],",
            ),
            "feed",
            "fix pour",
        ),
        (
            more(
                "mass: Sphere(1000.0), spawner: (point: (0.0, 0.0, 0.01), velocity: (0.0, 0.0, 0.0), interval: 0.1, count: 2, \
                  radius: Fixed(0.03)),",
            ),
            "spawner.point",
            "touches a wall",
        ),
    ];
    for case in cases {
        assert_export_refused(case);
    }
}

/// Two spheres on a floor at this height, m, with these ids.
fn on_a_floor_at(height: f64, ids: [u32; 2], here: &Path) -> Loaded {
    let [low, high] = [height + 0.0045, height + 0.0052];
    let grains = format!(
        "id,radius,mass,x,y,z,vx,vy,vz\n{},0.005,0.001,0.02,0.02,{high},0.3,0.1,-0.2\n{},0.004,0.0006,0.029,0.02,{low},0,0,0\n",
        ids[0], ids[1]
    );
    fs::write(here.join("grains.csv"), grains).unwrap();
    let scene = format!(
        "(space: Solid, gravity: (0.0, 0.0, -9.81), integrator: Verlet, step: Fixed(1.0e-5),
        contact: Linear(k: 1.0e4, damping: PerMass(300.0), tangential: Spring(k: 2857.0, damping: OfNormal(1.0), friction: 0.4)),
        walls: [HalfPlane(point: (0.0, 0.0, {height}), normal: (0.0, 0.0, 1.0))],
        grains: (file: \"grains.csv\"), until: 0.02, pictures: None, series: (interval: 0.003), data_frames: (interval: 0.02))"
    );
    load::from_text("floor.ron", "floor", here, scene, &[]).unwrap_or_else(|fault| panic!("{fault}"))
}

#[test]
fn files_of_lammps_have_all_digits() {
    let here = tempfile::tempdir().unwrap();
    let loaded = on_a_floor_at(1000.0, [1, 2], here.path());
    let script = lammps::export(&loaded).unwrap().script;
    // The formats of whole numbers and of wall-clock time are the only others.
    for (_, rest) in script.match_indices(":%").map(|(at, _)| script.split_at(at)) {
        assert!([":%.17g)", ":%.0f)", ":%.3f)"].iter().any(|format| rest.starts_with(format)), "{}", &rest[..10]);
    }
    if !has_lammps() {
        return;
    }
    write(&loaded, here.path());
    lmp(here.path(), 1, &["-screen", "none"]);
    let mut simulation = crate::simulation(&loaded, 1);
    simulation.run();
    let world = simulation.world_mut();
    let ours: BTreeMap<u32, f64> = world
        .query_filtered::<(&GrainId, &Position<siloflow::dem::space::Solid>), With<Grain>>()
        .iter(world)
        .map(|(id, x)| (id.number(), x.0.z))
        .collect();
    let dump = fs::read_to_string(here.path().join("frames.dump")).unwrap();
    let last = dump.rsplit("ITEM: ATOMS id type radius mass x y z").next().unwrap();
    for row in last.lines().skip(1) {
        let cells: Vec<&str> = row.split_whitespace().collect();
        let (id, z): (u32, f64) = (cells[0].parse().unwrap(), cells[6].parse().unwrap());
        // Round-off of places at 1000 m, 1e-13 m in each of 2000 steps. With six digits a place is known to 5 mm.
        assert!((z - ours[&id]).abs() < 1e-9, "{row}: {}", ours[&id]);
    }
    // Times are multiples of the step.
    let series = fs::read_to_string(here.path().join("series.csv")).unwrap();
    let times: Vec<f64> = series.lines().skip(1).map(|row| row.split(',').next().unwrap().parse().unwrap()).collect();
    assert!(
        times.len() >= 7 && times.iter().all(|time| ((time / 1e-5).round() * 1e-5 - time).abs() < 1e-17),
        "{times:?}"
    );
}

#[test]
fn identifiers_that_lammps_does_not_have_are_refused() {
    let here = tempfile::tempdir().unwrap();
    for (ids, word) in [([0, 2], "id 0"), ([7, GrainId::MAX_GRAIN], "")] {
        let loaded = on_a_floor_at(0.0, ids, here.path());
        match lammps::export(&loaded) {
            Err(fault) => assert!(fault.to_string().contains(word), "{ids:?}: {fault}"),
            Ok(_) => assert_ne!(ids[0], 0, "{ids:?}"),
        }
    }
    // A fixed sphere would get the id after the largest.
    let mut loaded = on_a_floor_at(0.0, [7, GrainId::MAX_GRAIN], here.path());
    assert!(lammps::export(&loaded).is_ok());
    let centre = siloflow::dem::space::Solid::ZERO;
    let species = Species(0);
    loaded.fixed = vec![FixedGrain { position: centre, radius: 0.001, velocity: centre, species }];
    assert!(lammps::export(&loaded).unwrap_err().to_string().contains("last id"));
}

#[test]
fn doors_that_do_not_map_are_refused() {
    let linear = "Linear(k: 1.0e4, damping: PerMass(60.0))";
    let cases = [
        (
            (
                linear.to_owned(),
                "HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0), velocity: (0.1, 0.0, 0.0), name: \"belt\")".to_owned(),
                "doors: [(walls: \"belt\", opens: At(0.1), how: Move(by: (0.0, 0.0, -0.1), speed: 1.0))],".to_owned(),
            ),
            "walls[0]",
            "of its own",
        ),
        (
            (
                linear.to_owned(),
                panel(0.0, "gate"),
                "gravity: (0.0, 0.0, -9.81), doors: [(walls: \"gate\", opens: Schedule([(0.1, 0.2)]), how: Move(by: (0.2, 0.0, 0.0), speed: 1.0))], stop: [AtRest],
                 rest: (speed: 0.1, energy: 1.0e-2, hold: 0.01),"
                    .to_owned(),
            ),
            "stop",
            "stops at rest",
        ),
        (
            (
                linear.to_owned(),
                panel(0.0, "gate"),
                "doors: [(walls: \"gate\", opens: Schedule([(0.1, 0.2)]), how: Move(by: (0.2, 0.0, 0.0), speed: 1.0))],
                 mass: Sphere(1000.0), spawner: (point: (0.5, 0.5, 0.5), velocity: (0.0, 0.0, 0.0), interval: 0.1, count: 2,
                  radius: Fixed(0.03)),"
                    .to_owned(),
            ),
            "doors[0].opens",
            "given times",
        ),
    ];
    for case in cases {
        assert_export_refused(case);
    }
}

/// Asserts that a scene with this contact law, these walls and keys is refused with a key and words, and that nothing is written.
fn assert_export_refused(((contact, walls, more), key, reason): ((String, String, String), &str, &str)) {
    let here = tempfile::tempdir().unwrap();
    let loaded = scene(here.path(), "Solid", &contact, &walls, &more, true, 1);
    let fault = lammps::export(&loaded).expect_err(&format!("{key} {reason}"));
    assert_eq!((fault.code(), fault.scene_key()), ("lammps::unmapped", Some(key)), "{fault}");
    assert!(fault.to_string().contains(reason), "{fault}");
    fs::write(here.path().join("refused.ron"), &loaded.source.text).unwrap();
    let output = siloflow(here.path(), &["export", "refused.ron", "--to", "lammps"]);
    let said = text(&output.stderr);
    assert!(output.status.code() == Some(2) && said.contains(key) && said.contains("help:"), "{said}");
    assert!(output.stdout.is_empty() && !here.path().join("out").exists(), "{key}");
}

#[test]
fn wrong_calls_are_refused() {
    let here = tempfile::tempdir().unwrap();
    let bed = crate::scene("bed3d.ron").display().to_string();
    let lattice = crate::scene("silo2d-lattice.ron").display().to_string();
    let table = crate::scene("hard/moving-walls.ron").display().to_string();
    fs::create_dir(here.path().join("run")).unwrap();
    fs::create_dir_all(here.path().join("there")).unwrap();
    fs::write(here.path().join("text.ron"), "no scene").unwrap();
    for (arguments, says) in [
        (vec!["missing.ron", "--to", "lammps"], "missing.ron"),
        (vec!["run", "--to", "lammps"], "run/scene.ron"),
        (vec!["text.ron", "--to", "lammps"], "text.ron"),
        (vec![lattice.as_str(), "--to", "lammps"], "lattice gas"),
        (vec![table.as_str(), "--to", "lammps"], "motions by a table"),
        (vec![bed.as_str(), "--to", "lamps"], "lammps"),
        (vec![bed.as_str(), "--to", "lammps", "--out", "there"], "there exists"),
        (vec![bed.as_str(), "--to", "lammps", "--set", "contct=1"], "contct"),
        (vec!["run", "--to", "vtk", "--seed", "1"], "--seed"),
    ] {
        let output = siloflow(here.path(), &[&["export"], &arguments[..]].concat());
        let said = text(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains(says), "{arguments:?}: {said}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
    }
    assert!(fs::read_dir(here.path().join("there")).unwrap().next().is_none());
    assert!(!here.path().join("out").exists());
}

/// Exports a scene with settings into `out` and runs it in LAMMPS; returns its summary.
fn run_exported(here: &Path, scene: &Path, settings: &[&str], out: &str, ranks: usize) -> Value {
    let set: Vec<_> = settings.iter().flat_map(|setting| ["--set", setting]).collect();
    let scene = scene.display().to_string();
    let output = siloflow(here, &[&["export", &scene, "--to", "lammps", "--out", out], &set[..]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("not the same in LAMMPS") && text(&output.stdout).contains("mpirun"));
    lmp(&here.join(out), ranks, &["-screen", "none"]);
    serde_json::from_str(&fs::read_to_string(here.join(out).join("summary.json")).unwrap()).unwrap()
}

#[test]
fn silos_fill_come_to_rest_and_discharge_in_lammps_and_their_figures_are_drawn() {
    if !has_lammps() {
        return;
    }
    let here = tempfile::tempdir().unwrap();
    let small = ["fill[0].count=60", "data_frames=(interval: 0.5)"];
    for (name, ranks) in [("flat", 1), ("wedge", 2), ("cone", 1)] {
        let scene = crate::root().join(format!("docs/measure/lammps/{name}.ron"));
        let summary = run_exported(here.path(), &scene, &small, name, ranks);
        let [rest, opened, end] =
            ["rest_time_s", "door_open_time_s", "end_time_s"].map(|key| summary[key].as_f64().unwrap());
        assert!(rest > 0.0 && rest == opened && opened < end && end < 10.0, "{summary}");
        let [out, inside] = ["out", "inside"].map(|key| summary["grains"][key].as_u64().unwrap());
        // A flat bottom keeps some grains.
        assert!(out + inside == 60 && out > 30 && (name == "flat" || inside == 0), "{summary}");
        for file in ["series.csv", "wall_forces.csv", "door_forces.csv", "frames.dump", "final.data"] {
            assert!(here.path().join(name).join(file).metadata().unwrap().len() > 100, "{file}");
        }
    }
    let output = siloflow(here.path(), &["compare", "flat", "wedge", "--out", "compared", "--quiet"]);
    let table = fs::read_to_string(here.path().join("compared/compare.csv")).unwrap_or_default();
    assert!(output.status.success() && table.lines().count() == 3, "{table} {}", text(&output.stderr));
    let output = siloflow(here.path(), &["plot", "flat", "wedge", "--out", "plots", "--quiet"]);
    assert!(output.status.success() && here.path().join("plots").is_dir(), "{}", text(&output.stderr));
}

#[test]
fn a_spawner_releases_all_grains_in_lammps() {
    if !has_lammps() {
        return;
    }
    let here = tempfile::tempdir().unwrap();
    let settings = ["spawner.count=40", "data_frames=None", "pictures=None"];
    let summary = run_exported(here.path(), &crate::scene("silo1.ron"), &settings, "silo1", 1);
    assert!(summary["grains"]["out"] == 40 && summary["grains"]["released"] == 40, "{summary}");
    // The first grain has the place and the speed that siloflow gives it.
    let loaded = crate::load("silo1.ron", &[("spawner.count", "40")]);
    let mut simulation = crate::simulation(&loaded, 1);
    simulation.step();
    let world = simulation.world_mut();
    let first = world.query_filtered::<&Position, With<Grain>>().iter(world).next().unwrap().0;
    let script = fs::read_to_string(here.path().join("silo1").join(lammps::SCRIPT)).unwrap();
    let line = format!("create_atoms 1 single {:?} {:?} 0.0 units box", first.x, first.y);
    assert!(script.contains(&line), "{line}");
}
