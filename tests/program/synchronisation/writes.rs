//! Writes by systems, commands and callers take effect. Systems that cannot be synchronised are refused.

use std::num::NonZeroUsize;

use siloflow::prelude::*;

use super::{scene, state_and_flows, with};

/// Components that the tests change between two steps, by entity.
type Moving<'a> = (Entity, &'a mut Position, &'a mut Velocity, &'a mut Spin, &'a mut Force);

const FRICTION: (&str, &[(&str, &str)]) = ("couette.ron", &[("integrator", "Verlet"), ("on_loss", "Continue")]);

fn change(world: &mut World, step: u64) {
    let mut grains = world.query_filtered::<Moving, With<Grain>>();
    let mut grains: Vec<_> = grains.iter_mut(world).collect();
    grains.sort_by_key(|(grain, ..)| *grain);
    let (taken, ..) = grains[7];
    let (_, x, v, spin, force) = &mut grains[20];
    match step {
        50 => v.0.x += 0.5,
        100 => (x.0.y, spin.0) = (x.0.y + 1e-4, 40.0),
        150 => (force.0.y, v.0.y) = (force.0.y + 1.0, v.0.y - 0.1),
        _ => {}
    }
    if step == 100 {
        world.despawn(taken);
    }
}

#[test]
fn change_between_steps_equals_a_change_at_the_end_of_the_step() {
    let loaded = scene(FRICTION.0, FRICTION.1);
    let steps = [50, 100, 150, 400];
    let between = |changes: bool| {
        let mut run = with(&loaded, |_| {});
        for step in steps {
            run.run_steps(step);
            if changes {
                change(run.world_mut(), step);
            }
        }
        state_and_flows(&mut run)
    };
    let at_the_end = move |world: &mut World| {
        let step = world.resource::<Clock>().steps;
        if steps.contains(&step) {
            change(world, step);
        }
    };
    let mut by_system = with(&loaded, |app| {
        app.add_systems(Step, at_the_end.in_set(Phase::Observe));
    });
    by_system.run_steps(400);
    let changed = between(true);
    assert_eq!(changed, state_and_flows(&mut by_system));
    assert_ne!(changed, between(false));
}

#[test]
fn wall_moved_between_steps_affects_grains() {
    let run = |moves: bool| {
        let mut run = with(&scene("silo1.ron", &[("spawner.count", "20")]), |_| {});
        run.run_steps(3000);
        let world = run.world_mut();
        let mut walls = world.query_filtered::<&mut Position, With<Fixed>>();
        walls.iter_mut(world).filter(|_| moves).for_each(|mut wall| wall.0.x += 0.01);
        run.run_steps(3500);
        state_and_flows(&mut run)
    };
    assert_ne!(run(true), run(false));
}

/// One disc without weight or contacts, 0.16 kg, at 3 m/s.
const FREE: &str = "(gravity: (0.0, 0.0), contact: Linear(k: 1.0e5, damping: B(0.0)), step: Fixed(1.0e-3), until: 1.0, \
     grains: (file: \"free-fall.csv\"), pictures: None)";

fn free(more: impl FnOnce(&mut App)) -> Simulation {
    let loaded = load::from_text("free.ron", "free", &crate::root().join("scenes"), FREE.to_owned(), &[]).unwrap();
    with(&loaded, more)
}

/// Returns position (m) and velocity (m/s) of the only grain, along x.
fn only(run: &mut Simulation) -> (f64, f64) {
    let world = run.world_mut();
    let (x, v) = world.query::<(&Position, &Velocity)>().single(world).unwrap();
    (x.0.x, v.0.x)
}

#[test]
fn velocity_written_in_any_phase_acts_from_the_next_drift_on() {
    let set = |velocity: f64| {
        move |clock: Res<Clock>, mut grains: Query<&mut Velocity, With<Grain>>| {
            if clock.steps == 10 {
                grains.iter_mut().for_each(|mut v| v.0.x = velocity);
            }
        }
    };
    // The drift of step 10 precedes these phases, so the velocity acts from step 11 on: 10 steps at 3 m/s and 10 at 5
    // m/s. In `Spawn` the clock shows the steps done, so there too the velocity acts from step 11 on.
    for phase in [Phase::Spawn, Phase::Drift, Phase::Forces, Phase::Kick, Phase::Control, Phase::Cull, Phase::Observe] {
        let mut run = free(|app| {
            app.add_systems(Step, set(5.0).in_set(phase));
        });
        run.run_steps(20);
        let (x, v) = only(&mut run);
        // Round-off of 20 sums of numbers below 1 m.
        assert!((x - 0.08).abs() < 1e-14 && v == 5.0, "{phase:?}: {x}");
    }
}

/// A constant force, N, and a velocity that a command inserts while the kick of the step is pending.
#[test]
fn command_may_insert_a_velocity_while_a_kick_is_pending() {
    let push = |mut grains: Query<&mut Force, With<Grain>>| grains.iter_mut().for_each(|mut force| force.0.x += 0.32);
    let insert = |clock: Res<Clock>, grains: Query<Entity, With<Grain>>, mut commands: Commands| {
        if clock.steps == 10 {
            grains.iter().for_each(|grain| {
                commands.entity(grain).insert(Velocity(Vector::new(1.0, 0.0)));
            });
        }
    };
    let mut run = free(|app| {
        app.add_systems(Step, (push.in_set(ForceStage::Added), insert.in_set(Phase::Control)));
    });
    run.run_steps(20);
    let (_, v) = only(&mut run);
    // From 1 m/s for 10 ms at 2 m/s^2: 20 sums of numbers near 1.
    assert!((v - 1.02).abs() < 1e-14, "{v}");
}

#[test]
fn grain_can_be_stopped_and_fixed_in_one_system() {
    let hold =
        |clock: Res<Clock>, mut grains: Query<(Entity, &mut Velocity), Without<Fixed>>, mut commands: Commands| {
            if clock.steps == 10 {
                for (grain, mut v) in &mut grains {
                    v.0 = Vector::ZERO;
                    commands.entity(grain).insert(Fixed);
                }
            }
        };
    let mut run = free(|app| {
        app.add_systems(Step, hold.in_set(Phase::Control));
    });
    run.run_steps(20);
    let (x, v) = only(&mut run);
    assert!((x - 0.03).abs() < 1e-15 && v == 0.0, "{x} {v}");
}

fn refusal(more: impl FnOnce(&mut App)) -> siloflow::text::fault::Fault {
    let loaded = load::from_text("free.ron", "free", &crate::root().join("scenes"), FREE.to_owned(), &[]).unwrap();
    let refused = Simulation::with_plugins(&loaded, &Registry::default(), NonZeroUsize::MIN, more);
    refused.map(|_| ()).expect_err("a system that cannot be synchronised")
}

#[test]
fn system_without_a_phase_or_in_an_engine_stage_is_refused() {
    fn read_position(_: Query<&Position>) {}
    let fault = refusal(|app| {
        app.add_systems(Step, read_position);
    });
    let said = format!("{:?}", miette::Report::new(fault.clone()));
    assert_eq!(fault.code(), "behaviour::no_phase");
    assert!(
        ["read_position", "Spawn", "Drift", "Neighbours", "Forces", "Kick", "Control", "Cull", "Observe"]
            .iter()
            .all(|word| said.contains(word)),
        "{said}"
    );
    let fault = refusal(|app| {
        app.add_systems(Step, read_position.in_set(ForceStage::Contacts));
    });
    assert_eq!(fault.code(), "behaviour::engine");
}

#[test]
fn a_spin_that_is_not_finite_and_inserted_by_a_command_stops_the_run() {
    let loaded = scene(FRICTION.0, FRICTION.1);
    let insert = |clock: Res<Clock>, grains: Query<(Entity, &GrainId), With<Grain>>, mut commands: Commands| {
        if clock.steps == 10 {
            let (grain, _) = grains.iter().min_by_key(|(_, id)| **id).unwrap();
            commands.entity(grain).insert(Spin(f64::NAN));
        }
    };
    let mut run = with(&loaded, |app| {
        app.add_systems(Step, insert.in_set(Phase::Control));
    });
    let Some(End::Failed(failure)) = run.run_steps(20) else {
        panic!("the run goes on with a spin that is not finite")
    };
    assert!(failure.to_string().starts_with("step 10: the spin of "), "{failure}");
}
