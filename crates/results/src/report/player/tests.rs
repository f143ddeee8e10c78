//! The data of a player hold the frames within their resolution.

use std::path::Path;

use super::unpack::{Unpacked, unpack};
use super::{Packed, SCRIPT};
use siloflow_files::frames::file::FrameFile;
use siloflow_files::frames::scale::{Palette, Scale};
use siloflow_files::frames::{Column, FORMAT, Frame, Header, RegisteredColumn, Table, Values, WallGeometry};

fn column(name: &str, components: u8, values: Values) -> Column {
    Column { name: name.to_owned(), unit: "u".to_owned(), components, values }
}

fn wall(number: u32, points: &[[f64; 3]]) -> WallGeometry {
    let triangles = if points.is_empty() { Vec::new() } else { vec![[0, 1, 2]] };
    WallGeometry { number, points: points.to_vec(), triangles, ..WallGeometry::default() }
}

fn start_of(number: u32) -> WallGeometry {
    let x = f64::from(number);
    wall(number, &[[x, 0.0, 0.0], [x, 1.0, 0.0], [-2.0, 0.0, 3.5]])
}

fn header() -> Header {
    Header {
        format: FORMAT,
        version: String::new(),
        scene: "made-up".to_owned(),
        title: "</script>".to_owned(),
        dimension: 3,
        species: vec![("one".to_owned(), [1, 2, 3])],
        periodic: [None; 3],
        domain: [[-2.0, 0.0, 0.0], [2.0, 1.0, 3.5]],
        walls: vec![start_of(1), start_of(2)],
        columns: vec![RegisteredColumn {
            name: "same".to_owned(),
            unit: "u".to_owned(),
            label: "the same".to_owned(),
            behaviour: String::new(),
            scale: Some(Scale { from: 0.0, to: 254.0, palette: Palette::BlueRed }),
        }],
    }
}

/// A number between 0 and 1 that differs from others without order.
fn mixed(a: usize, b: usize) -> f64 {
    (a as f64 * 12.9898 + b as f64 * 78.233).sin().abs()
}

/// Frame `number`: grains come and go, and wall grain 4 is always there. Grain 1 leaves the scene by far in frame 3.
fn frame(number: usize) -> Frame {
    let ids: Vec<i32> = (1..40).filter(|id| (id + number as i32) % 7 != 0).chain([-4]).collect();
    let id = |row: usize| ids[row].unsigned_abs() as usize;
    let floats = |of: &dyn Fn(usize, usize) -> f64, components: usize| {
        Values::F64(
            (0..ids.len())
                .flat_map(|row| (0..components).map(move |axis| (row, axis)))
                .map(|(row, axis)| of(row, axis))
                .collect(),
        )
    };
    let far = |row: usize| if number == 3 && ids[row] == 1 { 1e4 } else { 0.0 };
    let drift = 0.01 * number as f64;
    let columns = vec![
        column("id", 1, Values::I32(ids.clone())),
        column("kind", 1, Values::U8(ids.iter().map(|&id| u8::from(id < 0)).collect())),
        column("species", 1, Values::U8(vec![0; ids.len()])),
        column("radius", 1, floats(&|row, _| 0.01 + 1e-4 * id(row) as f64, 1)),
        column(
            "position",
            3,
            floats(
                &|row, axis| {
                    [4.0, 1.0, 3.0][axis] * mixed(id(row), axis) - 2.0 * f64::from(axis == 0) + drift + far(row)
                },
                3,
            ),
        ),
        column("velocity", 3, floats(&|row, axis| mixed(id(row) + number, axis), 3)),
        column(
            "coordination",
            1,
            Values::U16(ids.iter().map(|id| (id.unsigned_abs() as u16 + number as u16) % 9).collect()),
        ),
        column(
            "temperature",
            1,
            floats(&|row, _| if id(row) == 5 { f64::NAN } else { 300.0 + 50.0 * mixed(id(row), number) }, 1),
        ),
        column("same", 1, floats(&|_, _| 7.0, 1)),
    ];
    let grains = Table { name: "grains".to_owned(), rows: ids.len(), columns };
    // Each grain touches the one three rows further, given in both orders, and the last 10 touch wall 2.
    let pairs: Vec<(i32, i32)> = (0..ids.len() - 3).map(|row| (ids[row], ids[row + 3])).collect();
    let turned: Vec<(i32, i32)> =
        pairs.iter().enumerate().map(|(row, &(a, b))| if row % 2 == 0 { (b, a) } else { (a, b) }).collect();
    let contacts = Table {
        name: "contacts".to_owned(),
        rows: turned.len(),
        columns: vec![
            column("grain", 1, Values::I32(turned.iter().map(|pair| pair.0).collect())),
            column("partner", 1, Values::I32(turned.iter().map(|pair| pair.1).collect())),
            column("normal_force", 1, Values::F64((0..turned.len()).map(|row| 1.0 + row as f64).collect())),
            column("sliding", 1, Values::U8((0..turned.len()).map(|row| u8::from(row % 3 == 0)).collect())),
        ],
    };
    let with_wall = &ids[ids.len() - 10..];
    let point = |row: usize| (0..3).map(move |axis| 0.5 * mixed(row, axis));
    let wall_contacts = Table {
        name: "wall_contacts".to_owned(),
        rows: 10,
        columns: vec![
            column("grain", 1, Values::I32(with_wall.to_vec())),
            column("normal_force", 1, Values::F64((0..10).map(|row| 3.0 * f64::from(row)).collect())),
            column("sliding", 1, Values::U8(vec![1; 10])),
            column("point", 3, Values::F64((0..10).flat_map(point).collect())),
        ],
    };
    let lower: Vec<_> = start_of(2).points.iter().map(|[x, y, z]| [*x, y - 0.1 * number as f64, *z]).collect();
    let changed_walls = match number {
        0 => vec![],
        1 => vec![wall(2, &[])],
        _ => vec![wall(2, &lower), wall(1, &[])],
    };
    let counts = [number as u64 + 3, 2, 1, 0];
    Frame {
        step: number as u64,
        time: 0.25 * number as f64,
        counts,
        changed_walls,
        tables: vec![grains, contacts, wall_contacts],
    }
}

fn write(run: &Path, header: &Header, frames: &[Frame]) {
    let mut file = FrameFile::create(&run.join("frames.bin"), header).unwrap();
    for frame in frames {
        file.add(frame).unwrap();
    }
}

fn packed(header: &Header, frames: &[Frame], characters: usize) -> std::io::Result<Packed> {
    let run = tempfile::tempdir().unwrap();
    write(run.path(), header, frames);
    Packed::within(run.path(), characters).map(Option::unwrap)
}

fn read(frames: &[Frame]) -> Unpacked {
    unpack(&packed(&header(), frames, usize::MAX).unwrap().text)
}

/// Asserts that two points differ by at most half a step along each axis.
fn assert_near(found: [f64; 3], expected: &[f64], step: f64) {
    for axis in 0..3 {
        assert!((found[axis] - expected[axis]).abs() < 0.501 * step, "{found:?} {expected:?}");
    }
}

#[test]
fn grains_are_within_the_resolution() {
    let frames: Vec<Frame> = (0..6).map(frame).collect();
    let run = read(&frames);
    let step = run.description["step"].as_f64().unwrap();
    // The box of the scene is 4 m long. The grain that is far away widens it by its size.
    assert!((step * 65535.0 - 8.0).abs() < 1e-9, "{step}");
    assert_eq!((run.ids.len(), run.ids[0], run.ids[39], run.kinds[39]), (40, 1, -4, 1));
    assert!(
        run.ids
            .iter()
            .zip(&run.radii)
            .all(|(id, radius)| (radius - (0.01 + 1e-4 * id.unsigned_abs() as f32)).abs() < 1e-7)
    );
    assert_eq!((run.first[0], run.first[6], run.first[39]), (0.0, 0.25, 0.0));
    let names: Vec<&str> = run.frames[0].numbers.iter().map(|(name, _)| &**name).collect();
    assert_eq!(names, ["speed", "radius", "coordination", "temperature", "same"]);
    let same = &run.description["quantities"][4];
    assert_eq!((&same["label"], &same["palette"], &same["is_kept"]), (&"the same".into(), &1.into(), &true.into()));
    assert!(run.frames[0].numbers[4].1.iter().all(|number| (number - 7.0).abs() < 1e-9));
    for (number, (found, expected)) in run.frames.iter().zip(&frames).enumerate() {
        assert_eq!((found.time, found.counts[0], found.counts[2]), (expected.time, number as f64 + 3.0, 1.0));
        let grains = expected.table("grains").unwrap();
        let ids = grains.whole("id").unwrap();
        let positions = grains.floats("position").unwrap();
        let shown: Vec<usize> = (0..ids.len()).filter(|row| positions[3 * row] < 1e3).collect();
        assert_eq!((found.left_out == 1, shown.len()), (number == 3, found.particles.len()));
        for (row, &from) in shown.iter().enumerate() {
            assert_eq!(i64::from(run.ids[found.particles[row]]), ids[from]);
            assert_near(found.positions[row], &positions[3 * from..], step);
            let v = &grains.floats("velocity").unwrap()[3 * from..3 * from + 3];
            let speed = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
            // Levels are roots of speeds: the slope of a square is at most 2.
            assert!((found.numbers[0].1[row] - speed).abs() < 2.0 * 0.51 * 1.8 / 254.0);
            assert_eq!(found.numbers[2].1[row].round() as i64, grains.whole("coordination").unwrap()[from]);
            let temperature = grains.floats("temperature").unwrap()[from];
            let read = found.numbers[3].1[row];
            assert!((read - temperature).abs() < 0.51 * 50.0 / 254.0 || (read.is_nan() && temperature.is_nan()));
        }
    }
}

#[test]
fn contacts_and_walls_are_within_the_resolution() {
    let frames: Vec<Frame> = (0..6).map(frame).collect();
    let run = read(&frames);
    let step = run.description["step"].as_f64().unwrap();
    let high = run.description["forces"]["high"].as_f64().unwrap();
    let level = |force: f64| (force / high * 127.0).round().min(127.0) as u8;
    // Weak forces are left out.
    let is_drawn = |force: f64| f64::from(level(force)) >= 0.1 * 127.0;
    assert!((run.description["forces"]["low"].as_f64().unwrap() - 0.1 * high).abs() < 1e-12 * high);
    for (number, (found, expected)) in run.frames.iter().zip(&frames).enumerate() {
        let id = |row: usize| i64::from(run.ids[found.particles[row]]);
        let table = expected.table("contacts").unwrap();
        let [grains, partners, sliding] = ["grain", "partner", "sliding"].map(|name| table.whole(name).unwrap());
        let forces = table.floats("normal_force").unwrap();
        let known = |id: &i64| found.particles.iter().any(|&particle| i64::from(run.ids[particle]) == *id);
        let mut all: Vec<_> = (0..table.rows)
            .filter(|&row| known(&grains[row]) && known(&partners[row]) && is_drawn(forces[row]))
            .map(|row| ([grains[row], partners[row]], level(forces[row]), sliding[row] == 1))
            .collect();
        let mut read: Vec<_> =
            found.contacts.iter().map(|&(a, b, force, slides)| ([id(a), id(b)], force, slides)).collect();
        for (ids, ..) in all.iter_mut().chain(&mut read) {
            ids.sort_unstable();
        }
        all.sort_unstable();
        read.sort_unstable();
        assert_eq!(read, all);

        let table = expected.table("wall_contacts").unwrap();
        let strong = table.floats("normal_force").unwrap().iter().filter(|force| is_drawn(**force)).count();
        assert!(found.wall_contacts.len() == strong && strong > 6 && strong < table.rows, "{strong}");
        for (grain, point, force, slides) in &found.wall_contacts {
            let from = table.whole("grain").unwrap().iter().position(|grain_id| *grain_id == id(*grain)).unwrap();
            assert_near(*point, &table.floats("point").unwrap()[3 * from..], step);
            assert_eq!((*force, *slides), (level(3.0 * from as f64), true));
        }
        for (wall, first) in found.walls.iter().zip(&header().walls) {
            let now = expected.changed_walls.iter().find(|wall| wall.number == first.number).unwrap_or(first);
            assert_eq!((wall.0.len(), wall.1, wall.2), (now.points.len(), 0, now.triangles.len()), "frame {number}");
            wall.0.iter().zip(&now.points).for_each(|(found, expected)| assert_near(*found, expected, step));
        }
    }
}

#[test]
fn a_long_run_is_shown_with_fewer_frames() {
    let frames: Vec<Frame> = (0..60).map(frame).collect();
    let whole = packed(&header(), &frames, usize::MAX).unwrap().text.len();
    let part = packed(&header(), &frames, whole / 3).unwrap().text;
    let run = unpack(&part);
    assert!(run.frames.len() > 10 && run.frames.len() < 30, "{}", run.frames.len());
    assert_eq!(run.description["frames_of_run"], 60);
    let steps: Vec<f64> = run.frames.iter().map(|frame| frame.time / 0.25).collect();
    assert_eq!((steps[0], *steps.last().unwrap()), (0.0, 59.0));
    let gaps: Vec<f64> = steps.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let [least, most] = [gaps.iter().copied().fold(f64::MAX, f64::min), gaps.iter().copied().fold(0.0, f64::max)];
    assert!(most - least <= 1.0, "{gaps:?}");
    assert_eq!(unpack(&packed(&header(), &frames, 1).unwrap().text).frames.len(), 2);
}

#[test]
fn a_radius_that_changes_is_a_quantity() {
    let mut frames: Vec<Frame> = (0..3).map(frame).collect();
    let grows = |column: &mut Column| column.name == "radius";
    let radius = frames[2].tables[0].columns.iter_mut().find_map(|column| grows(column).then_some(&mut column.values));
    let Some(Values::F64(radii)) = radius else { panic!() };
    for radius in radii {
        *radius *= 2.0;
    }
    let run = read(&frames);
    assert_eq!(run.description["changes_radius"], true);
    let (name, radii) = &run.frames[2].numbers[1];
    assert!(name == "radius" && (radii[0] - 2.0 * 0.0101).abs() < 2e-4, "{radii:?}");
}

#[test]
fn runs_without_frames_or_grains_are_packed() {
    let run = tempfile::tempdir().unwrap();
    assert!(Packed::of(run.path()).unwrap().is_none());
    write(run.path(), &header(), &[]);
    assert_eq!(unpack(&Packed::of(run.path()).unwrap().unwrap().text).frames.len(), 0);
    assert_eq!(read(&[Frame::default()]).frames[0].particles.len(), 0);
}

#[test]
fn damaged_files_are_errors() {
    let changed = |change: &dyn Fn(&mut Header, &mut Vec<Frame>)| {
        let mut header = header();
        let mut frames = (0..3).map(frame).collect();
        change(&mut header, &mut frames);
        packed(&header, &frames, usize::MAX)
    };
    assert!(changed(&|_, _| {}).is_ok());
    for dimension in [0, 1, 4, 255] {
        assert!(changed(&|header, _| header.dimension = dimension).is_err());
    }
    assert!(changed(&|header, _| header.dimension = 2).is_err());
    for name in ["id", "radius", "position"] {
        assert!(
            changed(&|_, frames| frames[1].tables[0].columns.retain(|column| column.name != name)).is_err(),
            "{name}"
        );
    }
    assert!(changed(&|_, frames| frames[1].tables[0].columns[0].values = Values::I32(vec![1; 35])).is_err());
    // Places and forces that are no numbers, and contacts of unknown grains, are left out.
    let odd = changed(&|header, frames| {
        header.domain = [[f64::NAN; 3], [f64::INFINITY; 3]];
        for values in frames
            .iter_mut()
            .flat_map(|frame| &mut frame.tables)
            .flat_map(|table| &mut table.columns)
            .map(|column| &mut column.values)
        {
            match values {
                Values::F64(numbers) => numbers.iter_mut().step_by(5).for_each(|number| *number = f64::NAN),
                Values::I32(numbers) => numbers.iter_mut().rev().take(1).for_each(|id| *id = i32::MIN),
                _ => {}
            }
        }
    });
    assert!(unpack(&odd.unwrap().text).frames[0].left_out > 5);
}

#[test]
fn every_wrong_byte_of_a_file_is_an_error_or_hides_frames() {
    let run = tempfile::tempdir().unwrap();
    write(run.path(), &header(), &[frame(0), frame(1)]);
    let path = run.path().join("frames.bin");
    let whole = std::fs::read(&path).unwrap();
    for place in (0..whole.len()).step_by(97) {
        let mut wrong = whole.clone();
        wrong[place] ^= 1 << (place % 8);
        std::fs::write(&path, &wrong).unwrap();
        let read = Packed::of(run.path());
        assert!(read.is_err() || unpack(&read.unwrap().unwrap().text).frames.len() < 2, "byte {place}");
    }
}

#[test]
fn nothing_ends_a_script_element_early() {
    let packed = packed(&header(), &[frame(0)], usize::MAX).unwrap();
    for text in [SCRIPT, &packed.element("data")[..packed.element("data").len() - "</script>".len()]] {
        assert!(!text.to_lowercase().contains("</script") && !text.contains("<!--"));
    }
}
