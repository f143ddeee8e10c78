//! Lone grains: particles that have had at most one contact since they were last without any. Contacts with one are evaluated
//! anew ([`window`](super::window)), because all forces that change the velocity of a lone grain are known. The neighbour list marks their pairs
//! ([`PairList::mark`]).
//!
//! A grain that falls or bounces is lone. A grain that has had two contacts is not, even if it has one later: in a bed many grains rest
//! or roll on one contact, and evaluating these contacts anew costs more than it gains.
//!
//! Contacts are counted every few steps, and few particles change between two counts.

use crate::neighbours::list::{Chosen, PairList};
use crate::space::Space;
use crate::store::{ParticleStore, Prediction};

impl<V: Space> ParticleStore<V> {
    /// Stores which particles are lone, from the counts of the force pass. At the start of a run, `starts`, the past does not count.
    pub(in crate::contact) fn store_lone(&mut self, starts: bool) {
        let lone = &mut self.prediction.lone;
        let contacts = &self.loads.contacts;
        lone.resize(contacts.len(), 0);
        let changed = &mut self.prediction.lone_changed;
        changed.clear();
        let starts = u8::from(starts);
        let now = |flag: u8, contacts: u16| u8::from(contacts == 0) | u8::from(contacts == 1) & (flag | starts);
        for (number, (lone, contacts)) in
            lone.chunks_mut(COMPARED_AT_ONCE).zip(contacts.chunks(COMPARED_AT_ONCE)).enumerate()
        {
            // Most chunks have no change, which a vectorised loop finds out.
            let differ = lone.iter().zip(contacts).fold(0, |all, (&flag, &contacts)| all | flag ^ now(flag, contacts));
            if differ > 0 {
                for (place, (flag, &contacts)) in lone.iter_mut().zip(contacts).enumerate() {
                    if *flag != now(*flag, contacts) {
                        *flag = now(*flag, contacts);
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
    pub(in crate::contact) fn mark_lone<V: Space>(&mut self, prediction: &Prediction<V>) {
        let Prediction { lone, lone_changed, lone_changes, .. } = prediction;
        self.mark(Chosen { particles: lone, changed: lone_changed, version: *lone_changes });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Plane;

    #[test]
    fn a_grain_is_lone_until_it_has_two_contacts_and_again_once_it_has_none() {
        let mut store = ParticleStore::<Plane>::default();
        let mut count = |contacts: &[u16], starts: bool| {
            store.loads.contacts = contacts.to_vec();
            store.store_lone(starts);
            (store.prediction.lone.clone(), store.prediction.lone_changes, store.prediction.lone_changed.clone())
        };
        assert_eq!(count(&[4, 1, 0, 2], true), (vec![0, 1, 1, 0], 1, vec![1, 2]));
        // Other counts, but the same lone particles.
        assert_eq!(count(&[1, 0, 1, 1], false), (vec![0, 1, 1, 0], 1, vec![]));
        // A particle that has entered.
        assert_eq!(count(&[1, 2, 1, 0, 1], false), (vec![0, 0, 1, 1, 0], 2, vec![1, 3]));
        assert_eq!(count(&[0, 1, 6, 1, 0], false), (vec![1, 0, 0, 1, 1], 3, vec![0, 2, 4]));
    }
}
