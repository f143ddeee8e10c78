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

/// What one donor asks in one round.
struct Proposal {
    donor: usize,
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
        for &(donor, left) in spare.iter().filter(|(_, left)| *left > 0) {
            propose(sites, donor, left, resting, &number, streams(0).of(donor), &mut proposals);
        }
        // One neighbour's proposals side by side, in ascending order of direction.
        proposals.sort_unstable_by_key(|p| (p.to, p.direction));
        let accept = streams(1);
        for asked in proposals.chunk_by(|a, b| a.to == b.to) {
            let chosen = asked.iter().fold(0, |set, p| set | 1 << p.direction);
            let direction = nth(chosen, below(accept.of(asked[0].to).high(0), chosen.count_ones()));
            let Some(winner) = asked.iter().find(|p| p.direction == direction) else { continue };
            resting[winner.to] = 1;
            taken(winner.donor);
            // Donors are few and in ascending order.
            if let Ok(place) = spare.binary_search_by_key(&winner.donor, |&(site, _)| site) {
                spare[place].1 -= 1;
            }
        }
    }
}

/// The proposals of one donor for `left` particles.
fn propose(
    sites: &Sites,
    donor: usize,
    left: u8,
    resting: &[u8],
    number: &impl Fn(usize) -> u8,
    draws: Draws,
    proposals: &mut Vec<Proposal>,
) {
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
    for &(_, _, direction) in free[..count].iter().take(usize::from(left)) {
        proposals.push(Proposal { donor, to: sites.neighbour(donor, direction), direction });
    }
}
