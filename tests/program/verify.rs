//! `siloflow verify`: every damaged file of a run is named, and nothing else is.

use std::fs;
use std::os::unix::fs::symlink;
use std::os::unix::process::ExitStatusExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::Value;

use crate::command_line::{siloflow, text};
use crate::run_directory::content;

/// A run of grains with every kind of output, or one of the lattice gas.
const GRAINS: &[&str] = &[
    "drum.ron",
    "--png",
    "--set",
    "pictures=(interval: 0.01, width: 60)",
    "--set",
    "data_frames=(interval: 0.01, format: [Vtk, ExtXyz, LammpsDump])",
];
const LATTICE: &[&str] = &["funnel-flow.ron", "--set", "pictures=(interval: 10, width: 60.0)"];

/// Runs a scene into `run`, with more arguments.
fn run(here: &Path, scene: &[&str], more: &[&str]) {
    let path = crate::scene(scene[0]).display().to_string();
    let until = if scene == LATTICE { "20" } else { "0.03" };
    let done =
        siloflow(here, &[&["run", &path, "--quiet", "--out", "run", "--until", until], &scene[1..], more].concat());
    assert!(done.status.success(), "{}", text(&done.stderr));
}

/// A run that SIGKILL has ended, with a checkpoint.
fn killed(here: &Path, scene: &[&str]) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_siloflow"));
    command.current_dir(here).arg("run").arg(crate::scene(scene[0])).args(&scene[1..]);
    command.args(["--quiet", "--out", "run", "--checkpoint-every", "0.0002", "--until", "100000"]);
    let mut run = command.stderr(Stdio::null()).spawn().unwrap();
    let checkpoints = here.join("run/checkpoints");
    let has_one = || {
        let entries = fs::read_dir(&checkpoints).into_iter().flatten().flatten();
        entries.map(|entry| entry.path()).any(|path| path.extension().is_some_and(|ending| ending == "checkpoint"))
    };
    // A first picture after that of the start.
    while !(has_one() && here.join("run/frames/00001.svg").exists()) {
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(300));
    run.kill().unwrap();
    run.wait().unwrap();
}

/// Verifies `run`. Returns the exit status and the findings.
fn verify(here: &Path) -> (i32, Value) {
    let output = siloflow(here, &["verify", "run", "--json"]);
    let found: Value = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", text(&output.stderr)));
    (output.status.code().unwrap(), found[0].clone())
}

fn assert_sound(here: &Path, status: &str) -> Value {
    let (code, found) = verify(here);
    assert_eq!((code, &found["status"], &found["is_sound"]), (0, &Value::from(status), &Value::from(true)), "{found}");
    found
}

/// Asserts that this file alone is named.
fn assert_damaged(here: &Path, name: &str, case: &str) {
    let (code, found) = verify(here);
    let damage = found["damage"].as_array().unwrap();
    assert_eq!(code, 1, "{case}: {found}");
    assert!(damage.len() == 1 && damage[0]["file"] == name, "{case} {name}: {found}");
}

/// Damages each file in several ways, one after the other.
fn damage_each(here: &Path, is_examined: impl Fn(&str) -> bool) -> usize {
    let run = here.join("run");
    let mut count = 0;
    for (path, bytes) in content(&run) {
        let name = path.strip_prefix(&run).unwrap().to_str().unwrap().to_owned();
        if !is_examined(&name) || bytes.is_empty() {
            continue;
        }
        let mut flipped = bytes.clone();
        flipped[bytes.len() / 2] ^= 1;
        for (case, changed) in [
            ("emptied", Vec::new()),
            ("zeroed", vec![0; bytes.len()]),
            ("cut", bytes[..bytes.len() - 1].to_vec()),
            ("flipped", flipped),
        ] {
            fs::write(&path, changed).unwrap();
            assert_damaged(here, &name, case);
        }
        fs::remove_file(&path).unwrap();
        // The deletion of a checkpoint is not noticed.
        if !name.starts_with("checkpoints/") {
            assert_damaged(here, &name, "deleted");
        }
        fs::write(&path, bytes).unwrap();
        count += 1;
    }
    count
}

#[test]
fn every_damaged_file_of_a_finished_run_is_named() {
    for (scene, files) in [(GRAINS, 25), (LATTICE, 8)] {
        let here = tempfile::tempdir().unwrap();
        run(here.path(), scene, &[]);
        let found = assert_sound(here.path(), "time_reached");
        assert!(found["files"].as_u64().unwrap() >= files && found["notes"].as_array().unwrap().is_empty(), "{found}");
        let count = damage_each(here.path(), |name| name != ".siloflow");
        assert!(count as u64 >= files, "{count}");
        assert_sound(here.path(), "time_reached");
    }
}

#[test]
fn what_a_killed_run_has_written_before_its_checkpoint_is_checked() {
    for scene in [GRAINS, LATTICE] {
        let here = tempfile::tempdir().unwrap();
        killed(here.path(), scene);
        assert_sound(here.path(), "killed");
        for (name, case) in [("series.csv", "zeroed"), ("scene.ron", "zeroed"), ("frames/00000.svg", "zeroed")] {
            let path = here.path().join("run").join(name);
            let bytes = fs::read(&path).unwrap();
            fs::write(&path, vec![0; bytes.len()]).unwrap();
            assert_damaged(here.path(), name, case);
            fs::write(&path, bytes).unwrap();
        }
        // Rows after the checkpoint are no part of it.
        let path = here.path().join("run/series.csv");
        let rows = fs::read(&path).unwrap();
        fs::write(&path, [&rows[..], b"half a ro"].concat()).unwrap();
        assert_sound(here.path(), "killed");
    }
}

#[test]
fn what_was_added_later_is_no_damage() {
    let here = tempfile::tempdir().unwrap();
    run(here.path(), GRAINS, &[]);
    for command in
        [&["report", "run"][..], &["plot", "run"], &["render", "run", "--movie"], &["export", "run", "--to", "csv"]]
    {
        let done = siloflow(here.path(), command);
        assert!(done.status.success(), "{}", text(&done.stderr));
    }
    fs::write(here.path().join("run/notes.txt"), "mine").unwrap();
    fs::write(here.path().join("run/frames/00099.svg"), "mine").unwrap();
    fs::create_dir(here.path().join("run/more")).unwrap();
    assert_sound(here.path(), "time_reached");
    // A copy without the marker, as `cp run/* copy` makes it, is a run as well.
    fs::remove_file(here.path().join("run/.siloflow")).unwrap();
    assert_sound(here.path(), "time_reached");
    // A removed checkpoint saves space.
    fs::remove_dir_all(here.path().join("run/checkpoints")).unwrap();
    assert_sound(here.path(), "time_reached");
}

#[test]
fn a_run_of_a_version_without_hashes_says_so() {
    let here = tempfile::tempdir().unwrap();
    run(here.path(), GRAINS, &["--set", "checkpoint=None"]);
    let path = here.path().join("run/summary.json");
    let mut summary: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    summary.as_object_mut().unwrap().remove("files").unwrap();
    fs::write(&path, serde_json::to_string_pretty(&summary).unwrap()).unwrap();
    fs::remove_file(here.path().join("run/hashes.txt")).unwrap();
    let found = assert_sound(here.path(), "time_reached");
    assert!(found["notes"][0].as_str().unwrap().contains("no hashes"), "{found}");
    let frames = here.path().join("run/frames.bin");
    let mut bytes = fs::read(&frames).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&frames, bytes).unwrap();
    assert_damaged(here.path(), "frames.bin", "flipped");
    fs::write(&path, "{\"status\": \"emp").unwrap();
    assert_eq!(verify(here.path()).0, 1);
}

#[test]
fn a_wrong_call_is_refused_before_anything_is_read() {
    let here = tempfile::tempdir().unwrap();
    run(here.path(), LATTICE, &[]);
    fs::create_dir(here.path().join("empty")).unwrap();
    let scene = crate::scene("drum.ron").display().to_string();
    let scenes = crate::root().join("scenes").display().to_string();
    for (wrong, words) in [
        ("nosuch", "there is no run nosuch"),
        ("empty", "empty holds no run"),
        (&scene, "is no directory"),
        (&scenes, "holds no run"),
    ] {
        let output = siloflow(here.path(), &["verify", "run", wrong, "--json"]);
        let said = text(&output.stderr).split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
        assert_eq!(output.status.code(), Some(2), "{wrong}: {said}");
        assert!(said.contains(words) && output.stdout.is_empty(), "{wrong}: {said}");
    }
    for arguments in [&["verify"][..], &["verify", "run", "--no-such-option"], &["verifi", "run"]] {
        assert_eq!(siloflow(here.path(), arguments).status.code(), Some(2), "{arguments:?}");
    }
    // Several runs: one that is damaged decides.
    fs::create_dir(here.path().join("other")).unwrap();
    let copied = Command::new("cp").args(["-r", "run/.", "other"]).current_dir(here.path()).status();
    assert!(copied.unwrap().success());
    fs::write(here.path().join("other/series.csv"), "").unwrap();
    let output = siloflow(here.path(), &["verify", "run", "other"]);
    let said = text(&output.stdout);
    assert!(
        output.status.code() == Some(1) && said.contains("run: sound") && said.contains("other: damaged"),
        "{said}"
    );
    assert!(said.contains("damaged: series.csv has 0 bytes"), "{said}");
}

#[test]
fn links_and_pipes_in_a_run_are_damage_and_a_link_to_a_run_is_a_run() {
    let here = tempfile::tempdir().unwrap();
    run(here.path(), GRAINS, &[]);
    symlink("run", here.path().join("link")).unwrap();
    let linked = siloflow(here.path(), &["verify", "link"]);
    assert_eq!(linked.status.code(), Some(0), "{}", text(&linked.stdout));
    let place = |name: &str| here.path().join("run").join(name);
    for name in ["series.csv", "frames.bin", "summary.json", "hashes.txt", "scene.ron", "frames/00001.svg", ".siloflow"]
    {
        let kept = here.path().join("kept");
        fs::rename(place(name), &kept).unwrap();
        // The very same content, but somewhere else.
        symlink(&kept, place(name)).unwrap();
        assert_damaged(here.path(), name, "a link");
        fs::remove_file(place(name)).unwrap();
        assert!(Command::new("mkfifo").arg(place(name)).status().unwrap().success());
        assert_damaged(here.path(), name, "a pipe");
        fs::remove_file(place(name)).unwrap();
        fs::rename(&kept, place(name)).unwrap();
    }
    let kept = here.path().join("frames");
    fs::rename(place("frames"), &kept).unwrap();
    symlink(&kept, place("frames")).unwrap();
    let (code, found) = verify(here.path());
    assert!(code == 1 && found.to_string().contains("frames is a symbolic link"), "{found}");
}

#[test]
fn a_run_that_goes_on_is_checked_up_to_its_checkpoint() {
    let here = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_siloflow"));
    command.current_dir(here.path()).arg("run").arg(crate::scene("drum.ron"));
    command.args(["--quiet", "--out", "run", "--checkpoint-every", "0.0002", "--until", "1000"]);
    let mut child = command.stderr(Stdio::null()).spawn().unwrap();
    while fs::read_dir(here.path().join("run/checkpoints")).map_or(0, Iterator::count) < 2 {
        std::thread::sleep(Duration::from_millis(5));
    }
    for _ in 0..5 {
        let found = assert_sound(here.path(), "running");
        assert!(found["notes"][0].as_str().unwrap().contains(&format!("process {}", child.id())), "{found}");
    }
    child.kill().unwrap();
    child.wait().unwrap();
}

#[test]
fn a_signal_ends_it_and_nothing_is_changed() {
    let here = tempfile::tempdir().unwrap();
    run(here.path(), LATTICE, &[]);
    let before = content(here.path());
    let mut command = Command::new("env");
    command.args(["--default-signal=TERM", env!("CARGO_BIN_EXE_siloflow"), "verify"]).current_dir(here.path());
    let mut child = command.args(vec!["run"; 20_000]).stdout(Stdio::null()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(200));
    Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    let status = child.wait().unwrap();
    assert_eq!(status.signal().or(status.code()), Some(15), "{status:?}");
    assert_eq!(content(here.path()), before);
}

/// Returns the paths of a run in `here`, for messages.
fn names(here: &Path) -> Vec<PathBuf> {
    content(&here.join("run")).into_iter().map(|(path, _)| path.strip_prefix(here).unwrap().to_owned()).collect()
}

#[test]
fn a_run_that_went_on_without_damaged_files_is_sound_and_says_what_is_missing() {
    let here = tempfile::tempdir().unwrap();
    killed(here.path(), GRAINS);
    let place = |name: &str| here.path().join("run").join(name);
    for name in ["series.csv", "frames.bin", "frames.dump", "vtk/grains.pvd", "frames/00000.svg"] {
        fs::write(place(name), "").unwrap();
    }
    for name in ["frames.xyz", "frames/00001.svg", "vtk/grains-00000.vtp"] {
        fs::remove_file(place(name)).unwrap();
    }
    let scene = fs::read_to_string(place("scene.ron")).unwrap();
    assert!(scene.contains("until"), "{scene}");
    let refused = siloflow(here.path(), &["run", "--resume", "run", "--quiet"]);
    let said = text(&refused.stderr);
    assert!(refused.status.code() == Some(2) && said.contains("--accept-damage"), "{said}");
    // The run has no end soon, so that it is interrupted again.
    let mut command = Command::new("env");
    command.args(["--default-signal=TERM", env!("CARGO_BIN_EXE_siloflow"), "run", "--resume", "run", "--quiet"]);
    let mut child = command.arg("--accept-damage").current_dir(here.path()).spawn().unwrap();
    let later = || fs::metadata(place("frames.bin")).is_ok_and(|found| found.len() > 20_000);
    while child.try_wait().unwrap().is_none() && !later() {
        std::thread::sleep(Duration::from_millis(5));
    }
    Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(143));
    let found = assert_sound(here.path(), "interrupted");
    let notes = found["notes"].to_string();
    let summary: Value = serde_json::from_slice(&fs::read(place("summary.json")).unwrap()).unwrap();
    let damaged: Vec<_> =
        summary["damaged"].as_array().unwrap().iter().map(|damage| damage["file"].as_str().unwrap()).collect();
    for name in [
        "series.csv",
        "frames.bin",
        "frames.dump",
        "frames.xyz",
        "vtk/grains.pvd",
        "frames/00000.svg",
        "frames/00001.svg",
    ] {
        assert!(damaged.contains(&name) && notes.contains(name), "{name}: {damaged:?} {notes}");
    }
    assert_eq!(damaged.len(), 8, "{damaged:?}");
    for name in ["series.csv.damaged", "vtk/grains.pvd.damaged", "frames/00000.svg.damaged"] {
        assert!(place(name).exists(), "{name}: {:?}", names(here.path()));
    }
    assert!(!place("frames/00001.svg").exists() && !place("frames/00000.svg").exists());
    // The new files are whole.
    let series = fs::read_to_string(place("series.csv")).unwrap();
    assert!(series.starts_with("time_s,") && series.lines().count() > 1, "{series}");
    for command in [&["plot", "run"][..], &["export", "run", "--to", "csv"]] {
        let done = siloflow(here.path(), command);
        assert!(done.status.success(), "{}", text(&done.stderr));
    }
    // A later resume is as any other.
    let mut command = Command::new("env");
    command.args(["--default-signal=TERM", env!("CARGO_BIN_EXE_siloflow"), "run", "--resume", "run", "--quiet"]);
    let mut child = command.current_dir(here.path()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(500));
    Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(143));
    assert_sound(here.path(), "interrupted");
    // A run that replaces it takes what is left of damaged files along.
    run(here.path(), GRAINS, &["--force"]);
    assert!(!place("series.csv.damaged").exists() && !place("frames/00000.svg.damaged").exists());
}
