//! A run in slices, as a page steps it: the files of a run by the command line, also if its state is looked at between slices.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use siloflow::cli::sliced::{Slice, SlicedRun};
use siloflow::output::frame_recording::{frame_of_world, header};
use siloflow::prelude::*;
use siloflow::results::report::player::live::LiveFrames;
use siloflow::scene::load as loading;
use siloflow::scene::loaded::AnyScene;
use siloflow::scene::outputs::DataFrames;

use crate::scene;

/// Short runs: settings of each scene.
const SCENES: [(&str, &[(&str, &str)]); 3] = [
    ("silo1-mixture.ron", &[("until", "3.0"), ("spawner.count", "40")]),
    ("round-silo.ron", &[("until", "0.002"), ("pictures", "None"), ("data_frames", "(interval: 0.001)")]),
    ("parabola.ron", &[]),
];

fn by_command_line(name: &str, settings: &[(&str, &str)], out: &Path) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_siloflow"));
    command.args(["run", "--quiet", "--out"]).arg(out).arg(scene(name));
    for (key, value) in settings {
        command.arg("--set").arg(format!("{key}={value}"));
    }
    assert!(command.status().unwrap().success(), "{name}");
}

/// Looks at the state as a page does: as a packed frame, with contacts.
fn look<V: Space>(run: &mut SlicedRun, frames: &mut LiveFrames) {
    let header = frames.header().clone();
    let frame = frame_of_world::<V>(&header, true, run.world()).unwrap();
    assert!(frames.pack(&frame).unwrap().len() > 100);
}

fn in_slices(name: &str, settings: &[(&str, &str)], out: &Path) -> u32 {
    let settings: Vec<_> = settings.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
    let scene = loading::any(&scene(name), &settings).unwrap();
    let mut run = SlicedRun::start(scene, Registry::default(), out).unwrap();
    let header = match run.scene() {
        AnyScene::Grains(loaded) if loaded.scene.space == Dimension::Plane => {
            Some(header::<Plane>(loaded, &DataFrames::default(), run.present()))
        }
        AnyScene::Grains(loaded) => Some(header::<Solid>(loaded, &DataFrames::default(), run.present())),
        AnyScene::Lattice(_) => None,
    };
    let mut frames = header.map(LiveFrames::new);
    let mut slices = 0;
    // A slice of no time ends after its first steps, on any machine.
    while run.advance(Duration::ZERO, |_| false) == Slice::Over {
        slices += 1;
        match &mut frames {
            Some(frames) if frames.header().dimension == 2 => look::<Plane>(&mut run, frames),
            Some(frames) => look::<Solid>(&mut run, frames),
            None => {}
        }
    }
    let finished = run.finish();
    assert!(finished.is_done && finished.words.contains("state hash"), "{name}: {}", finished.words);
    slices
}

#[test]
fn a_run_in_slices_has_the_files_of_a_run() {
    let here = tempfile::tempdir().unwrap();
    for (name, settings) in SCENES {
        let [whole, sliced] = ["whole", "sliced"].map(|kind| here.path().join(format!("{name}-{kind}")));
        by_command_line(name, settings, &whole);
        let slices = in_slices(name, settings, &sliced);
        assert!(slices > 3, "{name}: {slices} slices");
        for file in fs::read_dir(&whole).unwrap().map(|entry| entry.unwrap().path()) {
            let file_name = file.file_name().unwrap().to_owned();
            // These have times and the machine, and the command line.
            if file.is_dir() || ["summary.json", "hashes.txt", ".siloflow"].iter().any(|name| file_name == **name) {
                continue;
            }
            let is_same = fs::read(&file).unwrap() == fs::read(sliced.join(&file_name)).unwrap();
            assert!(is_same, "{name}: {}", file_name.display());
        }
        let hash = |directory: &Path| {
            let summary: serde_json::Value =
                serde_json::from_slice(&fs::read(directory.join("summary.json")).unwrap()).unwrap();
            summary["state_hash"].as_str().unwrap().to_owned()
        };
        assert_eq!(hash(&whole), hash(&sliced), "{name}");
    }
}

#[test]
fn a_slice_ends_at_what_its_caller_waits_for() {
    let here = tempfile::tempdir().unwrap();
    let loaded = loading::any(&scene("free-fall.ron"), &[]).unwrap();
    let mut run = SlicedRun::start(loaded, Registry::default(), &here.path().join("run")).unwrap();
    let time = |run: &SlicedRun| run.present().resource::<Clock>().time();
    assert_eq!(time(&run), 0.0);
    let long = Duration::from_secs(100);
    assert_eq!(run.advance(long, |world| world.resource::<Clock>().has_reached(0.25)), Slice::Reached);
    assert!((time(&run) - 0.25).abs() < 1e-9);
    // A slice has at least one step, and one that is over goes on where it was.
    assert_eq!(run.advance(Duration::ZERO, |_| true), Slice::Reached);
    assert!((time(&run) - 0.251).abs() < 1e-9);
    assert_eq!(run.advance(long, |_| false), Slice::Ended);
    assert_eq!((time(&run), run.advance(long, |_| false)), (1.0, Slice::Ended));
    assert!(run.finish().is_done);
}
