//! `frames.bin` holds what happened: its numbers agree with `state.csv`, with each other and with laws that do not depend on it.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use siloflow::dem::space::Solid;
use siloflow::files::frames::reader::FrameReader;
use siloflow::files::frames::{Frame, Header, Table};
use siloflow::scene::expected;

use crate::command_line::{siloflow, text};

/// Runs a scene with settings in `here` and returns the frames.
fn run(here: &Path, scene: &str, settings: &[&str]) -> (Header, Vec<Frame>) {
    let set: Vec<_> = settings.iter().flat_map(|setting| ["--set", setting]).collect();
    let path = crate::scene(scene).display().to_string();
    let output = siloflow(here, &[&["run", &path, "--quiet", "--out", "run"], &set[..]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    read(&here.join("run/frames.bin"))
}

fn read(path: &Path) -> (Header, Vec<Frame>) {
    let reader = FrameReader::open(path).unwrap();
    (reader.header.clone(), reader.map(Result::unwrap).collect())
}

fn vector(table: &Table, name: &str, row: usize) -> Solid {
    let components = usize::from(table.column(name).unwrap().components);
    let numbers = &table.floats(name).unwrap()[components * row..components * (row + 1)];
    Solid::new(numbers[0], numbers[1], numbers.get(2).copied().unwrap_or(0.0))
}

/// The state of grains in the last frame, as rows of `state.csv` have it, apart from the order of columns.
fn assert_same_as_state(here: &Path, last: &Frame) {
    let mut rows = csv::Reader::from_path(here.join("run/state.csv")).unwrap();
    let names = rows.headers().unwrap().clone();
    let grains = last.table("grains").unwrap();
    let ids = grains.whole("id").unwrap();
    let kinds = grains.whole("kind").unwrap();
    let mut of_grains = (0..grains.rows).filter(|&row| kinds[row] == 0);
    let mut count = 0;
    for state in rows.records() {
        let state = state.unwrap();
        let row = of_grains.next().unwrap();
        for (name, cell) in names.iter().zip(&state) {
            let number: f64 = cell.parse().unwrap();
            let found = match name {
                "id" => ids[row] as f64,
                "species" => grains.whole("species").unwrap()[row] as f64,
                "radius" | "mass" => grains.floats(name).unwrap()[row],
                "x" | "y" | "z" => vector(grains, "position", row)[usize::from(name.as_bytes()[0] - b'x')],
                "vx" | "vy" | "vz" => vector(grains, "velocity", row)[usize::from(name.as_bytes()[1] - b'x')],
                // A planar spin is one number.
                "wz" if grains.column("spin").unwrap().components == 1 => grains.floats("spin").unwrap()[row],
                _ => vector(grains, "spin", row)[usize::from(name.as_bytes()[1] - b'x')],
            };
            assert!(number.to_bits() == found.to_bits(), "{name} of {}: {number:e}, {found:e}", ids[row]);
        }
        count += 1;
    }
    assert!(count > 10 && of_grains.next().is_none());
}

#[test]
fn the_last_frame_is_the_final_state_to_the_last_bit() {
    for (scene, settings) in [
        ("silo1-mixture.ron", &["spawner.count=40", "until=3.3", "pictures.interval=0.5"][..]),
        ("couette.ron", &["until=1.3", "data_frames=(interval: 0.5)"]),
        ("silo3d.ron", &["until=0.03", "data_frames=(interval: 0.01)", "pictures=None"]),
    ] {
        let here = tempfile::tempdir().unwrap();
        let (header, frames) = run(here.path(), scene, settings);
        let last = frames.last().unwrap();
        assert_same_as_state(here.path(), last);
        let summary = fs::read_to_string(here.path().join("run/summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
        assert_eq!(summary["steps"], last.step, "{scene}");
        let counts = ["released", "inside", "out", "lost"].map(|name| summary["grains"][name].as_u64().unwrap());
        assert_eq!(counts, last.counts, "{scene}");
        assert_eq!(format!("{scene}"), format!("{}.ron", header.scene));
        let until = last.time;
        let interval = frames[1].time - frames[0].time;
        assert_eq!(frames.len() as f64, (until / interval + 1.0 - 1e-6).ceil(), "{scene}: {until} s, {interval} s");
        assert!(frames.is_sorted_by(|a, b| a.step < b.step), "{scene}");
    }
}

/// Grains without damping, so that forces do not depend on velocities: the force on each grain is its weight and the sum of its
/// contacts.
#[test]
fn contacts_and_weight_sum_to_the_force_on_every_grain() {
    let elastic = |k: f64, tangential: f64| {
        format!(
            "contact=Linear(k: {k:?}, damping: B(0.0), tangential: Spring(k: {tangential:?}, damping: B(0.0), friction: 0.5))"
        )
    };
    let cases = [
        // Rough discs, and a periodic side.
        ("couette.ron", elastic(1.0e5, 5.0e4), "until=0.5", 0.1, Solid::ZERO),
        // Wall surfaces.
        ("hard/undamped-drift.ron", "seed=3".to_owned(), "until=4.0", 0.02, Solid::ZERO),
        // Solid space, fixed spheres, weight.
        ("chute3d.ron", elastic(256.8, 73.4), "until=0.05", 0.01, Solid::new(3.990, 0.0, -8.962)),
    ];
    for (scene, contact, until, interval, gravity) in cases {
        let here = tempfile::tempdir().unwrap();
        let (header, frames) =
            run(here.path(), scene, &[&contact, until, &format!("data_frames=(interval: {interval})")]);
        let contacts: usize = frames.iter().map(|frame| check_contacts(&header, frame, gravity)).sum();
        assert!(contacts > 100, "{scene}: {contacts}");
    }
}

/// Checks overlaps, coordination numbers and sums of forces of a frame. Returns the number of contacts.
fn check_contacts(header: &Header, frame: &Frame, gravity: Solid) -> usize {
    let [grains, between, walls] = ["grains", "contacts", "wall_contacts"].map(|name| frame.table(name).unwrap());
    let ids = grains.whole("id").unwrap();
    let row_of: HashMap<i64, usize> = ids.iter().copied().zip(0..).collect();
    assert_eq!(row_of.len(), grains.rows);
    let radius = |row: usize| grains.floats("radius").unwrap()[row];
    let mass = grains.floats("mass").unwrap();
    let mut sums: Vec<Solid> = mass.iter().map(|&mass| mass * gravity).collect();
    let mut coordination = vec![0; grains.rows];
    let wrapped = |mut separation: Solid| {
        for (axis, side) in header.periodic.iter().enumerate() {
            let length = side.map_or(f64::INFINITY, |(low, high)| high - low);
            if separation[axis].abs() > 0.5 * length {
                separation[axis] -= length.copysign(separation[axis]);
            }
        }
        separation
    };
    for (table, partner) in [(between, "partner"), (walls, "wall")] {
        let first = table.whole("grain").unwrap();
        let second = table.whole(partner).unwrap();
        for contact in 0..table.rows {
            let i = row_of[&first[contact]];
            let (away, reach) = if partner == "wall" {
                (vector(grains, "position", i) - vector(table, "point", contact), radius(i))
            } else {
                let j = row_of[&second[contact]];
                let away = wrapped(vector(grains, "position", i) - vector(grains, "position", j));
                (away, radius(i) + radius(j))
            };
            // Positions of the order of 1 m have errors of 1e-16 m.
            let overlap = table.floats("overlap").unwrap()[contact];
            assert!((reach - away.length() - overlap).abs() < 1e-14, "{overlap}");
            let normal = table.floats("normal_force").unwrap()[contact] * away.normalize();
            let force = normal + vector(table, "tangential_force", contact);
            sums[i] += force;
            coordination[i] += 1;
            if partner == "partner" {
                let j = row_of[&second[contact]];
                sums[j] -= force;
                coordination[j] += 1;
            }
        }
    }
    assert_eq!(grains.whole("coordination").unwrap(), coordination);
    for (row, sum) in sums.iter().enumerate() {
        // An overlap has an error of 2e-16 m; in springs of 1e5 N/m, and with six contacts of a grain, that is 1.2e-10 N.
        let force = vector(grains, "force", row);
        assert!((*sum - force).length() < 1e-9, "{}: {sum}, {force}", ids[row]);
    }
    between.rows + walls.rows
}

#[test]
fn a_door_that_is_gone_is_missing_from_the_walls() {
    let here = tempfile::tempdir().unwrap();
    let settings = ["door.opens=At(0.01)", "until=0.02", "data_frames=(interval: 0.01)"];
    let (header, frames) = run(here.path(), "silo3d.ron", &settings);
    let doors = |frame: &Frame| frame.walls(&header).iter().filter(|wall| wall.is_door).count();
    let first = &frames[0];
    let last = frames.last().unwrap();
    assert!(doors(first) >= 1 && first.changed_walls.is_empty());
    assert_eq!(doors(last), 0);
    assert_eq!(last.walls(&header).len() + doors(first), header.walls.len());
    // The domain holds all walls with ends. The first four are half-spaces.
    for wall in header.walls.iter().filter(|wall| wall.number > 4) {
        let inside =
            |x: &[f64; 3]| (0..3).all(|axis| (header.domain[0][axis]..=header.domain[1][axis]).contains(&x[axis]));
        assert!(wall.points.iter().all(inside), "{wall:?}");
    }
}

#[test]
fn a_scene_chooses_what_frames_hold() {
    let here = tempfile::tempdir().unwrap();
    let settings = ["spawner.count=3", "until=0.5", "pictures=None"];
    let none = |more: &str| {
        let all = [&settings[..], &[more]].concat();
        let set: Vec<_> = all.iter().flat_map(|setting| ["--set", setting]).collect();
        let path = crate::scene("silo1-polydisperse.ron").display().to_string();
        let output =
            siloflow(here.path(), &[&["run", &path, "--quiet", "--force", "--out", "none"], &set[..]].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        !here.path().join("none/frames.bin").exists()
    };
    assert!(none("seed=1") && none("data_frames=None") && !none("data_frames=(interval: 0.1)"));
    let less = [&settings[..], &["data_frames=(interval: 0.1, contacts: false, walls: false)"]].concat();
    let (header, frames) = run(here.path(), "silo1-polydisperse.ron", &less);
    assert_eq!(frames.len(), 6);
    assert!(header.walls.is_empty() && frames.iter().all(|frame| frame.tables.len() == 1));
}

/// The estimate is meant for planning: it is right within a factor of two.
#[test]
fn check_estimates_the_size_of_the_file() {
    for (scene, settings) in [
        ("chute3d.ron", [("until", "0.1"), ("data_frames", "(interval: 0.01)")]),
        ("silo1.ron", [("until", "60.0"), ("data_frames", "(interval: 2.0)")]),
    ] {
        let here = tempfile::tempdir().unwrap();
        let as_text: Vec<_> = settings.iter().map(|(key, value)| format!("{key}={value}")).collect();
        let (_, frames) = run(here.path(), scene, &as_text.iter().map(String::as_str).collect::<Vec<_>>());
        let loaded = crate::load(scene, &settings);
        let outputs = expected::outputs(&loaded, expected::known_step(&loaded).unwrap());
        let each = outputs.iter().find(|output| output.key == "data_frames.interval").unwrap().bytes;
        let size = fs::metadata(here.path().join("run/frames.bin")).unwrap().len() as f64 / frames.len() as f64;
        eprintln!("{scene}: {size} B a frame, {each} B estimated");
        assert!((0.5..2.0).contains(&(size / each)), "{scene}: {size} B a frame, {each} B estimated");
    }
}
