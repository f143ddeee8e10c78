//! `siloflow export`: what it writes, what is written during a run, and what it refuses. `tests/readback` reads the files with the
//! programs that they are meant for.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use siloflow::files::frames::file::FrameFile;
use siloflow::files::frames::reader::FrameReader;

use crate::command_line::{siloflow, text};
use crate::run_directory::content;

const FORMATS: [(&str, &str); 3] = [("vtk", "vtk"), ("extxyz", "frames.xyz"), ("dump", "frames.dump")];

/// Runs a scene with settings into `run`.
fn run(here: &Path, scene: &str, settings: &[&str]) {
    let set: Vec<_> = settings.iter().flat_map(|setting| ["--set", setting]).collect();
    let path = crate::scene(scene).display().to_string();
    let output = siloflow(here, &[&["run", &path, "--quiet", "--force", "--out", "run"], &set[..]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
}

/// Returns names and contents of a file, or of the files of a directory.
fn files(path: &Path) -> Vec<(String, Vec<u8>)> {
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    if path.is_file() {
        return vec![(String::new(), fs::read(path).unwrap())];
    }
    content(path).into_iter().map(|(path, bytes)| (name(&path), bytes)).collect()
}

#[test]
fn a_run_writes_the_same_files_as_a_later_export() {
    let here = tempfile::tempdir().unwrap();
    let formats = "data_frames=(interval: 0.02, format: [Vtk, ExtXyz, LammpsDump])";
    for (scene, until) in [("couette.ron", "until=0.05"), ("chute3d.ron", "until=0.05"), ("silo3d.ron", "until=0.001")]
    {
        run(here.path(), scene, &[formats, until]);
        for (format, name) in FORMATS {
            let other = format!("{scene}-{name}");
            let output = siloflow(here.path(), &["export", "run", "--to", format, "--out", &other]);
            assert!(output.status.success(), "{}", text(&output.stderr));
            let frames = if scene == "silo3d.ron" { 2 } else { 4 };
            let said = text(&output.stdout);
            assert!(said.contains(&other) && said.contains(&format!(": {frames} frames")), "{said}");
            let [during, later] =
                [here.path().join("run").join(name), here.path().join(other)].map(|path| files(&path));
            assert!(!later.is_empty() && during == later, "{scene} {format}");
            if format == "vtk" {
                // Three lists, and three files for each frame; the shear cell has no wall surface.
                let kinds = if scene == "silo3d.ron" { 3 } else { 2 };
                assert_eq!(later.len(), kinds * (1 + frames), "{scene}");
            }
        }
    }
    // A replaced run takes its files along.
    run(here.path(), "couette.ron", &["until=0.01", "data_frames=None"]);
    assert!(FORMATS.iter().all(|(_, name)| !here.path().join("run").join(name).exists()));
}

#[test]
fn tables_hold_every_frame_and_go_with_their_run() {
    let here = tempfile::tempdir().unwrap();
    run(here.path(), "couette.ron", &["until=0.05", "data_frames=(interval: 0.01)"]);
    let output = siloflow(here.path(), &["export", "run", "--to", "csv"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let frames = FrameReader::open(&here.path().join("run/frames.bin")).unwrap().map(Result::unwrap);
    let frames: Vec<_> = frames.collect();
    for name in ["grains", "contacts", "wall_contacts"] {
        let mut rows = csv::Reader::from_path(here.path().join(format!("run/csv/{name}.csv"))).unwrap();
        let places: HashMap<_, _> =
            rows.headers().unwrap().iter().enumerate().map(|(place, name)| (name.to_owned(), place)).collect();
        let mut rows = rows.records().map(Result::unwrap);
        for frame in &frames {
            let table = frame.table(name).unwrap();
            for row in 0..table.rows {
                let cells = rows.next().unwrap();
                let number = |name: &str| cells[places[name]].parse::<f64>().unwrap();
                assert!(number("time_s") == frame.time && number("step") == frame.step as f64);
                let (quantity, column) = if name == "grains" {
                    ("velocity", "velocity_y")
                } else {
                    ("tangential_force", "tangential_force_y")
                };
                assert_eq!(number(column).to_bits(), table.floats(quantity).unwrap()[2 * row + 1].to_bits());
            }
        }
        assert!(rows.next().is_none());
    }
    fs::write(here.path().join("run/csv/notes.txt"), "mine").unwrap();
    assert_eq!(siloflow(here.path(), &["export", "run", "--to", "csv"]).status.code(), Some(2));
    fs::remove_file(here.path().join("run/csv/notes.txt")).unwrap();
    run(here.path(), "couette.ron", &["until=0.01", "data_frames=None"]);
    assert!(!here.path().join("run/csv").exists());
    assert_eq!(fs::read_dir(here.path()).unwrap().count(), 1);
}

#[test]
fn a_run_that_was_killed_is_exported_up_to_its_last_whole_frame() {
    let here = tempfile::tempdir().unwrap();
    run(here.path(), "couette.ron", &["until=0.05", "data_frames=(interval: 0.01)"]);
    let path = here.path().join("run/frames.bin");
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() - 1]).unwrap();
    let output = siloflow(here.path(), &["export", "run", "--to", "extxyz"]);
    assert!(output.status.success() && text(&output.stdout).contains(": 5 frames"), "{output:?}");
    // A frame in the middle that has changed is no end.
    let mut wrong = whole.clone();
    wrong[whole.len() / 2] ^= 1;
    fs::write(&path, wrong).unwrap();
    let output = siloflow(here.path(), &["export", "run", "--to", "dump"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("export::read"), "{}", text(&output.stderr));
    assert!(!here.path().join("run/frames.dump").exists());
}

#[test]
fn what_cannot_be_exported_is_refused_with_a_remedy() {
    let here = tempfile::tempdir().unwrap();
    run(here.path(), "free-fall.ron", &["data_frames=(interval: 0.1)"]);
    let assert_refused = |arguments: &[&str], words: &[&str]| {
        let before = content(here.path());
        let output = siloflow(here.path(), &[&["export"], arguments].concat());
        let said = text(&output.stderr).split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(words.iter().all(|word| said.contains(word)), "{words:?}: {said}");
        assert_eq!(content(here.path()), before);
    };
    assert_refused(&["nowhere", "--to", "vtk"], &["there is no nowhere", "siloflow run"]);
    assert_refused(&[".", "--to", "vtk"], &["no run directory"]);
    assert_refused(&["run", "--to", "povray"], &["povray", "vtk", "extxyz", "dump"]);
    assert_refused(&["run"], &["--to"]);
    if !cfg!(feature = "parquet") {
        assert_refused(&["run", "--to", "parquet"], &["without", "cargo build --release --features parquet"]);
    }
    fs::write(here.path().join("taken"), "mine").unwrap();
    assert_refused(&["run", "--to", "extxyz", "--out", "taken"], &["taken exists", "--out"]);
    assert_refused(&["run", "--to", "vtk", "--out", "a/b/c"], &["could not export", "--out"]);
    let frames = here.path().join("run/frames.bin");
    fs::write(&frames, "nothing").unwrap();
    assert_refused(&["run", "--to", "vtk"], &["it is no file of frames"]);
    fs::remove_file(&frames).unwrap();
    assert_refused(&["run", "--to", "vtk"], &["kept no frames", "data_frames=(interval: 0.1)"]);
    run(here.path(), "funnel-flow.ron", &["until=5"]);
    assert_refused(&["run", "--to", "vtk"], &["lattice gas"]);
}

/// Discs that spin and enter from 0.02 s on, so the first frames have no grain.
const LATE_FEED: &str = "(
    gravity: (0.0, -9.81), contact: Linear(k: 1.0e4, damping: Restitution(0.3), tangential: Spring(k: 2857.0, damping: OfNormal(0.5), friction: 0.4)),
    mass: Disc(10.0), step: Fixed(2.0e-5), walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))],
    feed: [(
        region: Box(low: (-0.02, 0.05), high: (0.02, 0.06)), rate: Grains(200.0), total: Grains(5),
        radius: Fixed(0.002), velocity: (0.0, -0.5), from: 0.02,
    )],
    until: 0.05, pictures: None, checkpoint: None, data_frames: (interval: 0.01, format: [Vtk, ExtXyz, LammpsDump]),
)";

/// Returns the names of the columns in each frame of a text format, from the lines that have this word.
fn names_in(path: &Path, word: &str) -> Vec<String> {
    let text = fs::read_to_string(path).unwrap();
    let lines = text.lines().filter_map(|line| Some(line.split_once(word)?.1.split(" Time=").next()?.to_owned()));
    lines.collect()
}

/// Checks that all frames have the columns of the last one, and that the tables have as many cells in a row as in the header.
fn assert_same_columns(run: &Path, dump: &Path, xyz: &Path, tables: &Path) {
    for names in [names_in(dump, "ITEM: ATOMS"), names_in(xyz, "Properties=")] {
        assert!(names.len() == 6 && names.iter().all(|own| *own == names[0]), "{names:?}");
        assert!(names[0].contains("omegaz") || names[0].contains("spin:R:1"), "{names:?}");
    }
    for name in ["grains", "contacts", "wall_contacts"] {
        // The reader refuses rows of different lengths.
        let mut rows = csv::Reader::from_path(tables.join(format!("{name}.csv"))).unwrap();
        let spin = rows.headers().unwrap().iter().position(|column| column == "spin_z");
        assert_eq!(spin.is_some(), name == "grains");
        let rows: Vec<_> = rows.records().map(Result::unwrap).collect();
        assert!(name != "grains" || rows.len() > 5, "{} rows", rows.len());
        if let Some(last) = rows.last().filter(|_| name == "grains") {
            let frame = FrameReader::open(&run.join("frames.bin")).unwrap().last().unwrap().unwrap();
            let expected = *frame.table("grains").unwrap().floats("spin").unwrap().last().unwrap();
            assert_eq!(last[spin.unwrap()].parse::<f64>().unwrap().to_bits(), expected.to_bits());
        }
    }
}

#[test]
fn a_frame_without_grains_has_the_columns_of_the_run() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("late.ron"), LATE_FEED).unwrap();
    let done = |arguments: &[&str]| {
        let output = siloflow(here.path(), arguments);
        assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    };
    let run = here.path().join("out/late");
    done(&["run", "late.ron", "--quiet"]);
    done(&["export", "out/late", "--to", "csv"]);
    assert_same_columns(&run, &run.join("frames.dump"), &run.join("frames.xyz"), &run.join("csv"));
    let vtk = fs::read(run.join("vtk/grains-00000.vtp")).unwrap();
    assert!(String::from_utf8_lossy(&vtk).contains("Name=\"spin\""), "VTK");
    // A colour that the first frame has no number of.
    done(&["render", "out/late", "--movie", "--colour", "spin", "--width", "200"]);
    // A run that ends before any grain enters has the columns too.
    done(&["run", "late.ron", "--quiet", "--set", "until=0.01", "--out", "none"]);
    done(&["export", "none", "--to", "csv"]);
    let header = |path: &str| fs::read_to_string(here.path().join(path)).unwrap().lines().next().unwrap().to_owned();
    assert_eq!(header("none/csv/grains.csv"), header("out/late/csv/grains.csv"));
    assert_eq!(header("none/state.csv"), header("out/late/state.csv"));
}

/// Earlier versions wrote frames without grains without the spin.
#[test]
fn the_columns_of_a_run_are_those_of_all_its_frames() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("late.ron"), LATE_FEED).unwrap();
    assert!(siloflow(here.path(), &["run", "late.ron", "--quiet"]).status.success());
    let run = here.path().join("out/late");
    let reader = FrameReader::open(&run.join("frames.bin")).unwrap();
    let header = reader.header.clone();
    let frames: Vec<_> = reader.map(Result::unwrap).collect();
    fs::remove_file(run.join("frames.bin")).unwrap();
    let mut file = FrameFile::create(&run.join("frames.bin"), &header).unwrap();
    for mut frame in frames {
        let grains = &mut frame.tables[0];
        if grains.rows == 0 {
            grains.columns.retain(|column| column.name != "spin");
        }
        file.add(&frame).unwrap();
    }
    for (format, out) in [("dump", "a.dump"), ("extxyz", "a.xyz"), ("csv", "tables"), ("vtk", "vtk")] {
        let output = siloflow(here.path(), &["export", "out/late", "--to", format, "--out", out]);
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
    let [dump, xyz, tables] = ["a.dump", "a.xyz", "tables"].map(|name| here.path().join(name));
    assert_same_columns(&run, &dump, &xyz, &tables);
    for (name, own) in [("a.dump", "frames.dump"), ("a.xyz", "frames.xyz")] {
        assert!(files(&here.path().join(name)) == files(&run.join(own)), "{name}");
    }
    assert!(files(&here.path().join("vtk")) == files(&run.join("vtk")));
    let output = siloflow(here.path(), &["render", "out/late", "--movie", "--colour", "spin", "--width", "200"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
}
