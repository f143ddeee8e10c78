//! Forces and torques are components of particles where a system uses them, or a caller gets the world.

use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};

use serde::Deserialize;
use siloflow::dem::particle::{GrainBundle, Particle};
use siloflow::prelude::*;

use super::{SCENES, scene, state_and_flows, with};

type Having<'w, 's, C> = Query<'w, 's, (), With<C>>;

/// Number of steps in which [`Check`] has looked.
static STEPS: AtomicUsize = AtomicUsize::new(0);

/// Checks in each step which particles have forces and torques: all with a reader, none without. A filter reads no component.
#[derive(Deserialize)]
struct Check {
    reads: bool,
}

impl Behaviour for Check {
    fn build(self: Box<Self>, app: &mut App) {
        let read =
            |forces: Query<&Force>, torques: Query<&Torque>| assert!(forces.iter().count() > torques.iter().count());
        if self.reads {
            app.add_systems(Step, read.in_set(Phase::Control));
        }
        let check =
            move |forces: Having<Force>, torques: Having<Torque>, all: Having<GrainId>, grains: Having<Grain>| {
                let all = [all.iter().count(), grains.iter().count()];
                let expected = if self.reads { all } else { [0, 0] };
                assert_eq!([forces.iter().count(), torques.iter().count()], expected);
                STEPS.fetch_add(1, Ordering::Relaxed);
            };
        app.add_systems(Step, check.in_set(Phase::Observe));
    }
}

#[test]
fn a_run_of_the_program_has_them_only_with_a_reader() {
    let mut registry = Registry::default();
    registry.register::<Check>("check");
    let hashes = [true, false].map(|reads| {
        let out = tempfile::tempdir().unwrap();
        let scene = crate::root().join("scenes/couette.ron");
        let run = out.path().join("run");
        let behaviours = format!("behaviours={{\"check\": (reads: {reads})}}");
        let settings = ["pictures=None", "profiles=[]", "until=2e-3", "integrator=Centred", &behaviours];
        let settings = settings.iter().flat_map(|setting| ["--set".into(), setting.into()]);
        let arguments = ["siloflow".into(), "run".into(), scene.into_os_string(), "--quiet".into(), "--out".into()];
        let arguments = arguments.into_iter().chain([run.clone().into_os_string()]).chain(settings);
        assert_eq!(siloflow::cli::run_with(&registry, arguments), ExitCode::SUCCESS);
        let summary: serde_json::Value =
            serde_json::from_slice(&std::fs::read(run.join("summary.json")).unwrap()).unwrap();
        summary["state_hash"].as_str().unwrap().to_owned()
    });
    assert_eq!(hashes[0], hashes[1]);
    // Two runs of 40 steps, with step zero.
    assert_eq!(STEPS.load(Ordering::Relaxed), 82);
}

#[test]
fn a_caller_of_the_library_finds_them_from_the_start() {
    let mut run = with(&scene("couette.ron", &[]), |_| {});
    for step in [0, 3] {
        run.run_steps(step);
        let world = run.world_mut();
        let forces = world.query::<&Force>().iter(world).count();
        let torques = world.query::<&Torque>().iter(world).count();
        let all = world.query::<&GrainId>().iter(world).count();
        let grains = world.query_filtered::<(), With<Grain>>().iter(world).count();
        assert_eq!([forces, torques], [all, grains]);
    }
}

#[test]
fn adding_them_changes_no_bit() {
    for (name, settings, steps) in SCENES {
        let loaded = scene(name, settings);
        let mut undisturbed = with(&loaded, |_| {});
        undisturbed.run_steps(steps);
        for first in [0, 7, steps / 2] {
            let mut run = with(&loaded, |_| {});
            run.run_steps(first);
            let _ = run.world_mut();
            run.run_steps(steps);
            assert_eq!(state_and_flows(&mut run), state_and_flows(&mut undisturbed), "{name}, step {first}");
        }
    }
}

#[test]
fn a_grain_that_enters_without_a_force_starts_with_its_weight() {
    let loaded = scene("free-fall.ron", &[]);
    let [none, weight, zero] = [None, Some(-9.81 * 0.5), Some(0.0)].map(|force| {
        let mut run = with(&loaded, |_| {});
        run.run_steps(3);
        let grain = GrainBundle {
            particle: Particle {
                id: GrainId::grain(900).unwrap(),
                position: Position(Vector::new(0.5, 0.5)),
                velocity: Velocity(Vector::ZERO),
                radius: Radius(0.01),
            },
            mass: Mass(0.5),
            species: Species(0),
            grain: Grain,
        };
        let entity = match force {
            None => run.world_mut().spawn(grain).id(),
            Some(force) => run.world_mut().spawn((grain, Force(Vector::new(0.0, force)))).id(),
        };
        run.run_steps(4);
        run.world().get::<Velocity>(entity).unwrap().0.y
    });
    assert_eq!(none.to_bits(), weight.to_bits());
    // The first of two equal half kicks is missing. Tolerance: two roundings.
    assert!((none - 2.0 * zero).abs() <= 2.0 * f64::EPSILON * none.abs(), "{none} {zero}");
}
