#![allow(missing_docs, reason = "criterion's macros")]
//! Site updates per second of the lattice gas in its base case: 35,000 sites of the funnel-flow silo, with a bed that
//! has settled for 800 steps. Cases: one replica on one thread, two replicas side by side on two threads, one replica
//! on two threads. The time includes all work of a user's run in a step except series and pictures. Criterion prints
//! site updates (elements) per second.

use std::num::NonZeroUsize;
use std::path::Path;
use std::sync::mpsc::{Receiver, Sender, channel};

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use siloflow::lattice::sites::Sites;
use siloflow::lattice_silo::loaded::LoadedLattice;
use siloflow::prelude::*;

const STEPS: u64 = 50;

fn settled(seed: &str, threads: usize) -> Simulation {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/funnel-flow.ron");
    let settings = [("seed", seed), ("door.opens", "Never"), ("until", "1000000000")];
    let settings: Vec<_> = settings.iter().map(|&(key, value)| (key.to_owned(), value.to_owned())).collect();
    let loaded = LoadedLattice::read(&scene, &settings).expect("the scene is valid");
    let threads = NonZeroUsize::new(threads).expect("at least one");
    let mut simulation = Simulation::of_lattice(&loaded, &Registry::default(), threads).expect("no behaviours");
    simulation.run_steps(800);
    simulation
}

fn run_further(simulation: &mut Simulation) {
    let done = simulation.world().resource::<Clock>().steps;
    simulation.run_steps(done + STEPS);
}

/// A replica on its own thread, which takes its steps on request.
struct Replica {
    go: Sender<()>,
    done: Receiver<()>,
}

impl Replica {
    fn start(seed: &'static str) -> Self {
        let (go, requests) = channel();
        let (finished, done) = channel();
        std::thread::spawn(move || {
            let mut simulation = settled(seed, 1);
            while requests.recv().is_ok() {
                run_further(&mut simulation);
                if finished.send(()).is_err() {
                    break;
                }
            }
        });
        Self { go, done }
    }
}

fn base_case(criterion: &mut Criterion) {
    let mut one = settled("1", 1);
    let sites = one.world().resource::<Sites>().fluid_count() as u64;
    let mut group = criterion.benchmark_group("lattice gas, base case, 35000 sites");
    group.sample_size(40).throughput(Throughput::Elements(sites * STEPS));
    group.bench_function("one replica", |bencher| bencher.iter(|| run_further(&mut one)));
    let mut on_two = settled("1", 2);
    group.bench_function("one replica on two threads", |bencher| bencher.iter(|| run_further(&mut on_two)));
    let replicas = ["1", "2"].map(Replica::start);
    group.throughput(Throughput::Elements(2 * sites * STEPS));
    group.bench_function("two replicas on two threads", |bencher| {
        bencher.iter(|| {
            for replica in &replicas {
                replica.go.send(()).expect("the thread runs");
            }
            for replica in &replicas {
                replica.done.recv().expect("the thread runs");
            }
        });
    });
    group.finish();
}

criterion_group!(benches, base_case);
criterion_main!(benches);
