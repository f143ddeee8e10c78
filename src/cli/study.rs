//! `siloflow study`: runs the lattice-gas study over silos, variants and seeds, and judges the claims of its paper.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use clap::Args;
use rayon::prelude::*;

use crate::cli::exit_status::ExitStatus;
use crate::cli::{check_results, picture_files, say, say_aside, write_results};
use crate::studies::study::figures::Flights;
use crate::studies::study::plan::{Case, StudyPlan};
use crate::studies::study::replica::Replica;
use crate::studies::study::report;
use crate::studies::study::results::Results;
use siloflow_text::fault::Fault;

/// Number of particles thrown for the parabola, and the g of the throw.
const THROWN: (u64, f64) = (1000, 0.05);

/// Arguments of `study`.
#[derive(Args, Debug)]
pub(super) struct StudyArgs {
    /// The study, a RON file: scenes, seeds, variants.
    #[arg(default_value = "scenes/studies/lattice-gas.ron")]
    study: PathBuf,
    /// The directory of the results.
    #[arg(long, value_name = "DIR", default_value = "out/study")]
    out: PathBuf,
    /// Number of replicas in parallel. Default: the number of cores.
    #[arg(long, value_name = "N")]
    threads: Option<NonZeroUsize>,
}

pub(super) fn study(args: &StudyArgs, quiet: bool) -> Result<ExitStatus, Fault> {
    let (plan, cases) = StudyPlan::read(&args.study)?;
    check_results(&args.out)?;
    let cores = || std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
    let threads = args.threads.unwrap_or_else(cores);
    let start = Instant::now();
    let results = run_all(&plan, cases, threads, quiet)?;
    let seconds = start.elapsed().as_secs_f64();
    let flights = Flights::run(THROWN.0, THROWN.1)?;
    let tables = report::tables(&plan, &results, &flights).into_iter();
    let mut files: Vec<_> = tables.map(|(name, content)| (name.to_string(), content.into_bytes())).collect();
    for (name, svg) in report::pictures(&plan, &results, &flights) {
        files.extend(picture_files(&name, svg)?);
    }
    let status = write_results(&args.out, &files);
    let updates: u64 = results.0.iter().map(|replica| replica.updates).sum();
    #[expect(clippy::cast_precision_loss, reason = "a figure for people")]
    let speed = updates as f64 / seconds / 1e6;
    say(&format!(
        "{} runs in {seconds:.1} s, {speed:.1} M site updates/s, threads: {threads}\nwritten to   {}\n",
        results.0.len(),
        args.out.display()
    ));
    Ok(status)
}

fn run_all(plan: &StudyPlan, cases: Vec<Case>, threads: NonZeroUsize, quiet: bool) -> Result<Results, Fault> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.get()).build().map_err(|error| {
        Fault::new("call::threads", format!("could not start the threads: {error}"))
            .help("ask for fewer with --threads")
    })?;
    let count = cases.len();
    let done = AtomicUsize::new(0);
    let run = |case: Case| {
        let replica = Replica::run(case, &plan.pictures)?;
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        if !quiet && done.is_multiple_of(10) {
            say_aside(&format!("{done} of {count} runs"));
        }
        Ok(replica)
    };
    // Replicas finish in any order; results keep the order of the plan.
    pool.install(|| cases.into_par_iter().with_max_len(1).map(run).collect::<Result<Vec<_>, _>>()).map(Results)
}
