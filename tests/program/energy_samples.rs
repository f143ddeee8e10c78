//! Energy balance of scenes with many grains: dissipation is summed in some steps only.

use std::num::NonZeroUsize;
use std::path::Path;

use siloflow::energy::{Channels, EnergyFlows};
use siloflow::prelude::*;

use crate::command_line::{siloflow, text};
use crate::{hash, load, simulation};

/// A bed of frictional spheres with rolling resistance, periodic sideways, which falls on a floor.
const BED: [(&str, &str); 4] = [
    ("fill[0].count", "2500"),
    ("contact.rolling", "(k: 700.0, damping: PerMass(1.0e4), friction: 0.1)"),
    ("profiles", "[]"),
    ("pictures", "None"),
];

fn bed(every: &str) -> Loaded {
    load("bed3d.ron", &[&BED[..], &[("energy_balance_every", every)]].concat())
}

/// Dissipated energy and its parts by friction and rolling resistance, J.
fn dissipation(run: &Simulation) -> [f64; 3] {
    let channels = run.world().resource::<Channels>();
    [run.world().resource::<EnergyFlows>().dissipated, channels.tangential, channels.rolling]
}

#[test]
fn samples_change_no_bit_of_the_motion_and_hardly_the_dissipation() {
    let run = |every: &str, threads: usize| {
        let mut run = simulation(&bed(every), threads);
        run.run_steps(3000);
        (hash(&mut run), dissipation(&run))
    };
    let (state, all) = run("1", 1);
    assert!(all.iter().all(|&energy| energy > 0.0), "{all:?}");
    for (every, block) in [("None", 4.0), ("3", 3.0)] {
        let (sampled_state, sampled) = run(every, 1);
        assert_eq!(sampled_state, state, "every: {every}");
        // An impact of n steps has an error of 0.8 b/n (`energy::sampling`), and here n = 20. Each grain has had at least
        // one impact, and later ones are weaker. Five standard deviations:
        let bound = 5.0 * 0.8 * block / 20.0 / 2500f64.sqrt();
        for (sampled, all) in sampled.iter().zip(all) {
            assert!((sampled / all - 1.0).abs() < bound, "every: {every}: {sampled} J, not {all} J, bound {bound:.1e}");
        }
        // Not equal by chance: some steps were skipped.
        assert!(sampled[0].to_bits() != all[0].to_bits(), "every: {every}");
        let (_, on_two) = run(every, 2);
        assert_eq!(on_two.map(f64::to_bits), sampled.map(f64::to_bits), "every: {every}");
    }
}

#[test]
fn a_saved_run_continues_to_the_same_dissipation() {
    let loaded = bed("3");
    let mut straight = simulation(&loaded, 1);
    straight.run_steps(300);
    let mut run = simulation(&loaded, 1);
    // Saved at all places of a block.
    for steps in (50..300).step_by(7) {
        run.run_steps(steps);
        run = Simulation::restored(&loaded, &Registry::default(), NonZeroUsize::MIN, &run.save().unwrap()).unwrap();
    }
    run.run_steps(300);
    assert_eq!(hash(&mut run), hash(&mut straight));
    let [dissipated, expected] = [&run, &straight].map(dissipation);
    assert_eq!(dissipated.map(f64::to_bits), expected.map(f64::to_bits), "{dissipated:?} {expected:?}");
}

#[test]
fn samples_without_an_energy_balance_are_an_error() {
    let here = tempfile::tempdir().unwrap();
    let file = crate::scene("column.ron").display().to_string();
    let set = ["--set", "energy_balance=false", "--set", "energy_balance_every=4"];
    let output = siloflow(here.path(), &[&["check", &file], &set[..]].concat());
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("scene::no_energy_balance") && said.contains("energy_balance_every"), "{said}");
    let output = siloflow(here.path(), &["check", &file, "--set", "energy_balance_every=0"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("energy_balance_every"));
}

/// Side of a layer of spheres: 1600 of them, of which one step in four sums dissipation without demand.
const SIDE: u32 = 40;
/// Radius of the spheres, m.
const RADIUS: f64 = 0.001;
/// Restitution of their impacts.
const RESTITUTION: f64 = 0.3;

/// A layer of `side` x `side` spheres above this height, m, with a velocity, m/s.
fn layer(side: u32, low: f64, velocity: f64) -> String {
    let wide = 0.0045 * f64::from(side) + 0.001;
    format!(
        "(low: (0.0, 0.0, {low}), high: ({wide}, {wide}, {}), spacing: 0.0045, count: {}, radius: Fixed({RADIUS}), velocity: (0.0, 0.0, {velocity}))",
        low + 0.009,
        side * side
    )
}

/// Runs a scene with these layers and further keys to its end, and returns the energy that it dissipates, J.
fn dissipated(layers: &str, more: &str, every: &str) -> f64 {
    let scene = format!(
        "(space: Solid, contact: Linear(k: 1.0e3, damping: Restitution({RESTITUTION})), mass: Sphere(2500.0), step: Fixed(1.0e-5),
        fill: [{layers}], pictures: None, checkpoint: None, energy_balance_every: {every}, {more})"
    );
    let loaded =
        load::from_text("layer.ron", "layer", Path::new(""), scene, &[]).unwrap_or_else(|fault| panic!("{fault}"));
    let mut run = simulation(&loaded, 1);
    assert_eq!(run.run(), End::TimeReached, "{layers} {more}");
    run.world().resource::<EnergyFlows>().dissipated
}

const FALL: &str =
    "gravity: (0.0, 0.0, -9.81), walls: [HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))], until: 0.012";

#[test]
fn impacts_of_a_layer_in_one_step_are_seen() {
    for side in [SIDE, 101] {
        let layer = layer(side, RADIUS, -0.5);
        let [sampled, all] = ["None", "Some(1)"].map(|every| dissipated(&layer, FALL, every));
        // Each sphere loses the share 1 - e^2 of its energy in one impact. In the 32 steps of the impact the integral of the power has
        // errors of the second order in 1/32.
        let mass = 2500.0 * 4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3);
        let square = 0.25 + 2.0 * 9.81 * 0.00225;
        let expected = 0.5 * f64::from(side * side) * mass * square * (1.0 - RESTITUTION * RESTITUTION);
        assert!((all / expected - 1.0).abs() < 5e-3, "{all} J, not {expected} J");
        // The step of the first contacts is placed by their number; its power is that of a later step, up to a half of 1/32 of the power each.
        assert!((sampled / all - 1.0).abs() < 5e-3, "{side}: {sampled} J, not {all} J");
    }
}

#[test]
fn synchronous_events_are_seen() {
    // A plate under a layer at rest, which it touches.
    let plate = |start: &str| {
        format!(
            "gravity: (0.0, 0.0, 0.0), until: 0.01, motions: [(walls: \"plate\", translate: Steady((0.0, 0.0, 0.5)), from: {start})],
            walls: [Panel(corner: (-0.01, -0.01, 0.00225), along: (0.3, 0.0, 0.0), across: (0.0, 0.3, 0.0), name: \"plate\")]"
        )
    };
    let at_rest = layer(SIDE, RADIUS, 0.0);
    let cases = [
        // The second layer lands about when the first leaves the floor.
        (format!("{}, {}", layer(SIDE, RADIUS, -0.5), layer(SIDE, 0.0052, -0.9)), FALL.to_owned()),
        // A plate that meets the layer at different places of the blocks of samples.
        (at_rest.clone(), plate("0.00002")),
        (at_rest.clone(), plate("0.00101")),
        (at_rest, plate("0.00203")),
    ];
    for (layers, more) in &cases {
        let [sampled, all] = ["None", "Some(1)"].map(|every| dissipated(layers, more, every));
        assert!(all > 0.0 && (sampled / all - 1.0).abs() < 1e-2, "{more}: {sampled} J, not {all} J");
    }
}

/// Friction loads springs, and a wall that touches a bed starts at once: no contact begins or ends.
#[test]
fn a_wall_that_starts_under_a_bed_is_seen() {
    let run = |every: &str, start: &str| {
        let motion = format!("[(walls: \"plate\", translate: Steady((0.5, 0.0, 0.3)), from: {start})]");
        let scene = format!(
            "(space: Solid, gravity: (0.0, 0.0, -9.81), mass: Sphere(2500.0), step: Fixed(1.0e-5), until: 0.02,
            contact: Linear(k: 1.0e3, damping: Restitution(0.3), tangential: Spring(k: 286.0, damping: OfNormal(0.5), friction: 0.4)),
            fill: [{}], pictures: None, checkpoint: None, energy_balance_every: {every}, motions: {motion},
            walls: [Panel(corner: (-0.1, -0.1, 0.00225), along: (0.5, 0.0, 0.0), across: (0.0, 0.5, 0.0), name: \"plate\")])",
            layer(SIDE, RADIUS, 0.0)
        );
        let loaded =
            load::from_text("bed.ron", "bed", Path::new(""), scene, &[]).unwrap_or_else(|fault| panic!("{fault}"));
        let mut run = simulation(&loaded, 1);
        assert_eq!(run.run(), End::TimeReached);
        dissipation(&run)
    };
    for start in ["0.01502", "0.01505", "0.01509"] {
        let [sampled, all] = ["None", "Some(1)"].map(|every| run(every, start));
        // Without the step of the start the error is up to four of the 32 steps of an impact.
        for (sampled, all) in sampled.iter().zip(all).take(2) {
            assert!((sampled / all - 1.0).abs() < 1e-2, "from {start} s: {sampled} J, not {all} J");
        }
    }
}
