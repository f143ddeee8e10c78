#![allow(clippy::print_stdout, reason = "a benchmark prints")]
//! Nanoseconds per particle-step: whole steps of beds of a thousand to a million grains, and the cost of the neighbour
//! list.
//!
//! The beds are the ones of `crystal`, with at least twice the contacts of a settled bed. The coordination number is
//! printed with each result. docs/speed/side-by-side.py times a settled bed side by side with LAMMPS. The planar silo
//! is `scenes/silo1.ron` with 500 grains at rest, once for each neighbour search. The time includes all work of a
//! user's run in a step except series and pictures. Criterion prints elements (particle-steps) per second; divide the
//! time by the number of elements.

mod crystal;

use std::num::NonZeroUsize;
use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use siloflow::dem::neighbours::{Neighbours, Search};
use siloflow::dem::store::ParticleStore;
use siloflow::dem::threads::Threads;
use siloflow::measure::totals;
use siloflow::prelude::*;

use self::crystal::{Crystal, R, run_further};

/// Returns the silo with 500 grains at rest and its door closed.
fn silo(neighbours: &str) -> Simulation {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/silo1.ron");
    let settings = [
        ("neighbours", neighbours),
        ("pictures", "None"),
        ("until", "1.0e9"),
        ("spawner.count", "500"),
        ("bed", "None"),
        ("door", "(opens: Never)"),
    ];
    let loaded = load::load(&scene, &settings.map(|(key, value)| (key.to_owned(), value.to_owned())))
        .expect("the scene is valid");
    let mut simulation =
        Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN).expect("the scene needs no behaviours");
    // 500 x 0.05 s to fill and 4 s to settle.
    simulation.run_steps(29_000);
    simulation
}

/// Times runs of `steps` steps.
fn measure(criterion: &mut Criterion, group: &str, name: &str, steps: u64, mut simulation: Simulation) {
    let totals = totals::of_world(simulation.world_mut());
    println!("{group}/{name}: {} grains, {:.2} contacts per grain", totals.grains, totals.coordination);
    let mut group = criterion.benchmark_group(group);
    group.throughput(Throughput::Elements(totals.grains as u64 * steps)).sample_size(10);
    group.bench_function(name, |bencher| {
        bencher.iter(|| run_further(&mut simulation, steps));
    });
    group.finish();
}

fn whole_steps(criterion: &mut Criterion) {
    for (grains, steps) in [(1_000, 1000), (10_000, 100), (100_000, 10), (1_000_000, 1)] {
        measure(criterion, "discs", &grains.to_string(), steps, Crystal::of(false, grains).simulation());
    }
    for (grains, steps) in [(1_000, 500), (10_000, 50), (100_000, 5)] {
        measure(criterion, "frictional spheres", &grains.to_string(), steps, Crystal::of(true, grains).simulation());
    }
    for neighbours in ["VerletList(skin: 0.04)", "Cells(size: 0.25)", "Cells(size: 0.08)", "AllPairs"] {
        measure(criterion, "silo1", neighbours, 200, silo(neighbours));
    }
}

/// Times the construction of the neighbour list of a bed of 10,000 grains.
fn neighbour_lists(criterion: &mut Criterion) {
    let simulation = Crystal::of(false, 10_000).simulation();
    let store = simulation.world().resource::<ParticleStore>();
    let mut group = criterion.benchmark_group("neighbour list");
    group.throughput(Throughput::Elements(store.len() as u64)).sample_size(10);
    for skin in [0.04, 0.01] {
        let kind = Neighbours::VerletList { skin: skin.try_into().expect("a skin is positive") };
        group.bench_function(format!("skin {skin} m"), |bencher| {
            bencher.iter(|| Search::new(kind, store.periodic, R).update(store, 1e-4, &Threads::one()));
        });
    }
    group.finish();
}

criterion_group!(benches, whole_steps, neighbour_lists);
criterion_main!(benches);
