//! Energy balance of scenes with many grains: dissipation is summed in some steps only.

use std::num::NonZeroUsize;

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
