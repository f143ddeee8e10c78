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
        let mut has_changed = false;
        for (flag, &contacts) in lone.iter_mut().zip(contacts) {
            let is_lone = u8::from(contacts <= 1);
            has_changed |= *flag != is_lone;
            *flag = is_lone;
        }
        self.prediction.lone_changes += u64::from(has_changed);
    }
}

/// Candidates with a lone particle, ascending.
#[derive(Default)]
pub(super) struct LonePairs {
    pairs: Vec<Candidate>,
    /// Version of the list from which they were chosen, and the number of changes of lone particles at that time.
    chosen_at: (u64, u64),
}

impl LonePairs {
    /// Returns the pairs of a list.
    pub(super) fn of<V: Space>(&mut self, list: &PairList, prediction: &Prediction<V>) -> &[Candidate] {
        let now = (list.version(), prediction.lone_changes);
        if self.chosen_at != now {
            self.chosen_at = now;
            let lone = &prediction.lone[..];
            self.pairs.clear();
            self.pairs.extend(list.pairs().iter().filter(|pair| {
                let [i, j] = pair.both();
                lone[i] | lone[j] > 0
            }));
        }
        &self.pairs
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
            (store.prediction.lone.clone(), store.prediction.lone_changes)
        };
        assert_eq!(changes(&[4, 1, 0, 2]), (vec![0, 1, 1, 0], 1));
        // Other counts, but the same particles.
        assert_eq!(changes(&[3, 0, 1, 5]), (vec![0, 1, 1, 0], 1));
        assert_eq!(changes(&[3, 2, 1, 5, 6]), (vec![0, 0, 1, 0, 0], 2));
    }
}
