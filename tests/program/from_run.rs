//! `siloflow run SCENE --from DIR`: a run starts with the grains and contacts of another run.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::command_line::{siloflow, text};

/// A frictional bed of spheres in a box whose floor is the door.
const BED: &str = "(
    space: Solid,
    gravity: (0.0, 0.0, -9.81),
    contact: Linear(
        k: 2.0e4, damping: Restitution(0.2),
        tangential: Spring(k: 5.7e3, damping: OfNormal(0.5), friction: 0.5),
    ),
    integrator: Verlet,
    mass: Sphere(2500.0),
    step: Fixed(1.0e-4),
    walls: [
        HalfPlane(point: (-0.2, 0.0, 0.0), normal: (1.0, 0.0, 0.0)), HalfPlane(point: (0.2, 0.0, 0.0), normal: (-1.0, 0.0, 0.0)),
        HalfPlane(point: (0.0, -0.2, 0.0), normal: (0.0, 1.0, 0.0)), HalfPlane(point: (0.0, 0.2, 0.0), normal: (0.0, -1.0, 0.0)),
        Panel(corner: (-0.2, -0.2, 0.0), along: (0.4, 0.0, 0.0), across: (0.0, 0.4, 0.0), door: true),
    ],
    fill: [(low: (-0.2, -0.2, 0.0), high: (0.2, 0.2, 0.4), spacing: 0.08, radius: Uniform(0.025, 0.03), jitter: 0.005)],
    door: (opens: Never),
    cull: (below: -0.3),
    pictures: None,
    series: (interval: 0.005),
    until: 2.5,
)";

fn bed(here: &Path) {
    fs::write(here.join("bed.ron"), BED).unwrap();
}

fn run(here: &Path, arguments: &[&str]) {
    let output = siloflow(here, &[&["run", "--quiet"], arguments].concat());
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
}

fn summary(run: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(run.join("summary.json")).unwrap()).unwrap()
}

/// Returns a column of a CSV file.
fn column(file: &Path, name: &str) -> Vec<f64> {
    let mut reader = csv::Reader::from_path(file).unwrap();
    let index = reader.headers().unwrap().iter().position(|column| column == name).unwrap();
    reader.records().map(|record| record.unwrap()[index].parse().unwrap()).collect()
}

/// With `Verlet` and without dashpots, positions, velocities, spins and memories determine all that follows. Only the order of
/// sums may differ, so the two motions part by round-off, which collisions amplify. (With dashpots the forces of the last step
/// depend on velocities that are half a step old.)
#[test]
fn a_run_goes_on_from_another_one_as_if_it_had_not_ended() {
    let here = tempfile::tempdir().unwrap();
    let at = |name: &str| here.path().join(name).join("state.csv");
    fs::write(here.path().join("bed.ron"), BED.replace("Restitution(0.2)", "Restitution(1.0)")).unwrap();
    run(here.path(), &["bed.ron", "--until", "0.3", "--out", "half"]);
    run(here.path(), &["bed.ron", "--until", "0.4", "--out", "whole"]);
    run(here.path(), &["bed.ron", "--until", "0.1", "--out", "rest", "--from", "half"]);
    let forgetful = ["bed.ron", "--until", "0.1", "--out", "forgetful", "--set", "fill=[]", "--set"];
    run(here.path(), &[&forgetful[..], &["grains=(file: \"half/state.csv\")"]].concat());
    for name in ["x", "y", "z", "vx", "vz", "wx"] {
        let [whole, rest, forgetful] = ["whole", "rest", "forgetful"].map(|run| column(&at(run), name));
        let size = whole.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        let off = |other: &[f64]| whole.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / size;
        assert_eq!(whole.len(), rest.len());
        assert!(off(&rest) < 1e-9, "{name}: {}", off(&rest));
        // Without the memories of contacts the bed moves otherwise, so the bound above means something.
        assert!(off(&forgetful) > 1e-6, "{name}: {}", off(&forgetful));
    }
}

#[test]
fn one_settled_bed_serves_many_discharges() {
    let here = tempfile::tempdir().unwrap();
    bed(here.path());
    run(here.path(), &["bed.ron", "--out", "settled"]);
    let settled = summary(&here.path().join("settled"));
    for (out, friction) in [("rough", "0.5"), ("smooth", "0.1")] {
        let friction = format!("contact.tangential.friction={friction}");
        let discharge =
            ["bed.ron", "--from", "settled", "--set", "door.opens=At(0.0)", "--set", &friction, "--until", "0.4"];
        run(here.path(), &[&discharge[..], &["--out", out]].concat());
        let own = here.path().join(out);
        let found = summary(&own);
        assert_eq!(found["grains"]["released"], settled["grains"]["released"], "{out}");
        assert!(found["grains"]["out"].as_u64().unwrap() > 20, "{out}: {}", found["grains"]);
        let parent = &found["parent"];
        assert_eq!(parent["run"], here.path().join("settled").canonicalize().unwrap().display().to_string());
        for key in ["state_hash", "steps", "time_s"] {
            assert_eq!(parent[key], settled[key], "{out}: {key}");
        }
        // The run directory has all that it takes to repeat the run.
        run(here.path(), &[&format!("{out}/scene.ron"), "--out", "again", "--force"]);
        let again = summary(&here.path().join("again"));
        assert_eq!(again["state_hash"], found["state_hash"], "{out}");
        assert!(
            fs::read_to_string(own.join("scene.ron")).unwrap().starts_with("// The grains and contacts at the start")
        );
    }
    // Contacts of the settled bed are at rest at once; without their memories the bed settles anew.
    run(here.path(), &["bed.ron", "--from", "settled", "--until", "0.1", "--out", "still"]);
    let forgetful = ["bed.ron", "--until", "0.1", "--out", "forgetful", "--set", "fill=[]", "--set"];
    run(here.path(), &[&forgetful[..], &["grains=(file: \"settled/state.csv\")"]].concat());
    let most =
        |run: &str| column(&here.path().join(run).join("series.csv"), "kinetic_j").into_iter().fold(0.0, f64::max);
    assert!(most("still") < 0.05 * most("forgetful"), "{} {}", most("still"), most("forgetful"));
}

#[test]
fn grains_that_have_left_stay_away_and_new_ones_get_new_ids() {
    let here = tempfile::tempdir().unwrap();
    let silo = crate::scene("silo1.ron").display().to_string();
    let half = ["--set", "spawner.count=60", "--set", "door.opens=At(3.5)", "--set", "cull=None", "--until", "4.5"];
    run(here.path(), &[&[&silo, "--out", "half"], &half[..]].concat());
    let before = summary(&here.path().join("half"));
    assert!(before["grains"]["out"].as_u64().unwrap() > 0, "{}", before["grains"]);
    let more = [
        "--set",
        "spawner.count=10",
        "--set",
        "door.opens=Never",
        "--set",
        "watchdog=None",
        "--set",
        "on_loss=Continue",
    ];
    // A grain in the doorway may be pushed out through the closed door.
    siloflow(
        here.path(),
        &[&["run", &silo, "--quiet", "--until", "1.0", "--from", "half", "--out", "more"], &more[..]].concat(),
    );
    let after = summary(&here.path().join("more"));
    assert_eq!(after["grains"]["released"], before["grains"]["inside"].as_u64().unwrap() + 10);
    let mut ids = column(&here.path().join("more/state.csv"), "id");
    let count = ids.len();
    ids.dedup();
    assert_eq!(ids.len(), count);
}

#[test]
fn a_run_that_cannot_be_a_parent_is_refused() {
    let here = tempfile::tempdir().unwrap();
    bed(here.path());
    let refused = |arguments: &[&str]| {
        let output = siloflow(here.path(), &[&["run", "--quiet", "--out", "new"], arguments].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {}", text(&output.stderr));
        assert!(!here.path().join("new").exists());
        text(&output.stderr).split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
    };
    assert!(refused(&["bed.ron", "--from", "nowhere"]).contains("nowhere holds no run"));
    let gas = crate::scene("funnel-flow.ron").display().to_string();
    run(here.path(), &[&gas, "--until", "3", "--out", "gas"]);
    assert!(refused(&["bed.ron", "--from", "gas"]).contains("gas is a run of the lattice gas"));
    run(here.path(), &["bed.ron", "--until", "0.01", "--out", "without", "--set", "checkpoint=None"]);
    assert!(refused(&["bed.ron", "--from", "without"]).contains("without holds no checkpoint"));
    run(here.path(), &["bed.ron", "--until", "0.01", "--out", "with"]);
    assert!(refused(&[&gas, "--from", "with"]).contains("cannot start from grains"));
    // The parent of another space.
    let plane = crate::scene("silo1.ron").display().to_string();
    let said = refused(&[&plane, "--from", "with"]);
    assert!(said.contains("planar"), "{said}");
}

/// A rough floor of fixed grains at random offsets, under grains that fall. The floor is the second entry of `fill`.
const ROUGH: &str = "(
    gravity: (0.0, -9.81), contact: Linear(k: 1.0e5, damping: Restitution(0.5)), mass: Disc(20.0), integrator: Verlet,
    step: Fixed(1.0e-4), periodic: (x: (0.0, 1.0)), pictures: None, until: 0.1, seed: 3,
    fill: [(low: (0.0, 0.2), high: (1.0, 0.5), spacing: 0.1, radius: Uniform(0.03, 0.04), jitter: 0.01),
        (low: (0.0, 0.0), high: (1.0, 0.1), spacing: 0.1, radius: Uniform(0.03, 0.04), jitter: 0.01, fixed: true)],
)";

#[test]
fn fixed_grains_at_random_places_stay_where_they_were() {
    let here = tempfile::tempdir().unwrap();
    fs::write(here.path().join("rough.ron"), ROUGH).unwrap();
    run(here.path(), &["rough.ron", "--out", "first"]);
    run(here.path(), &["rough.ron", "--from", "first", "--out", "next"]);
    run(here.path(), &["next/scene.ron", "--from", "next", "--out", "third"]);
    let loaded = |run: &str| siloflow::scene::load::load(&here.path().join(run).join("scene.ron"), &[]).unwrap();
    let [first, next, third] = ["first", "next", "third"].map(loaded);
    assert_eq!((first.grains.len(), first.fixed.len()), (30, 10));
    for later in [next, third] {
        assert_eq!((later.grains.len(), later.fixed), (30, first.fixed.clone()));
    }
    // Another seed would move the floor under the grains.
    let other =
        siloflow(here.path(), &["run", "rough.ron", "--quiet", "--from", "first", "--out", "other", "--seed", "4"]);
    assert_eq!(other.status.code(), Some(2));
    assert!(
        text(&other.stderr).contains("scene::seed") && text(&other.stderr).contains("seed 3"),
        "{}",
        text(&other.stderr)
    );
    // A scene without such grains may have any seed.
    let even = ["--set", "fill[1].jitter=0.0", "--set", "fill[1].radius=Fixed(0.03)"];
    run(here.path(), &[&["rough.ron", "--from", "first", "--out", "even", "--seed", "4"], &even[..]].concat());
}
