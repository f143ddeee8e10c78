//! Propagation (phase F): each mover goes to the site that its velocity points to.
//!
//! A blocked mover stays at its site with a reflected velocity ([`reflection`](crate::reflection)). A mover
//! that arrives in a sink is out. Each site gathers the movers from its twelve neighbours. A column of sites is
//! therefore the union of twelve shifted columns, each masked to one direction.

use bevy_ecs::prelude::*;

use crate::bands;
use crate::draws::{Purpose, Streams, below};
use crate::gas::Gas;
use crate::rules::Odds;
use crate::sites::{Edge, Kind, Run, Sites};
use crate::velocities::{OPPOSITE, directions, nth, turned_round};
use siloflow_dem::threads::Threads;

/// How walls reflect movers.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReflectionRule {
    /// Specular reflection.
    Specular,
    /// Rough walls reflect into random directions, other walls specularly.
    Random,
}

/// Moves the movers of step `t` and writes the next states.
pub fn propagate(
    sites: &Sites,
    gas: &mut Gas,
    threads: &Threads,
    odds: &Odds,
    reflection_rule: ReflectionRule,
    t: u64,
) {
    let streams = Streams::new(odds.seed, t, Purpose::Reflect, 0);
    let reflected: Vec<u16> =
        sites.edges.iter().map(|edge| reflect_blocked(edge, &mut gas.movers, reflection_rule, streams)).collect();
    let Gas { states, movers, resting, .. } = gas;
    bands::for_each_band_of_states(states, sites, threads, |runs, first, states| {
        for run in runs {
            let states = &mut states[run.start - first..][..run.len];
            gather(run, states, &resting[run.start..], movers, sites);
        }
    });
    for (edge, reflected) in sites.edges.iter().zip(reflected) {
        gas.states[edge.site] |= reflected;
    }
    let arrived = count_arrivals_in_sinks(sites, gas);
    gas.add_out(arrived);
}

/// Writes the next states of a run of sites: the particles at rest and the movers that arrive from the neighbours.
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

/// Removes the blocked movers of a site and returns their reflected directions, as a state.
fn reflect_blocked(edge: &Edge, movers: &mut [u16], reflection_rule: ReflectionRule, streams: Streams) -> u16 {
    let blocked = movers[edge.site] & edge.blocked;
    if blocked == 0 {
        return 0;
    }
    movers[edge.site] &= !edge.blocked;
    if reflection_rule == ReflectionRule::Specular || edge.rough == 0 {
        return directions(blocked).fold(0, |reflected, d| reflected | 1 << edge.reflection[d]);
    }
    let draws = streams.of(edge.site);
    let mut left = turned_round(edge.blocked);
    let mut reflected = 0;
    for d in directions(blocked) {
        let to = 1 << nth(left, below(draws.high(d as u64), left.count_ones()));
        left &= !to;
        reflected |= to;
    }
    reflected
}

/// Returns the number of movers that arrive in sinks.
fn count_arrivals_in_sinks(sites: &Sites, gas: &Gas) -> u32 {
    let open = sites.doorway.iter().filter(|&&s| sites.kinds[s] == Kind::Sink);
    open.map(|&s| {
        let arrives = |d: usize| u32::from(gas.movers[sites.neighbour(s, OPPOSITE[d])] & 1 << d != 0);
        (1..=12).map(arrives).sum::<u32>()
    })
    .sum()
}
