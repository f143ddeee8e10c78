//! How many particles of a site stop in a collision (phase A).
//!
//! A site with N >= 2 particles, one of them moving, stops n of them, with P(n >= j) = p^j, j <= N. One stays in the site's own
//! place at rest, n - 1 want a place at rest next to it ([`scatter`](crate::lattice::scatter)). Of 13 particles one has to
//! rest. A lone particle does not collide: it moves on, or stays at rest.
//!
//! With p = 0 momentum is to be exact: a particle at rest then stays there if no state of N movers has the momentum.

use crate::lattice::bands::{self, Band};
use crate::lattice::collisions::Collisions;
use crate::lattice::draws::{Purpose, Streams};
use crate::lattice::gas::Gas;
use crate::lattice::rules::Odds;
use crate::lattice::sites::Sites;
use crate::threads::Threads;

/// Decides on every site; the sites with more than one stopped particle are in `spare` afterwards.
pub(super) fn stop(sites: &Sites, gas: &mut Gas, threads: &Threads, table: &Collisions, odds: &Odds, t: u64) {
    let streams = Streams::new(odds.seed, t, Purpose::Stop, 0);
    bands::work(gas, sites, threads, |band| stop_in(band, table, odds, streams));
}

fn stop_in(band: &mut Band<'_>, table: &Collisions, odds: &Odds, streams: Streams) {
    let Band { runs, first, states, resting, numbers, held, spare, .. } = band;
    for run in *runs {
        let range = run.start - *first..run.start - *first + run.len;
        let columns = states[range.clone()].iter().zip(&mut resting[range.clone()]);
        let columns = columns.zip(numbers[range.clone()].iter_mut().zip(&mut held[range.clone()]));
        for (s, ((&state, resting), (number, held))) in (run.start..).zip(columns) {
            let moving = table.sum(state).count;
            let rests = (state & 1) as u8;
            *number = moving + rests;
            if *number < 2 {
                (*resting, *held) = (rests, 0);
                continue;
            }
            let mut stopped = odds.stop.draw(streams.of(s).high(0), *number).max(number.saturating_sub(12));
            if odds.is_elastic && stopped < rests && !is_attainable(table, state, *number) {
                stopped = rests;
            }
            *resting = stopped.min(1);
            *held = *resting;
            if stopped > 1 {
                spare.push((s, stopped - 1));
            }
        }
    }
}

/// Whether some state of so many movers has the momentum of `state`.
fn is_attainable(table: &Collisions, state: u16, number: u8) -> bool {
    number <= 12 && table.choice(number, table.sum(state).resultant).is_exact
}
