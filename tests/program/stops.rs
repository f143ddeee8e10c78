//! Conditions that end a run: `stop`. The scene drops three grains through a door and keeps four on a floor beside it, so the number
//! that leaves is known.

use std::fs;
use std::num::NonZeroUsize;
use std::path::Path;
use std::process::Command;

use siloflow::door::DoorState;
use siloflow::ending::stop::avalanches::Avalanches;
use siloflow::energy::EnergyFlows;
use siloflow::measure::totals;
use siloflow::prelude::*;
use siloflow::rest::RestDetector;
use siloflow::scene::check;
use siloflow::text::fault::Fault;

use crate::command_line::text;
use crate::{hash, simulation};

const DOOR: &str = "2 9\n-0.1 0 0.01\n0.1 0 0.01\n-0.08 0 0.01\n-0.06 0 0.01\n-0.04 0 0.01\n-0.02 0 0.01\n0 0 0.01\n0.02 0 0.01\n\
                    0.04 0 0.01\n0.06 0 0.01\n0.08 0 0.01\n";

/// The column of three grains above the door.
const COLUMN: &str = "(low: (-0.035, 0.02), high: (0.035, 0.23), spacing: 0.07, radius: Fixed(0.03)),";

const DT: f64 = 1.0e-4;

fn scene(more: &str) -> String {
    format!(
        "(gravity: (0.0, -9.81), contact: Linear(k: 1.0e4, damping: B(5.0)), mass: ArealSquare(100.0), integrator: Verlet,
        step: Fixed({DT}), silo: (file: \"door.dat\", unit: Metre), door: (opens: At(0.2)), cull: (below: -0.3),
        walls: [Segment(from: (-1.0, 0.0), to: (-0.1, 0.0)), Segment(from: (1.0, 0.0), to: (0.1, 0.0))],
        fill: [{COLUMN} (low: (-0.8, 0.0), high: (-0.5, 0.075), spacing: 0.075, radius: Fixed(0.03))],
        until: 5.0, pictures: None, {more})"
    )
}

fn loaded(text: &str) -> Result<Loaded, Fault> {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("door.dat"), DOOR).unwrap();
    load::from_text("a.ron", "a", here.path(), text.to_owned(), &[])
}

fn run(text: &str) -> (End, Simulation) {
    let mut run = simulation(&loaded(text).unwrap(), 1);
    (run.run(), run)
}

/// Simulated time, and numbers of grains inside and out.
fn result(run: &Simulation) -> (f64, u32, u32) {
    let ledger = run.world().resource::<Ledger>();
    (run.world().resource::<Clock>().time(), ledger.inside(), ledger.out())
}

fn last_out(run: &Simulation) -> f64 {
    run.world().resource::<Ledger>().departures.last().unwrap()
}

#[test]
fn a_flow_ends_a_stated_time_after_the_last_grain() {
    let (end, run) = run(&scene("stop: [EndOfFlow(still: 0.5)]"));
    let (time, inside, out) = result(&run);
    assert_eq!((end, inside, out), (End::FlowEnded { still_s: 0.5 }, 4, 3));
    assert!(last_out(&run) > 0.2 && (time - last_out(&run) - 0.5).abs() < 1.5 * DT, "{time}");
}

#[test]
fn a_flow_that_never_begins_ends_after_the_opening_of_the_door() {
    let (end, run) = run(&scene("stop: [EndOfFlow(still: 0.5)]").replace(COLUMN, ""));
    let (time, inside, out) = result(&run);
    assert_eq!((end, inside, out), (End::FlowEnded { still_s: 0.5 }, 4, 0));
    let open = run.world().resource::<DoorState>().open_time().unwrap();
    assert!(open >= 0.2 && (time - open - 0.5).abs() < 1.5 * DT, "{time}");
}

#[test]
fn a_number_of_grains_ends_the_run_in_the_step_in_which_the_last_of_them_leaves() {
    for stop in ["Out(2)", "EndOfFlow(still: 0.5), Out(2)", "Out(2), EndOfFlow(still: 0.5)"] {
        let (end, run) = run(&scene(&format!("stop: [{stop}]")));
        let (time, inside, out) = result(&run);
        assert_eq!((end, inside, out, time), (End::OutReached { count: 2 }, 5, 2, last_out(&run)), "{stop}");
    }
}

#[test]
fn without_conditions_and_without_a_condition_that_holds_the_time_ends_the_run() {
    let (end, mut plain) = run(&scene(""));
    assert_eq!((end, result(&plain).0), (End::TimeReached, 5.0));
    let (end, mut waiting) = run(&scene("stop: [Out(8)]"));
    assert_eq!((end, hash(&mut waiting)), (End::TimeReached, hash(&mut plain)));
}

#[test]
fn rest_ends_the_run_by_either_key() {
    let rest = "rest: (speed: 2.0e-3, energy: 1.0e-6, hold: 0.05";
    let ends = [format!("{rest}, stop: true)"), format!("{rest}), stop: [AtRest]")].map(|keys| {
        // The door stays closed, and the bed rests on it.
        let (end, mut run) = run(&scene(&keys).replace("At(0.2)", "Never"));
        let rest = run.world().resource::<RestDetector>().rest_time;
        assert_eq!((end, Some(result(&run).0)), (End::AtRest, rest), "{keys}");
        hash(&mut run)
    });
    assert_eq!(ends[0], ends[1]);
}

#[test]
fn a_resumed_run_ends_in_the_same_step() {
    let text = scene("stop: [EndOfFlow(still: 0.5)]");
    let (end, mut whole) = run(&text);
    let loaded = loaded(&text).unwrap();
    let mut first = simulation(&loaded, 1);
    // After the last grain has left, within the half second.
    let steps = (last_out(&whole) / DT).round() as u64 + 1000;
    assert_eq!(first.run_steps(steps), None);
    let saved = first.save().unwrap();
    let mut second = Simulation::restored(&loaded, &Registry::default(), NonZeroUsize::MIN, &saved).unwrap();
    assert_eq!(second.run(), end);
    assert_eq!((result(&second), hash(&mut second)), (result(&whole), hash(&mut whole)));
}

#[test]
fn conditions_that_cannot_hold_are_refused_or_warned_of() {
    let closed = |keys: &str| scene(keys).replace("At(0.2)", "Never");
    for (text, code, message) in [
        (scene("stop: [Out(1), AtRest]"), "scene::missing_key", "nothing detects rest"),
        (closed("stop: [Out(1), EndOfFlow(still: 1.0)]"), "scene::no_door", "no door opens"),
        (scene("stop: [Out(1), Out(0)]"), "scene::out_of_range", "at least 1"),
        (scene("stop: [Out(1), EndOfFlow(still: 0.0)]"), "scene::out_of_range", "greater than 0"),
    ] {
        let fault = loaded(&text).unwrap_err();
        assert_eq!(fault.code(), code, "{fault}");
        assert!(fault.scene_key().unwrap().starts_with("stop[1]") && fault.to_string().contains(message), "{fault}");
    }
    let outside =
        scene("stop: [Out(1)]").replace("silo: (file: \"door.dat\", unit: Metre), door: (opens: At(0.2)),", "");
    assert!(loaded(&outside).unwrap_err().to_string().contains("the scene has no door"));
    let codes = |text: &str| -> Vec<_> {
        check::warnings(&loaded(text).unwrap()).into_iter().map(|warning| warning.code).collect()
    };
    assert!(codes(&scene("stop: [Out(8)]")).contains(&"check::stop_out_of_reach"));
    assert!(!codes(&scene("stop: [Out(7)]")).contains(&"check::stop_out_of_reach"));
}

fn siloflow(directory: &Path, arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_siloflow")).args(arguments).current_dir(directory).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    text(&output.stdout)
}

#[test]
fn the_summary_names_the_condition_and_what_is_left() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("door.dat"), DOOR).unwrap();
    fs::write(here.path().join("a.ron"), scene("stop: [EndOfFlow(still: 0.25)]")).unwrap();
    fs::write(here.path().join("b.ron"), scene("")).unwrap();
    let words = siloflow(here.path(), &["run", "a.ron"]);
    assert!(words.contains("stopped      no grain has left for 0.25 s; 4 grains inside, 0.3600 kg\n"), "{words}");
    let summary: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(here.path().join("out/a/summary.json")).unwrap()).unwrap();
    assert_eq!((&summary["status"], &summary["stop"]), (&"end_of_flow".into(), &"no grain has left for 0.25 s".into()));
    // Four grains of rho R^2 = 0.09 kg.
    assert!((summary["grains"]["inside_kg"].as_f64().unwrap() - 0.36).abs() < 1e-12);
    // The run is over: its checkpoint is the final one.
    let again = Command::new(env!("CARGO_BIN_EXE_siloflow"))
        .args(["run", "--resume", "out/a"])
        .current_dir(here.path())
        .output()
        .unwrap();
    assert!(text(&again.stderr).contains("checkpoint::final"), "{}", text(&again.stderr));
    let [with, without] = ["a.ron", "b.ron"].map(|scene| siloflow(here.path(), &["explain", scene]));
    assert!(
        with.lines().any(|line| line.contains("stop::conditions::end_by_flow") && line.ends_with(" stop")),
        "{with}"
    );
    assert!(!without.contains("stop::"), "{without}");
}

/// A grain too wide for the door, above the column.
const PLUG: &str = "(low: (-0.15, 0.3), high: (0.15, 0.6), spacing: 0.3, radius: Fixed(0.15)),";

/// A scene whose contacts are stiff enough to bear the plug.
fn stiff(more: &str) -> String {
    scene(more).replace("k: 1.0e4, damping: B(5.0)", "k: 1.0e6, damping: B(50.0)")
}

#[test]
fn a_grain_that_blocks_the_outlet_is_a_clog_and_a_dead_zone_is_none() {
    // Three grains leave, and the plug stays on the orifice. `Clogged` has precedence.
    for stop in ["Clogged(still: 0.5)", "EndOfFlow(still: 0.5), Clogged(still: 0.5)"] {
        let (end, run) = run(&stiff(&format!("stop: [{stop}]")).replace(COLUMN, &format!("{COLUMN} {PLUG}")));
        assert_eq!(end, End::Clogged { still_s: 0.5, above: 1, avalanche: 3 }, "{stop}");
        let (time, inside, _) = result(&run);
        assert!(inside == 5 && (time - last_out(&run) - 0.5).abs() < 1.5 * DT, "{time}");
    }
    // The plug alone lets nothing through: an avalanche of no grain.
    let (end, _) = run(&stiff("stop: [Clogged(still: 0.5)]").replace(COLUMN, PLUG));
    assert_eq!(end, End::Clogged { still_s: 0.5, above: 1, avalanche: 0 });
    // Grains beside the orifice do not clog it.
    let (end, _) = run(&stiff("stop: [Clogged(still: 0.5)]").replace("until: 5.0", "until: 2.0"));
    assert_eq!(end, End::TimeReached);
    let (end, _) = run(&stiff("stop: [Clogged(still: 0.5), EndOfFlow(still: 0.6)]"));
    assert_eq!(end, End::FlowEnded { still_s: 0.6 });
}

#[test]
fn a_clog_is_in_the_summary_and_needs_a_door_that_opens() {
    let fault = loaded(&stiff("stop: [Clogged(still: 0.5)]").replace("At(0.2)", "Never")).unwrap_err();
    assert_eq!((fault.code(), fault.scene_key()), ("scene::no_door", Some("stop[0]")), "{fault}");
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("door.dat"), DOOR).unwrap();
    fs::write(here.path().join("a.ron"), stiff("stop: [Clogged(still: 0.3)]").replace(COLUMN, PLUG)).unwrap();
    let output =
        Command::new(env!("CARGO_BIN_EXE_siloflow")).args(["run", "a.ron"]).current_dir(here.path()).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("clogged: no grain has left for 0.3 s, and 1 are above it"));
    let summary = fs::read_to_string(here.path().join("out/a/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(summary["status"], "clogged");
    assert_eq!(summary["clog"], serde_json::json!({ "grains_above": 1, "avalanche_grains": 0 }));
}

#[test]
fn kicks_end_avalanches_and_do_the_work_of_their_force() {
    // Each wait is long enough for the plug to come to rest.
    let kick = "kick: (still: 1.5, acceleration: (0.0, 20.0), duration: 0.05, reach: 0.3, most: 2), stop: [Clogged(still: 2.0)]";
    let scene = stiff(kick).replace("B(50.0)", "B(400.0)").replace("until: 5.0", "until: 9.0");
    let (end, run) = run(&scene.replace(COLUMN, &format!("{COLUMN} {PLUG}")));
    assert_eq!(end, End::Clogged { still_s: 2.0, above: 1, avalanche: 3 });
    let avalanches = &run.world().resource::<Avalanches>().all;
    assert_eq!(avalanches.iter().map(|avalanche| avalanche.grains).collect::<Vec<_>>(), [3, 0]);
    // Each of the three waits and two kicks ends within a step of its time.
    let ends = [avalanches[0].end_s, avalanches[1].end_s, result(&run).0];
    for (end, waited) in ends.into_iter().zip([1.5, 3.05, 5.1]) {
        assert!((end - last_out(&run) - waited).abs() < 5.0 * DT, "{ends:?}");
    }
    // The plug of rho R^2 = 2.25 kg rises by (a - g) t^2/2 = 0.0127 m in a kick. The springs that bear its weight add at most a speed
    // of 2 g/w0 = 0.027 m/s, with w0 = 740/s of two inclined contacts: 0.0013 m. The four grains beside are out of reach.
    let work = 2.0 * 2.25 * 20.0 * (20.0 - 9.81) * 0.05f64.powi(2) / 2.0;
    let flows = *run.world().resource::<EnergyFlows>();
    assert!((0.999..1.11).contains(&(flows.added_work / work)), "{flows:?} {work}");
    let energy = totals::of_world(run.world()).energy();
    assert!((energy - flows.expected()).abs() < 1e-3 * flows.released, "{energy} {flows:?}");
}

#[test]
fn a_kick_needs_a_door_a_force_and_a_bound() {
    let kick = "kick: (still: 0.3, acceleration: (0.0, 20.0), duration: 0.05, reach: 0.3, most: 2)";
    for (from, to, code, key) in [
        ("At(0.2)", "Never", "scene::no_door", "kick"),
        ("(0.0, 20.0)", "(0.0, 0.0)", "scene::out_of_range", "kick.acceleration"),
        ("(0.0, 20.0)", "(0.0, 20.0, 0.0)", "scene::dimension", "kick.acceleration"),
        ("most: 2", "most: 0", "scene::out_of_range", "kick.most"),
    ] {
        let fault = loaded(&scene(kick).replace(from, to)).unwrap_err();
        assert_eq!((fault.code(), fault.scene_key()), (code, Some(key)), "{fault}");
    }
}
