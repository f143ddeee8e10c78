//! Wall friction: rough walls stop particles (phase D, the paper's second method).
//!
//! Each mover that a rough wall blocks stops with probability b. One of the stopped particles takes the site's own rest
//! place if it is free. The others need a rest place at a neighbour ([`scatter`](crate::scatter)), which
//! prefers neighbours with few movers. A particle that finds no place keeps moving and is reflected.

use crate::draws::{Draws, Purpose, Streams, below};
use crate::gas::{Gas, Surplus};
use crate::rules::Odds;
use crate::scatter::{Rounds, scatter};
use crate::sites::{Edge, Sites};
use crate::velocities::{directions, nth};

/// First word of a stream that selects the particles that have found a place.
const PLACED: u64 = 13;

/// Movers of a site that a wall has stopped and that need a rest place at a neighbour.
struct Stopped {
    site: usize,
    movers: u16,
    placed: u64,
}

/// Stops particles at rough walls in step `t`.
pub fn stop_at_rough_walls(sites: &Sites, gas: &mut Gas, odds: &Odds, t: u64) {
    let streams = Streams::new(odds.seed, t, Purpose::StopAtWall, 0);
    let mut stopped: Vec<Stopped> = Vec::new();
    for edge in &sites.edges {
        let movers = stopped_at(edge, gas, odds, streams.of(edge.site));
        if movers != 0 {
            stopped.push(Stopped { site: edge.site, movers, placed: 0 });
        }
    }
    let Gas { movers, resting, surplus, .. } = gas;
    #[expect(clippy::cast_possible_truncation, reason = "at most 12")]
    let number = |s: usize| movers[s].count_ones() as u8;
    surplus.clear();
    let count = |one: &Stopped| u8::try_from(one.movers.count_ones()).unwrap_or(0);
    surplus.extend(stopped.iter().map(|one| Surplus { site: one.site, count: count(one) }));
    let rounds = Rounds { seed: odds.seed, t, purpose: Purpose::ScatterAtWall };
    scatter(sites, surplus, resting, &rounds, number, |donor| {
        if let Ok(place) = stopped.binary_search_by_key(&donor, |one| one.site) {
            stopped[place].placed += 1;
        }
    });
    for Stopped { site, movers: mut left, placed } in stopped {
        for i in 0..placed {
            let removed = nth(left, below(streams.of(site).high(PLACED + i), left.count_ones()));
            left &= !(1 << removed);
            movers[site] &= !(1 << removed);
        }
    }
}

/// Draws the movers of a site that the wall stops, and puts one of them into the site's own rest place if it is free.
/// Returns the other stopped movers, as a state.
fn stopped_at(edge: &Edge, gas: &mut Gas, odds: &Odds, draws: Draws) -> u16 {
    let hits = gas.movers[edge.site] & edge.rough;
    let mut stopped = directions(hits)
        .filter(|&d| odds.stop_at_wall.happens(draws.high(d as u64)))
        .fold(0, |stopped, d| stopped | 1 << d);
    if stopped != 0 && gas.resting[edge.site] == 0 {
        let rests = 1 << nth(stopped, below(draws.high(0), stopped.count_ones()));
        stopped &= !rests;
        gas.movers[edge.site] &= !rests;
        gas.resting[edge.site] = 1;
    }
    stopped
}
