//! `siloflow estimate`: a figure with its error, wrong calls, interruptions, and windows that follow events.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

use crate::command_line::{siloflow, text};

/// Forty discs fall into a trough, come to rest, and leave through a door in its floor. A run takes a few hundredths of a second.
const SCENE: &str = r#"(
    parameters: {"stiff": 1.0e5},
    gravity: (0.0, -9.81),
    contact: Linear(k: "= stiff", damping: Restitution(0.5), tangential: Spring(k: "= stiff / 3", damping: OfNormal(0.5), friction: 0.4)),
    mass: Disc(100.0),
    integrator: Verlet,
    step: Fixed(4.0e-5),
    walls: [
        HalfPlane(point: (-0.1, 0.0), normal: (1.0, 0.0)), HalfPlane(point: (0.1, 0.0), normal: (-1.0, 0.0)),
        Segment(from: (-0.1, 0.0), to: (-0.05, 0.0), name: "floor"), Segment(from: (0.05, 0.0), to: (0.1, 0.0), name: "floor"),
        Segment(from: (-0.05, 0.0), to: (0.05, 0.0), door: true),
    ],
    fill: [(low: (-0.09, 0.02), high: (0.09, 0.4), place: Random, count: 40, radius: Uniform(0.009, 0.011))],
    rest: (speed: 0.2, energy: 1.0e-3, hold: 0.02),
    door: (opens: AtRest),
    cull: (below: -0.2),
    stop: [EndOfFlow(still: 0.3)],
    outflow: (from: AfterDoor(0.0), to: AfterDoor(0.1)),
    until: 3.0,
    series: (interval: 0.01),
    pictures: None,
)"#;

fn here(scene: &str) -> tempfile::TempDir {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("trough.ron"), scene).unwrap();
    here
}

fn estimate(here: &Path, more: &[&str]) -> Output {
    siloflow(here, &[&["estimate", "trough.ron", "--cores", "2"], more].concat())
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {}", text(&output.stderr)))
}

#[test]
fn an_estimate_has_a_value_an_interval_and_its_sources_and_runs_nothing_twice() {
    let here = here(SCENE);
    let figure = ["--figure", "series.csv: coordination, AfterRest(0) to AfterRest(0.01)", "--json"];
    let first = estimate(here.path(), &[&figure[..], &["--within", "20%"]].concat());
    assert!(first.status.success(), "{}", text(&first.stderr));
    let found = json(&first);
    let number =
        |path: &str| found.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}: {found:#}"));
    let (value, low, high) = (number("/value"), number("/interval/0"), number("/interval/1"));
    // A disc of a packing with friction has three to four contacts in the plane, and at the walls and on top fewer.
    assert!(low < value && value < high && (1.0..4.0).contains(&value), "{found:#}");
    assert!(0.5 * (high - low) <= 0.2 * value && number("/confidence") == 0.95, "{found:#}");
    assert!(found["refused"].is_null() && number("/wall_s") > 0.0 && number("/spread") > 0.0, "{found:#}");
    let sum = number("/sources/chance") + number("/sources/stiffness");
    assert!((sum - 0.5 * (high - low)).abs() < 1e-9 * value, "{found:#}");
    let runs = found["runs"].as_array().unwrap().clone();
    assert!(runs.iter().any(|run| run["softness"].as_f64().unwrap() > 1.0), "{found:#}");
    assert!(runs.iter().any(|run| run["step_share"] == 0.5), "{found:#}");
    for name in
        ["report.html", "estimate.json", "estimate.svg", "estimate.png", "runs.csv", "rungs.csv", "estimate.ron"]
    {
        assert!(here.path().join("out/trough-estimate").join(name).is_file(), "{name}");
    }
    // A narrower one has all runs of the first.
    let second = json(&estimate(here.path(), &[&figure[..], &["--within", "7%"]].concat()));
    let again = second["runs"].as_array().unwrap();
    assert!(again.len() > runs.len(), "{second:#}");
    for run in &runs {
        assert!(again.contains(run), "{run} was made again: {second:#}");
    }
}

#[test]
fn softer_runs_have_softer_springs_and_longer_steps() {
    let here = here(SCENE);
    let output = estimate(here.path(), &["--figure", "grains.out", "--within", "3"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let runs = here.path().join("out/trough-estimate/runs");
    // The first rung has the scene's own stiffness, the next 1/3.16 of it.
    let key = |run: &str, key: &str| {
        let scene = fs::read_to_string(runs.join(run).join("scene.ron")).unwrap();
        let at = scene.find(key).unwrap_or_else(|| panic!("{key}: {scene}"));
        scene[at + key.len()..].split([',', ')']).next().unwrap().trim().to_owned()
    };
    let soft = fs::read_dir(&runs).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let soft = soft.filter(|name| name.starts_with("0002-")).min().unwrap();
    assert_eq!(key(&soft, "Linear(k: "), "\"= (stiff", "an expression is kept");
    let step: f64 = key(&soft, "step: Fixed(").parse().unwrap();
    assert!((step / 4.0e-5 - 3.16f64.sqrt()).abs() < 1e-9, "{step}");
}

#[test]
fn with_growth_softer_grains_are_larger_and_a_bed_without_rest_is_told() {
    let here = here(SCENE);
    let call = ["--figure", "grains.out", "--within", "3", "--grow", "--json"];
    let found = json(&estimate(here.path(), &call));
    let runs = found["runs"].as_array().unwrap();
    let overlap = found["growth"]["overlap"].as_f64().unwrap();
    let softest = found["growth"]["softness"].as_f64().unwrap();
    assert!(runs[0]["growth"] == 0.0 && runs[0]["softness"].as_f64() == Some(softest), "{found:#}");
    for run in &runs[1..] {
        let softness = run["softness"].as_f64().unwrap();
        // Half of the further overlap; overlaps of linear springs grow with the softness. Six digits are kept.
        let expected = 0.5 * overlap * (softness - 1.0) / softest;
        assert!((run["growth"].as_f64().unwrap() - expected).abs() < 1e-5 * expected + 1e-12, "{run}");
        let of_run = here.path().join("out/trough-estimate/runs").join(run["run"].as_str().unwrap());
        let summary: Value = serde_json::from_slice(&fs::read(of_run.join("summary.json")).unwrap()).unwrap();
        assert_eq!(summary["growth"], run["growth"]);
    }
    assert!(runs.iter().any(|run| run["growth"].as_f64().unwrap() > 0.0), "{found:#}");
    // The first run is that of all later estimates.
    let again = json(&estimate(here.path(), &call));
    let again = again["runs"].as_array().unwrap();
    assert!(runs.iter().all(|run| again.contains(run)), "{again:#?}");
    assert_eq!(again.iter().filter(|run| run["growth"] == 0.0 && run["softness"] != 1.0).count(), 1);
    // Nothing is measured without rest.
    let restless = SCENE.replace("rest: (speed: 0.2, energy: 1.0e-3, hold: 0.02),", "").replace("AtRest", "At(0.5)");
    fs::write(here.path().join("trough.ron"), restless).unwrap();
    let output = estimate(here.path(), &[&call[..], &["--out", "restless"]].concat());
    assert!(text(&output.stderr).contains("radii do not grow"), "{}", text(&output.stderr));
    assert!(json(&output)["growth"].is_null());
}

#[test]
fn a_larger_silo_is_compared_with_the_runs_of_its_stiffness() {
    let here = here(SCENE);
    let figure = ["--figure", "grains.out", "--within", "3", "--json"];
    // Twice the grains: twice as many leave, but for the few that stay beside the door.
    let output = estimate(here.path(), &[&figure[..], &["--size", "fill[0].count=80", "--out", "more"]].concat());
    let found = json(&output);
    let size = &found["size"];
    let change = size["change"].as_f64().unwrap();
    assert!(output.status.success() && (30.0..=50.0).contains(&change), "{found:#}");
    assert!(size["is_significant"] == true && size["settings"][0] == "fill[0].count = 80", "{found:#}");
    let runs = found["runs"].as_array().unwrap();
    let larger: Vec<_> = runs.iter().filter(|run| run["is_larger"] == true).collect();
    assert_eq!(larger.len(), 4);
    let softest = runs.iter().filter(|run| run["softness"] == larger[0]["softness"]);
    let own: Vec<_> = softest.filter(|run| run["is_larger"] == false && run["step_share"] == 1.0).collect();
    assert!(!own.is_empty(), "{found:#}");
    let mean = |of: &[&Value]| of.iter().map(|run| run["value"].as_f64().unwrap()).sum::<f64>() / of.len() as f64;
    assert!((change - (mean(&larger) - mean(&own))).abs() < 1e-9, "{found:#}");
    // The value is that of the scene itself.
    assert!(found["value"].as_f64().unwrap() <= 40.0, "{found:#}");
    // A later end changes nothing once the flow has ended.
    let output = estimate(here.path(), &[&figure[..], &["--size", "until=3.5", "--out", "later"]].concat());
    let found = json(&output);
    assert!(found["size"]["is_significant"] == false, "{found:#}");
}

#[test]
fn a_larger_silo_without_chance_is_compared_exactly() {
    let here = tempfile::tempdir().unwrap();
    let scene = "(gravity: (0.0, -10.0), contact: Linear(k: 1.0e3, damping: Restitution(0.5)), mass: Disc(10.0), step: Fixed(1.0e-4), walls: [], \
        fill: [(low: (0.0, 0.0), high: (1.0, 1.0), spacing: 0.3, radius: Fixed(0.1), count: 2)], until: 0.1, pictures: None)";
    fs::write(here.path().join("trough.ron"), scene).unwrap();
    let output = estimate(here.path(), &["--figure", "grains.released", "--size", "fill[0].count=5", "--json"]);
    let found = json(&output);
    assert!(found["is_certain"] == true && found["value"] == 2.0, "{found:#}");
    assert!(found["size"]["change"] == 3.0 && found["size"]["error"] == 0.0, "{found:#}");
    assert!(found["size"]["is_significant"] == true, "{found:#}");
}

#[test]
fn windows_of_the_outflow_follow_the_door() {
    let here = here(SCENE);
    let output = siloflow(here.path(), &["run", "trough.ron", "--json", "--quiet"]);
    let summary = json(&output);
    let number =
        |path: &str| summary.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}: {summary:#}"));
    assert_eq!(number("/outflow/from_s"), number("/door_open_time_s"));
    assert!((number("/outflow/to_s") - number("/door_open_time_s") - 0.1).abs() < 1e-9);
    // The grains of the window, counted from the rows of the series.
    let series = fs::read_to_string(here.path().join("out/trough/series.csv")).unwrap();
    let mut rows = series.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(',').collect::<Vec<_>>());
    let header = rows.next().unwrap();
    let column = |name: &str| header.iter().position(|found| *found == name).unwrap();
    let (time, out) = (column("time_s"), column("out"));
    let rows: Vec<(f64, f64)> = rows.map(|row| (row[time].parse().unwrap(), row[out].parse().unwrap())).collect();
    let grains = number("/outflow/grains");
    let at = |t: f64| rows.iter().rfind(|row| row.0 <= t).unwrap().1;
    let end = number("/outflow/to_s");
    // A row each 0.01 s: the count lies between those of the rows around the end.
    assert!(
        at(end) <= grains && grains <= at(end + 0.011) && grains > 0.0,
        "{grains}: {} {}",
        at(end),
        at(end + 0.011)
    );
    // Shares of the grains: half of those that leave between a quarter and three quarters of all.
    let shares = ["--set", "outflow.from=Out(0.25)", "--set", "outflow.to=Out(0.75)", "--out", "shares"];
    let summary = json(&siloflow(here.path(), &[&["run", "trough.ron", "--json", "--quiet"], &shares[..]].concat()));
    let grains = summary["outflow"]["grains"].as_f64().unwrap();
    assert!((19.0..=21.0).contains(&grains), "{summary:#}");
}

#[test]
fn windows_that_no_run_can_have_are_refused() {
    for (outflow, words) in [
        ("(from: AfterDoor(0.2), to: AfterDoor(0.1))", "the window is empty"),
        ("(from: Out(0.5), to: Out(0.5))", "the window is empty"),
        ("(from: soon, to: 1.0)", "expected a time in s"),
        ("(from: 0.0, to: 9.0)", "ends at 9 s"),
        (
            "(from: Out(0.1), to: 1.0, mass_flow: (axis: (0.0, 0.0), low: 0.0, high: 0.1, centre: 0.02, wall: 0.05))",
            "known at the end",
        ),
    ] {
        let here = here(&SCENE.replace("(from: AfterDoor(0.0), to: AfterDoor(0.1))", outflow));
        let output = siloflow(here.path(), &["check", "trough.ron"]);
        assert!(
            output.status.code() == Some(2) && text(&output.stderr).contains(words),
            "{outflow}: {}",
            text(&output.stderr)
        );
    }
    for (key, words) in
        [("door: (opens: AtRest),", "no door opens"), ("rest: (speed: 0.2, energy: 1.0e-3, hold: 0.02),", "rest")]
    {
        let scene = SCENE.replace(key, if key.starts_with("door") { "door: (opens: Never)," } else { "" });
        let here = here(
            &scene
                .replace("stop: [EndOfFlow(still: 0.3)],", "")
                .replace("AfterDoor(0.0)", "AfterRest(0.0)")
                .replace("opens: AtRest", "opens: At(1.0)"),
        );
        let output = siloflow(here.path(), &["check", "trough.ron"]);
        assert!(
            output.status.code() == Some(2) && text(&output.stderr).contains(words),
            "{key}: {}",
            text(&output.stderr)
        );
    }
}

#[test]
fn wrong_calls_are_refused_and_leave_nothing() {
    for (more, words) in [
        (&["--figure", "discharge.rate_pers"][..], "did you mean `rate_per_s`"),
        (&["--figure", "series.csv: 1 s to 2 s"], "does not name one column"),
        (&["--figure", "share of clogs"], "no status"),
        (&["--figure", "grains.out", "--within", "none"], "expected a share such as 2%"),
        (&["--figure", "grains.out", "--budget", "-3s"], "unexpected argument"),
        (&["--figure", "grains.out", "--set", "parameters.stif=1"], "stiff"),
        (&["--figure", "grains.out", "--size", "parameters.grains=80"], "does not have this key"),
        (&["--figure", "grains.out", "--size", "fill[0].count=-1"], "count"),
        (&["--figure", "grains.out", "--size", "count"], "="),
        (&[], "--figure"),
    ] {
        let here = here(SCENE);
        let output = estimate(here.path(), more);
        assert_eq!(output.status.code(), Some(2), "{more:?}: {}", text(&output.stderr));
        assert!(text(&output.stderr).contains(words), "{more:?}: {}", text(&output.stderr));
        assert!(!here.path().join("out").exists(), "{more:?}");
    }
    let here = here(SCENE);
    let missing = siloflow(here.path(), &["estimate", "none.ron", "--figure", "grains.out"]);
    assert!(missing.status.code() == Some(2) && !here.path().join("out").exists(), "{}", text(&missing.stderr));
    // A directory with something else.
    fs::create_dir_all(here.path().join("out/trough-estimate/mine")).unwrap();
    let output = estimate(here.path(), &["--figure", "grains.out"]);
    assert!(output.status.code() == Some(2) && text(&output.stderr).contains("--out"), "{}", text(&output.stderr));
}

#[test]
fn a_figure_that_no_run_has_is_named_after_the_first_runs() {
    let here = here(SCENE);
    let output = estimate(here.path(), &["--figure", "wall_bands.csv: sides, pressure"]);
    assert!(
        output.status.code() == Some(1) && text(&output.stderr).contains("there is no wall_bands.csv"),
        "{}",
        text(&output.stderr)
    );
    // No grain is kicked, so that most runs lack the figure.
    let output = estimate(here.path(), &["--figure", "clog.avalanche_grains", "--json"]);
    let found = json(&output);
    assert!(
        output.status.code() == Some(1) && found["refused"].as_str().unwrap().contains("do not have the figure"),
        "{found:#}"
    );
}

#[test]
fn a_budget_bounds_the_runs_and_the_best_is_reported() {
    let here = here(SCENE);
    let figure = ["--figure", "discharge.rate_per_s", "--json", "--quiet"];
    let output = estimate(here.path(), &[&figure[..], &["--within", "0.01%", "--budget", "2s"]].concat());
    let found = json(&output);
    assert!(output.status.code() == Some(1) && found["refused"].as_str().unwrap().contains("budget"), "{found:#}");
    assert!(found["value"].as_f64().unwrap() > 0.0 && found["tighter"]["half_width"].as_f64().is_some(), "{found:#}");
    let output = estimate(here.path(), &[&figure[..], &["--budget", "2s"]].concat());
    assert!(output.status.success() && json(&output)["refused"].is_null(), "{}", text(&output.stdout));
}

#[test]
fn a_probability_has_the_interval_of_its_counts() {
    let here = here(SCENE);
    let output = estimate(here.path(), &["--figure", "share of end_of_flow", "--within", "0.3", "--json"]);
    let found = json(&output);
    let count = found["runs"].as_array().unwrap().len();
    // All runs end so, or with an empty trough: Clopper and Pearson's interval of n of n or 0 of n has an end at 1 - 0.025^(1/n).
    let reach = 1.0 - 0.025f64.powf(1.0 / count as f64);
    let [low, high] = [0, 1].map(|end| found["interval"][end].as_f64().unwrap());
    let is_certain =
        [(0.0, reach), (1.0 - reach, 1.0)].iter().any(|(a, b)| (low - a).abs() < 1e-9 && (high - b).abs() < 1e-9);
    assert!(is_certain || (low > 0.0 && high < 1.0), "{found:#}");
    assert!(output.status.success() && high - low <= 0.6 && found["not_softened"].is_string(), "{found:#}");
}

#[test]
fn a_lattice_gas_has_chance_alone() {
    let here = tempfile::tempdir().unwrap();
    let scene = crate::scene("silo2d-lattice.ron");
    let arguments = [
        "estimate",
        scene.to_str().unwrap(),
        "--set",
        "until=300",
        "--figure",
        "series.csv: out, 200 to 300",
        "--within",
        "50%",
        "--json",
    ];
    let output = siloflow(here.path(), &arguments);
    let found = json(&output);
    assert!(found["law"].is_null() && found["not_softened"].as_str().unwrap().contains("lattice"), "{found:#}");
}

/// Interrupts an estimate as soon as `count` of the directory of its runs is at least `least`.
#[cfg(unix)]
fn interrupted(here: &Path, arguments: &[&str], count: impl Fn(&Path) -> usize, least: usize) -> Output {
    let child = Command::new(env!("CARGO_BIN_EXE_siloflow"))
        .args(arguments)
        .current_dir(here)
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let runs = here.join("out/trough-estimate/runs");
    let begun = std::time::Instant::now();
    while count(&runs) < least {
        assert!(begun.elapsed().as_secs() < 120, "not so many runs");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let id = rustix::process::Pid::from_raw(i32::try_from(child.id()).unwrap()).unwrap();
    rustix::process::kill_process(id, rustix::process::Signal::INT).unwrap();
    child.wait_with_output().unwrap()
}

/// Number of directories that fulfil a condition.
#[cfg(unix)]
fn directories(of: &Path, are: impl Fn(&Path) -> bool) -> usize {
    fs::read_dir(of).map_or(0, |all| all.flatten().filter(|entry| are(&entry.path())).count())
}

#[cfg(unix)]
#[test]
fn an_interrupted_estimate_is_continued() {
    let here = here(SCENE);
    let arguments =
        ["estimate", "trough.ron", "--cores", "1", "--figure", "discharge.rate_per_s", "--within", "0.2%", "--json"];
    // Two runs are over, on a slow machine too, so that the command has read the first one.
    let over = |runs: &Path| directories(runs, |run| run.join("summary.json").is_file());
    let output = interrupted(here.path(), &arguments, over, 2);
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    let first = json(&output)["runs"].as_array().unwrap().clone();
    let again = siloflow(here.path(), &[&arguments[..arguments.len() - 3], &["--within", "15%", "--json"]].concat());
    let second = json(&again);
    assert!(again.status.success() && !first.is_empty(), "{}", text(&again.stderr));
    let second = second["runs"].as_array().unwrap();
    let kept = first.iter().filter(|run| second.contains(run)).count();
    assert!(kept >= first.len().min(second.len()).saturating_sub(2), "{kept} of {}", first.len());
}

#[cfg(unix)]
#[test]
fn an_interrupt_while_a_larger_silo_is_compared_ends_the_estimate_with_its_value() {
    let here = here(SCENE);
    let size = ["--size", "fill[0].high=(0.09, 4.0)", "--size", "fill[0].count=1000"];
    let arguments =
        [&["estimate", "trough.ron", "--cores", "1", "--figure", "grains.out", "--within", "30", "--json"][..], &size];
    // The ladder has three rungs, and so has it with half of the step: the points of the larger silo follow.
    let larger = |runs: &Path| directories(runs, |run| run.file_name().unwrap().to_string_lossy().as_ref() > "0007");
    let output = interrupted(here.path(), &arguments.concat(), larger, 1);
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    let found = json(&output);
    assert!(found["value"].is_number() && found["refused"].is_null() && found["size"]["change"].is_null(), "{found:#}");
}
