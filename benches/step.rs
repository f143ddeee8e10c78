#![allow(clippy::print_stdout, reason = "a benchmark prints")]
//! Nanoseconds per particle-step of two beds at rest.
//!
//! The one in solid space is that of `scenes/bed3d.ron`, 10,000 frictional spheres after 0.15 s, at a step of 1e-6 s: the
//! bed that LAMMPS (29Sep2021, Debian's binary) takes 122 ns a particle-step for where this program takes 184 ns, in one
//! sitting on one core of a 2-core EPYC, both with a skin of 0.1 d; LAMMPS alone on the machine 106 ns, and 89 ns with a
//! skin of 0.02 d. Making the bed takes a minute.
//!
//! The planar one is that of `scenes/silo1.ron` with its first 500 grains at rest, the door closed, for each neighbour
//! search. Both are everything that a user's run does in a step, without series and pictures. Divide the time by the
//! throughput's elements: criterion prints elements (particle-steps) a second. The coordination number is printed
//! beside it, for a bed that only looks settled runs twice as fast.

use std::num::NonZeroUsize;
use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use siloflow::measure::totals;
use siloflow::prelude::*;

/// A scene with a neighbour search and other settings, after so many steps.
fn settled(scene: &str, neighbours: &str, settings: &[(&str, &str)], steps: u64) -> Simulation {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene);
    let always = [("neighbours", neighbours), ("pictures", "None"), ("until", "1.0e9")];
    let settings = always.iter().chain(settings).map(|&(key, value)| (key.to_owned(), value.to_owned()));
    let loaded = load::load(&scene, &settings.collect::<Vec<_>>()).expect("the scene is valid");
    let mut simulation =
        Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN).expect("the scene needs no behaviours");
    simulation.run_steps(steps);
    simulation
}

/// Times `steps` steps of a bed of `grains` for each search; `bed` makes it.
fn measure(
    criterion: &mut Criterion,
    name: &str,
    (grains, steps): (u64, u64),
    searches: &[&str],
    bed: impl Fn(&str) -> Simulation,
) {
    let mut group = criterion.benchmark_group(name);
    group.throughput(Throughput::Elements(grains * steps)).sample_size(20);
    for &neighbours in searches {
        let mut simulation = bed(neighbours);
        let coordination = totals::of_world(simulation.world_mut()).coordination;
        println!("{neighbours}: {coordination:.2} contacts a grain");
        group.bench_function(neighbours, |bencher| {
            bencher.iter(|| {
                let done = simulation.world().resource::<Clock>().steps;
                simulation.run_steps(done + steps)
            });
        });
    }
    group.finish();
}

fn silo1_bed(criterion: &mut Criterion) {
    let searches = ["VerletList(skin: 0.04)", "Cells(size: 0.25)", "Cells(size: 0.08)", "AllPairs"];
    measure(criterion, "silo1 bed, 500 grains at rest", (500, 200), &searches, |neighbours| {
        let settings = [("spawner.count", "500"), ("bed", "None"), ("door", "(opens: Never)")];
        // 500 x 0.05 s to fill and 4 s to settle.
        settled("silo1.ron", neighbours, &settings, 29_000)
    });
}

fn frictional_bed(criterion: &mut Criterion) {
    let searches = ["VerletList(skin: 1.0e-4)", "VerletList(skin: 2.0e-5)"];
    measure(criterion, "bed3d, 10,000 frictional spheres at rest", (10_000, 20), &searches, |neighbours| {
        let mut simulation = settled("bed3d.ron", neighbours, &[("profiles", "[]")], 60_000);
        simulation.world_mut().resource_mut::<Clock>().dt = 1e-6;
        simulation
    });
}

criterion_group!(benches, silo1_bed, frictional_bed);
criterion_main!(benches);
