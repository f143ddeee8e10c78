//! Determinism: thread count, neighbour search, skin and components of users change no bit.

use crate::{hash, load, simulation};
use siloflow::dem::instruction_set::InstructionSet;
use siloflow::energy::EnergyFlows;
use siloflow::prelude::*;
use siloflow::studies::diff::where_they_part;
use siloflow::text::source::places;

/// Starts a small fill, rest and discharge, up to its end or to 30 s.
fn start(name: &str, neighbours: &str, threads: usize) -> Simulation {
    let settings = [
        ("pictures", "None"),
        ("spawner.count", "150"),
        ("until", "30.0"),
        ("neighbours", neighbours),
        ("on_loss", "Continue"),
    ];
    simulation(&load(name, &settings), threads)
}

/// Returns hashes at three times and at the end.
fn hashes(name: &str, neighbours: &str, threads: usize) -> Vec<u64> {
    let mut run = start(name, neighbours, threads);
    let mut hashes = Vec::new();
    for steps in [4_000, 9_000, 12_000, u64::MAX] {
        run.run_steps(steps);
        hashes.push(hash(&mut run));
    }
    assert_eq!(run.world().resource::<Ledger>().released, 150, "{name}");
    hashes
}

fn assert_same(name: &str) {
    let reference = hashes(name, "AllPairs", 1);
    assert_ne!(reference[0], reference[1]);
    for (neighbours, threads) in [
        ("Cells(size: 0.25)", 1),
        ("Cells(size: 0.1)", 2),
        ("VerletList(skin: 0.04)", 1),
        ("VerletList(skin: 0.003)", 1),
        ("VerletList(skin: 0.3)", 2),
        ("AllPairs", 2),
    ] {
        assert_eq!(
            hashes(name, neighbours, threads),
            reference,
            "{name}: {neighbours} on {threads} threads: {}",
            where_they_part(start(name, neighbours, threads), start(name, "AllPairs", 1), u64::MAX)
        );
    }
}

#[test]
fn searches_and_threads_change_no_bit_of_silo1() {
    assert_same("silo1.ron");
}

#[test]
fn searches_and_threads_change_no_bit_of_silo1_mixture() {
    assert_same("silo1-mixture.ron");
}

#[test]
fn searches_and_threads_change_no_bit_of_silo1_polydisperse() {
    assert_same("silo1-polydisperse.ron");
}

/// Radii 1:20, in the plane and in space: small grains among large ones, with one grid of cells per size class.
#[test]
fn searches_and_threads_change_no_bit_of_grains_of_very_different_sizes() {
    let spheres = "(space: Solid, seed: 5, gravity: (0.0, 0.0, -9.81), mass: Sphere(2500.0), step: Fixed(1.0e-5), until: 1.0, pictures: None,
        contact: Linear(k: 2.0e4, damping: Restitution(0.5), tangential: Spring(k: 6.0e3, damping: OfNormal(0.5), friction: 0.5)),
        periodic: (x: (0.0, 0.082), y: (0.0, 0.082)), walls: [HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))],
        fill: [(low: (0.0, 0.0, 0.0), high: (0.082, 0.082, 0.013), spacing: 4.1e-3, radius: Uniform(1.0e-3, 2.0e-3), jitter: 5.0e-5),
            (low: (0.0, 0.0, 0.014), high: (0.05, 0.05, 0.064), spacing: 0.05, radius: Fixed(0.02), jitter: 2.0e-3, velocity: (0.0, 0.0, -1.0))])";
    let run = |neighbours: &str, threads: usize| {
        let settings = [("neighbours".to_owned(), neighbours.to_owned())];
        let spheres = load::from_text("a.ron", "a", std::path::Path::new(""), spheres.to_owned(), &settings).unwrap();
        // The large grains land after about 600 and 4000 steps.
        [(spheres, 900), (load("hard/caught.ron", &[("neighbours", neighbours)]), 6_000)].map(|(loaded, steps)| {
            let mut run = simulation(&loaded, threads);
            run.run_steps(steps);
            hash(&mut run)
        })
    };
    let reference = run("AllPairs", 1);
    for (neighbours, threads) in [
        ("CellsOfRange(rng: 2.0)", 1),
        ("VerletList(skin: 2.0e-4)", 1),
        ("VerletList(skin: 2.0e-4)", 2),
        ("VerletList(skin: 3.0e-3)", 1),
    ] {
        assert_eq!(run(neighbours, threads), reference, "{neighbours} on {threads} threads");
    }
}

/// The topmost grain of a bed at rest is thrown into the bed at 20 m/s while other grains still fall. The neighbour
/// list must contain a fast grain among slow ones.
#[test]
fn no_search_misses_contacts_of_a_fast_grain() {
    let bed_with_fast_grain = |neighbours: &str| {
        let settings = [
            ("pictures", "None"),
            ("spawner.count", "60"),
            ("contact.k", "3.0e5"),
            ("step", "Fixed(2.0e-4)"),
            ("neighbours", neighbours),
            ("on_loss", "Continue"),
            ("until", "4.0"),
        ];
        let mut run = simulation(&load("silo1.ron", &settings), 1);
        run.run_steps(15_000);
        let world = run.world_mut();
        let mut grains = world.query_filtered::<(&Position, &mut Velocity), With<Grain>>();
        let highest = grains.iter(world).map(|(x, _)| x.0.y).fold(f64::NEG_INFINITY, f64::max);
        for (x, mut v) in grains.iter_mut(world) {
            if x.0.y == highest {
                v.0 = Vector::new(2.0, -20.0);
            }
        }
        run
    };
    let run = |neighbours: &str| {
        let mut run = bed_with_fast_grain(neighbours);
        run.run();
        hash(&mut run)
    };
    let reference = run("AllPairs");
    for neighbours in ["Cells(size: 0.08)", "VerletList(skin: 0.001)", "VerletList(skin: 0.02)"] {
        let part = || where_they_part(bed_with_fast_grain(neighbours), bed_with_fast_grain("AllPairs"), u64::MAX);
        assert_eq!(run(neighbours), reference, "{neighbours}: {}", part());
    }
}

#[test]
fn components_of_users_change_no_bit() {
    #[derive(Component)]
    struct Marker(#[expect(dead_code, reason = "it only changes the table of the entity")] u64);
    let settings = [("pictures", "None"), ("spawner.count", "40")];
    let start = |add_marker: bool| {
        let mut run = simulation(&load("silo1.ron", &settings), 1);
        run.run_steps(1500);
        if add_marker {
            // Every third grain moves to another table, in a different order.
            let world = run.world_mut();
            let mut grains = world.query_filtered::<(Entity, &GrainId), With<Grain>>();
            let chosen: Vec<_> =
                grains.iter(world).filter(|(_, id)| id.number() % 3 == 0).map(|(grain, _)| grain).collect();
            for (number, grain) in chosen.into_iter().rev().enumerate() {
                world.entity_mut(grain).insert(Marker(number as u64));
            }
        }
        run
    };
    let run = |add_marker: bool| {
        let mut run = start(add_marker);
        run.run_steps(6000);
        hash(&mut run)
    };
    assert_eq!(run(false), run(true), "{}", where_they_part(start(false), start(true), 6000));
}

#[test]
fn run_depends_on_the_seed_only() {
    let start = |seed: &str| {
        simulation(&load("silo1.ron", &[("pictures", "None"), ("seed", seed), ("spawner.count", "20")]), 1)
    };
    let run = |seed: &str| {
        let mut run = start(seed);
        run.run_steps(2500);
        hash(&mut run)
    };
    assert_eq!(run("1"), run("1"), "{}", where_they_part(start("1"), start("1"), 2500));
    assert_ne!(run("1"), run("2"));
}

#[test]
fn distant_grain_costs_no_memory_and_no_time() {
    let text = std::fs::read_to_string(crate::scene("column.ron")).unwrap();
    let text = places::set(&text, "neighbours", "Cells(size: 0.25)").unwrap();
    let mut loaded =
        siloflow::scene::load::from_text("far.ron", "far", &crate::root().join("scenes"), text, &[]).unwrap();
    loaded.grains.last_mut().unwrap().position = Solid::new(1e9, 1e9, 0.0);
    let mut run = simulation(&loaded, 1);
    // A square grid that covers this distance would have 1e19 cells.
    assert_eq!(run.run_steps(10), None);
}

/// Runs with every instruction set that the machine supports, on several threads.
#[test]
fn instructions_change_no_bit() {
    let scenes: [(&str, &[(&str, &str)], u64); 4] = [
        ("silo1-mixture.ron", &[("spawner.count", "60"), ("pictures", "None")], 6_000),
        ("silo1.ron", &[("spawner.count", "60"), ("pictures", "None"), ("integrator", "Centred")], 6_000),
        ("bed3d.ron", &[("fill[0].count", "2500"), ("profiles", "[]"), ("pictures", "None")], 3_000),
        ("chute3d.ron", &[("pictures", "None"), ("integrator", "Centred"), ("profiles", "[]")], 300),
    ];
    assert!(
        !cfg!(target_arch = "x86_64") || InstructionSet::all().len() > 1,
        "this machine supports one instruction set only: no comparison"
    );
    for (name, settings, steps) in scenes {
        let start = |instructions: InstructionSet, threads: usize| {
            let mut run = simulation(&load(name, settings), threads);
            run.world_mut().insert_resource(instructions);
            run
        };
        let run = |instructions: InstructionSet, threads: usize| {
            let mut run = start(instructions, threads);
            run.run_steps(steps);
            (hash(&mut run), run.world().resource::<EnergyFlows>().dissipated.to_bits())
        };
        let reference = run(InstructionSet::Baseline, 1);
        for instructions in InstructionSet::all() {
            for threads in [1, 2, 3] {
                assert_eq!(
                    run(instructions, threads),
                    reference,
                    "{name}: {instructions:?} on {threads} threads: {}",
                    where_they_part(start(instructions, threads), start(InstructionSet::Baseline, 1), steps)
                );
            }
        }
    }
}

/// Grains that enter in a different order: the order of slots and of table rows changes no bit.
#[test]
fn order_of_entering_changes_no_bit() {
    let start = |reversed: bool| {
        let mut loaded = load("bed3d.ron", &[("fill[0].count", "5000"), ("profiles", "[]"), ("pictures", "None")]);
        if reversed {
            loaded.grains.reverse();
        }
        simulation(&loaded, 1)
    };
    let run = |reversed: bool| {
        let mut run = start(reversed);
        run.run_steps(1_500);
        hash(&mut run)
    };
    assert_eq!(run(false), run(true), "{}", where_they_part(start(false), start(true), 1_500));
}

/// Every search finds the contacts of a grain that is moved onto others between two steps.
#[test]
fn contacts_of_a_grain_moved_between_steps_are_found() {
    let moved = |neighbours: &str| {
        let settings = [
            ("spawner.count", "40"),
            ("pictures", "None"),
            ("neighbours", neighbours),
            ("door", "(opens: Never)"),
            ("bed", "None"),
        ];
        let mut run = simulation(&load("silo1.ron", &settings), 1);
        // At rest, so that the neighbour list is not rebuilt for a long time.
        run.run_steps(20_000);
        let world = run.world_mut();
        let mut grains = world.query_filtered::<&mut Position, With<Grain>>();
        let lowest = grains.iter(world).map(|x| x.0).min_by(|a, b| a.y.total_cmp(&b.y)).unwrap();
        let highest = grains.iter(world).map(|x| x.0.y).fold(f64::NEG_INFINITY, f64::max);
        for mut x in grains.iter_mut(world) {
            if x.0.y == highest {
                x.0 = lowest + Vector::new(0.0, 0.05);
            }
        }
        run
    };
    let run = |neighbours: &str| {
        let mut run = moved(neighbours);
        run.run_steps(20_050);
        hash(&mut run)
    };
    let reference = run("AllPairs");
    for neighbours in ["Cells(size: 0.25)", "VerletList(skin: 0.02)", "VerletList(skin: 0.3)"] {
        let part = || where_they_part(moved(neighbours), moved("AllPairs"), 20_050);
        assert_eq!(run(neighbours), reference, "{neighbours}: {}", part());
    }
}
