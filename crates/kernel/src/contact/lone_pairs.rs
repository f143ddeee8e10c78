//! Lone grains: particles with at most one contact. [`centred`](super::centred) contacts with one are evaluated anew, because all that
//! changes the velocity of a lone grain is known. The neighbour list marks their pairs ([`PairList::mark`]).
//!
//! Contacts are counted every few steps. Between two counts few particles change.

use crate::neighbours::list::{Chosen, PairList};
use crate::space::Space;
use crate::store::{ParticleStore, Prediction};

impl<V: Space> ParticleStore<V> {
    /// Stores which particles have at most one contact, from the counts of the force pass.
    pub(super) fn store_lone(&mut self) {
        let (lone, contacts) = (&mut self.prediction.lone, &self.loads.contacts);
        lone.resize(contacts.len(), 0);
        let changed = &mut self.prediction.lone_changed;
        changed.clear();
        let is_lone = |contacts: u16| u8::from(contacts <= 1);
        for (number, (lone, contacts)) in
            lone.chunks_mut(COMPARED_AT_ONCE).zip(contacts.chunks(COMPARED_AT_ONCE)).enumerate()
        {
            // Most chunks have no change, which a vectorised loop finds out.
            let differ = lone.iter().zip(contacts).fold(0, |all, (&flag, &contacts)| all | flag ^ is_lone(contacts));
            if differ > 0 {
                for (place, (flag, &contacts)) in lone.iter_mut().zip(contacts).enumerate() {
                    if *flag != is_lone(contacts) {
                        *flag = is_lone(contacts);
                        changed.push(number * COMPARED_AT_ONCE + place);
                    }
                }
            }
        }
        self.prediction.lone_changes += u64::from(!changed.is_empty());
    }
}

/// Number of particles whose counts are compared at once.
const COMPARED_AT_ONCE: usize = 64;

impl PairList {
    /// Marks the pairs with a lone particle.
    pub(super) fn mark_lone<V: Space>(&mut self, prediction: &Prediction<V>) {
        let Prediction { lone, lone_changed, lone_changes, .. } = prediction;
        self.mark(Chosen { particles: lone, changed: lone_changed, version: *lone_changes });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Plane;

    #[test]
    fn lone_pairs_are_chosen_anew_after_changes_alone() {
        let mut store = ParticleStore::<Plane>::default();
        let mut changes = |contacts: &[u16]| {
            store.loads.contacts = contacts.to_vec();
            store.store_lone();
            (store.prediction.lone.clone(), store.prediction.lone_changes, store.prediction.lone_changed.clone())
        };
        assert_eq!(changes(&[4, 1, 0, 2]), (vec![0, 1, 1, 0], 1, vec![1, 2]));
        // Other counts, but the same particles.
        assert_eq!(changes(&[3, 0, 1, 5]), (vec![0, 1, 1, 0], 1, vec![]));
        assert_eq!(changes(&[3, 2, 1, 5, 6]), (vec![0, 0, 1, 0, 0], 2, vec![1]));
    }
}
