//! Lone grains: particles with at most one contact, and the candidate pairs that contain one. [`centred`](super::centred) contacts
//! evaluate these pairs anew, because all that changes the velocity of a lone grain is known.
//!
//! Contacts are counted every few steps. Between two counts few particles change, so pairs are chosen anew only near these.

use crate::neighbours::list::{Candidate, PairList};
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

/// Candidates with a lone particle, ascending.
#[derive(Default)]
pub(super) struct LonePairs {
    pairs: Vec<Candidate>,
    /// Version of the list from which they were chosen, and the number of changes of lone particles at that time.
    chosen_at: (u64, u64),
    /// The largest difference of the slots of a candidate.
    span: usize,
    /// Memory for the next choice.
    spare: Vec<Candidate>,
}

impl LonePairs {
    /// Returns the pairs of a list.
    pub(super) fn of<V: Space>(&mut self, list: &PairList, prediction: &Prediction<V>) -> &[Candidate] {
        let now = (list.version(), prediction.lone_changes);
        let before = std::mem::replace(&mut self.chosen_at, now);
        if before == (now.0, now.1.wrapping_sub(1)) {
            self.choose_near(list.pairs(), &prediction.lone, &prediction.lone_changed);
        } else if before != now {
            self.span = list.pairs().iter().map(|pair| pair.second() - pair.first()).max().unwrap_or(0);
            self.pairs.clear();
            self.pairs.extend(with_lone(list.pairs(), &prediction.lone));
        }
        &self.pairs
    }

    /// Chooses anew among the candidates that may contain one of the `changed` particles, ascending.
    fn choose_near(&mut self, candidates: &[Candidate], lone: &[u8], changed: &[usize]) {
        std::mem::swap(&mut self.pairs, &mut self.spare);
        self.pairs.clear();
        let (mut kept, mut left, mut changed) = (&self.spare[..], candidates, changed.iter().peekable());
        while let Some(&particle) = changed.next() {
            let (first, mut end) = (particle.saturating_sub(self.span), particle + 1);
            while let Some(&next) = changed.next_if(|&&next| next <= end + self.span) {
                end = next + 1;
            }
            let before = |row: usize, pairs: &[Candidate]| pairs.partition_point(|pair| pair.first() < row);
            self.pairs.extend_from_slice(&kept[..before(first, kept)]);
            kept = &kept[before(end, kept)..];
            self.pairs.extend(with_lone(&left[before(first, left)..before(end, left)], lone));
            left = &left[before(end, left)..];
        }
        self.pairs.extend_from_slice(kept);
    }
}

/// Returns the candidates with a lone particle.
fn with_lone<'c>(candidates: &'c [Candidate], lone: &'c [u8]) -> impl Iterator<Item = &'c Candidate> {
    candidates.iter().filter(|pair| {
        let [i, j] = pair.both();
        lone[i] | lone[j] > 0
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

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

    proptest! {
        /// Changes of a few or many particles of a list give the pairs that a choice among all candidates gives.
        #[test]
        fn pairs_chosen_near_changes_are_those_chosen_among_all(
            pairs in prop::collection::btree_set((0u32..300, 1u32..9), 0..900),
            changes in prop::collection::vec(prop::collection::vec(0usize..308, 0..40), 1..5),
        ) {
            let mut list = PairList::default();
            list.fill(pairs.iter().map(|&(i, apart)| Candidate::new(i, i + apart)), 308);
            list.assign_tasks(308, 1, 1024);
            let mut store = ParticleStore::<Plane>::default();
            let mut chosen = LonePairs::default();
            store.loads.contacts = vec![2; 308];
            for particles in changes {
                for particle in particles {
                    store.loads.contacts[particle] ^= 3;
                }
                store.store_lone();
                let all: Vec<_> = with_lone(list.pairs(), &store.prediction.lone).copied().collect();
                prop_assert_eq!(chosen.of(&list, &store.prediction), &all[..]);
            }
        }
    }
}
