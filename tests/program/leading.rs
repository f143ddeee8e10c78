//! Whether components or columns lead shows nowhere: a behaviour that does nothing makes components lead.

use std::num::NonZeroUsize;

use serde::Deserialize;
use siloflow::columns::{Columns, Slot};
use siloflow::divergence::where_they_part;
use siloflow::energy::EnergyFlows;
use siloflow::output::state_hash;
use siloflow::prelude::*;
use siloflow::space::Solid;
use siloflow::spin::Spin;

use crate::load;

/// Does nothing.
#[derive(Deserialize)]
struct Idle();

impl Behaviour for Idle {
    fn lives_in(&self, _: Dimension) -> bool {
        true
    }

    fn build(self: Box<Self>, _: &mut App) {}
}

/// A scene without pictures, led by components if `idle`.
fn scene(name: &str, settings: &[(&str, &str)], idle: bool) -> Loaded {
    let mut settings = [settings, &[("pictures", "None")]].concat();
    if idle {
        settings.push(("behaviours", "{\"idle\": ()}"));
    }
    load(name, &settings)
}

fn simulation(name: &str, settings: &[(&str, &str)], idle: bool) -> Simulation {
    let mut registry = Registry::default();
    registry.register::<Idle>("idle");
    Simulation::new(&scene(name, settings, idle), &registry, NonZeroUsize::MIN).unwrap()
}

/// State and books.
fn look(run: &mut Simulation) -> (u64, [u64; 3], usize) {
    let world = run.world_mut();
    let flows = *world.resource::<EnergyFlows>();
    let ledger = world.resource::<Ledger>();
    let counts = ledger.released as usize + ledger.out() as usize;
    let books = [flows.dissipated, flows.wall_work, flows.lifted].map(f64::to_bits);
    (state_hash::of_world(world), books, counts)
}

/// A spawner, with a discharge; friction between moving walls and periodic sides; gravity along those, in solid space; and
/// centred contacts with all of it, and without.
const SCENES: [(&str, &[(&str, &str)], [u64; 3]); 5] = [
    ("silo1.ron", &[("spawner.count", "20"), ("door.opens", "At(2.5)")], [900, 2000, 4000]),
    ("couette.ron", &[("integrator", "Verlet")], [0, 100, 400]),
    ("couette.ron", &[("integrator", "Centred")], [0, 100, 400]),
    ("chute3d.ron", &[("integrator", "Verlet")], [0, 300, 2000]),
    ("chute3d.ron", &[("integrator", "Centred")], [0, 300, 900]),
];

#[test]
fn who_leads_changes_no_bit_of_state_and_books() {
    for (name, settings, steps) in SCENES {
        let start = || [false, true].map(|idle| simulation(name, settings, idle));
        let part = |steps: u64| {
            let [columns, components] = start();
            where_they_part(columns, components, steps)
        };
        let [mut columns, mut components] = start();
        let mut before = None;
        for steps in steps {
            columns.run_steps(steps);
            components.run_steps(steps);
            let found = look(&mut columns);
            assert_eq!(found, look(&mut components), "{name}, step {steps}: {}", part(steps));
            assert_ne!(before.replace(found), Some(found), "{name}: nothing happened");
        }
    }
}

type Moving<'a> = (Entity, &'a mut Position, &'a mut Velocity, &'a mut Spin, &'a mut Force);

#[test]
fn what_is_changed_between_steps_counts() {
    let settings = [("integrator", "Verlet")];
    let run = |idle: bool, changes: bool| {
        let mut run = simulation("couette.ron", &settings, idle);
        for step in [50, 100, 150, 400] {
            run.run_steps(step);
            if !changes {
                continue;
            }
            let world = run.world_mut();
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
        look(&mut run)
    };
    let changed = run(false, true);
    assert_eq!(changed, run(true, true));
    assert_ne!(changed, run(false, false));
}

#[test]
fn a_wall_that_is_moved_between_steps_is_felt() {
    let run = |idle: bool, moves: bool| {
        let mut run = simulation("silo1.ron", &[("spawner.count", "20")], idle);
        run.run_steps(3000);
        let world = run.world_mut();
        let mut walls = world.query_filtered::<&mut Position, With<Fixed>>();
        walls.iter_mut(world).filter(|_| moves).for_each(|mut wall| wall.0.x += 0.01);
        run.run_steps(3500);
        look(&mut run)
    };
    let moved = run(false, true);
    assert_eq!(moved, run(true, true));
    assert_ne!(moved, run(false, false));
}

/// How many grains a program's own system has looked at.
#[derive(Resource, Default)]
struct Seen(usize);

type Now<V> = (
    &'static Slot,
    (&'static Position<V>, &'static Velocity<V>, &'static Force<V>),
    Option<&'static Spin<<V as Space>::Spin>>,
);

/// Components are what columns hold.
fn compare<V: Space>(columns: Res<Columns<V>>, particles: Query<Now<V>>, mut seen: ResMut<Seen>) {
    for (slot, (x, v, force), spin) in &particles {
        let body = &columns.body[slot.index()];
        assert_eq!((x.0, v.0), (body.position, body.velocity));
        assert_eq!(force.0, columns.loads.force.of(slot.index()));
        assert!(spin.is_none_or(|spin| spin.0 == columns.rotation[slot.index()].spin));
        seen.0 += 1;
    }
}

#[test]
fn a_program_s_own_systems_see_every_step() {
    fn watch<V: Space>(app: &mut App) {
        app.init_resource::<Seen>().add_systems(Step, compare::<V>.in_set(Phase::Observe));
    }
    for (name, settings, [_, steps, _]) in SCENES {
        let loaded = scene(name, settings, false);
        let add = if loaded.scene.space == Dimension::Plane { watch::<Plane> } else { watch::<Solid> };
        let registry = Registry::default();
        let mut run = Simulation::with_plugins(&loaded, &registry, NonZeroUsize::MIN, add).unwrap();
        run.run_steps(steps);
        assert!(run.world().resource::<Seen>().0 as u64 > 20 * steps, "{name}");
        let [mut without, mut with] = [simulation(name, settings, false), run];
        without.run_steps(steps);
        assert_eq!(look(&mut with), look(&mut without), "{name}");
    }
}

#[test]
fn the_world_is_up_to_date_after_every_step() {
    let mut run = simulation("chute3d.ron", &[], false);
    for _ in 0..20 {
        run.step();
        let world = run.world();
        let body = &world.resource::<Columns<Solid>>().body;
        let mut followers = world.try_query::<(&Slot, &Position<Solid>)>().unwrap();
        let up_to_date = followers.iter(world).filter(|(slot, x)| x.0 == body[slot.index()].position);
        assert_eq!(up_to_date.count(), body.len());
    }
}
