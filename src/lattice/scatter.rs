//! Stopped particles look for a place at rest next to their site (phase B).
//!
//! Two rounds of proposing and accepting. A donor with e particles left proposes to the first e of its nearest neighbours
//! whose place at rest is free, those with the fewest particles first, equal ones in random order. A neighbour that got
//! proposals takes one of them at random. What finds no place goes on moving.
//!
//! Every decision depends on what was there before the round and on draws of its own site: not on the order of the sites.

use crate::lattice::draws::{Draws, Purpose, Streams, below};
use crate::lattice::gas::Gas;
use crate::lattice::rules::Odds;
use crate::lattice::sites::Sites;
use crate::lattice::velocities::nth;

const ROUNDS: u64 = 2;

/// The streams of the rounds.
pub(super) struct Rounds {
    /// Seed of the draws.
    pub seed: u64,
    /// The step.
    pub t: u64,
    /// What they are for.
    pub purpose: Purpose,
}

/// Finds places for those that a collision has stopped.
pub(super) fn place(sites: &Sites, gas: &mut Gas, odds: &Odds, t: u64) {
    let Gas { resting, numbers, held, spare, .. } = gas;
    let rounds = Rounds { seed: odds.seed, t, purpose: Purpose::Scatter };
    scatter(sites, spare, resting, &rounds, |s| numbers[s], |donor| held[donor] += 1);
}

/// What one donor, by its place on the list, asks in one round.
struct Proposal {
    place: usize,
    to: usize,
    direction: usize,
}

/// Gives places in `resting` to the particles of `spare` (site, how many) and tells `taken` the donor of each. `number` is how
/// crowded a site is.
pub(super) fn scatter(
    sites: &Sites,
    spare: &mut [(usize, u8)],
    resting: &mut [u8],
    rounds: &Rounds,
    number: impl Fn(usize) -> u8,
    mut taken: impl FnMut(usize),
) {
    let mut proposals = Vec::new();
    for round in 0..ROUNDS {
        let streams = |sub_step| Streams::new(rounds.seed, rounds.t, rounds.purpose, 2 * round + sub_step);
        proposals.clear();
        for (place, &(donor, left)) in spare.iter().enumerate().filter(|(_, (_, left))| *left > 0) {
            let to = propose(sites, donor, left, resting, &number, streams(0).of(donor));
            proposals.extend(to.map(|(to, direction)| Proposal { place, to, direction }));
        }
        // One neighbour's proposals side by side, in ascending order of direction.
        proposals.sort_unstable_by_key(|p| (p.to, p.direction));
        let accept = streams(1);
        for asked in proposals.chunk_by(|a, b| a.to == b.to) {
            let chosen = asked.iter().fold(0, |set, p| set | 1 << p.direction);
            let direction = nth(chosen, below(accept.of(asked[0].to).high(0), chosen.count_ones()));
            let Some(winner) = asked.iter().find(|p| p.direction == direction) else { continue };
            resting[winner.to] = 1;
            let (donor, left) = &mut spare[winner.place];
            *left -= 1;
            taken(*donor);
        }
    }
}

/// The sites to which one donor proposes for `left` particles, and in which directions they are.
fn propose(
    sites: &Sites,
    donor: usize,
    left: u8,
    resting: &[u8],
    number: &impl Fn(usize) -> u8,
    draws: Draws,
) -> impl Iterator<Item = (usize, usize)> {
    let mut free = [(0, 0, 0); 6];
    let mut count = 0;
    for direction in 1..=6 {
        let to = sites.neighbour(donor, direction);
        if resting[to] == 0 {
            free[count] = (number(to), draws.word(direction as u64), direction);
            count += 1;
        }
    }
    free[..count].sort_unstable();
    let chosen = free.into_iter().take(count.min(usize::from(left)));
    chosen.map(move |(_, _, direction)| (sites.neighbour(donor, direction), direction))
}
