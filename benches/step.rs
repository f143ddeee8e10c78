#![allow(clippy::print_stdout, reason = "a benchmark prints")]
//! Nanoseconds per particle-step of two beds at rest.
//!
//! The one in solid space is that of `scenes/bed3d.ron`, 10,000 frictional spheres after 0.15 s, at a step of 1e-6 s: the
//! bed that LAMMPS (29Sep2021, Debian's binary) takes 122 ns a particle-step for where this program takes 184 ns, in one
//! sitting on one core of a 2-core EPYC, both with a skin of 0.1 d; LAMMPS alone on the machine 106 ns, and 89 ns with a
//! skin of 0.02 d. Making the bed takes a minute.
//!
//! The planar one is for each neighbour search.
//! The bed is that of `scenes/silo1.ron` with its first 500 grains at rest, the door closed: everything that a
//! user's run does in a step, without series and pictures. Divide the time by the throughput's elements: criterion
//! prints elements (particle-steps) a second. The coordination number is printed beside it, for a bed that only looks
//! settled runs twice as fast.

use std::num::NonZeroUsize;
use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use siloflow::measure::totals;
use siloflow::prelude::*;

const GRAINS: u64 = 500;
const STEPS: u64 = 200;

/// silo1's bed at rest.
fn bed(neighbours: &str) -> Simulation {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/silo1.ron");
    let settings = [
        ("spawner.count", "500"),
        ("neighbours", neighbours),
        ("pictures", "None"),
        ("bed", "None"),
        ("door", "(opens: Never)"),
        ("until", "1.0e9"),
    ];
    let settings = settings.map(|(key, value)| (key.to_owned(), value.to_owned()));
    let loaded = load::load(&scene, &settings).expect("the scene is valid");
    let mut simulation =
        Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN).expect("the scene needs no behaviours");
    // 500 x 0.05 s to fill and 4 s to settle.
    simulation.run_steps(29_000);
    simulation
}

fn silo1_bed(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("silo1 bed, 500 grains at rest");
    group.throughput(Throughput::Elements(GRAINS * STEPS)).sample_size(20);
    for neighbours in ["VerletList(skin: 0.04)", "Cells(size: 0.25)", "Cells(size: 0.08)", "AllPairs"] {
        let mut simulation = bed(neighbours);
        let coordination = totals::of_world(simulation.world_mut()).coordination;
        println!("{neighbours}: {coordination:.2} contacts a grain");
        group.bench_function(neighbours, |bencher| {
            bencher.iter(|| {
                let steps = simulation.world().resource::<Clock>().steps;
                simulation.run_steps(steps + STEPS)
            });
        });
    }
    group.finish();
}

/// The frictional bed, settled.
fn bed3d(neighbours: &str) -> Simulation {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/bed3d.ron");
    let settings = [("neighbours", neighbours), ("pictures", "None"), ("profiles", "[]"), ("until", "1.0e9")];
    let settings = settings.map(|(key, value)| (key.to_owned(), value.to_owned()));
    let loaded = load::load(&scene, &settings).expect("the scene is valid");
    let mut simulation =
        Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN).expect("the scene needs no behaviours");
    simulation.run_steps(60_000);
    simulation.world_mut().resource_mut::<Clock>().dt = 1e-6;
    simulation
}

fn frictional_bed(criterion: &mut Criterion) {
    const GRAINS: u64 = 10_000;
    const STEPS: u64 = 20;
    let mut group = criterion.benchmark_group("bed3d, 10,000 frictional spheres at rest");
    group.throughput(Throughput::Elements(GRAINS * STEPS)).sample_size(20);
    for neighbours in ["VerletList(skin: 1.0e-4)", "VerletList(skin: 2.0e-5)"] {
        let mut simulation = bed3d(neighbours);
        let coordination = totals::of_world(simulation.world_mut()).coordination;
        println!("{neighbours}: {coordination:.2} contacts a grain");
        group.bench_function(neighbours, |bencher| {
            bencher.iter(|| {
                let steps = simulation.world().resource::<Clock>().steps;
                simulation.run_steps(steps + STEPS)
            });
        });
    }
    group.finish();
}

criterion_group!(benches, silo1_bed, frictional_bed);
criterion_main!(benches);
