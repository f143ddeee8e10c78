//! The collision table: lists the states of m movers with a given momentum, or with the momentum nearest to it.
//!
//! The 4096 sets of movers have 109 different sums V = (X, Y), 108 of them nonzero. The table has an entry for each
//! number of movers m and each V that a collision can reach, -8 <= X <= 8 and -14 <= Y <= 12. An entry lists all sets
//! of m movers with the sum V. If no set has this sum, it lists all sets whose sum is nearest to V, measured by
//! |V|^2 = (3 X^2 + Y^2)/4. A collision draws one set of the list at random.

use std::sync::LazyLock;

use crate::draws::below;
use crate::velocities::momentum;

const COLUMNS: u16 = 17;
const ROWS: u16 = 27;
const PLANE: usize = COLUMNS as usize * ROWS as usize;

/// Sum of the velocities of a state (as an index into the table), and the number of its movers.
#[derive(Clone, Copy, Debug)]
pub struct Sum {
    /// Index of V within the part of the table for one number of movers: see [`resultant_index`].
    pub resultant: u16,
    /// Number of movers.
    pub count: u8,
}

/// An entry of the table: the states with a given number of movers and a given sum, or with the nearest sum.
#[derive(Clone, Copy, Debug)]
pub struct Choice {
    first: u16,
    count: u8,
    /// Whether the states have exactly the given sum.
    pub is_exact: bool,
}

/// The collision table.
#[derive(Debug)]
pub struct Collisions {
    sums: Box<[Sum; 4096]>,
    choices: Box<[Choice]>,
    states: Box<[u16]>,
}

/// Amount by which the index of a resultant decreases when direction 4, straight down, is added to the resultant.
pub const DOWNWARDS: u16 = 2 * COLUMNS;

/// Returns the index of the resultant (X, Y).
///
/// # Panics
/// In debug builds, if (X, Y) is outside the table.
#[must_use]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the table")]
pub fn resultant_index((x, y): (i32, i32)) -> u16 {
    debug_assert!((-8..=8).contains(&x) && (-14..=12).contains(&y), "({x}, {y}) is outside the table");
    ((y + 14) * i32::from(COLUMNS) + x + 8) as u16
}

impl Default for Collisions {
    fn default() -> Self {
        let sums = std::array::from_fn(|movers| Sum {
            resultant: resultant_index(momentum(to_state(movers))),
            count: u8::try_from(movers.count_ones()).unwrap_or(0),
        });
        let mut table = Self { sums: Box::new(sums), choices: Box::default(), states: Box::default() };
        let mut choices = Vec::with_capacity(13 * PLANE);
        let mut states = Vec::new();
        for count in 0..=12 {
            let candidates: Vec<(u16, (i32, i32))> = (0..4096)
                .filter(|&movers: &usize| movers.count_ones() == count)
                .map(|movers| (to_state(movers), momentum(to_state(movers))))
                .collect();
            for row in 0..ROWS {
                for column in 0..COLUMNS {
                    choices.push(nearest(&candidates, to_resultant(row, column), &mut states));
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

/// Appends to `states` all `candidates` (state, sum) whose sum is nearest to V = (x, y). Returns their entry.
fn nearest(candidates: &[(u16, (i32, i32))], (x, y): (i32, i32), states: &mut Vec<u16>) -> Choice {
    let distance = |sum: (i32, i32)| 3 * (sum.0 - x).pow(2) + (sum.1 - y).pow(2);
    let least = candidates.iter().map(|&(_, sum)| distance(sum)).min().unwrap_or(0);
    let first = u16::try_from(states.len()).unwrap_or(u16::MAX);
    states.extend(candidates.iter().filter(|&&(_, sum)| distance(sum) == least).map(|&(state, _)| state));
    let count = u8::try_from(states.len() - usize::from(first)).unwrap_or(u8::MAX);
    Choice { first, count, is_exact: least == 0 }
}

impl Collisions {
    /// Returns the table, which is built on first use and shared by the whole program.
    #[must_use]
    pub fn shared() -> &'static Self {
        static TABLE: LazyLock<Collisions> = LazyLock::new(Collisions::default);
        &TABLE
    }

    /// Returns the sum and the number of the movers of a state.
    #[inline]
    #[must_use]
    pub fn sum(&self, state: u16) -> Sum {
        self.sums[usize::from(state >> 1) & 0xFFF]
    }

    /// Returns the entry for `count` movers and the resultant with index `resultant`.
    #[inline]
    #[must_use]
    pub fn choice(&self, count: u8, resultant: u16) -> Choice {
        self.choices[usize::from(count) * PLANE + usize::from(resultant)]
    }

    /// Returns one of the states of an entry; `draw` is a random number of 32 bits.
    #[inline]
    #[must_use]
    pub fn pick(&self, choice: Choice, draw: u32) -> u16 {
        self.states[usize::from(choice.first) + below(draw, choice.count.into()) as usize]
    }

    /// Returns all states of an entry.
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
    fn there_are_108_nonzero_resultants() {
        let all: HashSet<_> = (0..4096).map(|movers| momentum(to_state(movers))).collect();
        assert_eq!(all.len(), 109);
        let by_count: Vec<usize> = (0..=12)
            .map(|m| {
                let sets = (0..4096).filter(|movers: &usize| movers.count_ones() == m);
                sets.map(|movers| momentum(to_state(movers))).collect::<HashSet<_>>().len()
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
    fn every_entry_lists_all_nearest_states_with_its_number_of_movers() {
        let table = Collisions::default();
        for m in 0..=12u8 {
            for (x, y) in (-8..=8).flat_map(|x| (-14..=12).map(move |y| (x, y))) {
                let choice = table.choice(m, resultant_index((x, y)));
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
    fn a_kick_does_not_change_a_mover_at_terminal_speed() {
        let table = Collisions::default();
        let Sum { resultant, count } = table.sum(1 << 9);
        assert_eq!(table.states(table.choice(count, resultant - DOWNWARDS)), [1 << 9]);
    }
}
