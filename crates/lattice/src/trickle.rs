//! Gravity of particles at rest (phase E).
//!
//! With probability h, a particle at rest proposes to move down into the rest place of another site. Its direction is
//! random among the downward directions that are not blocked and end at a free rest place or a sink. A site with
//! several proposals accepts a random one. A sink accepts all. A refused particle stays.

use crate::draws::{Purpose, Streams, below};
use crate::gas::Gas;
use crate::rules::Odds;
use crate::sites::{Kind, Sites};
use crate::velocities::{DESCENDING, directions, nth};

/// A proposed move of a particle at rest.
struct Move {
    from: usize,
    to: usize,
    direction: usize,
}

/// Moves particles at rest down in step `t`.
pub fn trickle(sites: &Sites, gas: &mut Gas, odds: &Odds, t: u64) {
    let streams = Streams::new(odds.seed, t, Purpose::Trickle, 0);
    let mut moves = Vec::new();
    for run in &sites.runs {
        for_each_resting(&gas.resting[run.start..run.start + run.len], |place| {
            let s = run.start + place;
            let draws = streams.of(s);
            if odds.trickle.happens(draws.high(0)) {
                let ways = ways_down(sites, gas, s);
                if ways != 0 {
                    let direction = nth(ways, below(draws.high(1), ways.count_ones()));
                    moves.push(Move { from: s, to: sites.neighbour(s, direction), direction });
                }
            }
        });
    }
    moves.sort_unstable_by_key(|one| (one.to, one.direction));
    let accept = Streams::new(odds.seed, t, Purpose::Trickle, 1);
    for rivals in moves.chunk_by(|a, b| a.to == b.to) {
        let to = rivals[0].to;
        if sites.kinds[to] == Kind::Sink {
            for one in rivals {
                gas.resting[one.from] = 0;
            }
            gas.add_out(u32::try_from(rivals.len()).unwrap_or(u32::MAX));
        } else {
            let winner = below(accept.of(to).high(0), u32::try_from(rivals.len()).unwrap_or(u32::MAX));
            gas.resting[rivals[winner as usize].from] = 0;
            gas.resting[to] = 1;
        }
    }
}

/// Calls `then` with the index of each site of a run that has a particle at rest. Tests eight sites at a time; the
/// elements of `resting` are 0 or 1.
fn for_each_resting(resting: &[u8], mut then: impl FnMut(usize)) {
    let (eights, others) = resting.as_chunks::<8>();
    for (n, eight) in eights.iter().enumerate() {
        let mut ones = u64::from_le_bytes(*eight);
        while ones != 0 {
            then(8 * n + ones.trailing_zeros() as usize / 8);
            ones &= ones - 1;
        }
    }
    let first = 8 * eights.len();
    (first..).zip(others).filter(|(_, resting)| **resting == 1).for_each(|(place, _)| then(place));
}

/// Returns the directions in which a particle at rest can move down, as a state.
fn ways_down(sites: &Sites, gas: &Gas, site: usize) -> u16 {
    let is_free = |&d: &usize| {
        let to = sites.neighbour(site, d);
        gas.resting[to] == 0 || sites.kinds[to] == Kind::Sink
    };
    directions(DESCENDING & !sites.blocked[site]).filter(is_free).fold(0, |ways, d| ways | 1 << d)
}
