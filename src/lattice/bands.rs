//! A gas in bands of columns, which several threads may work on side by side.
//!
//! One thread works on one band of all columns. No result depends on the bands: every decision reads draws of its own site
//! and nothing that another site writes in the same pass.

use crate::lattice::gas::Gas;
use crate::lattice::sites::{Run, Sites};
use crate::threads::Threads;

/// Bands for each thread: more than one, for columns are not equally full.
const BANDS: usize = 4;

/// Columns side by side.
pub(super) struct Band<'a> {
    /// Runs of fluid sites in these columns.
    pub runs: &'a [Run],
    /// The site at which the band's parts of the lists begin.
    pub first: usize,
    pub states: &'a [u16],
    pub movers: &'a mut [u16],
    pub resting: &'a mut [u8],
    pub numbers: &'a mut [u8],
    pub held: &'a mut [u8],
    /// Sites with stopped particles that want a place next to them, and how many, ascending.
    pub spare: Vec<(usize, u8)>,
}

/// Stored sites of a band.
fn length(sites: &Sites, threads: &Threads) -> usize {
    let columns = sites.kinds.len() / sites.stride;
    match threads.count() {
        1 => sites.kinds.len(),
        count => columns.div_ceil(BANDS * count) * sites.stride,
    }
}

/// The runs in the band from site `first` on.
fn runs(sites: &Sites, first: usize, length: usize) -> &[Run] {
    let begin = sites.runs.partition_point(|run| run.start < first);
    let end = sites.runs.partition_point(|run| run.start < first + length);
    &sites.runs[begin..end]
}

/// Works on all bands of a gas; `spare` is that of all of them afterwards.
pub(super) fn work(gas: &mut Gas, sites: &Sites, threads: &Threads, job: impl Fn(&mut Band<'_>) + Send + Sync) {
    let length = length(sites, threads);
    let Gas { states, movers, resting, numbers, held, spare, .. } = gas;
    let parts = states.chunks(length).zip(movers.chunks_mut(length)).zip(resting.chunks_mut(length));
    let parts = parts.zip(numbers.chunks_mut(length).zip(held.chunks_mut(length)));
    let bands = parts.enumerate().map(|(n, (((states, movers), resting), (numbers, held)))| {
        let first = n * length;
        Band { runs: runs(sites, first, length), first, states, movers, resting, numbers, held, spare: Vec::new() }
    });
    let mut bands: Vec<Band> = bands.collect();
    threads.share(bands.iter_mut().map(|band| || job(band)));
    spare.clear();
    for band in &mut bands {
        spare.append(&mut band.spare);
    }
}

/// Writes the states of all bands: the job gets a band's runs, its first site and its states.
pub(super) fn write(
    states: &mut [u16],
    sites: &Sites,
    threads: &Threads,
    job: impl Fn(&[Run], usize, &mut [u16]) + Send + Sync,
) {
    let length = length(sites, threads);
    let job = &job;
    let one = |(n, states): (usize, _)| move || job(runs(sites, n * length, length), n * length, states);
    threads.share(states.chunks_mut(length).enumerate().map(one));
}
