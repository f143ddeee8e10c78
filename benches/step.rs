#![allow(clippy::print_stdout, reason = "a benchmark prints")]
//! Nanoseconds per particle-step: whole steps of beds of a thousand to a million grains, and what the neighbour list costs.
//!
//! Beds are crystals under weight, made at once: discs on a hexagonal lattice, frictionless; spheres on a face-centred one,
//! with friction and its memory; neighbours overlap by a thousandth of a diameter. They have 6 and 12 contacts a grain, twice
//! and more what a settled bed has: the coordination number is printed beside, and a settled bed is timed side by side with
//! LAMMPS by docs/speed/side-by-side.py. The planar silo is `scenes/silo1.ron` with 500 grains at rest, for each search.
//! Everything that a user's run does in a step is in it, but series and pictures. Divide the time by the throughput's
//! elements: criterion prints elements (particle-steps) a second.

use std::fmt::Write as _;
use std::num::NonZeroUsize;
use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use siloflow::columns::Columns;
use siloflow::measure::totals;
use siloflow::neighbours::{Neighbours, Search};
use siloflow::prelude::*;

/// Radius, m.
const R: f64 = 0.04;
/// Distance of neighbours, m.
const PITCH: f64 = 2.0 * R * 0.999;

/// A crystal of about `grains` grains in a box that fits, after a few steps.
fn crystal(solid: bool, grains: u32) -> Simulation {
    let half = PITCH * 0.5;
    let mut rows = String::from("id,radius,mass,x,y,vx,vy,z,vz\n");
    let wide = (1u32..10_000).find(|side| side.pow(if solid { 3 } else { 2 }) >= grains).expect("there is such a side");
    let deep = if solid { wide } else { 1 };
    let mut id = 0;
    for layer in 0..grains.div_ceil(wide * deep) {
        for row in 0..deep {
            for place in 0..wide {
                // Spheres: square layers, each in the hollows of the one below.
                let shift = f64::from(layer % 2) * half;
                let x = f64::from(place).mul_add(PITCH, shift + half);
                let y = f64::from(row).mul_add(PITCH, shift + half);
                let up = R + f64::from(layer) * PITCH * if solid { 0.5f64.sqrt() } else { 0.75f64.sqrt() };
                let (y, z) = if solid { (y, up) } else { (up, 0.0) };
                writeln!(rows, "{id},{R},0.16,{x},{y},0,0,{z},0").expect("a string can be written to");
                id += 1;
            }
        }
    }
    let width = f64::from(wide) * PITCH;
    let scene = if solid {
        format!(
            "(space: Solid, gravity: (0.0, 0.0, -9.81), periodic: (x: (0.0, {width:?}), y: (0.0, {width:?})), \
             walls: [HalfPlane(point: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0))], \
             contact: Linear(k: 1.0e5, damping: PerMass(400.0), tangential: Spring(k: 2.9e4, \
             damping: PerMass(200.0), friction: 0.5)), "
        )
    } else {
        format!(
            "(gravity: (0.0, -9.81), periodic: (x: (0.0, {width:?})), \
             walls: [HalfPlane(point: (0.0, 0.0), normal: (0.0, 1.0))], \
             contact: Linear(k: 1.0e5, damping: PerMass(400.0)), "
        )
    };
    let directory = tempfile::tempdir().expect("a directory for the scene");
    let path = directory.path().join("crystal.ron");
    std::fs::write(directory.path().join("grains.csv"), rows).expect("the grains can be written");
    let rest = "grains: (file: \"grains.csv\"), integrator: Verlet, step: Fixed(1.0e-4), \
                neighbours: VerletList(skin: 0.01), pictures: None, until: 1.0e9)";
    std::fs::write(&path, scene + rest).expect("the scene can be written");
    let loaded = load::load(&path, &[]).expect("the scene is valid");
    let mut simulation =
        Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN).expect("the scene needs no behaviours");
    simulation.run_steps(5);
    simulation
}

/// 500 grains at rest in the silo, its door closed.
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

/// Times `steps` steps a time.
fn measure(criterion: &mut Criterion, group: &str, name: &str, steps: u64, mut simulation: Simulation) {
    let totals = totals::of_world(simulation.world_mut());
    println!("{group}/{name}: {} grains, {:.2} contacts a grain", totals.grains, totals.coordination);
    let mut group = criterion.benchmark_group(group);
    group.throughput(Throughput::Elements(totals.grains as u64 * steps)).sample_size(10);
    group.bench_function(name, |bencher| {
        bencher.iter(|| {
            let done = simulation.world().resource::<Clock>().steps;
            simulation.run_steps(done + steps)
        });
    });
    group.finish();
}

fn whole_steps(criterion: &mut Criterion) {
    for (grains, steps) in [(1_000, 1000), (10_000, 100), (100_000, 10), (1_000_000, 1)] {
        measure(criterion, "discs", &grains.to_string(), steps, crystal(false, grains));
    }
    for (grains, steps) in [(1_000, 500), (10_000, 50), (100_000, 5)] {
        measure(criterion, "frictional spheres", &grains.to_string(), steps, crystal(true, grains));
    }
    for neighbours in ["VerletList(skin: 0.04)", "Cells(size: 0.25)", "Cells(size: 0.08)", "AllPairs"] {
        measure(criterion, "silo1", neighbours, 200, silo(neighbours));
    }
}

/// Making the list, for a bed of 10,000 grains.
fn neighbour_lists(criterion: &mut Criterion) {
    let simulation = crystal(false, 10_000);
    let columns = simulation.world().resource::<Columns>();
    let mut group = criterion.benchmark_group("neighbour list");
    group.throughput(Throughput::Elements(columns.len() as u64)).sample_size(10);
    for skin in [0.04, 0.01] {
        let kind = Neighbours::VerletList { skin: skin.try_into().expect("a skin is positive") };
        group.bench_function(format!("skin {skin} m"), |bencher| {
            bencher.iter(|| Search::new(kind, 1, columns.periodic, R).update(columns, 1e-4));
        });
    }
    group.finish();
}

criterion_group!(benches, whole_steps, neighbour_lists);
criterion_main!(benches);
