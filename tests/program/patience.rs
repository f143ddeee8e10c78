//! Checks before a run have a budget of time, say what they did not examine, and hear signals.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use siloflow::dem::budget::Budget;
use siloflow::prelude::*;
use siloflow::scene::check;

use crate::command_line::{siloflow, text};

/// Grains whose radius was meant in mm: each of them overlaps all others, and pairs of 40,000 grains take minutes.
const ALL_OVERLAP: &str = "(space: Solid, gravity: (0.0, 0.0, -9.81), mass: Sphere(2500.0), step: Fixed(1.0e-5), until: 1.0,
    contact: Hertz(restitution: 0.5, tangential: Mindlin(friction: 0.3)), materials: [(young: 1.0e7, poisson: 0.3)],
    walls: [HalfSpace(point: (0.0, 0.0, -9.0), normal: (0.0, 0.0, 1.0))],
    fill: [(low: (0.0, 0.0, 0.0), high: (0.4, 0.4, 0.25), spacing: 0.01, radius: Fixed(2.0))], pictures: None, checkpoint: None)";

/// A box with a gap, a mesh with many open edges, and grains: something to do for every check.
const SMALL: &str = "(gravity: (0.0, -9.81), contact: Linear(k: 1.0e7, damping: Restitution(0.5)), mass: Disc(100.0), step: Fixed(1.0e-5), until: 1.0,
    walls: [Segment(from: (-0.5, 1.0), to: (-0.5, 0.0)), Segment(from: (0.1, 0.0), to: (0.5, 0.0)), Segment(from: (0.5, 0.0), to: (0.5, 1.0))],
    fill: [(low: (0.0, 0.2), high: (0.3, 0.5), spacing: 0.1, radius: Fixed(0.05))], cull: (below: -1.0), rest: None)";

fn warnings(scene: &str, budget: &Budget) -> Vec<(&'static str, String)> {
    let loaded = load::from_text("a.ron", "a", Path::new(""), scene.to_owned(), &[]).unwrap();
    check::warnings_within(&loaded, budget).into_iter().map(|warning| (warning.code, warning.message)).collect()
}

#[test]
fn checks_without_time_say_what_they_did_not_examine() {
    let all = warnings(SMALL, &Budget::of(Duration::from_mins(1)));
    assert!(all.iter().any(|(code, _)| *code == "check::leaky_walls"), "{all:?}");
    assert!(all.iter().all(|(code, _)| *code != "check::unfinished"), "{all:?}");
    let none = warnings(SMALL, &Budget::of(Duration::ZERO));
    let [.., (code, message)] = &none[..] else { panic!("no warning") };
    assert_eq!(*code, "check::unfinished");
    let parts = ["overlaps at the start", "grains in walls at the start, after 0 of 9 grains", "gaps in the walls"];
    assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    assert!(none.iter().all(|(code, _)| *code != "check::leaky_walls"), "{none:?}");
}

#[test]
fn a_search_that_needs_too_much_memory_is_named() {
    let long = SMALL.replace("(-0.5, 1.0), to: (-0.5, 0.0)", "(-5.0e8, 1.0), to: (-0.5, 0.0)");
    let found = warnings(&long, &Budget::usual());
    assert!(
        found.iter().any(|(code, message)| *code == "check::unfinished" && message.contains("grid of")),
        "{found:?}"
    );
}

#[test]
fn where_all_grains_overlap_the_checks_end_in_time_and_warn() {
    let start = Instant::now();
    let found = warnings(ALL_OVERLAP, &Budget::of(Duration::from_millis(500)));
    // Loading is a part of it.
    assert!(start.elapsed() < Duration::from_secs(20), "{:?}", start.elapsed());
    for code in ["check::overlaps_at_start", "check::unfinished"] {
        assert!(found.iter().any(|(found, _)| *found == code), "{found:?}");
    }
    let counted =
        |(code, message): &(&str, String)| *code == "check::overlaps_at_start" && message.starts_with("at least ");
    assert!(found.iter().any(counted), "{found:?}");
    let (_, message) = found.last().unwrap();
    assert!(message.contains("0.5 s") && message.contains("of 40000 bodies"), "{message}");
}

#[test]
fn the_first_signal_ends_a_command_that_still_checks() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("a.ron"), ALL_OVERLAP).unwrap();
    let check = ["check", "a.ron", "--patience", "600"];
    for (arguments, signal, status) in
        [(&check[..], "TERM", 143), (&check, "INT", 130), (&["run", "a.ron"], "INT", 130)]
    {
        // A job in the background of a script ignores SIGINT.
        let mut command = Command::new("env");
        command.args(["--default-signal=HUP,INT,TERM", env!("CARGO_BIN_EXE_siloflow")]).args(arguments);
        let mut running = command.current_dir(here.path()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        // The checks of `run` take five seconds.
        sleep(Duration::from_millis(1500));
        assert_eq!(running.try_wait().unwrap(), None);
        let sent = Instant::now();
        assert!(
            Command::new("kill").args([format!("-{signal}"), running.id().to_string()]).status().unwrap().success()
        );
        assert_eq!(running.wait().unwrap().code(), Some(status), "{arguments:?}");
        assert!(sent.elapsed() < Duration::from_secs(1), "{:?}", sent.elapsed());
        assert!(!here.path().join("out").exists());
    }
}

#[test]
fn patience_is_a_number_of_seconds() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("a.ron"), SMALL).unwrap();
    let check = |seconds: &str| siloflow(here.path(), &["check", "a.ron", "--patience", seconds]);
    assert!(text(&check("0").stdout).contains("check::unfinished"));
    assert!(!text(&check("1e300").stdout).contains("check::unfinished"));
    for wrong in ["-1", "nan", "long"] {
        assert_eq!(check(wrong).status.code(), Some(2), "{wrong}");
    }
}

#[test]
fn a_table_whose_slope_no_number_holds_is_refused_with_its_line() {
    let here = tempfile::tempdir().unwrap();
    let scene = "(gravity: (0.0, -9.81), contact: Linear(k: 1.0e4, damping: B(0.0)), mass: Disc(10.0), step: Fixed(1.0e-4), until: 0.01,
        walls: [Segment(from: (-1.0, 0.0), to: (1.0, 0.0), name: \"a\")], motions: [(walls: \"a\", translate: Table(file: \"t.csv\"))],
        fill: [(low: (-0.1, 0.2), high: (0.1, 0.3), spacing: 0.1, radius: Fixed(0.04))], pictures: None)";
    fs::write(here.path().join("a.ron"), scene).unwrap();
    for row in ["1e-308,10,0", "1e-308,1e308,-1e308", "1e-300,1e300,0"] {
        fs::write(here.path().join("t.csv"), format!("time_s,x,y\n0,0,0\n{row}\n")).unwrap();
        let output = siloflow(here.path(), &["check", "a.ron"]);
        assert_eq!(output.status.code(), Some(2), "{row}");
        assert!(text(&output.stderr).contains("line 3"), "{}", text(&output.stderr));
    }
}
