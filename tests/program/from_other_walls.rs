//! `--from DIR` into a scene with other walls, or without friction: memories of contacts belong to walls, not to places in a list.

use std::fs;
use std::path::Path;

use crate::command_line::{siloflow, text};

/// Words of an error or a log, without the frame of a report.
fn words(output: &std::process::Output) -> String {
    text(&output.stderr).split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}

/// Starts a run and returns what it logs.
fn run(here: &Path, arguments: &[&str]) -> String {
    let output = siloflow(here, &[&["run"], arguments].concat());
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    words(&output)
}

/// Returns the vertical force of each named group of walls in the first or the last row, N.
fn forces(run: &Path, last: bool) -> Vec<(String, f64)> {
    let mut reader = csv::Reader::from_path(run.join("wall_groups.csv")).unwrap();
    let header = reader.headers().unwrap().clone();
    let columns = ["time_s", "walls", "fy_n"].map(|name| header.iter().position(|column| column == name).unwrap());
    let rows: Vec<_> = reader.records().map(Result::unwrap).collect();
    let time = rows[if last { rows.len() - 1 } else { 0 }][columns[0]].to_owned();
    let rows = rows.iter().filter(|row| row[columns[0]] == time);
    rows.map(|row| (row[columns[1]].to_owned(), row[columns[2]].parse().unwrap())).collect()
}

/// A bin with rough walls, filled with discs.
fn bin(walls: &[&str], fill: &str) -> String {
    format!(
        "(gravity: (0.0, -9.81), seed: 3, contact: Linear(k: 1.0e5, damping: Restitution(0.3), tangential: Spring(k: 2.857e4, \
         damping: OfNormal(0.5), friction: 0.6)), mass: Disc(100.0), step: Fixed(4.0e-5), walls: [{}], {fill} until: 2.0, \
         cull: (below: -1.0), on_loss: Continue, pictures: None, data_frames: None, series: (interval: 0.002))",
        walls.join(", ")
    )
}

const LID: &str = "Segment(from: (-0.05, 0.5), to: (0.05, 0.5), name: \"lid\")";
const FLOOR: &str = "Segment(from: (-0.05, 0.0), to: (0.05, 0.0), name: \"floor\")";
const LEFT: &str = "Segment(from: (-0.05, 0.0), to: (-0.05, 0.5), name: \"left\")";
const RIGHT: &str = "Segment(from: (0.05, 0.0), to: (0.05, 0.5), name: \"right\")";

#[test]
fn friction_at_walls_carries_on_whatever_the_list_of_walls() {
    let here = tempfile::tempdir().unwrap();
    let write = |name: &str, walls: &[&str], fill: &str| {
        fs::write(here.path().join(format!("{name}.ron")), bin(walls, fill)).unwrap();
    };
    let fill = "fill: [(low: (-0.049, 0.001), high: (0.049, 0.3), spacing: 0.0105, count: 120, radius: Uniform(0.004, 0.005), \
                agitation: (0.1, 0.1))],";
    write("settle", &[LID, FLOOR, LEFT, RIGHT], fill);
    run(here.path(), &["settle.ron", "--out", "settled"]);
    let end = forces(&here.path().join("settled"), true);
    let of = |forces: &[(String, f64)], name: &str| forces.iter().find(|(walls, _)| walls == name).unwrap().1;
    assert!(of(&end, "left").abs() > 0.05 && of(&end, "right").abs() > 0.05, "the walls carry: {end:?}");
    // Shorter, divided, bent by a tenth of a micrometre, and under another name.
    let [low, high] = [
        "Segment(from: (-0.05, 0.0), to: (-0.05, 0.13), name: \"left\")",
        "Segment(from: (-0.05, 0.13), to: (-0.05, 0.4), name: \"left\")",
    ];
    let bent = RIGHT.replace("to: (0.05, 0.5)", "to: (0.0500001, 0.5)");
    let renamed = FLOOR.replace("floor", "ground");
    for (name, walls) in [
        ("same", vec![LID, FLOOR, LEFT, RIGHT]),
        ("no-lid", vec![FLOOR, LEFT, RIGHT]),
        ("turned", vec![RIGHT, LEFT, FLOOR, LID]),
        ("divided", vec![high, low, &bent, &renamed]),
    ] {
        write(name, &walls, "");
        let said = run(here.path(), &[&format!("{name}.ron"), "--from", "settled", "--until", "0.01", "--out", name]);
        assert!(!said.contains("left out"), "{name}: {said}");
        let start = forces(&here.path().join(name), false);
        for side in ["left", "right"] {
            // At rest the forces of the last step and of the first one differ by the dashpots and by half a step of sliding. Without the
            // memories friction would begin at zero.
            let off = (of(&start, side) - of(&end, side)).abs();
            assert!(off < 5e-3, "{name}, {side}: {start:?} {end:?}");
        }
        // The copy in the run directory starts in the same way.
        run(here.path(), &[&format!("{name}/scene.ron"), "--until", "0.01", "--out", "again", "--force"]);
        assert_eq!(forces(&here.path().join("again"), false), start, "{name}");
    }
    // The memories of a wall that is gone are left out, with their number.
    write("open", &[FLOOR, RIGHT], "");
    let said = run(here.path(), &["open.ron", "--from", "settled", "--until", "0.001", "--out", "open"]);
    assert!(said.contains("contacts_left_out") && said.contains("there is no wall `left`"), "{said}");
    run(here.path(), &["open/scene.ron", "--until", "0.001", "--out", "again", "--force"]);
}

#[test]
fn memories_follow_the_triangles_of_a_mesh() {
    let here = tempfile::tempdir().unwrap();
    let corners = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n";
    fs::write(here.path().join("a.obj"), format!("{corners}f 1 2 3\nf 1 3 4\n")).unwrap();
    fs::write(here.path().join("b.obj"), format!("{corners}f 2 4 1\nf 4 2 3\n")).unwrap();
    fs::write(
        here.path().join("g.csv"),
        "id,radius,mass,x,y,z,vx,vy,vz\n1,0.05,1,0.3,0.2,0.0499,0.3,0,0\n2,0.05,1,-0.3,0.2,0.0499,0,0.2,0\n",
    )
    .unwrap();
    let scene = |mesh: &str, grains: &str| {
        format!(
            "(space: Solid, gravity: (1.0, 0.0, -9.81), contact: Linear(k: 1.0e5, damping: Restitution(0.5), tangential: Spring(k: 2.857e4, \
             damping: OfNormal(0.5), friction: 0.6)), step: Fixed(1.0e-4), walls: [Mesh(file: \"{mesh}.obj\", unit: Metre)], {grains} \
             until: 0.3, on_loss: Continue, pictures: None)"
        )
    };
    for (name, mesh, grains) in [("first", "a", "grains: (file: \"g.csv\"),"), ("a", "a", ""), ("b", "b", "")] {
        fs::write(here.path().join(format!("{name}.ron")), scene(mesh, grains)).unwrap();
    }
    run(here.path(), &["first.ron", "--out", "first"]);
    for mesh in ["a", "b"] {
        let said = run(here.path(), &[&format!("{mesh}.ron"), "--from", "first", "--until", "0.002", "--out", mesh]);
        assert!(!said.contains("left out"), "{said}");
    }
    let numbers = |run: &str| {
        let mut reader = csv::Reader::from_path(here.path().join(run).join("state.csv")).unwrap();
        reader
            .records()
            .flat_map(|row| row.unwrap().iter().map(|cell| cell.parse::<f64>().unwrap()).collect::<Vec<_>>())
            .collect::<Vec<_>>()
    };
    // The triangles lie in one plane, so the motion is the same but for rounding.
    for (a, b) in numbers("a").into_iter().zip(numbers("b")) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
}

#[test]
fn rows_of_contacts_that_do_not_exist_are_refused_with_the_row() {
    let here = tempfile::tempdir().unwrap();
    fs::write(
        here.path().join("grains.csv"),
        "id,radius,mass,x,y,z,vx,vy,vz\n1,0.01,0.01,0,0,0.00999,0,0,0\n2,0.01,0.01,0.0199,0,0.00999,0,0,0\n3,0.01,0.01,0.5,0,0.00999,0,0,0\n",
    )
    .unwrap();
    fs::write(
        here.path().join("scene.ron"),
        "(space: Solid, gravity: (0.0, 0.0, -9.81), contact: Linear(k: 1.0e4, damping: Restitution(0.5), tangential: Spring(k: 2857.0, \
         damping: OfNormal(0.5), friction: 0.3)), step: Fixed(1.0e-5), walls: [HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0), \
         name: \"floor\"), Sphere(centre: (0.0, 0.0199, 0.01), radius: 0.01)], grains: (file: \"grains.csv\", contacts: \"contacts.csv\"), \
         until: 0.001, pictures: None, checkpoint: None)",
    )
    .unwrap();
    let header = "grain,with,number,spring_x,spring_y,spring_z,rolling_x,rolling_y,rolling_z,stiffness,twist";
    let zeros = "1e-6,0,0,0,0,0,0,0";
    let start = |more: &str, rows: &[&str]| {
        fs::write(here.path().join("contacts.csv"), format!("{header}{more}\n{}\n", rows.join("\n"))).unwrap();
        siloflow(here.path(), &["run", "scene.ron", "--quiet", "--out", "out", "--force"])
    };
    let good = format!("1,wall,1,{zeros}");
    for (row, reason) in [
        ("1,wall,9", "there is no wall 9"),
        ("1,wall,0", "there is no wall 0"),
        ("4,wall,1", "there is no grain 4"),
        ("1,grain,4", "there is no grain 4"),
        ("1,grain,1", "grain 1 does not touch itself"),
        ("1,grain,3", "grains 1 and 3 do not touch"),
        ("1,wall_grain,2", "there is no wall grain 2"),
        ("3,wall_grain,1", "grain 3 and wall grain 1 do not touch"),
    ] {
        let output = start("", &[&good, &format!("{row},{zeros}")]);
        let said = words(&output);
        assert!(output.status.code() == Some(2) && said.contains("row 2") && said.contains(reason), "{row}: {said}");
    }
    let output = start("", &[&good, &format!("1,grain,2,{zeros}"), &format!("1,wall_grain,1,{zeros}")]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    // By name and by point.
    for (row, code) in [("9", 0), ("1", 0)] {
        let output = start(",wall,at_x,at_y,at_z", &[&format!("1,wall,{row},{zeros},floor,0,0,0")]);
        assert_eq!(output.status.code(), Some(code), "{}", text(&output.stderr));
    }
    let said = words(&start(",wall,at_x,at_y,at_z", &[&format!("1,wall,1,{zeros},lid,0,0,0.5")]));
    assert!(said.contains("row 1") && said.contains("there is no wall `lid`"), "{said}");
}

#[test]
fn a_frictional_bed_starts_a_scene_without_friction() {
    let here = tempfile::tempdir().unwrap();
    let fill = "fill: [(low: (-0.049, 0.001), high: (0.049, 0.1), spacing: 0.0105, count: 30, radius: Uniform(0.004, 0.005), agitation: (0.1, 0.1))],";
    fs::write(here.path().join("rough.ron"), bin(&[FLOOR, LEFT, RIGHT], fill)).unwrap();
    run(here.path(), &["rough.ron", "--until", "0.3", "--out", "rough"]);
    let smooth = ["--set", "contact=Linear(k: 1.0e5, damping: Restitution(0.3))"];
    let said = run(
        here.path(),
        &[&["rough.ron", "--from", "rough", "--until", "0.01", "--out", "smooth"], &smooth[..]].concat(),
    );
    assert!(said.contains("spins_left_out"), "{said}");
    let grains = fs::read_to_string(here.path().join("smooth/input-grains.csv")).unwrap();
    assert!(!grains.lines().next().unwrap().contains("wz") && grains.lines().count() == 31, "{grains}");
    run(here.path(), &["smooth/scene.ron", "--until", "0.01", "--out", "again"]);
}
