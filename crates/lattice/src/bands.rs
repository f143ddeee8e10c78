//! Splits the gas into bands of adjacent columns, which several threads process in parallel.
//!
//! A single thread gets one band with all columns. Results do not depend on the bands: each decision uses the random
//! numbers of its own site, and reads no value that another site writes in the same pass.

use crate::gas::{Gas, Surplus};
use crate::sites::{Run, Sites};
use siloflow_dem::threads::Threads;

/// Bands per thread. More than one, because columns hold different numbers of particles.
const BANDS: usize = 4;

/// A band of adjacent columns. The slices cover the sites of the band only.
pub(crate) struct Band<'a> {
    /// Runs of fluid sites in the band, with indices into the whole lattice.
    pub runs: &'a [Run],
    /// Index of the band's first site in the whole lattice: element 0 of each slice.
    pub first: usize,
    pub states: &'a [u16],
    pub movers: &'a mut [u16],
    pub resting: &'a mut [u8],
    pub numbers: &'a mut [u8],
    pub stopped: &'a mut [u8],
    /// Stopped particles that need a rest place at a neighbour, by ascending site.
    pub surplus: Vec<Surplus>,
}

/// Returns the number of stored sites in a band; the last band may be shorter.
fn band_length(sites: &Sites, threads: &Threads) -> usize {
    let columns = sites.kinds.len() / sites.stride;
    match threads.count() {
        1 => sites.kinds.len(),
        count => columns.div_ceil(BANDS * count) * sites.stride,
    }
}

/// Returns the runs of the band that starts at site `first` and has `length` stored sites.
fn runs(sites: &Sites, first: usize, band_length: usize) -> &[Run] {
    let begin = sites.runs.partition_point(|run| run.start < first);
    let end = sites.runs.partition_point(|run| run.start < first + band_length);
    &sites.runs[begin..end]
}

/// Runs `job` on every band of a gas, then joins the `surplus` lists of all bands in [`Gas::surplus`].
pub(crate) fn for_each_band(
    gas: &mut Gas,
    sites: &Sites,
    threads: &Threads,
    job: impl Fn(&mut Band<'_>) + Send + Sync,
) {
    let band_length = band_length(sites, threads);
    let Gas { states, movers, resting, numbers, stopped, surplus, .. } = gas;
    let parts = states.chunks(band_length).zip(movers.chunks_mut(band_length)).zip(resting.chunks_mut(band_length));
    let parts = parts.zip(numbers.chunks_mut(band_length).zip(stopped.chunks_mut(band_length)));
    let bands = parts.enumerate().map(|(n, (((states, movers), resting), (numbers, stopped)))| {
        let first = n * band_length;
        let runs = runs(sites, first, band_length);
        Band { runs, first, states, movers, resting, numbers, stopped, surplus: Vec::new() }
    });
    let mut bands: Vec<Band> = bands.collect();
    threads.share(bands.iter_mut().map(|band| || job(band)));
    surplus.clear();
    for band in &mut bands {
        surplus.append(&mut band.surplus);
    }
}

/// Runs `job` on every band of `states`, with the band's runs, the index of its first site, and its states.
pub(crate) fn for_each_band_of_states(
    states: &mut [u16],
    sites: &Sites,
    threads: &Threads,
    job: impl Fn(&[Run], usize, &mut [u16]) + Send + Sync,
) {
    let band_length = band_length(sites, threads);
    let job = &job;
    let band_job =
        |(n, states): (usize, _)| move || job(runs(sites, n * band_length, band_length), n * band_length, states);
    threads.share(states.chunks_mut(band_length).enumerate().map(band_job));
}
