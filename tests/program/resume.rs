//! `siloflow run --resume`: runs that were killed or interrupted continue to the files of a run without interruption, and
//! checkpoints that cannot be trusted are refused.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use siloflow::output::checkpoint::file;

use crate::command_line::{siloflow, text};
use crate::run_directory::content;

/// A scene with settings that keep its run short.
struct Case {
    scene: &'static str,
    settings: &'static [&'static str],
}

/// Friction memory, rolling resistance, Hertz's law, solid space, periodic sides, profiles and fields in mid-average, a spawner in
/// mid-release, a sliding door, moving wall grains, losses, a flow field, figures of the outflow, frames in all formats, walls that move, a gate that opens and shuts, the
/// lattice gas.
const CASES: [Case; 9] = [
    Case {
        scene: "silo1.ron",
        settings: &[
            "spawner.count=150",
            "until=12.0",
            "door.how=Slide(0.05)",
            "flow=(cell: 0.1, sample: 0.01)",
            "outflow=(from: 2.0, to: 11.0, mass_flow: (axis: (0.0, 0.0), low: 0.0, high: 1.0, centre: 0.1, wall: 0.3))",
            "pictures=(interval: 0.5, width: 100, png: true)",
        ],
    },
    Case { scene: "silo1-literal.ron", settings: &["on_loss=Continue", "spawner.count=400", "until=21.0"] },
    Case {
        scene: "couette.ron",
        settings: &["until=3.0", "data_frames=(interval: 0.2, format: [Vtk, ExtXyz, LammpsDump])"],
    },
    Case {
        scene: "chute3d.ron",
        settings: &[
            "until=0.06",
            "fields=[(grid: RZ(radius: 0.02, low: 0.0, high: 0.02, cells: (2, 3)), sample: 0.0007, average: 0.025)]",
        ],
    },
    Case { scene: "silo3d.ron", settings: &["until=0.05"] },
    Case { scene: "hard/pressed-door.ron", settings: &[] },
    Case { scene: "hard/moving-walls.ron", settings: &["until=0.5"] },
    Case {
        scene: "gated-bin.ron",
        settings: &[
            "until=2.1",
            "pictures=None",
            "outflow=(from: AfterDoor(0.0), to: Out(0.9))",
            "slopes=[(name: \"surface\", falls: Outwards((0.0, 0.0)), low: (-1.0, -1.0), high: (1.0, 1.0), from: AfterDoor(0.1))]",
            "wall_bands=[(walls: \"gate\", low: -0.01, high: 0.01, bins: 2, sample: 0.003, average: 0.4)]",
        ],
    },
    Case { scene: "funnel-flow.ron", settings: &["until=1500"] },
];

impl Case {
    fn arguments(&self, out: &Path) -> Vec<String> {
        let mut arguments = vec!["run".to_owned(), crate::scene(self.scene).display().to_string()];
        for setting in self.settings {
            arguments.extend(["--set".to_owned(), (*setting).to_owned()]);
        }
        arguments.extend(["--quiet".to_owned(), "--out".to_owned(), out.display().to_string()]);
        arguments
    }

    /// Runs without interruption, and returns the wall-clock time that this took.
    fn straight(&self, out: &Path) -> Duration {
        let start = Instant::now();
        let done = start_run(&self.arguments(out)).wait_with_output().unwrap();
        assert!(matches!(done.status.code(), Some(0 | 1)), "{}: {}", self.scene, text(&done.stderr));
        start.elapsed()
    }

    /// Runs with `kills` interruptions, each after a part of `time` given by `random`. Returns the number of interruptions.
    fn interrupted(&self, out: &Path, time: Duration, kills: u32, random: &mut impl FnMut() -> f64) -> u32 {
        let frequent = ["--checkpoint-every".to_owned(), "0.0002".to_owned()];
        let mut arguments = self.arguments(out);
        let mut done = 0;
        loop {
            let mut run = start_run(&[&arguments[..], &frequent].concat());
            let end = Instant::now() + time.mul_f64(random() * 2.0 / f64::from(kills + 1));
            while run.try_wait().unwrap().is_none() && (done == kills || Instant::now() < end) {
                std::thread::sleep(Duration::from_millis(1));
            }
            if run.try_wait().unwrap().is_some() {
                let output = run.wait_with_output().unwrap();
                let said = text(&output.stderr);
                // A kill may have come after the end of the run.
                assert!(
                    matches!(output.status.code(), Some(0 | 1)) || said.contains("is over"),
                    "{}: {said}",
                    self.scene
                );
                return done;
            }
            let signal = ["KILL", "INT", "TERM", "HUP"][done as usize % 4];
            Command::new("kill").args([format!("-{signal}"), run.id().to_string()]).status().unwrap();
            run.wait().unwrap();
            done += 1;
            if !has_checkpoint(out) {
                let _ = fs::remove_dir_all(out);
                arguments = self.arguments(out);
                continue;
            }
            let threads = ["1", "2", "3"][done as usize % 3];
            let resume = ["run", "--resume", &out.display().to_string(), "--quiet", "--threads", threads];
            arguments = resume.map(str::to_owned).to_vec();
        }
    }
}

pub fn start_run(arguments: &[String]) -> Child {
    // A job in the background of a script ignores SIGINT, and so would the run.
    let mut command = Command::new("env");
    command.args(["--default-signal=HUP,INT,TERM", env!("CARGO_BIN_EXE_siloflow")]).args(arguments);
    command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

pub fn checkpoints(run: &Path) -> Vec<PathBuf> {
    let mut all: Vec<_> = content(run).into_iter().map(|(path, _)| path).collect();
    all.retain(|path| path.extension().is_some_and(|ending| ending == "checkpoint"));
    all
}

fn has_checkpoint(run: &Path) -> bool {
    run.join("scene.ron").exists() && !checkpoints(run).is_empty()
}

/// Returns all results of a run: without its checkpoints and what they and the run have cost.
fn results(run: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut all = Vec::new();
    for (path, bytes) in content(run) {
        let name = path.strip_prefix(run).unwrap().to_owned();
        if name.starts_with("checkpoints") || name.starts_with(".siloflow") {
            continue;
        }
        let bytes = if name.ends_with("summary.json") {
            let mut summary: Value = serde_json::from_slice(&bytes).unwrap();
            let keys = summary.as_object_mut().unwrap();
            keys.remove("performance").unwrap();
            keys.remove("checkpoints").unwrap();
            keys.remove("provenance").unwrap();
            // It has the hash of the summary.
            keys.remove("files").unwrap();
            summary.to_string().into_bytes()
        } else {
            bytes
        };
        all.push((name, bytes));
    }
    all
}

/// Asserts that two runs have the same results.
fn assert_same(expected: &Path, found: &Path, case: &str) {
    let expected = results(expected);
    let found = results(found);
    let names = |files: &[(PathBuf, Vec<u8>)]| files.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
    assert_eq!(names(&expected), names(&found), "{case}");
    for ((name, expected), (_, found)) in expected.iter().zip(&found) {
        assert!(expected == found, "{case}: {} differs", name.display());
    }
}

/// Interrupts every case `kills` times. Returns the number of interruptions.
fn interrupt_all(kills: u32, seed: u64) -> u32 {
    let here = tempfile::tempdir().unwrap();
    let mut state = seed;
    // A linear congruential generator; its high bits are random enough for moments.
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut all = 0;
    for case in &CASES {
        let [straight, interrupted] =
            ["straight", "interrupted"].map(|name| here.path().join(name).join(case.scene.replace('/', "-")));
        let time = case.straight(&straight);
        let done = case.interrupted(&interrupted, time, kills, &mut random);
        assert_same(&straight, &interrupted, &format!("{}, {done} interruptions", case.scene));
        eprintln!("{}: {done} interruptions, same results", case.scene);
        all += done;
    }
    all
}

#[test]
fn interrupted_runs_of_every_kind_continue_to_the_same_files() {
    assert!(interrupt_all(3, 1) >= 14);
}

/// The long form of the test above, for `.ci/full`: some 200 interruptions.
#[test]
#[ignore = "takes minutes"]
fn two_hundred_interruptions() {
    let done = interrupt_all(30, 2);
    eprintln!("{done} interruptions");
    assert!(done >= 180, "{done}");
}

/// A run that SIGINT has interrupted, in `run`.
fn interrupted_run(here: &Path) -> PathBuf {
    let out = here.join("run");
    let silo = crate::scene("silo1.ron").display().to_string();
    let run = start_run(
        &[
            "run",
            &silo,
            "--quiet",
            "--until",
            "40",
            "--checkpoint-every",
            "0.0002",
            "--out",
            &out.display().to_string(),
        ]
        .map(str::to_owned),
    );
    while checkpoints_if_any(&out) < 2 {
        std::thread::sleep(Duration::from_millis(2));
    }
    Command::new("kill").args(["-INT", &run.id().to_string()]).status().unwrap();
    assert_eq!(run.wait_with_output().unwrap().status.code(), Some(130));
    assert_eq!(checkpoints(&out).len(), 2);
    out
}

fn checkpoints_if_any(run: &Path) -> usize {
    let entries = fs::read_dir(run.join("checkpoints")).into_iter().flatten().flatten();
    entries.filter(|entry| entry.path().extension().is_some_and(|ending| ending == "checkpoint")).count()
}

fn resume(here: &Path, more: &[&str]) -> Output {
    siloflow(here, &[&["run", "--resume", "run", "--quiet"], more].concat())
}

/// Asserts that a resume is refused with these words, and that nothing has changed but the process in the marker.
fn assert_refused(here: &Path, words: &[&str]) {
    let files = || {
        let mut all = content(here);
        all.retain(|(path, _)| !path.ends_with(".siloflow"));
        all
    };
    let before = files();
    let output = resume(here, &[]);
    let said = text(&output.stderr).split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
    assert_eq!(output.status.code(), Some(2), "{said}");
    for word in words {
        assert!(said.contains(word), "`{word}` is missing: {said}");
    }
    assert!(files() == before, "{said}");
}

#[test]
fn a_resume_without_a_run_to_continue_is_refused() {
    let here = tempfile::tempdir().unwrap();
    assert_refused(here.path(), &["run holds no run", "give the directory of a run"]);
    fs::create_dir(here.path().join("run")).unwrap();
    assert_refused(here.path(), &["run holds no run"]);
    let fall = crate::scene("free-fall.ron").display().to_string();
    let run = |more: &[&str]| siloflow(here.path(), &[&["run", &fall, "--quiet", "--out", "run"], more].concat());
    assert!(run(&[]).status.success());
    assert_refused(here.path(), &["the run in run is over", "--from DIR"]);
    assert!(run(&["--force", "--set", "checkpoint=None"]).status.success());
    assert!(!here.path().join("run/checkpoints").exists());
    assert_refused(here.path(), &["run holds no checkpoint", "checkpoint.every"]);
    // Settings of a run cannot be changed on the way.
    for setting in [&["--set", "until=9"][..], &["--seed", "2"], &["--out", "other"], &["--until", "9"], &["--force"]] {
        assert_eq!(resume(here.path(), setting).status.code(), Some(2), "{setting:?}");
    }
}

#[test]
fn a_damaged_or_foreign_checkpoint_is_refused() {
    let here = tempfile::tempdir().unwrap();
    let out = interrupted_run(here.path());
    let [older, newer] = <[PathBuf; 2]>::try_from(checkpoints(&out)).unwrap();
    let [old, new] = [&older, &newer].map(|path| fs::read(path).unwrap());
    // The older one is used while it can be; with both damaged there is none.
    let mut flipped = old.clone();
    flipped[old.len() / 2] ^= 4;
    fs::write(&older, &flipped).unwrap();
    fs::write(&newer, &new[..new.len() - 1]).unwrap();
    assert_refused(here.path(), &["cannot be used", "has changed", "start the run again"]);
    // Another version.
    let mut checkpoint = file::read_from(&new).unwrap();
    checkpoint.header.version = "0.0.1".to_owned();
    let mut bytes = Vec::new();
    file::write(&mut bytes, &checkpoint.header, &checkpoint.sections).unwrap();
    fs::write(&newer, bytes).unwrap();
    assert_refused(here.path(), &["siloflow 0.0.1 with format 13 wrote it", "the version that began it"]);
    // State that does not fit.
    checkpoint.header.version = env!("CARGO_PKG_VERSION").to_owned();
    checkpoint.sections.retain(|(name, _)| name != "entities");
    let mut bytes = Vec::new();
    file::write(&mut bytes, &checkpoint.header, &checkpoint.sections).unwrap();
    fs::write(&newer, bytes).unwrap();
    assert_refused(here.path(), &["does not fit this scene"]);
    // A changed scene or input file.
    fs::write(&newer, &new).unwrap();
    for name in ["scene.ron", "input-silo.dat"] {
        let path = out.join(name);
        let text = fs::read(&path).unwrap();
        fs::write(&path, [&text[..], b"\n"].concat()).unwrap();
        assert_refused(here.path(), &["has changed since", "--from DIR"]);
        fs::write(&path, text).unwrap();
    }
    // Another format.
    let mut checkpoint = file::read_from(&new).unwrap();
    checkpoint.header.format = 6;
    let mut bytes = Vec::new();
    file::write(&mut bytes, &checkpoint.header, &checkpoint.sections).unwrap();
    fs::write(&newer, bytes).unwrap();
    assert_refused(here.path(), &["cannot be used", "with format 6 wrote it"]);
    fs::write(&newer, &new).unwrap();
    // With one whole checkpoint the run goes on.
    fs::write(&older, &old).unwrap();
    fs::write(&newer, &new[..50]).unwrap();
    // A kill during a checkpoint leaves an incomplete one. The next checkpoint removes it.
    let incomplete = out.join("checkpoints/0000000000000001.checkpoint.part");
    fs::write(&incomplete, "half").unwrap();
    let done = siloflow(here.path(), &["run", "--resume", "run"]);
    assert!(done.status.success() && text(&done.stderr).contains("an earlier checkpoint is used"), "{done:?}");
    assert_eq!(checkpoints(&out).len(), 1);
    assert!(!incomplete.exists());
}

#[test]
fn files_that_were_damaged_before_the_checkpoint_are_named_and_nothing_is_changed() {
    let here = tempfile::tempdir().unwrap();
    let out = interrupted_run(here.path());
    for name in ["series.csv", "frames.bin", "frames/00000.svg"] {
        let path = out.join(name);
        let bytes = fs::read(&path).unwrap();
        let mut flipped = bytes.clone();
        flipped[10] ^= 1;
        for (changed, what) in [
            (bytes[..100].to_vec(), "has 100 bytes"),
            (Vec::new(), "has 0 bytes"),
            (vec![0; bytes.len()], "has changed"),
            (flipped, "has changed"),
        ] {
            fs::write(&path, changed).unwrap();
            assert_refused(here.path(), &[&format!("{name} {what}"), "--accept-damage"]);
        }
        fs::remove_file(&path).unwrap();
        assert_refused(here.path(), &[&format!("{name} is missing"), "--accept-damage"]);
        fs::write(&path, bytes).unwrap();
    }
    fs::rename(out.join("frames"), here.path().join("frames")).unwrap();
    assert_refused(here.path(), &["frames/00000.svg is missing: there is no directory frames"]);
    fs::rename(here.path().join("frames"), out.join("frames")).unwrap();
    // Rows and pictures after the checkpoint are made again.
    let rows = fs::read(out.join("series.csv")).unwrap();
    fs::write(out.join("series.csv"), [&rows[..], b"half a r"].concat()).unwrap();
    fs::write(out.join("frames/00900.svg"), "").unwrap();
    assert!(resume(here.path(), &[]).status.success());
    assert!(!out.join("frames/00900.svg").exists());
}

#[test]
fn a_killed_run_is_not_replaced_unasked_and_says_how_it_continues() {
    let here = tempfile::tempdir().unwrap();
    let out = interrupted_run(here.path());
    fs::remove_file(out.join("summary.json")).unwrap();
    let silo = crate::scene("silo1.ron").display().to_string();
    let again = siloflow(here.path(), &["run", &silo, "--out", "run"]);
    assert_eq!(again.status.code(), Some(2));
    assert!(text(&again.stderr).contains("--resume"), "{}", text(&again.stderr));
    // A forced run leaves no checkpoint of the replaced one.
    let forced = siloflow(here.path(), &["run", &silo, "--out", "run", "--force", "--until", "0.1", "--quiet"]);
    assert!(forced.status.success());
    assert_eq!(checkpoints(&out).len(), 1);
}
