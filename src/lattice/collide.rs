//! What a collision gives (phase C).
//!
//! Of the N particles of a site, own and placed ones excepted, m go on as movers. Their momentum V is that of the particles
//! that came, without l of them, P(l >= j) = q^j; with probability k it is that of min(m, 6) random ones of the six nearly
//! horizontal directions instead; with probability g one downward velocity is added. The outgoing state is one of those of
//! [`Collisions`] for m and V. If several particles were stopped and no state of m movers has V (before gravity), the movers
//! go in random directions. A lone mover only meets gravity.

use crate::lattice::bands::{self, Band};
use crate::lattice::collisions::{Collisions, DOWNWARDS};
use crate::lattice::draws::{Draws, Purpose, Streams, below, high, low};
use crate::lattice::gas::Gas;
use crate::lattice::rules::Odds;
use crate::lattice::sites::Sites;
use crate::lattice::velocities::{LEVEL, MOVERS, nth};
use crate::threads::Threads;

/// Words of a stream from which the picks of each kind are drawn.
const FORGOTTEN: u64 = 2;
const LEVELLED: u64 = 14;
const RANDOM: u64 = 26;

/// Collides every site: `movers` are those that go on.
pub(super) fn collide(sites: &Sites, gas: &mut Gas, threads: &Threads, table: &Collisions, odds: &Odds, t: u64) {
    let streams = Streams::new(odds.seed, t, Purpose::Collide, 0);
    bands::work(gas, sites, threads, |band| collide_in(band, table, odds, streams));
}

fn collide_in(band: &mut Band<'_>, table: &Collisions, odds: &Odds, streams: Streams) {
    let Band { runs, first, states, movers, numbers, held, .. } = band;
    for run in *runs {
        let range = run.start - *first..run.start - *first + run.len;
        let columns = states[range.clone()].iter().zip(&mut movers[range.clone()]);
        let columns = columns.zip(numbers[range.clone()].iter().zip(&held[range.clone()]));
        for (s, ((&state, movers), (&number, &held))) in (run.start..).zip(columns) {
            *movers = if number >= 2 && number != held {
                outgoing(state, number, held, table, odds, streams.of(s))
            } else if number == 1 && state & MOVERS != 0 {
                lone(state, table, odds, streams.of(s))
            } else {
                0
            };
        }
    }
}

/// A lone mover, with gravity.
fn lone(state: u16, table: &Collisions, odds: &Odds, draws: Draws) -> u16 {
    let word = draws.word(1);
    let fall = if odds.fall.happens(low(word)) { DOWNWARDS } else { 0 };
    table.pick(table.choice(1, table.sum(state).resultant - fall), high(word))
}

#[inline]
fn outgoing(state: u16, number: u8, held: u8, table: &Collisions, odds: &Odds, draws: Draws) -> u16 {
    let count = number - held;
    let (first, second) = (draws.word(0), draws.word(1));
    let mut resultant = table.sum(state).resultant;
    let forgotten = odds.forget.draw(low(first), number);
    let is_level = odds.level.happens(high(first));
    if forgotten > 0 || is_level {
        resultant = table.sum(rubbed(state, number, count, forgotten, is_level, draws)).resultant;
    }
    if held >= 2 && !table.choice(count, resultant).is_exact {
        return subset(MOVERS, count, draws, RANDOM);
    }
    if odds.fall.happens(low(second)) {
        resultant -= DOWNWARDS;
    }
    table.pick(table.choice(count, resultant), high(second))
}

/// A state whose momentum counts instead of that of `state`: by internal friction that of nearly horizontal directions, or
/// else that of the particles that are not forgotten. Out of the way of the sites where neither happens.
#[inline(never)]
fn rubbed(state: u16, number: u8, count: u8, forgotten: u8, is_level: bool, draws: Draws) -> u16 {
    if is_level { subset(LEVEL, count.min(6), draws, LEVELLED) } else { without(state, forgotten, number, draws) }
}

/// A state without some of its particles, at random.
fn without(state: u16, count: u8, number: u8, draws: Draws) -> u16 {
    let mut left = u32::from(number);
    (0..u64::from(count)).fold(state, |state, i| {
        let gone = nth(state, below(draws.high(FORGOTTEN + i), left));
        left -= 1;
        state & !(1 << gone)
    })
}

/// So many random members of a set; draws from the words after `word`.
fn subset(set: u16, count: u8, draws: Draws, word: u64) -> u16 {
    if u32::from(count) == set.count_ones() {
        return set;
    }
    let (mut left, mut chosen) = (set, 0);
    for i in 0..u64::from(count) {
        let next = nth(left, below(draws.high(word + i), left.count_ones()));
        left &= !(1 << next);
        chosen |= 1 << next;
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::outline::Polygon;
    use crate::lattice::rules::Rules;
    use crate::lattice::scatter::place;
    use crate::lattice::stop::stop;
    use crate::lattice::velocities::momentum;
    use crate::space::Vector;

    /// One state a site of a wide box, collided once by the rules with these numbers.
    fn collided(p: f64, g: f64, seed: u64) -> Vec<(u16, u16, u8)> {
        let box_of = [(0.0, 0.0), (120.0, 0.0), (120.0, 80.0), (0.0, 80.0)].map(|(x, y)| Vector::new(x, y));
        let sites = Sites::new(&Polygon(box_of.to_vec()), &[], None, 1.0);
        let mut gas = Gas::new(&sites);
        let mine: Vec<usize> = sites.fluid().take(1 << 13).collect();
        assert_eq!(mine.len(), 1 << 13);
        for (state, &s) in (0..).zip(&mine) {
            gas.states[s] = state;
        }
        let keys = format!("(spacing: 1.0, p: {p:?}, q: 0.0, b: 0.0, k: 0.0, g: {g:?}, h: 0.0)");
        let rules: Rules = ron::from_str(&keys).unwrap();
        let (table, odds) = (Collisions::default(), Odds::new(&rules, seed));
        let threads = Threads::new(std::num::NonZeroUsize::MIN).unwrap();
        stop(&sites, &mut gas, &threads, &table, &odds, 1);
        place(&sites, &mut gas, &odds, 1);
        collide(&sites, &mut gas, &threads, &table, &odds, 1);
        mine.iter().map(|&s| (gas.states[s], gas.movers[s], gas.held[s])).collect()
    }

    #[test]
    fn elastic_collisions_keep_number_and_momentum_of_every_state() {
        for seed in 0..20 {
            for (before, movers, held) in collided(0.0, 0.0, seed) {
                if before.count_ones() > 1 {
                    assert_eq!(momentum(movers), momentum(before), "{before:#b}");
                    assert_eq!(movers.count_ones() + u32::from(held), before.count_ones(), "{before:#b}");
                }
            }
        }
    }

    #[test]
    fn stopped_and_moving_particles_are_all_there_were() {
        for (before, movers, held) in collided(0.6, 0.5, 3) {
            if before.count_ones() > 1 {
                assert_eq!(movers.count_ones() + u32::from(held), before.count_ones(), "{before:#b}");
            }
        }
    }

    #[test]
    fn a_kick_takes_the_momentum_of_a_lone_mover_down_by_one_if_there_is_such_a_direction() {
        let after = collided(0.0, 1.0, 4);
        for (direction, kicked) in [(2, 3), (6, 5), (7, 2), (12, 6), (3, 9), (5, 10)] {
            assert_eq!(after[1 << direction].1, 1 << kicked, "{direction}");
        }
        // As fast as they can fall; 4, 9 and 10 are equally near to twice 4.
        for direction in [9, 10] {
            assert_eq!(after[1 << direction].1, 1 << direction);
        }
        assert!([1 << 4, 1 << 9, 1 << 10].contains(&after[1 << 4].1));
    }
}
