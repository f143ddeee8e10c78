//! What a collision gives (phase C).
//!
//! Of the N particles of a site, own and placed ones excepted, m go on as movers. Their momentum V is that of the particles
//! that came, without l of them, P(l >= j) = q^j; with probability k it is that of min(m, 6) random ones of the six nearly
//! horizontal directions instead; with probability g one downward velocity is added. The outgoing state is one of those of
//! [`Collisions`] for m and V. If several particles were stopped and no state of m movers has V (before gravity), the movers
//! go in random directions. A lone mover only meets gravity.

use crate::lattice::collisions::{Collisions, DOWNWARDS};
use crate::lattice::draws::{Draws, Purpose, Streams, below, high, low};
use crate::lattice::gas::Gas;
use crate::lattice::rules::Odds;
use crate::lattice::sites::Sites;
use crate::lattice::velocities::{LEVEL, MOVERS, nth};

/// Words of a stream from which the picks of each kind are drawn.
const FORGOTTEN: u64 = 2;
const LEVELLED: u64 = 14;
const RANDOM: u64 = 26;

/// Collides every site: `movers` are those that go on.
pub(super) fn collide(sites: &Sites, gas: &mut Gas, table: &Collisions, odds: &Odds, t: u64) {
    let streams = Streams::new(odds.seed, t, Purpose::Collide, 0);
    let Gas { states, movers, numbers, held, .. } = gas;
    for run in &sites.runs {
        let range = run.start..run.start + run.len;
        let columns = states[range.clone()].iter().zip(&mut movers[range.clone()]);
        let columns = columns.zip(numbers[range.clone()].iter().zip(&held[range.clone()]));
        for (s, ((&state, movers), (&number, &held))) in range.zip(columns) {
            *movers = match number {
                _ if state & MOVERS == 0 => 0,
                1 => lone(state, table, odds, streams.of(s)),
                _ if number == held => 0,
                _ => outgoing(state, number, held, table, odds, streams.of(s)),
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
    if forgotten > 0 {
        resultant = table.sum(without(state, forgotten, number, draws)).resultant;
    }
    if odds.level.happens(high(first)) {
        resultant = table.sum(subset(LEVEL, count.min(6), draws, LEVELLED)).resultant;
    }
    if held >= 2 && !table.choice(count, resultant).is_exact {
        return subset(MOVERS, count, draws, RANDOM);
    }
    if odds.fall.happens(low(second)) {
        resultant -= DOWNWARDS;
    }
    table.pick(table.choice(count, resultant), high(second))
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
    let (mut left, mut chosen) = (set, 0);
    for i in 0..u64::from(count) {
        let next = nth(left, below(draws.high(word + i), left.count_ones()));
        left &= !(1 << next);
        chosen |= 1 << next;
    }
    chosen
}
