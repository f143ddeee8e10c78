//! Doors by name: each opens and shuts by its own key, and every grain that passes its place is out.

use siloflow::dem::particle::Door;
use siloflow::dem::walls::surfaces::Surfaces;
use siloflow::door::DoorState;
use siloflow::prelude::*;

use crate::{load, simulation};

/// Two bins side by side on a floor of two gates. In each bin a grain falls on the gate.
fn two_bins(doors: &str) -> Loaded {
    let text = format!(
        "(gravity: (0.0, -9.81), contact: Linear(k: 1.0e4, damping: Restitution(0.3)), mass: Disc(1.0e3), step: Fixed(1.0e-4),
        walls: [Segment(from: (0.0, 0.0), to: (1.0, 0.0), name: \"left\"), Segment(from: (1.0, 0.0), to: (2.0, 0.0), name: \"right\"),
            Segment(from: (0.0, 1.0), to: (0.0, 0.0)), Segment(from: (1.0, 1.0), to: (1.0, 0.0)),
            Segment(from: (2.0, 1.0), to: (2.0, 0.0))],
        fill: [(low: (0.3, 0.1), high: (0.7, 0.3), spacing: 0.1, radius: Fixed(0.04)),
            (low: (1.3, 0.1), high: (1.7, 0.3), spacing: 0.1, radius: Fixed(0.04))],
        doors: [{doors}], cull: (below: -1.0), until: 10.0, pictures: None)"
    );
    load::from_text("a.ron", "a", std::path::Path::new(""), text, &[]).unwrap_or_else(|fault| panic!("{fault}"))
}

/// Returns the numbers of grains out and lost after each of these times, s.
fn out_at(loaded: &Loaded, times: &[f64]) -> Vec<(u32, u32)> {
    let mut run = simulation(loaded, 1);
    let mut after = |time: &f64| {
        run.run_steps((time / 1.0e-4).round() as u64);
        let ledger = run.world().resource::<Ledger>();
        (ledger.out(), ledger.lost())
    };
    times.iter().map(&mut after).collect()
}

#[test]
fn each_door_opens_at_its_own_time() {
    let loaded = two_bins("(walls: \"right\", opens: At(1.0)), (walls: \"left\", opens: At(2.0))");
    let half = loaded.grains.len() as u32 / 2;
    assert!(half >= 4);
    assert_eq!(out_at(&loaded, &[0.9, 1.9, 3.0]), [(0, 0), (half, 0), (2 * half, 0)]);
}

#[test]
fn a_door_that_moves_lets_grains_out_and_shuts_again() {
    let how = "how: Move(by: (0.0, -0.5), speed: 100.0)";
    let loaded = two_bins(&format!(
        "(walls: \"right\", opens: At(1.0), {how}), (walls: \"left\", opens: Schedule([(0.5, 0.6), (2.0, 4.0)]), {how})"
    ));
    let half = loaded.grains.len() as u32 / 2;
    let counts = out_at(&loaded, &[0.49, 0.9, 1.9, 4.0]);
    let lost = counts.iter().map(|(_, lost)| *lost).sum::<u32>();
    assert_eq!((counts[0].0, lost), (0, 0), "{counts:?}");
    // In 0.1 s a grain falls by 5 cm, so the lowest row passes the place of the gate, and the others do not.
    assert!(counts[1].0 > 0 && counts[1].0 < half, "{counts:?}");
    assert_eq!(counts[2].0, counts[1].0 + half, "{counts:?}");
    assert_eq!(counts[3].0, 2 * half, "{counts:?}");
}

#[test]
fn a_gate_is_at_its_two_ends_exactly() {
    let loaded = two_bins(
        "(walls: \"left\", opens: Schedule([(0.1, 0.4), (0.45, 0.9)]), how: Move(by: (0.0, -0.5), speed: 2.0))",
    );
    let mut run = simulation(&loaded, 1);
    let mut height = |time: f64| {
        run.run_steps((time / 1.0e-4).round() as u64);
        run.world().resource::<Surfaces>().all[0].reference.y
    };
    assert_eq!([0.05, 0.36].map(&mut height), [0.0, -0.5]);
    // It begins to shut at 0.4 s, and opens again at 0.45 s, when it has come back by 0.05 s 2 m/s.
    assert!((height(0.45) + 0.4).abs() < 1e-12);
    assert_eq!(height(0.6), -0.5);
    assert_eq!(height(1.2), 0.0);
    let state = run.world().resource::<DoorState>();
    assert_eq!((state.openings(1), state.openings(2), state.is_open()), (Some(2), None, false));
    assert!((state.open_time().unwrap() - 0.1).abs() < 1e-9);
}

#[test]
fn the_gate_of_the_shipped_scene_lets_portions_out() {
    let loaded = load("gated-bin.ron", &[("pictures", "None")]);
    let mut run = simulation(&loaded, 1);
    let mut out = |steps: u64| {
        run.run_steps(steps);
        let ledger = run.world().resource::<Ledger>();
        assert_eq!(ledger.lost(), 0, "{:?}", ledger.lost.first());
        ledger.out()
    };
    // The gate is shut again 0.1 s after it has begun to shut: at 1.5 s.
    let [before, first, still, second] = [20_000, 30_000, 40_000, 50_000].map(&mut out);
    assert!(before == 0 && first > 20 && still == first && second > first, "{before} {first} {still} {second}");
    let world = run.world_mut();
    let doors = world.query::<&Door>().iter(world).filter(|door| door.0 == 1).count();
    assert_eq!(doors, 1);
}
