//! Propagation (phase F): every mover goes on to the site that its velocity points at.
//!
//! A blocked mover stays and turns round ([`reflection`](crate::lattice::reflection)); one that arrives in a sink is out.
//! Each site gathers what comes from its twelve neighbours, so a column of sites is twelve shifted columns, masked.

use crate::lattice::draws::{Purpose, Streams, below};
use crate::lattice::gas::Gas;
use crate::lattice::rules::Odds;
use crate::lattice::sites::{Edge, Kind, Sites};
use crate::lattice::velocities::{OPPOSITE, directions, nth, turned_round};

/// How walls reflect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mirror {
    /// Like mirrors.
    Specular,
    /// At rough walls, into random directions.
    Random,
}

/// Moves the movers.
pub(super) fn propagate(sites: &Sites, gas: &mut Gas, odds: &Odds, mirror: Mirror, t: u64) {
    let streams = Streams::new(odds.seed, t, Purpose::Reflect, 0);
    let turned: Vec<u16> = sites.edges.iter().map(|edge| turn(edge, &mut gas.movers, mirror, streams)).collect();
    for run in &sites.runs {
        let range = run.start..run.start + run.len;
        let states = &mut gas.states[range.clone()];
        for (state, &resting) in states.iter_mut().zip(&gas.resting[range]) {
            *state = u16::from(resting);
        }
        for direction in 1..=12 {
            let source = run.start.wrapping_add_signed(sites.offset(run.parity, OPPOSITE[direction]));
            for (state, &movers) in states.iter_mut().zip(&gas.movers[source..source + run.len]) {
                *state |= movers & 1 << direction;
            }
        }
    }
    for (edge, turned) in sites.edges.iter().zip(turned) {
        gas.states[edge.site] |= turned;
    }
    let drained = drain(sites, gas);
    gas.let_out(drained);
}

/// Takes the blocked movers of a site out and returns them as they are reflected.
fn turn(edge: &Edge, movers: &mut [u16], mirror: Mirror, streams: Streams) -> u16 {
    let blocked = movers[edge.site] & edge.blocked;
    if blocked == 0 {
        return 0;
    }
    movers[edge.site] &= !edge.blocked;
    if mirror == Mirror::Specular || edge.rough == 0 {
        return directions(blocked).fold(0, |turned, d| turned | 1 << edge.reflection[d]);
    }
    let draws = streams.of(edge.site);
    let mut left = turned_round(edge.blocked);
    let mut turned = 0;
    for d in directions(blocked) {
        let to = 1 << nth(left, below(draws.high(d as u64), left.count_ones()));
        left &= !to;
        turned |= to;
    }
    turned
}

/// Movers that arrive in sinks.
fn drain(sites: &Sites, gas: &Gas) -> u32 {
    let open = sites.doorway.iter().filter(|&&s| sites.kinds[s] == Kind::Sink);
    open.map(|&s| {
        let arrives = |&d: &usize| gas.movers[sites.neighbour(s, OPPOSITE[d])] & 1 << d != 0;
        (1..=12).filter(arrives).count() as u32
    })
    .sum()
}
