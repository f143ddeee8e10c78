//! The velocities in the middle of the step, with which springs advance, of the contacts of a batch.

use crate::contact::lanes::Lanes;
use crate::contact::{Gathered, LawRequirements, Pair};
use crate::neighbours::list::Candidate;
use crate::space::{Linear, Space};
use crate::store::ParticleStore;

/// [`Gathered`] in lanes.
#[derive(Clone, Debug, Default)]
pub struct GatheredLanes<V: Space> {
    relative_velocity: Lanes<V>,
    spins: [Lanes<V::Spin>; 2],
}

impl<V: Space> GatheredLanes<V> {
    /// Loads the velocities of two particles into a lane.
    #[inline(always)]
    pub(in crate::contact) fn take(&mut self, lane: usize, contact: Candidate, store: &ParticleStore<V>) {
        let [i, j] = contact.both();
        self.set(lane, store.middle_velocity(i) - store.middle_velocity(j), [i, j].map(|i| store.middle_spin(i)));
    }

    /// Loads the velocities of a contact with a wall surface into a lane.
    #[inline(always)]
    pub(in crate::contact) fn take_wall(
        &mut self,
        lane: usize,
        (i, pair): (usize, &Pair<V>),
        store: &ParticleStore<V>,
    ) {
        let ahead = store.body[i].velocity - store.middle_velocity(i);
        self.set(lane, pair.relative_velocity - ahead, [store.middle_spin(i), V::Spin::ZERO]);
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, relative_velocity: V, spins: [V::Spin; 2]) {
        self.relative_velocity.set(lane, relative_velocity);
        self.spins.iter_mut().zip(spins).for_each(|(lanes, spin)| lanes.set(lane, spin));
    }

    /// Returns the velocities in a lane; those that the law `L` does not require are zero.
    #[inline(always)]
    pub(super) fn get<L: LawRequirements>(&self, lane: usize) -> Gathered<V> {
        let [i, j] = &self.spins;
        let spins = if L::SPIN { [i.get(lane), j.get(lane)] } else { [V::Spin::ZERO; 2] };
        Gathered { relative_velocity: self.relative_velocity.get(lane), spins }
    }
}
