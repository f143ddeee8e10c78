//! A run directory from somebody else, or one that was changed: links and pipes in it lead nowhere, short files do not take gigabytes,
//! states that no run can have are refused, and what a killed process left is in nobody's way.

use std::fs::{self, File};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use siloflow::files::frames::file::FrameFile;
use siloflow::files::frames::reader::FrameReader;
use siloflow::files::frames::{Column, Frame, Table, Values};
use siloflow::output::checkpoint::file;

use crate::command_line::{siloflow, text};
use crate::resume::{checkpoints, start_run};
use crate::run_directory::content;

/// An interrupted run of a bed with walls, in `run`, with frames in all formats.
fn interrupted(here: &Path) {
    let drum = crate::scene("drum.ron").display().to_string();
    let out = here.join("run");
    let arguments = [
        "run",
        &drum,
        "--quiet",
        "--until",
        "3",
        "--checkpoint-every",
        "0.0002",
        "--out",
        &out.display().to_string(),
        "--set",
        "fill[0].count=40",
        "--set",
        "data_frames=(interval: 0.01, format: [Vtk, ExtXyz, LammpsDump])",
        "--set",
        "pictures=(interval: 0.01, width: 60)",
    ];
    let mut run = start_run(&arguments.map(str::to_owned));
    let checkpoint = out.join("checkpoints");
    while !fs::read_dir(&checkpoint).is_ok_and(|mut entries| {
        entries.any(|entry| entry.unwrap().path().extension().is_some_and(|ending| ending == "checkpoint"))
    }) {
        std::thread::sleep(Duration::from_millis(2));
    }
    Command::new("kill").args(["-INT", &run.id().to_string()]).status().unwrap();
    run.wait().unwrap();
}

/// Calls that read or change a run directory, `run`.
fn calls() -> Vec<Vec<String>> {
    let one = crate::scene("hard/one-grain.ron").display().to_string();
    let calls = [
        "run --resume run",
        "report run --out page.html",
        "plot run --out figures",
        "export run --to csv --out tables",
        "render run --every 0.01 --out drawn",
        "render run",
        "diff run run --until 0.001",
        "compare run run --out compared",
        &format!("run {one} --from run --out other"),
        &format!("run {one} --force --out run"),
    ];
    calls.iter().map(|call| call.split(' ').map(str::to_owned).chain(["--quiet".to_owned()]).collect()).collect()
}

/// Asserts that a call ends soon with status 2 and a message with this word.
fn assert_refused(here: &Path, call: &[String], word: &str) {
    let start = Instant::now();
    let arguments: Vec<_> = ["-k", "1", "20", env!("CARGO_BIN_EXE_siloflow")].into_iter().collect();
    let output = Command::new("timeout").args(arguments).args(call).current_dir(here).output().unwrap();
    let said = words(&output);
    assert_eq!(output.status.code(), Some(2), "{call:?} after {:?}: {said}", start.elapsed());
    assert!(said.contains(word) && !said.contains("panicked"), "{call:?}, {word}: {said}");
}

fn words(output: &Output) -> String {
    text(&output.stderr).split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}

#[test]
fn links_and_pipes_in_a_run_directory_are_neither_followed_nor_waited_for() {
    let here = tempfile::tempdir().unwrap();
    interrupted(here.path());
    let run = here.path().join("run");
    let elsewhere = here.path().join("elsewhere");
    for name in ["frames.dump", "frames.xyz", "frames.bin", "series.csv", "scene.ron", "frames", "vtk", "checkpoints"] {
        let moved = elsewhere.join(name);
        fs::create_dir_all(&elsewhere).unwrap();
        fs::rename(run.join(name), &moved).unwrap();
        if moved.is_dir() {
            for file in ["99999.svg", "grains-99999.vtp", "0000000000000001.checkpoint"] {
                fs::write(moved.join(file), "mine").unwrap();
            }
        }
        let before = content(&elsewhere);
        symlink(&moved, run.join(name)).unwrap();
        for call in calls() {
            assert_refused(here.path(), &call, name);
        }
        fs::remove_file(run.join(name)).unwrap();
        if moved.is_file() {
            assert!(Command::new("mkfifo").arg(run.join(name)).status().unwrap().success());
            for call in calls() {
                assert_refused(here.path(), &call, name);
            }
            fs::remove_file(run.join(name)).unwrap();
        }
        assert!(content(&elsewhere) == before, "{name}");
        for file in ["99999.svg", "grains-99999.vtp", "0000000000000001.checkpoint"] {
            let _ = fs::remove_file(moved.join(file));
        }
        fs::rename(moved, run.join(name)).unwrap();
    }
    // A link to the run directory itself is followed, because the user names it; and the run goes on.
    symlink("run", here.path().join("link")).unwrap();
    let resumed = siloflow(here.path(), &["run", "--resume", "link", "--quiet"]);
    assert!(resumed.status.success(), "{}", words(&resumed));
    let page = siloflow(here.path(), &["report", "link"]);
    assert!(page.status.success(), "{}", words(&page));
}

#[test]
fn what_a_killed_export_left_is_replaced_and_what_a_living_one_writes_is_not() {
    let here = tempfile::tempdir().unwrap();
    let column = crate::scene("column.ron").display().to_string();
    let set = ["--set", "data_frames=(interval: 0.05)", "--set", "pictures=None", "--until", "0.2"];
    let run = || siloflow(here.path(), &[&["run", &column, "--force", "--out", "run", "--quiet"], &set[..]].concat());
    assert!(run().status.success());
    let directory = here.path().join("run");
    let calls: [(&str, &str, &[&str]); 3] = [
        ("vtk", "grains-00000.vtp", &["export", "run", "--to", "vtk"]),
        ("csv", "grains.csv", &["export", "run", "--to", "csv"]),
        ("pictures", "t_0.00.png", &["render", "run", "--every", "0.1", "--width", "60"]),
    ];
    for (name, file, call) in calls {
        let part = directory.join(format!("{name}.part"));
        fs::create_dir(&part).unwrap();
        fs::write(part.join(file), "half").unwrap();
        let marker = File::create(part.join(".siloflow")).unwrap();
        marker.lock().unwrap();
        for call in [call, &["run", &column, "--force", "--out", "run", "--quiet"]] {
            let refused = siloflow(here.path(), call);
            assert_eq!(refused.status.code(), Some(2), "{}", words(&refused));
            assert!(words(&refused).contains("another process"), "{}", words(&refused));
        }
        assert_eq!(fs::read(part.join(file)).unwrap(), b"half");
        drop(marker);
        let done = siloflow(here.path(), call);
        assert!(done.status.success(), "{}", words(&done));
        assert!(!part.exists() && fs::read_dir(directory.join(name)).unwrap().count() > 0);
        assert!(!directory.join(name).join(".siloflow").exists());
        // A replaced run takes along what was left.
        fs::create_dir(&part).unwrap();
        fs::write(part.join(file), "half").unwrap();
        assert!(run().status.success());
        assert!(!part.exists() && !directory.join(name).exists());
    }
}

/// Calls siloflow within an address space of 1.5 GB.
fn bounded(here: &Path, call: &str) -> Output {
    let script = format!("ulimit -v 1500000; exec \"$0\" {call}");
    Command::new("sh").args(["-c", &script, env!("CARGO_BIN_EXE_siloflow")]).current_dir(here).output().unwrap()
}

#[test]
fn short_files_of_a_run_do_not_take_gigabytes() {
    let here = tempfile::tempdir().unwrap();
    interrupted(here.path());
    let run = here.path().join("run");
    // A checkpoint with the right hashes.
    let path = checkpoints(&run).pop().unwrap();
    let whole = fs::read(&path).unwrap();
    let mut checkpoint = file::read_from(&whole).unwrap();
    checkpoint.sections.push(("zeros".to_owned(), vec![0; 200 << 20]));
    let mut bytes = Vec::new();
    file::write(&mut bytes, &checkpoint.header, &checkpoint.sections).unwrap();
    assert!(bytes.len() < 10 << 20);
    fs::write(&path, bytes).unwrap();
    let one = crate::scene("hard/one-grain.ron").display().to_string();
    for call in ["run --resume run".to_owned(), format!("run {one} --from run --out other")] {
        let refused = bounded(here.path(), &call);
        assert_eq!(refused.status.code(), Some(2), "{}", words(&refused));
        assert!(words(&refused).contains("its scene can need"), "{}", words(&refused));
    }
    // A frame of zeros.
    let header = FrameReader::open(&run.join("frames.bin")).unwrap().header;
    fs::remove_file(run.join("frames.bin")).unwrap();
    let rows = 200 << 20;
    let column =
        Column { name: "kind".to_owned(), unit: String::new(), components: 1, values: Values::U8(vec![0; rows]) };
    let table = Table { name: "grains".to_owned(), rows, columns: vec![column] };
    let mut frames = FrameFile::create(&run.join("frames.bin"), &header).unwrap();
    frames.add(&Frame { tables: vec![table], ..Frame::default() }).unwrap();
    for call in ["export run --to csv", "render run --every 0.1"] {
        let refused = bounded(here.path(), call);
        assert_eq!(refused.status.code(), Some(2), "{}", words(&refused));
        assert!(words(&refused).contains("its scene can need"), "{}", words(&refused));
    }
    // The report says so, and shows the rest.
    let reported = bounded(here.path(), "report run");
    assert!(reported.status.success(), "{}", words(&reported));
    assert!(fs::read_to_string(run.join("report.html")).unwrap().contains("its scene can need"));
}
