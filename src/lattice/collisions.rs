//! The collision table: which states of m movers have a wanted momentum, or come nearest to it.
//!
//! The 4096 sets of movers have 109 different sums V = (X, Y), 108 of them not zero. For every number of movers m and every
//! V in reach of a collision, -8 <= X <= 8 and -14 <= Y <= 12, the table lists all sets of m movers whose sum is V; if there
//! is none, all whose sum is nearest to it, by |V|^2 = (3 X^2 + Y^2)/4. A collision takes one of the list at random.

use std::sync::LazyLock;

use crate::lattice::draws::below;
use crate::lattice::velocities::momentum;

const COLUMNS: u16 = 17;
const ROWS: u16 = 27;
const PLANE: usize = COLUMNS as usize * ROWS as usize;

/// Place of a resultant in the table, and the number of movers that make it.
#[derive(Clone, Copy, Debug)]
pub struct Sum {
    /// Place of V within the part of the table for one number of movers.
    pub resultant: u16,
    /// Movers.
    pub count: u8,
}

/// States of one number of movers that have one sum, or come nearest to it.
#[derive(Clone, Copy, Debug)]
pub struct Choice {
    first: u16,
    count: u8,
    /// Whether they have the sum itself.
    pub is_exact: bool,
}

/// The table.
#[derive(Debug)]
pub struct Collisions {
    sums: Box<[Sum; 4096]>,
    choices: Box<[Choice]>,
    states: Box<[u16]>,
}

/// What adding direction 4, straight down, does to the place of a resultant.
pub const DOWNWARDS: u16 = 2 * COLUMNS;

/// The place of the resultant (X, Y).
#[must_use]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the table")]
pub fn place((x, y): (i32, i32)) -> u16 {
    debug_assert!((-8..=8).contains(&x) && (-14..=12).contains(&y), "({x}, {y}) is out of the table");
    ((y + 14) * i32::from(COLUMNS) + x + 8) as u16
}

impl Default for Collisions {
    fn default() -> Self {
        let sums = std::array::from_fn(|movers| Sum {
            resultant: place(momentum(to_state(movers))),
            count: u8::try_from(movers.count_ones()).unwrap_or(0),
        });
        let mut table = Self { sums: Box::new(sums), choices: Box::default(), states: Box::default() };
        let (mut choices, mut states) = (Vec::with_capacity(13 * PLANE), Vec::new());
        for count in 0..=12 {
            let same: Vec<(u16, (i32, i32))> = (0..4096)
                .filter(|&movers: &usize| movers.count_ones() == count)
                .map(|movers| (to_state(movers), momentum(to_state(movers))))
                .collect();
            for row in 0..ROWS {
                for column in 0..COLUMNS {
                    choices.push(nearest(&same, to_resultant(row, column), &mut states));
                }
            }
        }
        table.choices = choices.into();
        table.states = states.into();
        table
    }
}

#[expect(clippy::cast_possible_truncation, reason = "12 bits")]
fn to_state(movers: usize) -> u16 {
    (movers as u16) << 1
}

fn to_resultant(row: u16, column: u16) -> (i32, i32) {
    (i32::from(column) - 8, i32::from(row) - 14)
}

/// Appends all of `same` whose sum is nearest to V.
fn nearest(same: &[(u16, (i32, i32))], (x, y): (i32, i32), states: &mut Vec<u16>) -> Choice {
    let distance = |sum: (i32, i32)| 3 * (sum.0 - x).pow(2) + (sum.1 - y).pow(2);
    let least = same.iter().map(|&(_, sum)| distance(sum)).min().unwrap_or(0);
    let first = u16::try_from(states.len()).unwrap_or(u16::MAX);
    states.extend(same.iter().filter(|&&(_, sum)| distance(sum) == least).map(|&(state, _)| state));
    let count = u8::try_from(states.len() - usize::from(first)).unwrap_or(u8::MAX);
    Choice { first, count, is_exact: least == 0 }
}

impl Collisions {
    /// The table, made once and for all.
    #[must_use]
    pub fn shared() -> &'static Self {
        static TABLE: LazyLock<Collisions> = LazyLock::new(Collisions::default);
        &TABLE
    }

    /// Sum and number of the movers of a state.
    #[inline]
    #[must_use]
    pub fn sum(&self, state: u16) -> Sum {
        self.sums[usize::from(state >> 1) & 0xFFF]
    }

    /// The states of `count` movers for the resultant at a place.
    #[inline]
    #[must_use]
    pub fn choice(&self, count: u8, resultant: u16) -> Choice {
        self.choices[usize::from(count) * PLANE + usize::from(resultant)]
    }

    /// One of the states, by a draw of 32 bits.
    #[inline]
    #[must_use]
    pub fn pick(&self, choice: Choice, draw: u32) -> u16 {
        self.states[usize::from(choice.first) + below(draw, choice.count.into()) as usize]
    }

    /// All states of a choice.
    #[must_use]
    pub fn states(&self, choice: Choice) -> &[u16] {
        &self.states[usize::from(choice.first)..][..usize::from(choice.count)]
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn there_are_108_resultants_besides_zero() {
        let all: HashSet<_> = (0..4096).map(|movers| momentum(to_state(movers))).collect();
        assert_eq!(all.len(), 109);
        let by_count: Vec<usize> = (0..=12)
            .map(|m| {
                let same = (0..4096).filter(|movers: &usize| movers.count_ones() == m);
                same.map(|movers| momentum(to_state(movers))).collect::<HashSet<_>>().len()
            })
            .collect();
        assert_eq!(by_count, [1, 12, 37, 61, 85, 97, 97, 97, 85, 61, 37, 12, 1]);
    }

    #[test]
    fn the_table_has_its_known_size() {
        let table = Collisions::default();
        assert_eq!(table.choices.len(), 5967);
        assert_eq!(table.states.len(), 17_814);
        assert_eq!(table.choices.iter().map(|choice| choice.count).max(), Some(66));
    }

    #[test]
    fn every_choice_has_the_number_wanted_and_no_state_is_nearer() {
        let table = Collisions::default();
        for m in 0..=12u8 {
            for (x, y) in (-8..=8).flat_map(|x| (-14..=12).map(move |y| (x, y))) {
                let choice = table.choice(m, place((x, y)));
                let distance = |state: u16| {
                    let sum = momentum(state);
                    3 * (sum.0 - x).pow(2) + (sum.1 - y).pow(2)
                };
                let of_number = |&movers: &u16| movers.count_ones() == u32::from(m);
                let least = (0..4096).filter(of_number).map(|movers| distance(movers << 1)).min().unwrap();
                assert_eq!(choice.is_exact, least == 0);
                let listed: HashSet<u16> = table.states(choice).iter().copied().collect();
                let best: HashSet<u16> =
                    (0..4096).filter(of_number).map(|movers| movers << 1).filter(|&s| distance(s) == least).collect();
                assert_eq!(listed, best);
            }
        }
    }

    #[test]
    fn a_fall_at_full_speed_takes_no_more_gravity() {
        let table = Collisions::default();
        let Sum { resultant, count } = table.sum(1 << 9);
        assert_eq!(table.states(table.choice(count, resultant - DOWNWARDS)), [1 << 9]);
    }
}
