//! The energy that a contact loses where it ends.

use crate::contact::force_pass::input::ForcePass;
use crate::contact::geometry::{ended_pair, ended_wall_pair};
use crate::contact::history::losses::EndLosses;
use crate::contact::memory::Memory;
use crate::contact::pair::Pair;
use crate::neighbours::list::Candidate;
use crate::space::Space;
use crate::store::ParticleStore;

impl<V: Space> ForcePass<'_, V> {
    /// Returns the energy stored in the springs of a contact that has ended, J. It is lost to friction and rolling
    /// resistance.
    #[cold]
    pub(super) fn on_contact_end(&self, store: &ParticleStore<V>, contact: Candidate, memory: &Memory) -> EndLosses {
        if !store.tracks_energy || memory.is_empty() {
            return EndLosses::default();
        }
        self.lost_at_end(&ended_pair(store, contact, self.dt), memory)
    }

    /// Returns the energy lost when a contact with a wall ends, J. Returns 0 if the wall is a door that has been
    /// removed: its removal has already accounted for the energy of all its contacts.
    #[cold]
    pub(super) fn on_wall_contact_end(
        &self,
        store: &ParticleStore<V>,
        contact: Candidate,
        memory: &Memory,
    ) -> EndLosses {
        let [i, wall] = contact.row_and_partner();
        if !(self.walls[wall].is_present && store.tracks_energy) || memory.is_empty() {
            return EndLosses::default();
        }
        self.lost_at_end(&ended_wall_pair(store, i, &self.walls[wall], self.dt), memory)
    }

    fn lost_at_end(&self, pair: &Pair<V>, memory: &Memory) -> EndLosses {
        let [sliding, rolling] = self.law.on_contact_end(pair, memory);
        let breaking = if memory.exists { self.law.lost_at_break(pair) } else { 0.0 };
        EndLosses { sliding, rolling, breaking }
    }
}
