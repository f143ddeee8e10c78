//! Runs without energy balance (`energy_balance: false`): the motion is the same to the last bit, and no data are kept
//! that only the balance needs.

use std::fs;
use std::num::NonZeroUsize;

use serde_json::Value;
use siloflow::dem::instruction_set::InstructionSet;
use siloflow::dem::space::{Solid, Space};
use siloflow::dem::spin::Torque;
use siloflow::dem::store::ParticleStore;
use siloflow::energy::{Channels, EnergyFlows};
use siloflow::prelude::*;
use siloflow::studies::diff::where_they_part;

use crate::behaviours::registry;
use crate::command_line::{siloflow, text};
use crate::{hash, load, scene, simulation};

const WITHOUT: (&str, &str) = ("energy_balance", "false");

/// In this order: spawner and discharge; friction between moving walls and periodic sides, with Verlet and
/// with centred contacts; contact history in solid space, with gravity along a periodic side; a bed in solid space.
const SCENES: [(&str, &[(&str, &str)], u64); 5] = [
    ("silo1.ron", &[("spawner.count", "20"), ("door.opens", "At(2.5)")], 5_000),
    ("couette.ron", &[("integrator", "Verlet")], 400),
    ("couette.ron", &[("integrator", "Centred")], 400),
    ("chute3d.ron", &[("integrator", "Verlet"), ("profiles", "[]")], 600),
    ("bed3d.ron", &[("fill[0].count", "2500"), ("profiles", "[]")], 2_000),
];

/// Loads a scene without pictures and with further settings.
fn quiet(name: &str, settings: &[(&str, &str)], more: &[(&str, &str)]) -> Loaded {
    load(name, &[settings, more, &[("pictures", "None")]].concat())
}

#[test]
fn energy_balance_changes_no_bit_of_the_motion() {
    for (name, settings, steps) in SCENES {
        let start = |more: &[(&str, &str)], instructions: InstructionSet, threads: usize| {
            let mut run = simulation(&quiet(name, settings, more), threads);
            run.world_mut().insert_resource(instructions);
            run
        };
        let run = |more: &[(&str, &str)], instructions: InstructionSet, threads: usize| {
            let mut run = start(more, instructions, threads);
            run.run_steps(steps);
            hash(&mut run)
        };
        let with = run(&[], InstructionSet::default(), 1);
        for instructions in InstructionSet::all() {
            for threads in [1, 2] {
                let without = run(&[WITHOUT], instructions, threads);
                let part = || {
                    let [without, with] = [&[WITHOUT][..], &[]].map(|more| start(more, instructions, threads));
                    where_they_part(without, with, steps)
                };
                assert_eq!(without, with, "{name}: {instructions:?} on {threads} threads: {}", part());
            }
        }
    }
}

/// Whether a world holds data of the energy balance.
fn has_energy_data<V: Space>(world: &World) -> bool {
    let store = world.resource::<ParticleStore<V>>();
    let flows = world.contains_resource::<EnergyFlows>() || world.contains_resource::<Channels>();
    flows || store.tracks_energy || !store.loads.rolling_drag.is_empty()
}

#[test]
fn without_energy_balance_no_energy_data_are_kept() {
    let keeps_energy_data = |name: &str, more: &[(&str, &str)]| {
        let mut run = simulation(&quiet(name, &[], more), 1);
        run.run_steps(3);
        match run.world().get_resource::<ParticleStore<Solid>>() {
            Some(_) => has_energy_data::<Solid>(run.world()),
            None => has_energy_data::<Plane>(run.world()),
        }
    };
    for name in ["silo1.ron", "couette.ron", "silo2d.ron", "bed3d.ron", "chute3d.ron"] {
        assert!(keeps_energy_data(name, &[]) && !keeps_energy_data(name, &[WITHOUT]), "{name}");
    }
}

#[test]
fn run_without_energy_balance_writes_the_other_columns() {
    let here = tempfile::tempdir().unwrap();
    let file = scene("couette.ron").display().to_string();
    let set = ["--set", "energy_balance=false", "--set", "pictures=None", "--until", "0.02", "--json"];
    let output = siloflow(here.path(), &[&["run", &file, "--out", "run"][..], &set].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    let energy = summary["energy"].as_object().unwrap();
    assert!(energy["kinetic"].is_number() && energy["balance_error"].is_null() && energy["channels"].is_null());
    assert!(!energy.contains_key("dissipated") && !energy.contains_key("released"));
    let series = fs::read_to_string(here.path().join("run/series.csv")).unwrap();
    let widths: Vec<_> = series.lines().map(|line| line.split(',').count()).collect();
    assert!(widths.len() > 1 && widths.iter().all(|&width| width == 16), "{series}");
    assert!(series.contains("kinetic_j") && !series.contains("dissipated_j"));
}

#[test]
fn non_finite_values_are_found_in_their_step_without_energy_balance() {
    let file = r#"(gravity: (0.0, 0.0), contact: Linear(k: 1.0e5, damping: B(0.0)), step: Fixed(1.0e-3), until: 1.0,
         grains: (file: "free-fall.csv"), pictures: None, energy_balance: false, behaviours: {"wind": (inf)})"#;
    let loaded = load::from_text("wind.ron", "wind", &crate::root().join("scenes"), file.to_owned(), &[]).unwrap();
    let mut run = Simulation::new(&loaded, &registry(), NonZeroUsize::MIN).unwrap();
    let End::Failed(Failure::NotFinite { step, cause, .. }) = run.run() else { panic!("the run did not stop") };
    assert!(step == 1 && cause.contains("behaviour"), "{step}: {cause}");

    // A spin that is not finite comes from a torque that the test sets. A velocity that is not finite comes from a
    // contact that is too stiff for any number.
    for more in [&[][..], &[WITHOUT]] {
        let mut run = simulation(&quiet("couette.ron", &[], more), 1);
        run.run_steps(5);
        let world = run.world_mut();
        let mut torques = world.query_filtered::<&mut Torque, (With<Grain>, Without<Fixed>)>();
        torques.iter_mut(world).next().unwrap().0 = f64::NAN;
        let Some(End::Failed(Failure::NotFinite { step, quantity, .. })) = run.run_steps(8) else {
            panic!("the run did not stop")
        };
        assert_eq!((step, quantity), (6, "spin"), "{more:?}");

        let here = tempfile::tempdir().unwrap();
        fs::write(here.path().join("two.csv"), TWO).unwrap();
        let settings: Vec<_> = more.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
        let loaded = load::from_text("stiff.ron", "stiff", here.path(), STIFF.to_owned(), &settings).unwrap();
        let mut run = simulation(&loaded, 1);
        let End::Failed(Failure::NotFinite { step, quantity, cause, .. }) = run.run() else {
            panic!("the run did not stop")
        };
        assert_eq!((step, quantity), (1, "velocity"), "{cause}");
    }
}

/// Two grains that touch in the first step: F of about 1e302 N on 1e-12 kg.
const TWO: &str = "id,radius,mass,x,y,vx,vy\n1,0.04,1e-12,0.0,0.0,1.0,0.0\n2,0.04,1e-12,0.0805,0.0,0.0,0.0\n";

const STIFF: &str = "(gravity: (0.0, 0.0), contact: Hertz(restitution: 1.0), materials: [(young: 1.0e308, poisson: 0.3)], \
     integrator: Verlet, step: Fixed(1.0e-3), until: 1.0, grains: (file: \"two.csv\"), pictures: None, watchdog: None)";

#[test]
fn energy_watchdog_without_energy_balance_is_an_error() {
    let here = tempfile::tempdir().unwrap();
    let file = scene("silo1.ron").display().to_string();
    let output =
        siloflow(here.path(), &["check", &file, "--set", "energy_balance=false", "--set", "watchdog=(energy: 0.2)"]);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("scene::no_energy_balance") && said.contains("watchdog.energy"), "{said}");
    for watchdog in ["(energy: None)", "(overlap: 0.9)", "None"] {
        let watchdog = format!("watchdog={watchdog}");
        let output = siloflow(here.path(), &["check", &file, "--set", "energy_balance=false", "--set", &watchdog]);
        assert!(output.status.success(), "{watchdog}: {}", text(&output.stderr));
    }
}

#[test]
fn the_former_name_of_the_key_is_accepted_with_a_warning() {
    let here = tempfile::tempdir().unwrap();
    let file = scene("silo1.ron").display().to_string();
    let output = siloflow(here.path(), &["check", &file, "--set", "energy_books=false"]);
    let said = text(&output.stdout);
    assert!(output.status.success() && said.contains("check::renamed_key"), "{said}");
    assert!(said.contains("write `energy_balance`"), "{said}");
    let both = siloflow(here.path(), &["check", &file, "--set", "energy_books=false", "--set", "energy_balance=true"]);
    assert_eq!(both.status.code(), Some(2), "{}", text(&both.stdout));
}
