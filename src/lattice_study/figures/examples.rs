//! Which collisions of four particles a figure shows, by a rule and not by hand.
//!
//! Of each class of states of four particles, the first one in ascending order (as numbers, bit i for velocity i) and the
//! last one that has another sum V. A state counts only if there are outgoing states of the very same V both without a
//! stopped particle and with one, so that all that is shown conserves number and momentum. Of the outgoing states five are
//! kept, the first and then at even distances in the table.

use crate::lattice::collisions::{Collisions, place};
use crate::lattice::velocities::{MOVERS, in_bonds, momentum};

/// Outgoing states that are kept.
const MOST: usize = 5;

/// A state of four particles and what its collision may give.
#[derive(Clone, Debug, PartialEq)]
pub struct Example {
    /// The class that it stands for.
    pub class: &'static str,
    /// The state that comes in.
    pub incoming: u16,
    /// Outgoing states of four movers.
    pub elastic: Vec<u16>,
    /// How many there are of these.
    pub elastic_count: usize,
    /// Outgoing states of three movers and one at rest.
    pub stopped: Vec<u16>,
    /// How many there are of these.
    pub stopped_count: usize,
}

type Test = fn(u16) -> bool;

/// The classes: of four movers by the size of their sum, in bonds a step, and one of three movers and one at rest.
const CLASSES: [(&str, Test); 4] = [
    ("V = 0", |state| moves(state) && size(state) < 0.1),
    ("0 < |V| ≤ 1", |state| moves(state) && size(state) > 0.1 && size(state) < 1.1),
    ("|V| ≥ 3", |state| moves(state) && size(state) > 2.9),
    ("one at rest", |state| !moves(state)),
];

fn moves(state: u16) -> bool {
    state & 1 == 0
}

fn size(state: u16) -> f64 {
    let (x, y) = in_bonds(momentum(state));
    x.hypot(y)
}

/// The examples, class by class.
#[must_use]
pub fn examples(table: &Collisions) -> Vec<Example> {
    CLASSES.iter().flat_map(|&(class, belongs)| of_class(table, class, belongs)).collect()
}

fn of_class(table: &Collisions, class: &'static str, belongs: Test) -> impl Iterator<Item = Example> {
    let states = (0..1 << 13).filter(|state: &u16| state.count_ones() == 4 && belongs(*state));
    let mut all = states.filter_map(|state| example(table, class, state));
    let first = all.next();
    let sum = first.as_ref().map(|example| momentum(example.incoming));
    first.into_iter().chain(all.rfind(|other| Some(momentum(other.incoming)) != sum))
}

/// The example of a state, if both kinds of outgoing states have its sum.
fn example(table: &Collisions, class: &'static str, incoming: u16) -> Option<Example> {
    let resultant = place(momentum(incoming & MOVERS));
    let (elastic, stopped) = (table.choice(4, resultant), table.choice(3, resultant));
    let is_exact = elastic.is_exact && stopped.is_exact;
    is_exact.then(|| {
        let (elastic, stopped) = (table.states(elastic), table.states(stopped));
        Example {
            class,
            incoming,
            elastic: some(elastic).collect(),
            elastic_count: elastic.len(),
            stopped: some(stopped).map(|movers| movers | 1).collect(),
            stopped_count: stopped.len(),
        }
    })
}

/// The first of these states, and then others at even distances.
fn some(states: &[u16]) -> impl Iterator<Item = u16> {
    let count = states.len().min(MOST);
    (0..count).map(move |n| states[n * states.len() / count])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_shown_conserves_number_and_momentum() {
        let all = examples(&Collisions::default());
        // With V = 0 there is no other sum.
        assert_eq!(all.len(), 2 * CLASSES.len() - 1);
        for example in all {
            assert!(!example.elastic.is_empty() && !example.stopped.is_empty());
            assert!(example.elastic.is_sorted_by(|a, b| a < b) && example.stopped.is_sorted_by(|a, b| a < b));
            assert!(example.elastic.iter().all(|state| state & 1 == 0));
            assert!(example.stopped.iter().all(|state| state & 1 == 1));
            for &state in example.elastic.iter().chain(&example.stopped) {
                assert_eq!(state.count_ones(), 4, "{example:?}");
                assert_eq!(momentum(state), momentum(example.incoming), "{example:?}");
            }
        }
    }

    #[test]
    fn classes_are_what_they_say() {
        let all = examples(&Collisions::default());
        let sizes: Vec<f64> = all.iter().map(|example| size(example.incoming)).collect();
        assert!(sizes[0] < 1e-12);
        assert!(sizes[1..3].iter().all(|&size| size > 1e-12 && size <= 1.0 + 1e-12));
        assert!(sizes[3..5].iter().all(|&size| size >= 3.0 - 1e-12));
        assert!(all[5..].iter().all(|example| example.incoming & 1 == 1));
    }
}
