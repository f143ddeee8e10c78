//! Scatters surplus stopped particles into rest places of neighbouring sites (phase B).
//!
//! There are two rounds of proposals and acceptance. A donor is a site with e surplus particles. It sorts its nearest
//! neighbours with a free rest place by their number of particles, with ties in random order, and proposes to the first
//! e. A neighbour with several proposals accepts a random one. Particles that find no place keep moving.
//!
//! Decisions depend only on the state before the round and on the random numbers of one site. The order of the sites
//! does not matter.

use crate::draws::{Draws, Purpose, Streams, below};
use crate::gas::{Gas, Surplus};
use crate::rules::Odds;
use crate::sites::Sites;
use crate::velocities::nth;

const ROUNDS: u64 = 2;

/// Parameters of the random streams that the rounds use.
pub(crate) struct Rounds {
    /// Seed of the random numbers.
    pub seed: u64,
    /// Step.
    pub t: u64,
    /// Purpose of the streams.
    pub purpose: Purpose,
}

/// Finds rest places at neighbours for surplus particles that collisions have stopped.
pub fn place_surplus(sites: &Sites, gas: &mut Gas, odds: &Odds, t: u64) {
    let Gas { resting, numbers, stopped, surplus, .. } = gas;
    let rounds = Rounds { seed: odds.seed, t, purpose: Purpose::Scatter };
    scatter(sites, surplus, resting, &rounds, |s| numbers[s], |donor| stopped[donor] += 1);
}

/// A proposal of a donor to the site `to`, which is its neighbour in `direction`.
struct Proposal {
    /// Index of the donor in the list of donors.
    index: usize,
    to: usize,
    direction: usize,
}

/// Assigns rest places in `resting` to the surplus particles of the donors. Calls `taken`
/// with the donor of each particle that gets a place. `number` returns the number of particles of a site.
pub(crate) fn scatter(
    sites: &Sites,
    donors: &mut [Surplus],
    resting: &mut [u8],
    rounds: &Rounds,
    number: impl Fn(usize) -> u8,
    mut taken: impl FnMut(usize),
) {
    let mut proposals = Vec::new();
    for round in 0..ROUNDS {
        let streams = |sub_step| Streams::new(rounds.seed, rounds.t, rounds.purpose, 2 * round + sub_step);
        proposals.clear();
        for (index, &Surplus { site, count }) in donors.iter().enumerate().filter(|(_, donor)| donor.count > 0) {
            let to = propose(sites, site, count, resting, &number, streams(0).of(site));
            proposals.extend(to.map(|(to, direction)| Proposal { index, to, direction }));
        }
        // Groups the proposals by neighbour, in ascending order of direction.
        proposals.sort_unstable_by_key(|p| (p.to, p.direction));
        let accept = streams(1);
        for rivals in proposals.chunk_by(|a, b| a.to == b.to) {
            let chosen = rivals.iter().fold(0, |set, p| set | 1 << p.direction);
            let direction = nth(chosen, below(accept.of(rivals[0].to).high(0), chosen.count_ones()));
            let Some(winner) = rivals.iter().find(|p| p.direction == direction) else { continue };
            resting[winner.to] = 1;
            let donor = &mut donors[winner.index];
            donor.count -= 1;
            taken(donor.site);
        }
    }
}

/// Returns the sites to which a donor with `left` surplus particles proposes, each with its direction from the donor.
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
