//! The command line: files, output streams and exit statuses.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

/// Runs the program in `directory`.
pub fn siloflow(directory: &Path, arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_siloflow");
    Command::new(program).args(arguments).current_dir(directory).env_remove("NO_COLOR").output().unwrap()
}

fn path(name: &str) -> String {
    crate::scene(name).display().to_string()
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

fn summary(run: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(run.join("summary.json")).unwrap()).unwrap()
}

#[test]
fn run_directory_is_complete_and_can_be_run_again() {
    let here = tempfile::tempdir().unwrap();
    let output = siloflow(
        here.path(),
        &[
            "run",
            &path("silo1.ron"),
            "--set",
            "spawner.count=12",
            "--seed",
            "5",
            "--until",
            "1.5",
            "--png",
            "--threads",
            "2",
        ],
    );
    assert!(output.status.success(), "{}", text(&output.stderr));
    let run = here.path().join("out/silo1");
    let mut names: Vec<_> =
        fs::read_dir(&run).unwrap().map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    assert_eq!(
        names,
        [
            ".siloflow",
            "checkpoints",
            "frames",
            "frames.bin",
            "hashes.txt",
            "input-silo.dat",
            "scene.ron",
            "series.csv",
            "state.csv",
            "summary.json"
        ]
    );
    // Frames at 0 and 1 s and at the end, each with its PNG.
    for frame in ["00000", "00001", "00002"] {
        assert!(fs::read_to_string(run.join(format!("frames/{frame}.svg"))).unwrap().ends_with("</svg>\n"));
        assert!(fs::read(run.join(format!("frames/{frame}.png"))).unwrap().starts_with(b"\x89PNG"));
    }
    assert!(!run.join("frames/00003.svg").exists());
    let first = summary(&run);
    assert_eq!(first["status"], "time_reached");
    assert_eq!(first["grains"]["released"], 12);
    // Two threads have nothing to share with 12 grains.
    assert_eq!(first["performance"]["threads"], 1);
    assert!(text(&output.stderr).contains("1 of 2 threads"), "{}", text(&output.stderr));
    let keys = [
        "format",
        "scene",
        "status",
        "steps",
        "time_s",
        "grains",
        "rest_time_s",
        "door_open_time_s",
        "empty_time_s",
        "max_overlap_ratio",
        "energy",
        "performance",
        "state_hash",
        "losses",
    ];
    for key in keys {
        assert!(first.get(key).is_some(), "{key}");
    }
    for key in ["kinetic", "potential", "elastic", "dissipated", "released", "removed", "wall_work", "balance_error"] {
        assert!(first["energy"][key].is_number(), "{key}");
    }
    for key in ["wall_s", "particle_steps", "particle_steps_per_s", "neighbour_rebuilds", "threads", "integrator"] {
        assert!(!first["performance"][key].is_null(), "{key}");
    }
    // The directory is self-contained: a run from it gives the same result.
    let again = siloflow(here.path(), &["run", "out/silo1/scene.ron", "--out", "again", "--json", "--quiet"]);
    let second: Value = serde_json::from_slice(&again.stdout).unwrap();
    assert_eq!(second["state_hash"], first["state_hash"]);
    assert!(again.stderr.is_empty(), "{}", text(&again.stderr));
    // A run that replaces an earlier one keeps nothing of it.
    let shorter = siloflow(
        here.path(),
        &["run", &path("silo1.ron"), "--until", "0.1", "--out", "again", "--set", "pictures=None", "--force"],
    );
    assert!(shorter.status.success());
    assert_eq!(fs::read_dir(here.path().join("again/frames")).unwrap().count(), 0);
}

#[test]
fn run_directory_can_be_run_again_into_itself() {
    let here = tempfile::tempdir().unwrap();
    let run = |scene: &str| {
        let output = siloflow(here.path(), &["run", scene, "--until", "0.1", "--out", "run", "--quiet", "--force"]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let copy = fs::read_to_string(here.path().join("run/input-grains.csv")).unwrap();
        (summary(&here.path().join("run"))["state_hash"].clone(), copy)
    };
    let first = run(&path("column.ron"));
    assert_eq!(first.1, fs::read_to_string(crate::scene("column.csv")).unwrap());
    // The grains file of this run is the copy in the directory itself.
    assert_eq!(run("run/scene.ron"), first);
    assert!(!here.path().join("run/input-grains.part").exists());
}

#[test]
fn unreadable_grains_file_is_reported_with_its_key() {
    let here = tempfile::tempdir().unwrap();
    let run = |file: &str| {
        let grains = format!("grains.file={file:?}");
        let output = siloflow(here.path(), &["check", &path("column.ron"), "--set", &grains]);
        assert_eq!(output.status.code(), Some(2));
        text(&output.stderr)
    };
    let missing = run("no-such-file.csv");
    assert!(missing.contains("scene::unreadable_file") && missing.contains("no-such-file.csv"), "{missing}");
    // A directory can be opened, but not read.
    let directory = run(here.path().to_str().unwrap());
    assert!(directory.contains("scene::unreadable_file"), "{directory}");
    let broken = here.path().join("broken.csv");
    fs::write(&broken, b"id,radius,mass,x,y,vx,vy\n1,0.1,\xff,0,0,0,0\n").unwrap();
    let broken = run(broken.to_str().unwrap());
    let broken = broken.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ");
    assert!(
        broken.contains("scene::unreadable_file") && broken.contains("line 2, column 7: the byte 0xff"),
        "{broken}"
    );
}

#[test]
fn series_has_a_header_and_the_grain_counts() {
    let here = tempfile::tempdir().unwrap();
    siloflow(here.path(), &["run", &path("silo1.ron"), "--until", "1.0", "--out", "run", "--quiet"]);
    let series = fs::read_to_string(here.path().join("run/series.csv")).unwrap();
    let rows: Vec<Vec<&str>> = series.lines().map(|line| line.split(',').collect()).collect();
    let column = |name: &str| rows[0].iter().position(|found| *found == name).unwrap_or_else(|| panic!("no {name}"));
    // Every 0.05 s from 0 to 1 s.
    assert_eq!(rows.len(), 1 + 21);
    for (k, row) in rows[1..].iter().enumerate() {
        assert_eq!(row.len(), rows[0].len());
        let number = |name: &str| row[column(name)].parse::<f64>().unwrap();
        assert!((number("time_s") - 0.05 * k as f64).abs() < 1e-9);
        assert_eq!(number("released"), number("inside") + number("out") + number("lost"));
        // The first grain enters in step zero. The grain due at k x 0.05 s enters in the step that begins at that time.
        assert_eq!(number("released"), (k as f64).max(1.0));
    }
}

#[test]
fn bad_input_is_reported_on_stderr_and_writes_no_file() {
    let here = tempfile::tempdir().unwrap();
    for arguments in [
        vec!["run", "no-such-scene.ron"],
        vec!["run", &path("bad/negative-stiffness.ron")],
        vec!["run", &path("bad/unknown-behaviour.ron")],
        vec!["check", &path("bad/missing-comma.ron")],
        vec!["explain", &path("bad/no-mass.ron")],
        vec!["run", &path("silo1.ron"), "--set", "spawner.sise=3"],
        vec!["run", &path("silo1.ron"), "--set", "nothing"],
        vec!["run", &path("silo1.ron"), "--set", "gone.key=3"],
        vec!["run", &path("silo1.ron"), "--until", "-3"],
        vec!["run", &path("silo1.ron"), "--threads", "0"],
        vec!["run", &path("silo1.ron"), "--threads", "100000"],
        vec!["render", "no-such-picture.svg"],
        vec!["fly"],
        vec![],
    ] {
        let output = siloflow(here.path(), &arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty() && !output.stderr.is_empty(), "{arguments:?}");
        assert!(!text(&output.stderr).contains("panicked"), "{arguments:?}");
    }
    assert_eq!(fs::read_dir(here.path()).unwrap().count(), 0, "something was written");
}

#[test]
fn error_of_a_wrong_setting_names_the_key() {
    let here = tempfile::tempdir().unwrap();
    let output = siloflow(here.path(), &["check", &path("silo1.ron"), "--set", "spawner.interval=-1.0"]);
    let message = text(&output.stderr);
    assert!(message.contains("spawner.interval") && message.contains("greater than 0, got -1"), "{message}");
}

#[test]
fn errors_that_beginners_make_say_what_to_write() {
    let here = tempfile::tempdir().unwrap();
    std::fs::copy(path("column.csv"), here.path().join("column.csv")).unwrap();
    std::fs::write(here.path().join("empty.ron"), "").unwrap();
    let silo = path("silo1.ron");
    for (arguments, expected) in [
        (vec!["check", &silo, "--set", "step=1e-4"], "write `Fixed(1e-4)`"),
        (vec!["check", &silo, "--set", "spawner.radius=0.04"], "write `Fixed(0.04)`"),
        (vec!["check", &silo, "--set", "integrator=2"], "the choices here are: Centred, Verlet"),
        (vec!["check", &silo, "--set", "integrator=Verlett"], "did you mean `Verlet`?"),
        (vec!["check", &silo, "--set", "gravty=(0.0, -9.8)"], "did you mean `gravity`?"),
        (vec!["check", &silo, "--set", "spawner.cuont=3"], "did you mean `count`?"),
        (vec!["check", &silo, "--set", "frobnicate=3"], "the keys here are: title"),
        (vec!["check", "column.csv"], "a scene is RON text that begins with `(`"),
        (vec![silo.as_str()], "write `siloflow run"),
    ] {
        let output = siloflow(here.path(), &arguments);
        let said = text(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(expected), "{arguments:?}: {said}");
    }
    assert_eq!(siloflow(here.path(), &["check", "empty.ron"]).status.code(), Some(2));
    let explained = siloflow(here.path(), &["explain", &silo]);
    assert!(text(&explained.stdout).contains("contact Assignment { k: 10000.0, b: 5.0 }"));
}

#[test]
fn door_without_flanking_wall_discs_causes_a_warning() {
    let here = tempfile::tempdir().unwrap();
    let doors = "0.00 0.0 0.01\n0.02 0.0 0.01\n";
    std::fs::write(here.path().join("bare.dat"), format!("0 2\n{doors}")).unwrap();
    std::fs::write(here.path().join("flanked.dat"), format!("2 2\n-0.02 0.0 0.01\n0.04 0.0 0.01\n{doors}")).unwrap();
    let scene = "(gravity: (0.0, -9.81), contact: Linear(k: 1e5, damping: B(5.0)), mass: Disc(20.0), step: Fixed(1e-5), \
                 until: 1.0, silo: (file: FILE, unit: Metre), door: (opens: Never), spawner: (point: (0.01, 0.1), \
                 velocity: (0.0, 0.0), interval: 1.0, count: 1, radius: Fixed(0.01)))";
    for (file, warns) in [("bare.dat", true), ("flanked.dat", false)] {
        std::fs::write(here.path().join("scene.ron"), scene.replace("FILE", &format!("{file:?}"))).unwrap();
        let output = siloflow(here.path(), &["check", "scene.ron"]);
        let said = text(&output.stdout) + &text(&output.stderr);
        assert_eq!(said.contains("check::no_orifice"), warns, "{file}: {said}");
    }
}

#[test]
fn help_and_documentation_list_every_exit_status() {
    let squeezed = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let help = squeezed(&text(&siloflow(crate::root(), &["--help"]).stdout));
    let page = fs::read_to_string(crate::root().join("docs/reference/command-line.md")).unwrap();
    for (status, meaning) in siloflow::cli::EXIT_STATUSES {
        assert!(help.contains(&format!("{status} {meaning}")), "{status}: {help}");
        assert!(page.contains(&format!("| {status} | {meaning} |")), "{status}");
    }
}

#[test]
#[cfg(unix)]
fn closed_and_full_streams_neither_stop_a_run_nor_change_an_exit_status() {
    let here = tempfile::tempdir().unwrap();
    let silo = path("silo1.ron");
    let run = ["run", &silo, "--until", "0.1", "--set", "pictures=None", "--out", "run", "--force"];
    for (arguments, status) in [
        // This run warns before it starts.
        (run.to_vec(), 0),
        ([&run[..], &["--json", "-vv"]].concat(), 0),
        (vec!["check", &silo, "--set", "gravty=1"], 2),
        (vec!["explain", &silo], 0),
        (vec!["--help"], 0),
        (vec![silo.as_str()], 2),
    ] {
        for is_full in [false, true] {
            let stream = || {
                let full = || fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
                if is_full { std::process::Stdio::from(full()) } else { std::io::pipe().unwrap().1.into() }
            };
            let mut command = Command::new(env!("CARGO_BIN_EXE_siloflow"));
            command.args(&arguments).current_dir(&here).stdout(stream()).stderr(stream());
            assert_eq!(command.status().unwrap().code(), Some(status), "{arguments:?}");
            if arguments[0] == "run" {
                assert_eq!(summary(&here.path().join("run"))["failure"], serde_json::Value::Null);
            }
        }
    }
}

#[test]
fn quiet_run_prints_nothing_but_json() {
    let here = tempfile::tempdir().unwrap();
    let silo = path("silo1.ron");
    let run = ["run", &silo, "--until", "0.1", "--set", "pictures=None", "--quiet", "--force"];
    let silent = siloflow(here.path(), &run);
    assert!(silent.stdout.is_empty() && silent.stderr.is_empty(), "{}", text(&silent.stderr));
    let json = siloflow(here.path(), &[&run[..], &["--json"]].concat());
    assert!(json.stdout.starts_with(b"{") && json.stderr.is_empty());
}

#[test]
fn failed_simulation_exits_with_1_and_keeps_its_results() {
    let here = tempfile::tempdir().unwrap();
    let output = siloflow(here.path(), &["run", &path("silo1-one-column.ron"), "--out", "run"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("blocked"), "{}", text(&output.stderr));
    let summary = summary(&here.path().join("run"));
    assert_eq!(summary["status"], "failed");
    assert!(summary["failure"].as_str().unwrap().contains("spawner.release_timeout"));
    assert!(here.path().join("run/state.csv").exists());
}

#[test]
fn lost_grain_stops_the_run_unless_on_loss_is_continue() {
    let here = tempfile::tempdir().unwrap();
    let literal = path("silo1-literal.ron");
    let few = ["--set", "spawner.count=5", "--set", "pictures=None", "--out", "run", "--quiet"];
    let stopped = siloflow(here.path(), &[&["run", &literal, "--set", "on_loss=Stop"], &few[..]].concat());
    assert_eq!(stopped.status.code(), Some(1));
    let first = summary(&here.path().join("run"));
    assert_eq!((&first["status"], first["losses"].as_array().unwrap().len()), (&Value::from("failed"), 1));
    let continued = siloflow(here.path(), &[&["run", &literal, "--force"], &few[..]].concat());
    assert_eq!(continued.status.code(), Some(1));
    let second = summary(&here.path().join("run"));
    assert_eq!((&second["status"], second["losses"].as_array().unwrap().len()), (&Value::from("grains_lost"), 5));
}

#[test]
fn unstable_step_is_refused_with_its_limit() {
    let here = tempfile::tempdir().unwrap();
    let output = siloflow(here.path(), &["run", &path("silo1.ron"), "--out", "run", "--set", "contact.k=1.0e9"]);
    let message = text(&output.stderr);
    // 2 (sqrt(1 + zeta^2) - zeta)/w0 with w0 = sqrt(1e9/0.08) and negligible damping.
    assert!(message.contains("scene::unstable_step") && message.contains("1.788e-5 s"), "{message}");
    assert_eq!(output.status.code(), Some(2));
    assert!(!here.path().join("run").exists());
}

#[test]
fn directory_that_is_no_run_directory_is_refused() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("thesis.tex"), "years of work").unwrap();
    let output = siloflow(here.path(), &["run", &path("free-fall.ron"), "--out", "."]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(fs::read_dir(here.path()).unwrap().count(), 1);
}

#[test]
fn render_writes_pngs_of_a_run() {
    let here = tempfile::tempdir().unwrap();
    siloflow(here.path(), &["run", &path("free-fall.ron"), "--out", "run", "--quiet"]);
    let output = siloflow(here.path(), &["render", "run"]);
    assert!(output.status.success());
    let pngs: Vec<_> = text(&output.stdout).lines().map(str::to_owned).collect();
    assert_eq!(pngs.len(), 11);
    assert!(pngs.iter().all(|png| fs::read(here.path().join(png)).unwrap().starts_with(b"\x89PNG")));
}

#[test]
fn explain_lists_exactly_the_active_systems() {
    let here = tempfile::tempdir().unwrap();
    let silo = text(&siloflow(here.path(), &["explain", &path("silo1.ron")]).stdout);
    for part in ["Position", "Velocity", "ledger::watch_paths", "door::open", "rest::detect", "spawner::release"] {
        assert!(silo.contains(part), "{part}\n{silo}");
    }
    let fall = text(&siloflow(here.path(), &["explain", &path("free-fall.ron")]).stdout);
    for part in ["watch_paths", "door::", "rest::", "spawner::", "surfaces::", "cull", "Spin", "Torque", " Force "] {
        assert!(!fall.contains(part), "{part}\n{fall}");
    }
    let oblique = text(&siloflow(here.path(), &["explain", &path("bounce-oblique.ron")]).stdout);
    assert!([" Spin ", " Inertia "].iter().all(|part| oblique.contains(part)), "{oblique}");
    assert!(![" Torque ", " Force "].iter().any(|part| oblique.contains(part)), "{oblique}");
    assert_eq!(fs::read_dir(here.path()).unwrap().count(), 0, "explain writes nothing");
}

#[test]
fn output_without_a_terminal_has_no_colour_codes() {
    let here = tempfile::tempdir().unwrap();
    for arguments in [vec!["run", &path("silo1-literal.ron"), "--until", "1"], vec!["check", &path("bad/no-mass.ron")]]
    {
        let output = siloflow(here.path(), &arguments);
        assert!(!output.stderr.contains(&0x1b) && !output.stdout.contains(&0x1b), "{}", text(&output.stderr));
    }
}
