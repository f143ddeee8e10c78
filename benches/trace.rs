#![allow(missing_docs, reason = "a program")]
#![allow(clippy::print_stdout, reason = "a benchmark prints")]
//! Where the threads of a step spend their time, and what more cores would gain.
//!
//! ```sh
//! cargo bench --bench trace              # two threads
//! cargo bench --bench trace -- 4
//! ```
//!
//! For each bed of `crystal` a table has a row for each phase, in microseconds per step:
//!
//! | column | meaning |
//! |---|---|
//! | 1 thread | time of the phase with one thread |
//! | n threads | the same with n threads: the sum of the next three |
//! | passes | the work of the busiest thread in passes that threads share |
//! | joining | the rest of the passes: waking, handing out, and waiting for the last thread |
//! | serial | time outside passes, in which one thread works |
//! | idle | time of all threads in passes without work |
//! | number | passes in a step |
//!
//! The *model* says how many times faster n threads would be than one: time(n) = serial + largest share of the contacts + largest share of the other
//! passes + joining of a step. Its shares are those that the program hands out to n threads: whole blocks of rows, at least 512 rows. The *border* is the
//! number of pairs between two threads by that of all pairs. One of the two evaluates such a pair, and hands the force over to the other one, which takes
//! 0.3 of the instructions of a pair ([`EXCHANGE`]). The model assumes that candidates and rows cost
//! the same everywhere, that memory serves all cores as it serves the measured ones, and that joining takes as long whatever the number of threads.
//!
//! A stopwatch between systems costs about 50 ns each, some 30 times in a step. It is part of `serial`. The last line has whole steps without it.

mod crystal;
mod stopwatch;

use std::num::NonZeroUsize;
use std::time::{Duration, Instant};

use siloflow::dem::neighbours::Search;
use siloflow::dem::space::{Plane, Solid, Space};
use siloflow::dem::threads::Threads;
use siloflow::dem::threads::trace::Passes;
use siloflow::prelude::Simulation;
use stopwatch::{PARTS, Stopwatch};

use self::crystal::{Crystal, run_further};

/// Numbers of threads of the model.
const MODELLED: [usize; 6] = [2, 4, 8, 16, 32, 64];

/// The time of a phase, or of a step.
#[derive(Clone, Copy, Debug, Default)]
struct Spent {
    whole: Duration,
    passes: Passes,
}

/// The phases of a bed with a number of threads, and the time of a whole step without the stopwatch.
struct Trace {
    parts: Vec<Spent>,
    bare: Duration,
}

/// Work of handing over the force of a pair, by the work of a pair: as much for the thread that evaluates the pair as for the thread that gets the force.
/// The sum of both is what `cachegrind` counted in W2 with 10,000 spheres on 16 threads: 1.12 times the instructions of one thread at a border of 39 %.
const EXCHANGE: f64 = 0.15;

/// The work that the program hands out to a number of threads: rows, pairs, and forces handed over.
#[derive(Clone, Copy, Debug)]
struct Shares {
    /// Work of all threads.
    all: f64,
    /// Work of the busiest thread.
    largest: f64,
    /// The largest part of the rows that a thread has.
    rows: f64,
    /// Pairs between two threads, by all pairs.
    border: f64,
}

impl Shares {
    /// Reads the tasks of a simulation.
    fn of<V: Space>(simulation: &Simulation) -> Self {
        let list = &simulation.world().resource::<Search<V>>().list;
        let pairs = list.pairs();
        let tasks = list.tasks();
        let number = |row: usize| tasks.partition_point(|task| task.rows.end <= row);
        let mut work: Vec<_> = tasks.iter().map(|task| ratio(task.rows.len(), 1)).collect();
        let mut border = 0;
        for pair in pairs {
            let [lower, row] = pair.slots().map(number);
            work[row] += 1.0;
            if lower != row {
                border += 1;
                work[lower] += EXCHANGE;
                work[row] += EXCHANGE;
            }
        }
        let rows: usize = tasks.iter().map(|task| task.rows.len()).sum();
        Self {
            all: work.iter().sum(),
            largest: work.iter().copied().fold(0.0, f64::max),
            rows: ratio(tasks.iter().map(|task| task.rows.len()).max().unwrap_or(0), rows),
            border: ratio(border, pairs.len()),
        }
    }
}

/// A bed in so many steps.
#[derive(Clone, Copy)]
struct Bed {
    crystal: Crystal,
    steps: u32,
}

impl Bed {
    fn trace(self, threads: NonZeroUsize) -> Trace {
        let fresh = || {
            // Before the first step, which shares out the neighbour list.
            let threads = Threads::new(threads).expect("the system starts threads").traced();
            self.crystal.simulation_with(threads)
        };
        let mut bare = fresh();
        run_further(&mut bare, u64::from(self.steps / 10));
        let begin = Instant::now();
        run_further(&mut bare, u64::from(self.steps));
        let bare = begin.elapsed() / self.steps;
        let mut simulation = fresh();
        stopwatch::put_into(&mut simulation);
        run_further(&mut simulation, u64::from(self.steps / 10));
        simulation.world_mut().resource_mut::<Stopwatch>().reset();
        run_further(&mut simulation, u64::from(self.steps));
        let watch = simulation.world().resource::<Stopwatch>();
        let parts = (0..PARTS.len()).map(|part| Spent { whole: watch.part(part), passes: watch.passes_of(part) });
        Trace { parts: parts.collect(), bare }
    }

    /// Returns what `threads` threads are handed.
    fn shares(self, threads: NonZeroUsize) -> Shares {
        let simulation = self.crystal.simulation_with(Threads::new(threads).expect("the system starts threads"));
        if self.crystal.is_solid { Shares::of::<Solid>(&simulation) } else { Shares::of::<Plane>(&simulation) }
    }

    /// Time of a step, us.
    fn each(self, time: Duration) -> f64 {
        time.as_secs_f64() * 1e6 / f64::from(self.steps)
    }

    fn row(self, name: &str, one: Duration, many: Spent, threads: u32) {
        let Spent { whole, passes } = many;
        let joining = passes.wall.saturating_sub(passes.longest);
        let serial = whole.saturating_sub(passes.wall);
        let idle = (passes.wall * threads).saturating_sub(passes.work);
        let columns = [one, whole, passes.longest, joining, serial, idle].map(|time| self.each(time));
        let columns = columns.map(|column| format!("{column:>10.2}")).concat();
        let number = real(passes.count) / f64::from(self.steps);
        println!("{columns}{number:>9.1}  {name}");
    }
}

fn table(name: &str, bed: Bed, threads: NonZeroUsize) {
    let count = u32::try_from(threads.get()).expect("fewer than 2^32 threads");
    let one = bed.trace(NonZeroUsize::MIN);
    let many = bed.trace(threads);
    println!("\n{name}: {} grains, {} steps, {count} threads; microseconds per step", bed.crystal.grains, bed.steps);
    let heads = ["1 thread", &format!("{count} threads"), "passes", "joining", "serial", "idle"]
        .map(|head| format!("{head:>10}"));
    println!("{}   number", heads.concat());
    for ((part, _), (one, many)) in PARTS.iter().zip(one.parts.iter().zip(&many.parts)) {
        bed.row(part, one.whole, *many, count);
    }
    let whole = |trace: &Trace| trace.parts.iter().map(|part| part.whole).sum::<Duration>();
    let passes = stopwatch::sum(many.parts.iter().map(|part| part.passes));
    bed.row("all", whole(&one), Spent { whole: whole(&many), passes }, count);
    let gain = one.bare.as_secs_f64() / many.bare.as_secs_f64();
    let us = |time: Duration| time.as_secs_f64() * 1e6;
    println!("whole steps without the stopwatch: {:.2} and {:.2}, gain {gain:.2}", us(one.bare), us(many.bare));
    let contacts = many.parts[PARTS.iter().position(|part| part.0 == "contacts").expect("contacts are a part")];
    model(bed, threads, whole(&many), passes, contacts.passes);
}

/// Prints the gain of more threads.
fn model(bed: Bed, threads: NonZeroUsize, whole: Duration, passes: Passes, contacts: Passes) {
    let serial = bed.each(whole.saturating_sub(passes.wall));
    let joining = bed.each(passes.wall.saturating_sub(passes.longest));
    let others = bed.each(passes.work.saturating_sub(contacts.work));
    let all = bed.shares(threads).all;
    // Time of so much work, us.
    let time_of = |work: f64| bed.each(contacts.work) * work / all;
    let contacts = time_of(bed.shares(NonZeroUsize::MIN).all);
    println!("model: serial {serial:.1}, contacts {contacts:.1}, other passes {others:.1}, joining {joining:.1}");
    for count in MODELLED.map(|count| NonZeroUsize::new(count).expect("not 0")) {
        let Shares { largest, rows, border, .. } = bed.shares(count);
        let time = serial + time_of(largest) + others * rows + joining;
        let gain = (serial + contacts + others) / time;
        println!("{count:>6} threads: gain {gain:.1}, border {:.1} %", 100.0 * border);
    }
}

#[expect(clippy::cast_precision_loss, reason = "numbers of rows and pairs")]
fn ratio(part: usize, whole: usize) -> f64 {
    part as f64 / whole as f64
}

#[expect(clippy::cast_precision_loss, reason = "a number of passes")]
fn real(count: u64) -> f64 {
    count as f64
}

fn main() {
    let wanted = std::env::args().skip(1).find_map(|argument| argument.parse().ok());
    let threads = wanted.unwrap_or(const { NonZeroUsize::new(2).expect("2 is not 0") });
    let beds = [
        ("discs", Bed { crystal: Crystal::of(false, 10_000), steps: 4000 }),
        ("frictional spheres", Bed { crystal: Crystal::of(true, 10_000), steps: 1000 }),
        ("frictional spheres", Bed { crystal: Crystal::of(true, 100_000), steps: 100 }),
    ];
    for (name, bed) in beds {
        table(name, bed, threads);
    }
}
