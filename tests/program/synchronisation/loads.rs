//! Forces and torques are components of particles only where a system uses them, or after a caller got the world.

use siloflow::particle::{GrainBundle, Particle};
use siloflow::prelude::*;
use siloflow::space::Space;

use super::{SCENES, scene, state_and_flows, with};

/// Particles with a force and particles with a torque, as counted in each step.
#[derive(Resource, Default)]
struct Counts(Vec<[usize; 2]>);

type Having<'w, 's, C> = Query<'w, 's, (), With<C>>;

/// A filter alone reads no component.
fn count<V: Space>(force: Having<Force<V>>, torque: Having<Torque<V::Spin>>, mut counts: ResMut<Counts>) {
    counts.0.push([force.iter().count(), torque.iter().count()]);
}

const FRICTION: (&str, &[(&str, &str)]) = ("couette.ron", &[("integrator", "Centred"), ("profiles", "[]")]);

fn counted(more: impl FnOnce(&mut App)) -> Simulation {
    with(&scene(FRICTION.0, FRICTION.1), |app| {
        app.init_resource::<Counts>().add_systems(Step, count::<Plane>.in_set(Phase::Observe));
        more(app);
    })
}

/// Returns the number of particles and the number of grains.
fn population(run: &mut Simulation) -> [usize; 2] {
    let world = run.world_mut();
    [world.query::<&GrainId>().iter(world).count(), world.query_filtered::<(), With<Grain>>().iter(world).count()]
}

#[test]
fn a_run_without_a_reader_has_no_such_components_until_the_caller_gets_the_world() {
    let mut run = counted(|_| {});
    run.run_steps(30);
    assert_eq!(run.world().resource::<Counts>().0, [[0, 0]; 31]);
    let all = population(&mut run);
    assert!(all[1] > 50 && all[0] > all[1], "{all:?}");
    run.run_steps(40);
    assert_eq!(run.world().resource::<Counts>().0[31..], [all; 10]);
}

#[test]
fn a_reader_gets_them_from_its_first_step_on() {
    let read = |forces: Query<&Force>, torques: Query<&Torque>| assert!(forces.iter().count() > torques.iter().count());
    let mut run = counted(|app| {
        app.add_systems(Step, read.in_set(Phase::Control));
    });
    run.run_steps(9);
    let all = population(&mut run);
    assert_eq!(run.world().resource::<Counts>().0, [all; 10]);
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
    // The first half kick is missing.
    assert!((none - 2.0 * zero).abs() < 1e-12, "{none} {zero}");
}
