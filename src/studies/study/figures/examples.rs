//! Selects example collisions of four particles for a figure, by a rule.
//!
//! The examples of a class of states are its first state in ascending order (as numbers, bit i for velocity i) and its
//! last state with a different sum V. A state qualifies only if there are outgoing states with exactly the sum V, both
//! without a stopped particle and with one. All examples therefore conserve number and momentum. Up to five outgoing
//! states are kept: the first one, and others at equal distances in the table.

use siloflow_lattice::collisions::{Collisions, resultant_index};
use siloflow_lattice::velocities::{MOVERS, in_bonds, momentum};

/// Largest number of outgoing states that are kept.
const MOST: usize = 5;

/// A state of four particles, and possible outgoing states of its collision.
#[derive(Clone, Debug, PartialEq)]
pub struct Example {
    /// Class of the incoming state.
    pub class: &'static str,
    /// Incoming state.
    pub incoming: u16,
    /// Some outgoing states of four movers.
    pub elastic: Vec<u16>,
    /// Number of all outgoing states of four movers.
    pub elastic_count: usize,
    /// Some outgoing states of three movers and one particle at rest.
    pub stopped: Vec<u16>,
    /// Number of all outgoing states of three movers and one particle at rest.
    pub stopped_count: usize,
}

type Test = fn(u16) -> bool;

/// The classes. States of four movers are classified by the size of their sum, in bonds per step. States of three
/// movers and one particle at rest are one class.
const CLASSES: [(&str, Test); 4] = [
    ("V = 0", |state| has_only_movers(state) && size(state) < 0.1),
    ("0 < |V| ≤ 1", |state| has_only_movers(state) && size(state) > 0.1 && size(state) < 1.1),
    ("|V| ≥ 3", |state| has_only_movers(state) && size(state) > 2.9),
    ("one at rest", |state| !has_only_movers(state)),
];

fn has_only_movers(state: u16) -> bool {
    state & 1 == 0
}

fn size(state: u16) -> f64 {
    let (x, y) = in_bonds(momentum(state));
    x.hypot(y)
}

/// Returns the examples, class by class.
#[must_use]
pub fn examples(table: &Collisions) -> Vec<Example> {
    CLASSES.iter().flat_map(|&(class, belongs)| class_examples(table, class, belongs)).collect()
}

fn class_examples(table: &Collisions, class: &'static str, belongs: Test) -> impl Iterator<Item = Example> {
    let states = (0..1 << 13).filter(|state: &u16| state.count_ones() == 4 && belongs(*state));
    let mut all = states.filter_map(|state| example(table, class, state));
    let first = all.next();
    let sum = first.as_ref().map(|example| momentum(example.incoming));
    first.into_iter().chain(all.rfind(|other| Some(momentum(other.incoming)) != sum))
}

/// Returns the example of a state; `None` unless both kinds of outgoing states have exactly the sum of the state.
fn example(table: &Collisions, class: &'static str, incoming: u16) -> Option<Example> {
    let resultant = resultant_index(momentum(incoming & MOVERS));
    let elastic = table.choice(4, resultant);
    let stopped = table.choice(3, resultant);
    let is_exact = elastic.is_exact && stopped.is_exact;
    is_exact.then(|| {
        let elastic = table.states(elastic);
        let stopped = table.states(stopped);
        Example {
            class,
            incoming,
            elastic: evenly_spaced(elastic).collect(),
            elastic_count: elastic.len(),
            stopped: evenly_spaced(stopped).map(|movers| movers | 1).collect(),
            stopped_count: stopped.len(),
        }
    })
}

/// Returns at most [`MOST`] of the states: the first one, and others at equal distances.
fn evenly_spaced(states: &[u16]) -> impl Iterator<Item = u16> {
    let count = states.len().min(MOST);
    (0..count).map(move |n| states[n * states.len() / count])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn examples_conserve_number_and_momentum() {
        let all = examples(&Collisions::default());
        // The class V = 0 has a single sum, and therefore one example.
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
    fn examples_belong_to_their_classes() {
        let all = examples(&Collisions::default());
        let sizes: Vec<f64> = all.iter().map(|example| size(example.incoming)).collect();
        assert!(sizes[0] < 1e-12);
        assert!(sizes[1..3].iter().all(|&size| size > 1e-12 && size <= 1.0 + 1e-12));
        assert!(sizes[3..5].iter().all(|&size| size >= 3.0 - 1e-12));
        assert!(all[5..].iter().all(|example| example.incoming & 1 == 1));
    }
}
