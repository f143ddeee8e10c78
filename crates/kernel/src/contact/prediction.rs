//! Velocity predictions of single contacts, from the gains in the store.

use crate::contact::Pair;
use crate::neighbours::list::{Candidate, PairList};
use crate::space::Space;
use crate::store::{ParticleStore, Prediction};

impl<V: Space> ParticleStore<V> {
    /// Turns a contact of two particles with predicted velocities into one with the velocities in the middle of the step
    /// and their prediction.
    pub(super) fn predict_pair(&self, contact: Candidate, pair: &mut Pair<V>) {
        let [i, j] = contact.both();
        // Differences of the two, so that they change their sign exactly if i and j are exchanged.
        pair.relative_velocity = self.middle_velocity(i) - self.middle_velocity(j);
        pair.ahead.velocity = self.gain(i) - self.gain(j);
        self.describe(i, 0, pair);
        self.describe(j, 1, pair);
    }

    /// Like [`Self::predict_pair`], for a contact with a wall surface.
    pub(super) fn predict_with_wall(&self, contact: Candidate, pair: &mut Pair<V>) {
        let i = contact.first();
        pair.relative_velocity -= self.body[i].velocity - self.middle_velocity(i);
        pair.ahead.velocity = self.gain(i);
        self.describe(i, 0, pair);
    }

    /// Velocity gain of particle `i` in half a step by the forces at its beginning, m/s.
    fn gain(&self, i: usize) -> V {
        // Predicted velocities contain a share of it.
        (self.body[i].velocity - self.middle_velocity(i)) * (1.0 / self.prediction.share)
    }

    /// Sets the numbers of particle `i` at one side of a contact.
    fn describe(&self, i: usize, side: usize, pair: &mut Pair<V>) {
        if self.is_fixed(i) {
            return;
        }
        pair.ahead.inverse_masses[side] = self.body[i].inverse_mass;
        pair.ahead.only_contact[side] = f64::from(self.prediction.lone[i]);
        if let Some(rotation) = self.rotation.get(i) {
            let middle = self.prediction.middle_spin[i];
            pair.ahead.spins[side] = (rotation.spin - middle) * (1.0 / self.prediction.spin_share);
            pair.ahead.inverse_inertias[side] = rotation.inverse_inertia;
            pair.spins[side] = middle;
        }
    }

    /// Stores which particles have at most one contact, from the counts of the force pass.
    pub(super) fn store_lone(&mut self) {
        let (lone, contacts) = (&mut self.prediction.lone, &self.loads.contacts);
        lone.resize(contacts.len(), 0);
        let changed = &mut self.prediction.lone_changed;
        changed.clear();
        let is_lone = |contacts: u16| u8::from(contacts <= 1);
        for (number, (lone, contacts)) in lone.chunks_mut(CHUNK).zip(contacts.chunks(CHUNK)).enumerate() {
            // Most chunks have no change, which a vectorised loop finds out.
            let differ = lone.iter().zip(contacts).fold(0, |all, (&flag, &contacts)| all | flag ^ is_lone(contacts));
            if differ > 0 {
                for (place, (flag, &contacts)) in lone.iter_mut().zip(contacts).enumerate() {
                    if *flag != is_lone(contacts) {
                        *flag = is_lone(contacts);
                        changed.push(number * CHUNK + place);
                    }
                }
            }
        }
        self.prediction.lone_changes += u64::from(!changed.is_empty());
    }
}

/// Particles whose counts are compared at once.
const CHUNK: usize = 64;

/// Candidates with a lone particle, ascending.
#[derive(Default)]
pub(super) struct LonePairs {
    pairs: Vec<Candidate>,
    /// Version of the list from which they were chosen, and the number of changes of lone particles at that time.
    chosen_at: (u64, u64),
    /// The largest difference of the slots of a candidate.
    span: usize,
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
