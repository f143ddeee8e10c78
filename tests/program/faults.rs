//! Kills and errors at every system call that changes files, injected by strace. Without strace these tests do nothing but
//! say so.
//!
//! Each case starts from a directory with a finished run and a file of another program, and replaces the run. After each
//! fault the directory is the old run or the new one, no file is torn, the other file is kept, and the next run works.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

use crate::command_line::text;
use crate::run_directory::content;

/// System calls that change files.
const CALLS: [&str; 14] = [
    "openat",
    "mkdir",
    "rename",
    "renameat2",
    "unlink",
    "unlinkat",
    "rmdir",
    "ftruncate",
    "fsync",
    "write",
    "linkat",
    "chmod",
    "copy_file_range",
    "flock",
];

fn has_strace() -> bool {
    let is_there = Command::new("strace").args(["-qq", "-o", "/dev/null", "true"]).status().is_ok_and(|s| s.success());
    if !is_there {
        eprintln!("skipped: strace is missing or may not trace");
    }
    is_there
}

/// A directory with a finished run in `out/run`.
struct Place(tempfile::TempDir);

const OLD: &str = "1";
const NEW: &str = "2";

impl Place {
    fn new() -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        assert!(place.run(OLD, &[]).status.success());
        fs::write(place.run_directory().join("notes.txt"), "mine").unwrap();
        place
    }

    fn run_directory(&self) -> std::path::PathBuf {
        self.0.path().join("out/run")
    }

    /// Replaces the run by one with another seed, under `strace` with these options if there are any.
    fn run(&self, seed: &str, strace: &[String]) -> Output {
        let mut command = Command::new(if strace.is_empty() { env!("CARGO_BIN_EXE_siloflow") } else { "strace" });
        if !strace.is_empty() {
            command.args(["-f", "-qq", "-o", "trace"]).args(strace).arg(env!("CARGO_BIN_EXE_siloflow"));
        }
        command
            .arg("run")
            .arg(crate::scene("silo1.ron"))
            .args(["--seed", seed, "--quiet", "--force", "--out", "out/run"]);
        for setting in ["spawner.count=2", "until=0.02", "series.interval=0.01"] {
            command.args(["--set", setting]);
        }
        command.args(["--set", "pictures=(interval: 0.01, width: 60, png: true)"]);
        command.current_dir(self.0.path()).output().unwrap()
    }

    /// Runs with a fault at the `n`th call of `name`. Returns `None` if there is no such call.
    fn inject(&self, fault: &str, name: &str, n: usize) -> Option<Output> {
        let options = ["-e".into(), format!("trace={name}"), "-e".into(), format!("inject={name}:{fault}:when={n}")];
        let output = self.run(NEW, &options);
        let trace = fs::read_to_string(self.0.path().join("trace")).unwrap_or_default();
        (trace.contains("INJECTED") || trace.contains("killed by SIGKILL")).then_some(output)
    }

    /// Whether the directory holds the new run, and its summary. Checks that it holds nothing else.
    fn state(&self, case: &str) -> (bool, Option<Value>) {
        let run = self.run_directory();
        let read = |name: &str| fs::read_to_string(run.join(name));
        let scene = read("scene.ron").unwrap_or_else(|error| panic!("{case}: the scene is lost: {error}"));
        let is_new = scene.contains(&format!("seed: {NEW}"));
        assert!(is_new || scene.contains(&format!("seed: {OLD}")), "{case}: {scene}");
        assert_eq!(read("notes.txt").unwrap(), "mine", "{case}");
        for (path, bytes) in content(&run) {
            let ending = path.extension().unwrap_or_default();
            let is_whole = match ending.to_str().unwrap() {
                "csv" => bytes.ends_with(b"\n"),
                "svg" => bytes.ends_with(b"</svg>\n"),
                "png" => bytes.ends_with(b"IEND\xae\x42\x60\x82"),
                _ => true,
            };
            assert!(is_whole, "{case}: {} is torn", path.display());
        }
        let summary = read("summary.json").ok().map(|text| serde_json::from_str::<Value>(&text).unwrap());
        if !is_new {
            assert_eq!(summary.as_ref().unwrap()["status"], "time_reached", "{case}");
            assert!(run.join("state.csv").exists() && run.join("frames/00002.png").exists(), "{case}");
        }
        (is_new, summary)
    }

    /// Checks that the next run works and cleans up, and returns to the old run.
    fn restore(&self, case: &str) {
        let next = self.run(OLD, &[]);
        assert!(next.status.success(), "{case}: {}", text(&next.stderr));
        assert_eq!(fs::read_dir(self.0.path().join("out")).unwrap().count(), 1, "{case}: something is left");
        self.state(case);
    }
}

/// Runs `check` on every fault of the given kind that can be injected. Returns the number of faults.
fn for_each_call(fault: &str, check: impl Fn(&Place, &str, &Output)) -> usize {
    let place = Place::new();
    let mut count = 0;
    for name in CALLS {
        for n in 1.. {
            let Some(output) = place.inject(fault, name, n) else { break };
            let case = format!("{fault} at {name} {n}");
            check(&place, &case, &output);
            place.restore(&case);
            count += 1;
        }
        place.restore(name);
    }
    count
}

#[test]
fn a_kill_at_any_call_leaves_one_whole_run() {
    if !has_strace() {
        return;
    }
    let count = for_each_call("signal=KILL", |place, case, _| {
        place.state(case);
    });
    assert!(count > 40, "{count}");
}

#[test]
fn an_error_at_any_call_is_reported_and_leaves_one_whole_run() {
    if !has_strace() {
        return;
    }
    for error in ["ENOSPC", "EIO"] {
        let count = for_each_call(&format!("error={error}"), |place, case, output| {
            let (is_new, summary) = place.state(case);
            let said = text(&output.stderr);
            match output.status.code() {
                // A call whose failure has no effect, for example on a file of the operating system.
                Some(0) => assert!(is_new && summary.unwrap()["failure"].is_null(), "{case}"),
                Some(1) => {
                    assert!(is_new && !said.is_empty(), "{case}");
                    if let Some(summary) = summary {
                        assert_eq!(summary["status"], "failed", "{case}");
                        assert!(summary["failure"].as_str().unwrap().contains("could not write"), "{case}: {summary}");
                    }
                }
                Some(2) => assert!(!is_new && !said.is_empty(), "{case}: {said}"),
                other => panic!("{case}: {other:?}: {said}"),
            }
        });
        assert!(count > 40, "{count}");
    }
}

#[test]
fn threads_that_cannot_start_leave_the_earlier_run() {
    if !has_strace() {
        return;
    }
    let place = Place::new();
    let before = content(&place.run_directory());
    let output = place.run(NEW, &["-e".into(), "inject=clone3,clone:error=EAGAIN".into()]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
    assert_eq!(content(&place.run_directory()), before);
}

/// File systems without an atomic exchange get two renames. A kill between them is repaired by the next run.
#[test]
fn an_exchange_in_two_renames_is_repaired() {
    if !has_strace() {
        return;
    }
    let place = Place::new();
    let no_exchange = [
        "-e".to_owned(),
        "trace=renameat2,rename".to_owned(),
        "-e".to_owned(),
        "inject=renameat2:error=EINVAL".to_owned(),
    ];
    let done = place.run(NEW, &no_exchange);
    assert!(done.status.success() && place.state("no exchange").0, "{}", text(&done.stderr));
    place.restore("no exchange");
    for n in 1.. {
        let kill = ["-e".to_owned(), format!("inject=rename:signal=KILL:when={n}")];
        let output = place.run(NEW, &[&no_exchange[..], &kill].concat());
        if output.status.success() {
            break;
        }
        place.restore(&format!("kill at rename {n} without exchange"));
    }
}

#[test]
fn a_directory_that_vanishes_or_cannot_be_written_is_reported() {
    if !has_strace() {
        return;
    }
    let place = Place::new();
    let before = content(&place.run_directory());
    for error in ["EROFS", "EACCES"] {
        let output = place.run(NEW, &["-e".into(), format!("inject=mkdir,mkdirat:error={error}")]);
        assert_eq!(output.status.code(), Some(2), "{error}: {}", text(&output.stderr));
        assert_eq!(content(&place.run_directory()), before);
    }
    // A directory that cannot be read is not empty.
    let output = place.run(NEW, &["-e".into(), "inject=getdents64:error=EACCES:when=1".into()]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
    assert_eq!(content(&place.run_directory()), before);
    assert!(Path::new(&place.run_directory()).exists());
}
