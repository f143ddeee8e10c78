//! `siloflow sweep`: interrupted sweeps, failing runs, wrong input, parts of a job array.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::Barrier;
use std::thread;
use std::time::{Duration, Instant};

use siloflow::studies::sweep::Sweep;
use siloflow::studies::sweep::directory::SweepDirectory;

use crate::command_line::{siloflow, text};

/// Three discs fall on a plate. A parameter may make the run last longer, or fail.
const SCENE: &str = r#"(
    parameters: {"height": 0.5, "end": 0.5, "stiff": 1.0e4},
    gravity: (0.0, -9.81),
    contact: Linear(k: "= stiff", damping: Restitution(0.5)),
    mass: Disc(10.0),
    step: Fixed(1.0e-4),
    walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))],
    fill: [(low: (-0.1, "= height"), high: (0.1, "= height + 0.05"), spacing: 0.05, count: 3, radius: Uniform(0.01, 0.02))],
    until: "= end",
    series: (interval: 0.1),
    pictures: None,
)"#;

const FIGURES: &str = r#"figures: ["energy.kinetic", "max_overlap_ratio"]"#;

/// Writes the scene and a sweep file with these axes and keys.
fn write_sweep(here: &Path, axes: &str, more: &str) {
    fs::write(here.join("plate.ron"), SCENE).unwrap();
    fs::write(here.join("s.ron"), format!("(scene: \"plate.ron\", axes: [{axes}], {more})")).unwrap();
}

fn read(path: PathBuf) -> String {
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn assert_refused(output: &Output, words: &[&str]) {
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    for word in words {
        assert!(message.contains(word), "{word} is missing in:\n{message}");
    }
}

#[test]
fn figures_of_a_sweep_may_come_from_tables_and_be_shares() {
    let here = tempfile::tempdir().unwrap();
    let column = "series.csv: largest largest_speed_m_per_s, 0 s to 0.3 s";
    let figures = format!("figures: [\"{column}\", \"share of time_reached\", \"series.csv: speeds\"]");
    write_sweep(here.path(), "Values(key: \"parameters.height\", values: [0.5])", &format!("seeds: [3, 5], {figures}"));
    let output = siloflow(here.path(), &["sweep", "s.ron"]);
    let said = text(&output.stderr);
    assert!(output.status.success() && said.contains("there is no column `speeds`"), "{said}");
    let mut table = csv::Reader::from_path(here.path().join("out/s/table.csv")).unwrap();
    let rows: Vec<_> = table.records().map(Result::unwrap).collect();
    let mean = |row: usize| rows[row][3].parse::<f64>();
    // The discs fall freely from 0.5 m: after 0.3 s all have 2.943 m/s.
    assert!((mean(0).unwrap() - 2.943).abs() < 1e-9 && &rows[0][2] == column, "{rows:?}");
    assert_eq!((mean(1), &rows[2][3]), (Ok(1.0), ""));
    write_sweep(here.path(), "", "seeds: 1, figures: [\"series.csv: 1 s to 2 s\"]");
    assert_refused(&siloflow(here.path(), &["sweep", "s.ron"]), &["figures[0]", "one column"]);
}

/// Five heights and three seeds, each run long enough that the sweep can be stopped within it.
fn heights(here: &Path) {
    let axes = r#"Range(key: "parameters.height", from: 0.5, to: 0.9, count: 5)"#;
    write_sweep(here, axes, &format!("set: {{\"parameters.end\": 1.0}}, seeds: 3, {FIGURES}"));
}

#[test]
fn a_sweep_writes_its_tables_and_pictures_and_runs_nothing_twice() {
    let here = tempfile::tempdir().unwrap();
    let axes =
        r#"Values(key: "parameters.height", values: [0.5, 0.6]), Values(key: "integrator", values: [Verlet, Centred])"#;
    let fit = r#"fit: (figure: "max_overlap_ratio", against: "parameters.height", law: Line)"#;
    let units = r#"units: {"parameters.height": "m"}"#;
    write_sweep(here.path(), axes, &format!("seeds: [3, 5], {FIGURES}, {fit}, {units}"));
    let output = siloflow(here.path(), &["sweep", "s.ron"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let out = here.path().join("out/s");
    let results = read(out.join("results.csv"));
    let lines: Vec<_> = results.lines().collect();
    assert_eq!(lines[0], "run,point,seed,parameters.height,integrator,status,failure,energy.kinetic,max_overlap_ratio");
    assert_eq!(lines.len(), 9);
    assert!(lines[3].starts_with("0002-3,2,3,0.5,Centred,time_reached,,"), "{results}");
    // The table agrees with the mean and the standard error of the two runs of a point: half of their difference.
    let cell = |line: &str, n: usize| line.split(',').nth(n).unwrap().parse::<f64>().unwrap();
    let [a, b] = [1, 2].map(|n| cell(lines[n], 7));
    let table = read(out.join("table.csv"));
    let first = table.lines().nth(1).unwrap();
    assert!(first.starts_with("1,0.5,Verlet,energy.kinetic,") && first.ends_with(",2,0,0,0"), "{table}");
    assert!((cell(first, 4) - 0.5 * (a + b)).abs() < 1e-12 * a.abs().max(b.abs()), "{table}");
    assert!((cell(first, 5) - 0.5 * (a - b).abs()).abs() < 1e-12 * a.abs().max(b.abs()), "{table}");
    assert_eq!(table.lines().count(), 1 + 4 * 2);
    assert_eq!(read(out.join("fit.csv")).lines().count(), 1 + 2 * 3);
    for name in ["parameters-height.svg", "parameters-height.png", "integrator.svg", "integrator.png"] {
        assert!(out.join("figures").join(name).is_file(), "{name}");
    }
    assert!(read(out.join("figures/parameters-height.svg")).contains(">parameters.height, m<"));
    assert!(read(out.join("figures/integrator.svg")).contains(">parameters.height = 0.5 m<"));
    assert_eq!(out.join("table.parquet").is_file(), cfg!(feature = "parquet"));
    let summary = out.join("runs/0002-3/summary.json");
    let before = fs::metadata(&summary).unwrap().modified().unwrap();
    let again = siloflow(here.path(), &["sweep", "s.ron"]);
    assert!(again.status.success() && text(&again.stdout) == text(&output.stdout), "{}", text(&again.stderr));
    assert_eq!(fs::metadata(&summary).unwrap().modified().unwrap(), before);
    let quiet = siloflow(here.path(), &["-q", "sweep", "s.ron", "--gather"]);
    assert!(quiet.status.success() && quiet.stdout.is_empty() && quiet.stderr.is_empty());
}

#[test]
#[cfg(unix)]
fn a_sweep_that_is_stopped_and_killed_continues_to_the_same_table() {
    let here = tempfile::tempdir().unwrap();
    heights(here.path());
    let straight = siloflow(here.path(), &["sweep", "s.ron", "--out", "straight", "--cores", "2"]);
    assert!(straight.status.success(), "{}", text(&straight.stderr));
    let over = || {
        let runs = fs::read_dir(here.path().join("stopped/runs"));
        runs.map_or(0, |runs| runs.filter(|run| run.as_ref().unwrap().path().join("summary.json").exists()).count())
    };
    for (signal, after) in [("TERM", 2), ("KILL", 6)] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_siloflow"))
            .args(["sweep", "s.ron", "--out", "stopped", "--cores", "2"])
            .current_dir(here.path())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let start = Instant::now();
        while over() < after && start.elapsed() < Duration::from_mins(5) {
            thread::sleep(Duration::from_millis(2));
        }
        Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().unwrap();
        let status = child.wait().unwrap();
        assert_eq!(status.code(), (signal == "TERM").then_some(143), "the sweep was over before its signal");
        assert!(over() < 15, "the sweep was over before its signal");
    }
    let last = siloflow(here.path(), &["sweep", "s.ron", "--out", "stopped", "--cores", "2"]);
    assert!(last.status.success(), "{}", text(&last.stderr));
    for name in ["table.csv", "results.csv", "figures/parameters-height.svg"] {
        assert_eq!(
            read(here.path().join("straight").join(name)),
            read(here.path().join("stopped").join(name)),
            "{name}"
        );
    }
}

#[test]
fn failing_runs_are_listed_and_do_not_hide_the_others() {
    let here = tempfile::tempdir().unwrap();
    // The overlap at a contact that is far too soft exceeds the limit of the watchdog.
    write_sweep(
        here.path(),
        r#"Values(key: "parameters.stiff", values: [1.0e4, 2.0])"#,
        &format!("seeds: 2, {FIGURES}"),
    );
    let output = siloflow(here.path(), &["sweep", "s.ron"]);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("run 0002-1 (parameters.stiff = 2.0, seed 1) has no result: step"), "{message}");
    assert!(message.contains("points 2: check::"), "{message}");
    let table = read(here.path().join("out/s/table.csv"));
    assert!(
        table.lines().any(|line| line.starts_with("1,1.0e4,energy.kinetic,") && line.ends_with(",2,0,0,0")),
        "{table}"
    );
    assert!(table.lines().any(|line| line == "2,2.0,energy.kinetic,,,0,0,2,0"), "{table}");
    // Failed runs are not repeated, unless that is asked for.
    let log = here.path().join("out/s/runs/0002-1/summary.json");
    let before = fs::metadata(&log).unwrap().modified().unwrap();
    assert_eq!(siloflow(here.path(), &["sweep", "s.ron"]).status.code(), Some(1));
    assert_eq!(fs::metadata(&log).unwrap().modified().unwrap(), before);
    assert_eq!(siloflow(here.path(), &["sweep", "s.ron", "--retry"]).status.code(), Some(1));
    assert_ne!(fs::metadata(&log).unwrap().modified().unwrap(), before);
}

#[test]
fn wrong_sweep_files_are_refused_before_anything_is_written() {
    let here = tempfile::tempdir().unwrap();
    let height = r#"Values(key: "parameters.height", values: [0.5])"#;
    let cases: [(&str, &str, &[&str]); 15] = [
        (r#"Values(key: "parameters.hight", values: [0.5])"#, "seeds: 1, figures: [\"steps\"]", &["hight", "height"]),
        (r#"Values(key: "contact.c", values: [0.5])"#, "seeds: 1, figures: [\"steps\"]", &["contact.c", "0001-1"]),
        (r#"Values(key: "step", values: [Fast])"#, "seeds: 1, figures: [\"steps\"]", &["Fast", "Fixed"]),
        (r#"Values(key: "seed", values: [1])"#, "seeds: 1, figures: [\"steps\"]", &["seeds are no axis"]),
        (r#"Values(key: "until", values: [])"#, "seeds: 1, figures: [\"steps\"]", &["no values"]),
        (r#"Values(key: "until", values: [1, 1])"#, "seeds: 1, figures: [\"steps\"]", &["twice"]),
        (r#"Range(key: "until", from: 2, to: 1, count: 3)"#, "seeds: 1, figures: [\"steps\"]", &["below"]),
        (r#"Range(key: "until", from: 1, to: 2, count: 1)"#, "seeds: 1, figures: [\"steps\"]", &["at least 2"]),
        (height, "seeds: [1, 1], figures: [\"steps\"]", &["each only once"]),
        (height, "seeds: 200000, figures: [\"steps\"]", &["more than 100000 runs"]),
        (height, "seeds: 1, figures: [\"discharge.rate\"]", &["rate_per_s"]),
        (
            height,
            "seeds: 1, figures: [\"steps\"], fit: (figure: \"time_s\", against: \"until\", law: Line)",
            &["time_s"],
        ),
        (
            height,
            "seeds: 1, figures: [\"steps\"], fit: (figure: \"steps\", against: \"until\", law: Line)",
            &["until", "height"],
        ),
        (height, "seeds: 1, figures: [\"steps\"], units: {\"until\": \"s\"}", &["units", "until", "height"]),
        (height, "seeds: 1, figure: [\"steps\"]", &["figure", "did you mean `figures`"]),
    ];
    for (axes, more, words) in cases {
        write_sweep(here.path(), axes, more);
        assert_refused(&siloflow(here.path(), &["sweep", "s.ron"]), words);
        assert!(!here.path().join("out").exists(), "{axes} {more}");
    }
}

#[test]
fn missing_and_wrong_files_and_existing_targets_are_refused() {
    let here = tempfile::tempdir().unwrap();
    heights(here.path());
    assert_refused(&siloflow(here.path(), &["sweep", "no.ron"]), &["no.ron", "give the path of a sweep file"]);
    assert_refused(&siloflow(here.path(), &["sweep", "plate.ron"]), &["it is a scene"]);
    fs::write(here.path().join("grains.csv"), "id,radius\n1,2\n").unwrap();
    assert_refused(&siloflow(here.path(), &["sweep", "grains.csv"]), &["no RON text"]);
    assert_refused(&siloflow(here.path(), &["run", "s.ron"]), &["this is a sweep file", "siloflow sweep"]);
    let lost = read(here.path().join("s.ron")).replace("plate.ron", "gone.ron");
    fs::write(here.path().join("lost.ron"), lost).unwrap();
    assert_refused(&siloflow(here.path(), &["sweep", "lost.ron"]), &["gone.ron", "scene"]);
    assert_refused(&siloflow(here.path(), &["sweep", "s.ron", "--gather"]), &["holds no sweep"]);
    for wrong in ["0/3", "4/3", "x"] {
        assert_refused(&siloflow(here.path(), &["sweep", "s.ron", "--task", wrong]), &["expected I/N"]);
    }
    assert_refused(&siloflow(here.path(), &["sweep", "s.ron", "--script", "pbs"]), &["slurm, parallel, hyperqueue"]);
    // A directory of something else, a file, and the directory of another sweep.
    fs::create_dir(here.path().join("photos")).unwrap();
    fs::write(here.path().join("photos/cat.png"), "").unwrap();
    for (target, word) in [("photos", "cat.png"), ("plate.ron", "plate.ron cannot be the directory")] {
        for more in ["--force", "--retry"] {
            assert_refused(&siloflow(here.path(), &["sweep", "s.ron", "--out", target, more]), &[word]);
        }
    }
    assert_eq!(fs::read_dir(here.path().join("photos")).unwrap().count(), 1);
    let short = |seeds| {
        let more = format!("seeds: {seeds}, {FIGURES}");
        write_sweep(here.path(), r#"Values(key: "parameters.height", values: [0.5])"#, &more);
        siloflow(here.path(), &["sweep", "s.ron", "--force"])
    };
    assert!(short(1).status.success());
    let first = here.path().join("out/s/runs/0001-1/summary.json");
    let before = fs::metadata(&first).unwrap().modified().unwrap();
    let other = read(here.path().join("s.ron")).replace("0.5", "0.6");
    fs::write(here.path().join("other.ron"), other).unwrap();
    for more in [&["--gather"] as &[&str], &["--list"], &["--task", "1/2"], &["--script", "slurm"], &[]] {
        let call = [&["sweep", "other.ron", "--out", "out/s"], more].concat();
        assert_refused(&siloflow(here.path(), &call), &["another file", "--force"]);
    }
    // With --force runs that both sweeps have in common are kept, and others are replaced.
    assert!(short(2).status.success());
    assert_eq!(fs::metadata(&first).unwrap().modified().unwrap(), before);
    assert_eq!(read(here.path().join("out/s/results.csv")).lines().count(), 3);
    let replaced = siloflow(here.path(), &["sweep", "other.ron", "--out", "out/s", "--force"]);
    assert!(replaced.status.success(), "{}", text(&replaced.stderr));
    assert_ne!(fs::metadata(&first).unwrap().modified().unwrap(), before);
}

#[test]
fn runs_of_a_scene_that_has_changed_are_not_mixed_with_others() {
    let here = tempfile::tempdir().unwrap();
    write_sweep(here.path(), r#"Values(key: "parameters.height", values: [0.5])"#, &format!("seeds: 2, {FIGURES}"));
    assert!(siloflow(here.path(), &["sweep", "s.ron"]).status.success());
    fs::write(here.path().join("plate.ron"), SCENE.replace("Disc(10.0)", "Disc(11.0)")).unwrap();
    for more in [&[] as &[&str], &["--gather"]] {
        assert_refused(&siloflow(here.path(), &[&["sweep", "s.ron"], more].concat()), &["another scene", "`mass"]);
    }
    let list = text(&siloflow(here.path(), &["sweep", "s.ron", "--list"]).stdout);
    assert!(list.contains("of another scene: mass"), "{list}");
    assert!(siloflow(here.path(), &["sweep", "s.ron", "--force"]).status.success());
    // A comment and other layout change nothing.
    let same = format!("// a comment\n{}", SCENE.replace("Disc(10.0)", "Disc( 11.0 )"));
    fs::write(here.path().join("plate.ron"), same).unwrap();
    fs::write(here.path().join("s.ron"), format!("// a comment\n{}\n", read(here.path().join("s.ron")))).unwrap();
    let again = siloflow(here.path(), &["sweep", "s.ron"]);
    assert!(again.status.success(), "{}", text(&again.stderr));
}

#[test]
fn tasks_of_an_array_do_every_run_once_and_are_gathered() {
    let here = tempfile::tempdir().unwrap();
    write_sweep(
        here.path(),
        r#"Values(key: "parameters.height", values: [0.5, 0.6, 0.7])"#,
        &format!("seeds: 2, {FIGURES}"),
    );
    let runs = || -> BTreeSet<String> {
        let runs = fs::read_dir(here.path().join("out/s/runs")).unwrap();
        runs.map(|run| run.unwrap().file_name().into_string().unwrap()).collect()
    };
    let mut before = BTreeSet::new();
    for task in 1..=4 {
        let output = siloflow(here.path(), &["sweep", "s.ron", "--task", &format!("{task}/4")]);
        assert!(output.status.success() && output.stdout.is_empty(), "{}", text(&output.stderr));
        let now = runs();
        assert_eq!(now.len() - before.len(), if task <= 2 { 2 } else { 1 });
        before = now;
        if task == 1 {
            let partial = siloflow(here.path(), &["sweep", "s.ron", "--gather"]);
            assert_eq!(partial.status.code(), Some(1));
            assert!(text(&partial.stderr).contains("run 0001-2 (parameters.height = 0.5, seed 2) has no result"));
            assert!(read(here.path().join("out/s/results.csv")).contains("0001-2,1,2,0.5,missing,,,"));
        }
    }
    assert!(siloflow(here.path(), &["sweep", "s.ron", "--gather"]).status.success());
    let gathered = read(here.path().join("out/s/table.csv"));
    assert!(siloflow(here.path(), &["sweep", "s.ron", "--out", "straight"]).status.success());
    assert_eq!(gathered, read(here.path().join("straight/table.csv")));
}

#[test]
fn scripts_pack_runs_into_a_stated_number_of_jobs() {
    let here = tempfile::tempdir().unwrap();
    heights(here.path());
    for (jobs, expected) in [("4", 4), ("100", 15)] {
        let script = |name| {
            let output = siloflow(here.path(), &["sweep", "s.ron", "--script", name, "--jobs", jobs]);
            assert!(output.status.success(), "{}", text(&output.stderr));
            text(&output.stdout)
        };
        let slurm = script("slurm");
        assert!(slurm.contains(&format!("#SBATCH --array=1-{expected}\n")), "{slurm}");
        assert!(slurm.contains(&format!("--task \"$SLURM_ARRAY_TASK_ID/{expected}\"")), "{slurm}");
        assert!(script("parallel").contains(&format!("seq {expected} | parallel")));
        assert!(script("hyperqueue").contains(&format!("--array 1-{expected} ")));
    }
    // No run has been made, and the directory is ready.
    assert_eq!(fs::read_dir(here.path().join("out/s/runs")).unwrap().count(), 0);
}

#[test]
#[cfg(unix)]
fn the_script_of_slurm_runs_in_a_shell_with_odd_names() {
    let here = tempfile::tempdir().unwrap();
    let odd = here.path().join("it's a $HOME");
    fs::create_dir(&odd).unwrap();
    write_sweep(&odd, r#"Values(key: "parameters.height", values: [0.5, 0.6])"#, &format!("seeds: 1, {FIGURES}"));
    let script = siloflow(&odd, &["sweep", "s.ron", "--script", "slurm", "--jobs", "2"]);
    fs::write(here.path().join("job.sh"), &script.stdout).unwrap();
    // Slurm starts a copy of the script with the number of the task.
    for (task, argument) in [("1", ""), ("2", ""), ("1", "gather")] {
        let status = Command::new("sh")
            .args(["job.sh", argument])
            .env("SLURM_ARRAY_TASK_ID", task)
            .current_dir(here.path())
            .status()
            .unwrap();
        assert!(status.success());
    }
    assert_eq!(read(odd.join("out/s/results.csv")).lines().filter(|line| line.contains("time_reached")).count(), 2);
}

/// Stands for `hq submit --name NAME --array 1-N --cpus 1 --wait -- COMMAND`.
#[cfg(unix)]
const HQ: &str = r#"#!/bin/sh
while [ "$1" != -- ]; do
    if [ "$1" = --array ]; then last=${2#1-}; fi
    shift
done
shift
for task in $(seq "$last"); do HQ_TASK_ID=$task "$@" || exit 1; done
"#;

#[test]
#[cfg(unix)]
fn the_script_of_hyperqueue_runs_in_a_shell_with_odd_names() {
    use std::os::unix::fs::PermissionsExt as _;
    let here = tempfile::tempdir().unwrap();
    let odd = here.path().join("it's a $HOME");
    fs::create_dir(&odd).unwrap();
    write_sweep(&odd, r#"Values(key: "parameters.height", values: [0.5, 0.6])"#, &format!("seeds: 2, {FIGURES}"));
    let script = siloflow(&odd, &["sweep", "s.ron", "--script", "hyperqueue", "--jobs", "3"]);
    fs::write(here.path().join("jobs.sh"), &script.stdout).unwrap();
    fs::write(here.path().join("hq"), HQ).unwrap();
    fs::set_permissions(here.path().join("hq"), fs::Permissions::from_mode(0o755)).unwrap();
    let path = format!("{}:{}", here.path().display(), std::env::var("PATH").unwrap());
    let run = Command::new("sh").arg("jobs.sh").env("PATH", path).current_dir(here.path()).output().unwrap();
    assert!(run.status.success() && run.stderr.is_empty(), "{}", text(&run.stderr));
    assert_eq!(read(odd.join("out/s/results.csv")).lines().filter(|line| line.contains("time_reached")).count(), 4);
}

#[test]
fn two_sweeps_in_one_directory_share_the_work() {
    let here = tempfile::tempdir().unwrap();
    heights(here.path());
    let start = || {
        Command::new(env!("CARGO_BIN_EXE_siloflow"))
            .args(["-q", "sweep", "s.ron", "--cores", "1"])
            .current_dir(here.path())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    };
    let both = [start(), start()];
    for child in both {
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success() && output.stderr.is_empty(), "{}", text(&output.stderr));
    }
    // A run that were done twice would have been refused or replaced, with a message in its log.
    for log in fs::read_dir(here.path().join("out/s/logs")).unwrap() {
        assert_eq!(read(log.unwrap().path()), "");
    }
    assert_eq!(
        read(here.path().join("out/s/results.csv")).lines().filter(|line| line.contains("time_reached")).count(),
        15
    );
}

#[test]
fn sweeps_that_start_at_once_agree_on_a_new_directory() {
    let here = tempfile::tempdir().unwrap();
    heights(here.path());
    let sweep = Sweep::read(&here.path().join("s.ron")).unwrap();
    for round in 0..50 {
        let path = here.path().join(format!("new-{round}"));
        let gate = Barrier::new(8);
        thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    gate.wait();
                    SweepDirectory::prepare(&path, &sweep, false).unwrap();
                });
            }
        });
    }
}

#[test]
fn a_latin_hypercube_reaches_the_runs() {
    let here = tempfile::tempdir().unwrap();
    let cube = r#"latin_hypercube: (samples: 3, keys: [(key: "parameters.height", low: 0.5, high: 0.8)])"#;
    write_sweep(here.path(), "", &format!("{cube}, seeds: 1, {FIGURES}"));
    assert!(siloflow(here.path(), &["sweep", "s.ron"]).status.success());
    let results = read(here.path().join("out/s/results.csv"));
    let parts = results.lines().skip(1).map(|line| {
        let height: f64 = line.split(',').nth(3).unwrap().parse().unwrap();
        ((height - 0.5) / 0.1) as u32
    });
    assert_eq!(parts.collect::<BTreeSet<_>>(), BTreeSet::from([0, 1, 2]), "{results}");
}

#[test]
fn a_run_as_a_function_call_has_the_figures_of_the_program() {
    let here = tempfile::tempdir().unwrap();
    write_sweep(here.path(), "", "seeds: 1, figures: []");
    let settings = [("parameters.height".to_owned(), "0.6".to_owned()), ("seed".to_owned(), "4".to_owned())];
    let registry = siloflow::behaviour::Registry::default();
    let called =
        siloflow::simulation::evaluate::evaluate(&here.path().join("plate.ron"), &settings, &registry).unwrap();
    let output =
        siloflow(here.path(), &["-q", "run", "plate.ron", "--set", "parameters.height=0.6", "--seed", "4", "--json"]);
    let printed: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    for key in ["state_hash", "energy", "steps", "grains"] {
        assert_eq!(called[key], printed[key], "{key}");
    }
    let wrong = [("parameters.hight".to_owned(), "0.6".to_owned())];
    assert!(siloflow::simulation::evaluate::evaluate(&here.path().join("plate.ron"), &wrong, &registry).is_err());
}

#[test]
fn the_shipped_sweep_is_valid() {
    let here = tempfile::tempdir().unwrap();
    let path = crate::scene("sweeps/beverloo.ron").display().to_string();
    let output = siloflow(here.path(), &["sweep", &path, "--list"]);
    assert!(output.status.success() && !text(&output.stderr).contains("check::"), "{}", text(&output.stderr));
    assert!(text(&output.stdout).ends_with("15 runs: 5 points, 3 seeds\n"), "{}", text(&output.stdout));
}
