//! Draws how many particles of each site stop in a collision (phase A).
//!
//! A site with N >= 2 particles, of which at least one moves, stops n of them, with P(n >= j) = p^j for j <= N. One
//! stopped particle takes the site's own rest place. The other n - 1 need a rest place at a neighbour
//! ([`scatter`](crate::scatter)). With 13 particles, n is at least 1, because a site holds at most 12 movers.
//! A lone particle does not collide: it keeps moving or stays at rest.
//!
//! With p = 0 momentum has to be exact. A particle at rest therefore stays at rest if no state of N movers has the
//! momentum of the site.

use crate::bands::{self, Band};
use crate::collisions::Collisions;
use crate::draws::{Purpose, Streams};
use crate::gas::{Gas, Surplus};
use crate::rules::Odds;
use crate::sites::Sites;
use siloflow_dem::threads::Threads;

/// Draws the stopped particles of every site. `Gas::surplus` then lists the sites with more than one stopped particle.
pub fn stop(sites: &Sites, gas: &mut Gas, threads: &Threads, table: &Collisions, odds: &Odds, t: u64) {
    let streams = Streams::new(odds.seed, t, Purpose::Stop, 0);
    bands::for_each_band(gas, sites, threads, |band| stop_in(band, table, odds, streams));
}

fn stop_in(band: &mut Band<'_>, table: &Collisions, odds: &Odds, streams: Streams) {
    let Band { runs, first, states, resting, numbers, stopped, surplus, .. } = band;
    for run in *runs {
        let range = run.start - *first..run.start - *first + run.len;
        let columns = states[range.clone()].iter().zip(&mut resting[range.clone()]);
        let columns = columns.zip(numbers[range.clone()].iter_mut().zip(&mut stopped[range.clone()]));
        for (s, ((&state, resting), (number, stopped))) in (run.start..).zip(columns) {
            let moving = table.sum(state).count;
            let rests = (state & 1) as u8;
            *number = moving + rests;
            if *number < 2 {
                *resting = rests;
                *stopped = 0;
                continue;
            }
            let mut count = odds.stop.draw(streams.of(s).high(0), *number).max(number.saturating_sub(12));
            if odds.is_elastic && count < rests && !is_attainable(table, state, *number) {
                count = rests;
            }
            *resting = count.min(1);
            *stopped = *resting;
            if count > 1 {
                surplus.push(Surplus { site: s, count: count - 1 });
            }
        }
    }
}

/// Whether a state of `number` movers has exactly the momentum of `state`.
fn is_attainable(table: &Collisions, state: u16, number: u8) -> bool {
    number <= 12 && table.choice(number, table.sum(state).resultant).is_exact
}
