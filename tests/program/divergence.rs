//! The first difference of two runs: the report names the step, the grain and the quantity that the test changed.

use siloflow::prelude::*;
use siloflow::studies::diff::{Difference, Divergence, Pair, Quantity, where_they_part};

use crate::{load, simulation};

/// Compares two runs of a bed of spheres. After 20 steps `change` is applied to grain 7 of the second run.
fn divergence(change: impl FnOnce(EntityWorldMut)) -> Option<Divergence> {
    let settings = [("fill[0].count", "60"), ("profiles", "[]"), ("pictures", "None")];
    let [first, mut second] = [(), ()].map(|()| {
        let mut run = simulation(&load("bed3d.ron", &settings), 1);
        run.run_steps(20);
        run
    });
    let world = second.world_mut();
    let mut grains = world.query_filtered::<(Entity, &GrainId), With<Grain>>();
    let grain = grains.iter(world).find(|(_, id)| id.number() == 7).unwrap().0;
    change(world.entity_mut(grain));
    let mut pair = Pair::new(first, second).unwrap();
    let divergence = pair.first_divergence(60, |_| {});
    if divergence.is_none() {
        assert_eq!(pair.runs()[1].world().resource::<Clock>().steps, 60);
    }
    divergence
}

fn assert_found(change: impl FnOnce(EntityWorldMut), step: u64, expected: Quantity) {
    let Some(Divergence {
        step: found, difference: Difference::Particle { particle, quantity, particles, .. }, ..
    }) = divergence(change)
    else {
        panic!("the change of {expected:?} is not found")
    };
    assert_eq!((found, particle.number(), quantity, particles), (step, 7, expected, 1));
}

#[test]
fn change_of_one_bit_in_any_quantity_is_found() {
    assert_eq!(divergence(|_| {}), None);
    assert_found(|mut grain| grain.get_mut::<Position<Solid>>().unwrap().0.z = 0.02, 20, Quantity::Position);
    let next = |x: &mut f64| *x = x.next_up();
    let heavier = |mut grain: EntityWorldMut| {
        let mass = grain.get::<Mass>().unwrap().0;
        grain.insert(Mass(mass.next_up()));
    };
    assert_found(heavier, 20, Quantity::Mass);
    let larger = |mut grain: EntityWorldMut| {
        let radius = grain.get::<Radius>().unwrap().0;
        grain.insert(Radius(radius.next_up()));
    };
    assert_found(larger, 20, Quantity::Radius);
    assert_found(|mut grain| next(&mut grain.get_mut::<Velocity<Solid>>().unwrap().0.x), 20, Quantity::Velocity);
    assert_found(|mut grain| next(&mut grain.get_mut::<Spin<Solid>>().unwrap().0.y), 20, Quantity::Spin);
    assert_found(|mut grain| next(&mut grain.get_mut::<Force<Solid>>().unwrap().0.z), 20, Quantity::Force);
    assert_found(|mut grain| next(&mut grain.get_mut::<Torque<Solid>>().unwrap().0.z), 20, Quantity::Torque);
    assert_found(|grain| grain.despawn(), 20, Quantity::Presence);
}

/// Forces and torques, which the state hash does not contain, have the same bits as well.
#[test]
fn searches_threads_and_energy_balance_cause_no_difference() {
    let scenes: [(&str, &[(&str, &str)], u64); 3] = [
        ("silo1.ron", &[("spawner.count", "40"), ("door.opens", "At(2.5)")], 3_000),
        ("bed3d.ron", &[("fill[0].count", "60"), ("profiles", "[]"), ("integrator", "Centred")], 1_500),
        ("couette.ron", &[("profiles", "[]")], 200),
    ];
    for (name, settings, steps) in scenes {
        let start = |more: (&str, &str), threads: usize| {
            let settings = [settings, &[("pictures", "None"), more]].concat();
            simulation(&load(name, &settings), threads)
        };
        let usual = ("on_loss", "Stop");
        for (more, threads) in [(("neighbours", "AllPairs"), 1), (("energy_balance", "false"), 1), (usual, 2)] {
            let mut pair = Pair::new(start(more, threads), start(usual, 1)).unwrap();
            assert_eq!(pair.first_divergence(steps, |_| {}), None, "{name}: {more:?} on {threads} threads");
        }
    }
}

#[test]
fn order_of_table_rows_causes_no_difference() {
    #[derive(Component)]
    struct Marker;
    let add_marker = |mut grain: EntityWorldMut| {
        grain.insert(Marker);
    };
    assert_eq!(divergence(add_marker), None);
}

#[test]
fn run_that_ends_earlier_differs_by_its_end() {
    let [first, second] = ["0.1", "0.2"].map(|until| simulation(&load("free-fall.ron", &[("until", until)]), 1));
    let mut pair = Pair::new(first, second).unwrap();
    let found = pair.first_divergence(u64::MAX, |_| {}).unwrap();
    assert_eq!((found.step, &found.difference), (100, &Difference::End { ends: [Some(End::TimeReached), None] }));
    assert!(found.to_string().ends_with("first   time_reached\n  second  goes on"), "{found}");
}

#[test]
fn runs_at_different_steps_are_not_compared() {
    let [first, mut second] = [(), ()].map(|()| simulation(&load("free-fall.ron", &[]), 1));
    second.step();
    assert_eq!(Pair::new(first, second).err().unwrap().code(), "divergence::clock");
}

#[test]
fn where_they_part_describes_the_first_difference() {
    let start = |name: &str, g: &str| simulation(&load(name, &[("gravity", g)]), 1);
    let fall = |g: &str| start("free-fall.ron", g);
    let message = where_they_part(fall("(0.0, -9.81)"), fall("(0.0, -1.62)"), 10);
    assert!(message.starts_with("they part at step 0, t = 0 s: the force of grain 1 (N)\n  first   ("), "{message}");
    assert!(message.ends_with("\n1 particle differs after this step"), "{message}");
    let message = where_they_part(fall("(0.0, -9.81)"), fall("(0.0, -9.81)"), 10);
    assert_eq!(message, "no quantity of a grain differs");
    let message = where_they_part(fall("(0.0, -9.81)"), start("stacked-pair.ron", "(0.0, 0.0, -9.81)"), 10);
    assert!(message.contains("in solid space"), "{message}");
}
