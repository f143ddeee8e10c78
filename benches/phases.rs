#![allow(missing_docs, reason = "criterion's macros")]
#![allow(clippy::print_stdout, reason = "a benchmark prints")]
//! Nanoseconds per particle-step of every phase. Phases are measured within whole steps, so they add up to the whole
//! step.
//!
//! For each bed the program first prints a table of all systems: the time of each, their sum, and the time of a whole
//! step without the stopwatch. The difference is overhead between steps. Then criterion times every phase.
//!
//! Work that does not occur in every step is provoked in each step: checking the neighbour list, renumbering because a
//! grain has changed, and sorting table rows in step zero. Outputs are a row and a picture per step. The beds are the
//! ones of `crystal`. Divide by criterion's elements.

mod crystal;
mod stopwatch;

use std::num::NonZeroUsize;
use std::time::{Duration, Instant};

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use siloflow::dem::store::ParticleStore;
use siloflow::files::growing::OutputPlace;
use siloflow::grains::file;
use siloflow::measure::totals;
use siloflow::output::pictures::PicturesPlugin;
use siloflow::output::series::SeriesPlugin;
use siloflow::prelude::*;
use siloflow::scene::outputs::Series;
use stopwatch::{PARTS, Stopwatch};

use self::crystal::{Crystal, R, run_further};

/// One layer of discs, which all touch the floor.
const LAYER: Crystal = Crystal { is_solid: false, grains: 10_000, wide: 10_000, is_mixed: false };

fn group<'a>(criterion: &'a mut Criterion, name: &str, grains: u32) -> BenchmarkGroup<'a, WallTime> {
    let mut group = criterion.benchmark_group(name);
    group.throughput(Throughput::Elements(u64::from(grains))).sample_size(10);
    group.warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1));
    group
}

fn watch(simulation: &mut Simulation) -> Mut<'_, Stopwatch> {
    simulation.world_mut().resource_mut::<Stopwatch>()
}

/// Prints the time of every system in ns per grain and step.
fn table(name: &str, bed: Crystal, simulation: &mut Simulation) {
    let steps = (4_000_000 / bed.grains).max(10);
    let share = |time: Duration| time.as_secs_f64() * 1e9 / f64::from(steps) / f64::from(bed.grains);
    let mut bare = bed.simulation();
    let begin = Instant::now();
    run_further(&mut bare, u64::from(steps));
    let whole = share(begin.elapsed());
    watch(simulation).reset();
    run_further(simulation, u64::from(steps));
    let coordination = totals::of_world(simulation.world()).coordination;
    println!("\n{name}: {coordination:.2} contacts per grain, {steps} steps; ns per grain and step");
    let watch = watch(simulation);
    for (part, (phase, _)) in PARTS.iter().enumerate() {
        println!("{:>8.3}  {phase}", share(watch.part(part)));
        for (entry, &spent) in watch.systems.iter().zip(&watch.spent).filter(|(entry, _)| entry.part == Some(part)) {
            println!("          {:>8.3}  {}", share(spent), entry.name);
        }
    }
    println!("{:>8.3}  all systems; a whole step without the stopwatch {whole:.3}\n", share(watch.total()));
}

/// Returns the reading of a stopwatch after `steps` steps, with `before` called before each step.
fn timed(
    simulation: &mut Simulation,
    steps: u64,
    mut before: impl FnMut(&mut World),
    read: impl Fn(&Stopwatch) -> Duration,
) -> Duration {
    watch(simulation).reset();
    for _ in 0..steps {
        before(simulation.world_mut());
        run_further(simulation, 1);
    }
    read(&watch(simulation))
}

fn phases(criterion: &mut Criterion) {
    let beds = [
        ("discs, 10000", Crystal::of(false, 10_000)),
        ("discs, 100000", Crystal::of(false, 100_000)),
        ("a layer of discs, 10000", LAYER),
        ("frictional spheres, 10000", Crystal::of(true, 10_000)),
    ];
    for (name, bed) in beds {
        let mut simulation = bed.simulation();
        stopwatch::put_into(&mut simulation);
        table(name, bed, &mut simulation);
        let mut group = group(criterion, name, bed.grains);
        for (part, (phase, _)) in PARTS.iter().enumerate() {
            if watch(&mut simulation).part(part) > Duration::ZERO {
                group.bench_function(*phase, |bencher| {
                    bencher.iter_custom(|steps| timed(&mut simulation, steps, |_| {}, |watch| watch.part(part)));
                });
            }
        }
        group.finish();
    }
}

/// Increases the travelled distance so that every displacement trigger fires.
fn fire_displacement_triggers(world: &mut World) {
    world.resource_mut::<ParticleStore>().travel += R;
}

/// Changes a grain as if it had just entered, which causes renumbering and a new neighbour list.
fn touch_grain(world: &mut World) {
    let grain = world.resource::<ParticleStore>().entity[0];
    let mass = *world.get::<Mass>(grain).expect("a grain has a mass");
    world.entity_mut(grain).insert(mass);
}

fn rare_work(criterion: &mut Criterion) {
    let bed = Crystal::of(false, 10_000);
    let mut simulation = bed.simulation();
    stopwatch::put_into(&mut simulation);
    let mut group = group(criterion, "rare work, discs, 10000", bed.grains);
    let provoked: [(&str, fn(&mut World), usize); 5] = [
        ("neighbour list checked", fire_displacement_triggers, 2),
        ("grains near walls searched", fire_displacement_triggers, 4),
        ("paths checked", fire_displacement_triggers, 8),
        ("renumbering", touch_grain, 0),
        ("neighbour list rebuilt", touch_grain, 2),
    ];
    for (name, before, part) in provoked {
        group.bench_function(name, |bencher| {
            bencher.iter_custom(|steps| timed(&mut simulation, steps, before, |watch| watch.part(part)));
        });
    }
    let mixed = Crystal { is_mixed: true, ..bed };
    group.bench_function("rows sorted", |bencher| {
        bencher.iter_custom(|times| {
            let once = |_| {
                let mut simulation = mixed.fresh();
                stopwatch::put_into(&mut simulation);
                simulation.step();
                watch(&mut simulation).system("rows::sort_rows")
            };
            (0..times).map(once).sum()
        });
    });
    group.finish();
}

fn outputs(criterion: &mut Criterion) {
    let bed = Crystal::of(false, 10_000);
    let directory = tempfile::tempdir().expect("a directory for outputs");
    let series = OutputPlace { path: directory.path().join("series.csv"), ..OutputPlace::default() };
    let mut group = group(criterion, "outputs, discs, 10000", bed.grains);
    for (name, pictures) in [
        ("a row of series.csv", "None"),
        ("a picture, SVG", "(interval: 1.0e-4)"),
        ("a picture, SVG and PNG", "(interval: 1.0e-4, png: true)"),
    ] {
        let loaded = bed.load(&[("pictures", pictures)]);
        let mut simulation = Simulation::with_plugins(&loaded, &Registry::default(), NonZeroUsize::MIN, |app| {
            let pictures = PicturesPlugin::<Plane>::of(&loaded, app.world(), directory.path().to_owned());
            if let Some(pictures) = pictures.expect("grains are coloured by species") {
                app.add_plugins(pictures);
            } else {
                let interval = Series { interval: 1.0e-4.try_into().expect("positive") };
                let plugin = SeriesPlugin::<Plane>::create(interval, true, app.world(), &series);
                app.add_plugins(plugin.expect("a file can be written"));
            }
        });
        let simulation = simulation.as_mut().expect("the scene needs no behaviours");
        stopwatch::put_into(simulation);
        group.bench_function(name, |bencher| {
            bencher.iter_custom(|steps| timed(simulation, steps, |_| {}, |watch| watch.part(9)));
        });
    }
    let mut simulation = bed.simulation();
    group.bench_function("state.csv", |bencher| {
        bencher.iter(|| file::write::<Plane>(simulation.world_mut()));
    });
    group.finish();
}

criterion_group!(benches, phases, rare_work, outputs);
criterion_main!(benches);
