//! Collisions: chooses the outgoing movers of each site (phase C).
//!
//! A site has N incoming particles. Phases A and B have stopped some of them, in the site's own rest place and in rest
//! places of its neighbours. The remaining m particles are the outgoing movers. Their momentum V is found in three
//! steps:
//!
//! 1. V is the sum of the incoming velocities. l random particles are left out of the sum, with P(l >= j) = q^j.
//! 2. With probability k, V is replaced by the sum of min(m, 6) different random directions out of the six nearly
//!    horizontal ones.
//! 3. With probability g, one downward velocity is added to V.
//!
//! The outgoing state is drawn from the states that [`Collisions`] lists for m and V. Exception: if at least two
//! particles were stopped and no state of m movers has the sum V (before gravity), the movers get random directions.
//! A lone mover does not collide; only gravity acts on it.

use crate::bands::{self, Band};
use crate::collisions::{Collisions, DOWNWARDS};
use crate::draws::{Draws, Purpose, Streams, below, high, low};
use crate::gas::Gas;
use crate::rules::Odds;
use crate::sites::Sites;
use crate::velocities::{LEVEL, MOVERS, nth};
use siloflow_dem::threads::Threads;

// First word of a stream that each kind of random choice uses. Words 0 and 1 decide the rest.
const EXCLUDED_WORDS: u64 = 2;
const LEVEL_WORDS: u64 = 14;
const RANDOM_WORDS: u64 = 26;

/// Collides the particles of every site and writes the outgoing movers to the gas.
pub fn collide(sites: &Sites, gas: &mut Gas, threads: &Threads, table: &Collisions, odds: &Odds, t: u64) {
    let streams = Streams::new(odds.seed, t, Purpose::Collide, 0);
    bands::for_each_band(gas, sites, threads, |band| collide_in(band, table, odds, streams));
}

fn collide_in(band: &mut Band<'_>, table: &Collisions, odds: &Odds, streams: Streams) {
    let Band { runs, first, states, movers, numbers, stopped, .. } = band;
    for run in *runs {
        let range = run.start - *first..run.start - *first + run.len;
        let columns = states[range.clone()].iter().zip(&mut movers[range.clone()]);
        let columns = columns.zip(numbers[range.clone()].iter().zip(&stopped[range.clone()]));
        for (s, ((&state, movers), (&number, &stopped))) in (run.start..).zip(columns) {
            *movers = if number >= 2 && number != stopped {
                outgoing(state, number, stopped, table, odds, streams.of(s))
            } else if number == 1 && state & MOVERS != 0 {
                lone_mover(state, table, odds, streams.of(s))
            } else {
                0
            };
        }
    }
}

/// Returns the outgoing movers of a site with a lone mover, on which only gravity acts.
fn lone_mover(state: u16, table: &Collisions, odds: &Odds, draws: Draws) -> u16 {
    let word = draws.word(1);
    let fall = if odds.fall.happens(low(word)) { DOWNWARDS } else { 0 };
    table.pick(table.choice(1, table.sum(state).resultant - fall), high(word))
}

/// Returns the outgoing movers of a site with `number` >= 2 particles, `stopped` of which have been stopped.
#[inline]
fn outgoing(state: u16, number: u8, stopped: u8, table: &Collisions, odds: &Odds, draws: Draws) -> u16 {
    let count = number - stopped;
    let first = draws.word(0);
    let second = draws.word(1);
    let mut resultant = table.sum(state).resultant;
    let excluded = odds.forget.draw(low(first), number);
    let is_level = odds.level.happens(high(first));
    if excluded > 0 || is_level {
        resultant = table.sum(replaced_state(state, number, count, excluded, is_level, draws)).resultant;
    }
    if stopped >= 2 && !table.choice(count, resultant).is_exact {
        return random_subset(MOVERS, count, draws, RANDOM_WORDS);
    }
    if odds.fall.happens(low(second)) {
        resultant -= DOWNWARDS;
    }
    table.pick(table.choice(count, resultant), high(second))
}

/// Returns a state whose momentum replaces the momentum of `state`. With internal friction (`is_level`) the state is a
/// random set of nearly horizontal directions; otherwise it is `state` without `excluded` random particles.
// Not inlined, because most sites need neither.
#[inline(never)]
fn replaced_state(state: u16, number: u8, count: u8, excluded: u8, is_level: bool, draws: Draws) -> u16 {
    if is_level {
        random_subset(LEVEL, count.min(6), draws, LEVEL_WORDS)
    } else {
        without_random(state, excluded, number, draws)
    }
}

/// Returns `state` without `count` random particles; `number` is the number of particles in `state`.
fn without_random(state: u16, count: u8, number: u8, draws: Draws) -> u16 {
    let mut left = u32::from(number);
    (0..u64::from(count)).fold(state, |state, i| {
        let removed = nth(state, below(draws.high(EXCLUDED_WORDS + i), left));
        left -= 1;
        state & !(1 << removed)
    })
}

/// Returns `count` random members of a set. Uses the words of the stream from `word` on.
fn random_subset(set: u16, count: u8, draws: Draws, word: u64) -> u16 {
    if u32::from(count) == set.count_ones() {
        return set;
    }
    let mut left = set;
    let mut chosen = 0;
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
    use crate::outline::Polygon;
    use crate::rules::Rules;
    use crate::scatter::place_surplus;
    use crate::stop::stop;
    use crate::velocities::momentum;
    use siloflow_dem::space::Vector;

    /// Collides each of the 8192 states once, with q = b = k = h = 0. The box has a site for each state. Returns the
    /// state before, the outgoing movers, and the number of stopped particles.
    fn collided(p: f64, g: f64, seed: u64) -> Vec<(u16, u16, u8)> {
        let box_of = [(0.0, 0.0), (120.0, 0.0), (120.0, 80.0), (0.0, 80.0)].map(|(x, y)| Vector::new(x, y));
        let sites = Sites::new(&Polygon(box_of.to_vec()), &[], None, 1.0);
        let mut gas = Gas::new(&sites);
        let filled: Vec<usize> = sites.fluid().take(1 << 13).collect();
        assert_eq!(filled.len(), 1 << 13);
        for (state, &s) in (0..).zip(&filled) {
            gas.states[s] = state;
        }
        let keys = format!("(spacing: 1.0, p: {p:?}, q: 0.0, b: 0.0, k: 0.0, g: {g:?}, h: 0.0)");
        let rules: Rules = ron::from_str(&keys).unwrap();
        let table = Collisions::default();
        let odds = Odds::new(&rules, seed);
        let threads = Threads::new(std::num::NonZeroUsize::MIN).unwrap();
        stop(&sites, &mut gas, &threads, &table, &odds, 1);
        place_surplus(&sites, &mut gas, &odds, 1);
        collide(&sites, &mut gas, &threads, &table, &odds, 1);
        filled.iter().map(|&s| (gas.states[s], gas.movers[s], gas.stopped[s])).collect()
    }

    #[test]
    fn elastic_collisions_keep_number_and_momentum_of_every_state() {
        for seed in 0..20 {
            for (before, movers, stopped) in collided(0.0, 0.0, seed) {
                if before.count_ones() > 1 {
                    assert_eq!(momentum(movers), momentum(before), "{before:#b}");
                    assert_eq!(movers.count_ones() + u32::from(stopped), before.count_ones(), "{before:#b}");
                }
            }
        }
    }

    #[test]
    fn collisions_conserve_the_number_of_particles() {
        for (before, movers, stopped) in collided(0.6, 0.5, 3) {
            if before.count_ones() > 1 {
                assert_eq!(movers.count_ones() + u32::from(stopped), before.count_ones(), "{before:#b}");
            }
        }
    }

    #[test]
    fn a_kick_lowers_the_momentum_of_a_lone_mover_by_one_if_the_lattice_has_that_direction() {
        let after = collided(0.0, 1.0, 4);
        for (direction, kicked) in [(2, 3), (6, 5), (7, 2), (12, 6), (3, 9), (5, 10)] {
            assert_eq!(after[1 << direction].1, 1 << kicked, "{direction}");
        }
        // Directions 9 and 10 already have the terminal speed. 4, 9 and 10 are equally near to twice direction 4.
        for direction in [9, 10] {
            assert_eq!(after[1 << direction].1, 1 << direction);
        }
        assert!([1 << 4, 1 << 9, 1 << 10].contains(&after[1 << 4].1));
    }
}
