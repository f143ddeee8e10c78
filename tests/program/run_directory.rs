//! The run directory as users meet it: runs that exist, two runs at once, signals.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::Duration;

use serde_json::Value;

use crate::command_line::{siloflow, text};

fn path(name: &str) -> String {
    crate::scene(name).display().to_string()
}

/// Returns all files below a directory with their content, in order.
pub fn content(directory: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut all = Vec::new();
    for entry in fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path()) {
        if entry.is_dir() {
            all.extend(content(&entry));
        } else {
            all.push((entry.clone(), fs::read(entry).unwrap()));
        }
    }
    all.sort();
    all
}

fn summary(run: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(run.join("summary.json")).unwrap()).unwrap()
}

/// A run that does not end by itself.
struct Running(Child);

impl Running {
    /// Starts a run and blocks until the file `sign` has content.
    fn start(directory: &Path, shell: &str, arguments: &[&str], sign: impl Fn() -> Option<PathBuf>) -> Self {
        // A job in the background of a script ignores SIGINT, and so would the run.
        let mut command = Command::new("env");
        command.args([
            "--default-signal=HUP,INT,TERM,USR1,USR2,XCPU,XFSZ",
            "sh",
            "-c",
            &format!("{shell} exec \"$@\""),
        ]);
        command.args(["sh", env!("CARGO_BIN_EXE_siloflow")]);
        command.args(arguments).current_dir(directory).stdout(Stdio::null()).stderr(Stdio::null());
        let mut run = Self(command.spawn().unwrap());
        while sign().and_then(|sign| fs::metadata(sign).ok()).is_none_or(|found| found.len() == 0) {
            assert_eq!(run.0.try_wait().unwrap(), None, "the run has ended");
            sleep(Duration::from_millis(5));
        }
        run
    }

    fn signal(&self, name: &str) {
        let sent = Command::new("sh").args(["-c", &format!("kill -{name} {}", self.0.id())]).status().unwrap();
        assert!(sent.success());
    }

    fn end(mut self) -> ExitStatus {
        self.0.wait().unwrap()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn an_earlier_run_is_replaced_only_with_force() {
    let here = tempfile::tempdir().unwrap();
    let run = |more: &[&str]| siloflow(here.path(), &[&["run", &path("free-fall.ron"), "--quiet"], more].concat());
    assert!(run(&[]).status.success());
    let before = content(here.path());
    let again = run(&["--set", "step=Fixed(0.002)"]);
    let said = text(&again.stderr);
    assert_eq!(again.status.code(), Some(2), "{said}");
    assert!(said.contains("out/free-fall holds a finished run"), "{said}");
    assert!(said.contains("--force") && said.contains("--out"), "{said}");
    assert_eq!(content(here.path()), before);
    // A call that cannot start leaves the earlier run as it is, even with `--force`.
    for wrong in [&["--set", "gravty=1"][..], &["--until", "-3"]] {
        assert_eq!(run(&[&["--force"], wrong].concat()).status.code(), Some(2), "{wrong:?}");
        assert_eq!(content(here.path()), before);
    }
    assert!(run(&["--force", "--set", "step=Fixed(0.002)"]).status.success());
    assert!(fs::read_to_string(here.path().join("out/free-fall/scene.ron")).unwrap().contains("0.002"));
}

#[test]
fn a_scene_without_a_usable_name_and_the_current_directory_are_refused() {
    let here = tempfile::tempdir().unwrap();
    fs::copy(path("free-fall.ron"), here.path().join("...ron")).unwrap();
    fs::copy(path("free-fall.csv"), here.path().join("free-fall.csv")).unwrap();
    let before = content(here.path());
    for arguments in [&["run", "...ron"][..], &["run", "...ron", "--out", "."], &["run", "...ron", "--out", ""]] {
        let output = siloflow(here.path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", text(&output.stderr));
        assert!(text(&output.stderr).contains("--out"), "{arguments:?}: {}", text(&output.stderr));
    }
    assert_eq!(content(here.path()), before);
    assert!(siloflow(here.path(), &["run", "...ron", "--out", "run", "--quiet"]).status.success());
}

#[test]
fn a_second_run_into_a_directory_is_refused_and_names_the_process() {
    let here = tempfile::tempdir().unwrap();
    let silo = path("silo1.ron");
    let run = endless_run(&silo);
    let first = Running::start(here.path(), "", &run, || Some(here.path().join("run/series.csv")));
    let scene = fs::read(here.path().join("run/scene.ron")).unwrap();
    let second = siloflow(here.path(), &[&run[..], &["--force", "--seed", "9"]].concat());
    let said = text(&second.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(second.status.code(), Some(2), "{said}");
    assert!(said.contains(&format!("run is in use by process {}", first.0.id())), "{said}");
    assert_eq!(fs::read(here.path().join("run/scene.ron")).unwrap(), scene);
    assert_eq!(fs::read_dir(here.path()).unwrap().count(), 1);
    first.signal("KILL");
    first.end();
    let third = siloflow(here.path(), &run);
    assert!(text(&third.stderr).contains("a run that was killed"), "{}", text(&third.stderr));
}

#[test]
fn a_run_whose_directory_was_moved_away_touches_no_other_run() {
    let here = tempfile::tempdir().unwrap();
    let silo = path("silo1.ron");
    let run = ["run", &silo, "--until", "1e6", "--set", "pictures.interval=0.1", "--out", "run"];
    let first = Running::start(here.path(), "", &run, || Some(here.path().join("run/series.csv")));
    fs::rename(here.path().join("run"), here.path().join("moved")).unwrap();
    let fall = path("free-fall.ron");
    assert!(siloflow(here.path(), &["run", &fall, "--out", "run", "--quiet"]).status.success());
    let second = content(&here.path().join("run"));
    assert_eq!(first.end().code(), Some(1));
    assert_eq!(content(&here.path().join("run")), second);
    assert!(!here.path().join("moved/summary.json").exists());
}

/// The signals that end a run, with the exit status.
const ENDING: [(&str, i32); 6] =
    [("INT", 130), ("TERM", 143), ("HUP", 129), ("XCPU", 152), ("USR1", 138), ("USR2", 140)];

#[test]
fn a_signal_ends_a_run_after_its_step_with_complete_results() {
    let silo = path("silo1.ron");
    let grains = endless_run(&silo);
    let flow = path("mass-flow.ron");
    let lattice = [
        "run",
        &flow,
        "--until",
        "100000000",
        "--set",
        "rest=None",
        "--set",
        "discharge=None",
        "--set",
        "door=None",
        "--out",
        "run",
    ];
    for (arguments, column) in [(&grains[..], "time_s"), (&lattice[..], "steps")] {
        for (signal, status) in ENDING {
            let here = tempfile::tempdir().unwrap();
            let run = here.path().join("run");
            let running = Running::start(here.path(), "", arguments, || Some(run.join("series.csv")));
            running.signal(signal);
            assert_eq!(running.end().code(), Some(status), "{signal}");
            let summary = summary(&run);
            assert_eq!((&summary["status"], &summary["failure"]), (&"interrupted".into(), &Value::Null), "{signal}");
            let series = fs::read_to_string(run.join("series.csv")).unwrap();
            let last = series.lines().last().unwrap().split(',').next().unwrap().parse::<f64>().unwrap();
            assert!((last - summary[column].as_f64().unwrap()).abs() < 1e-9, "{last}: {summary}");
            assert!(fs::metadata(run.join("state.csv")).unwrap().len() > 20);
            assert!(!run.join("summary.json.part").exists());
            assert_eq!(fs::read_dir(run.join("checkpoints")).unwrap().count(), 1, "{signal}");
        }
    }
}

#[test]
fn an_ignored_signal_stays_ignored() {
    let here = tempfile::tempdir().unwrap();
    let silo = path("silo1.ron");
    let run = endless_run(&silo);
    let sign = || Some(here.path().join("run/series.csv"));
    let running = Running::start(here.path(), "trap '' HUP;", &run, sign);
    running.signal("HUP");
    running.signal("TERM");
    assert_eq!(running.end().code(), Some(143));
    assert_eq!(summary(&here.path().join("run"))["status"], "interrupted");
}

/// Arguments of a run that only a signal ends.
fn endless_run(silo: &str) -> Vec<&str> {
    let never = ["--until", "1e6", "--set", "rest=None", "--set", "door=None", "--set", "bed=None"];
    [&["run", silo], &never[..], &["--out", "run"]].concat()
}

/// Arguments of a run with steps of seconds: every pair of many grains is examined.
fn slow_run(silo: &str) -> Vec<&str> {
    let fill = "fill=[(low: (-0.8, 1.4), high: (0.8, 2.3), spacing: 0.0068, count: 30000, radius: Fixed(0.002))]";
    vec![
        "run",
        silo,
        "--set",
        fill,
        "--set",
        "neighbours=AllPairs",
        "--set",
        "step=Fixed(1e-6)",
        "--set",
        "spawner=None",
        "--set",
        "pictures=None",
        "--set",
        "rest=None",
        "--set",
        "door=None",
        "--set",
        "bed=None",
        "--out",
        "run",
    ]
}

#[test]
fn a_signal_before_the_first_step_leaves_no_trace() {
    let here = tempfile::tempdir().unwrap();
    let silo = path("silo1.ron");
    let staged = || {
        let entries = fs::read_dir(here.path()).ok()?;
        let mut paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
        paths.find(|path| path.to_string_lossy().contains(".run.siloflow-")).map(|path| path.join("series.csv"))
    };
    let running = Running::start(here.path(), "", &slow_run(&silo), staged);
    running.signal("TERM");
    assert_eq!(running.end().code(), Some(143));
    assert_eq!(fs::read_dir(here.path()).unwrap().count(), 0);
}

/// Starts a run with steps of seconds in `here/run`.
fn start_slow_run(here: &Path) -> Running {
    let silo = path("silo1.ron");
    Running::start(here, "", &slow_run(&silo), || Some(here.join("run/series.csv")))
}

/// `timeout` and batch systems send a signal to the process and to its group.
#[test]
fn two_signals_at_once_are_one_request() {
    let here = tempfile::tempdir().unwrap();
    let running = start_slow_run(here.path());
    // Equal signals could be delivered as one.
    let kill = format!("kill -INT {0}; kill -TERM {0}", running.0.id());
    assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    // The signal that is handled second sets the status.
    assert!(matches!(running.end().code(), Some(130 | 143)));
    let run = here.path().join("run");
    assert_eq!(summary(&run)["status"], "interrupted");
    assert_eq!(fs::read_dir(run.join("checkpoints")).unwrap().count(), 1);
}

/// At its limit of processor time a process gets the signal in every second.
#[test]
fn the_limit_of_processor_time_ends_a_run_with_a_checkpoint() {
    let here = tempfile::tempdir().unwrap();
    let mut running = start_slow_run(here.path());
    while running.0.try_wait().unwrap().is_none() {
        running.signal("XCPU");
        sleep(Duration::from_millis(100));
    }
    assert_eq!(running.end().code(), Some(152));
    let run = here.path().join("run");
    assert_eq!(summary(&run)["status"], "interrupted");
    assert_eq!(fs::read_dir(run.join("checkpoints")).unwrap().count(), 1);
}

/// The limit counts in units of 512 or 1024 bytes.
#[test]
fn a_limit_of_file_sizes_is_reported_like_a_full_disk() {
    let here = tempfile::tempdir().unwrap();
    let silo = path("silo1.ron");
    let more = ["--set", "series=(interval: 0.001)", "--set", "pictures=None", "--set", "data_frames=None"];
    let arguments = [&endless_run(&silo)[..], &more].concat();
    let running =
        Running::start(here.path(), "ulimit -f 256;", &arguments, || Some(here.path().join("run/series.csv")));
    assert_eq!(running.end().code(), Some(1));
    let run = here.path().join("run");
    let summary = summary(&run);
    assert_eq!(summary["status"], "failed");
    assert!(summary["failure"].as_str().unwrap().contains("series.csv"), "{summary}");
    // The file ends with a whole row.
    assert!(fs::read_to_string(run.join("series.csv")).unwrap().ends_with('\n'));
    // Other commands say so too, and leave nothing.
    let call = format!("ulimit -f 0; exec '{}' new copy.ron", env!("CARGO_BIN_EXE_siloflow"));
    let output = Command::new("sh").args(["-c", &call]).current_dir(here.path()).output().unwrap();
    assert!(matches!(output.status.code(), Some(1 | 2)), "{output:?}");
    assert!(String::from_utf8_lossy(&output.stderr).contains("copy.ron"), "{output:?}");
}

#[test]
fn a_signal_a_second_after_the_first_stops_at_once() {
    let here = tempfile::tempdir().unwrap();
    let mut running = start_slow_run(here.path());
    running.signal("INT");
    // The step in progress and the last one take longer than a second. On a busy machine the second may last longer, too.
    while running.0.try_wait().unwrap().is_none() {
        running.signal("TERM");
        sleep(Duration::from_millis(100));
    }
    assert_eq!(running.end().code(), Some(143));
    assert!(!here.path().join("run/summary.json").exists());
}

#[test]
fn results_that_cannot_be_written_are_refused_before_the_work_for_them() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("notes.txt"), "mine").unwrap();
    let plan = path("studies/lattice-gas.ron");
    let before = content(here.path());
    for command in [&["accuracy", "bounce-0.5"][..], &["study", &plan]] {
        for out in ["notes.txt", "notes.txt/results"] {
            let output = siloflow(here.path(), &[command, &["--out", out]].concat());
            let said = text(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{command:?}: {said}");
            assert!(said.contains("results::write") && said.contains("--out"), "{command:?}: {said}");
            assert!(!said.contains("reference solutions") && !said.contains(" runs"), "{command:?}: {said}");
        }
    }
    assert_eq!(content(here.path()), before);
}
