//! Propagation (phase F): every mover goes on to the site that its velocity points at.
//!
//! A blocked mover stays and turns round ([`reflection`](crate::lattice::reflection)); one that arrives in a sink is out.
//! Each site gathers what comes from its twelve neighbours, so a column of sites is twelve shifted columns, masked.

use bevy_ecs::prelude::*;

use crate::lattice::bands;
use crate::lattice::draws::{Purpose, Streams, below};
use crate::lattice::gas::Gas;
use crate::lattice::rules::Odds;
use crate::lattice::sites::{Edge, Kind, Run, Sites};
use crate::lattice::velocities::{OPPOSITE, directions, nth, turned_round};
use crate::threads::Threads;

/// How walls reflect.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mirror {
    /// Like mirrors.
    Specular,
    /// At rough walls, into random directions.
    Random,
}

/// Moves the movers.
pub(super) fn propagate(sites: &Sites, gas: &mut Gas, threads: &Threads, odds: &Odds, mirror: Mirror, t: u64) {
    let streams = Streams::new(odds.seed, t, Purpose::Reflect, 0);
    let turned: Vec<u16> = sites.edges.iter().map(|edge| turn(edge, &mut gas.movers, mirror, streams)).collect();
    let Gas { states, movers, resting, .. } = gas;
    bands::write(states, sites, threads, |runs, first, states| {
        for run in runs {
            let states = &mut states[run.start - first..][..run.len];
            gather(run, states, &resting[run.start..], movers, sites);
        }
    });
    for (edge, turned) in sites.edges.iter().zip(turned) {
        gas.states[edge.site] |= turned;
    }
    let drained = drain(sites, gas);
    gas.let_out(drained);
}

/// What comes to a run of sites from its neighbours, and who rests there.
fn gather(run: &Run, states: &mut [u16], resting: &[u8], movers: &[u16], sites: &Sites) {
    for (state, &resting) in states.iter_mut().zip(resting) {
        *state = u16::from(resting);
    }
    for (direction, &back) in OPPOSITE.iter().enumerate().skip(1) {
        let source = run.start.wrapping_add_signed(sites.offset(run.parity, back));
        for (state, &movers) in states.iter_mut().zip(&movers[source..source + run.len]) {
            *state |= movers & 1 << direction;
        }
    }
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
        let arrives = |d: usize| u32::from(gas.movers[sites.neighbour(s, OPPOSITE[d])] & 1 << d != 0);
        (1..=12).map(arrives).sum::<u32>()
    })
    .sum()
}
