//! The velocities in the middle of the step, with which springs advance, of the contacts of a batch.

use crate::contact::law::LawRequirements;
use crate::contact::pair::Gathered;
use crate::lanes::Lanes;
use crate::space::{Linear, Space};

/// [`Gathered`] in lanes.
#[derive(Clone, Debug, Default)]
pub struct GatheredLanes<V: Space> {
    relative_velocity: Lanes<V>,
    spins: [Lanes<V::Spin>; 2],
}

impl<V: Space> GatheredLanes<V> {
    /// Sets the velocities in a lane.
    #[inline(always)]
    pub(in crate::contact) fn set(&mut self, lane: usize, gathered: Gathered<V>) {
        self.relative_velocity.set(lane, gathered.relative_velocity);
        self.spins.iter_mut().zip(gathered.spins).for_each(|(lanes, spin)| lanes.set(lane, spin));
    }

    /// Returns the velocities in a lane; those that the law `L` does not require are zero.
    #[inline(always)]
    pub(super) fn get<L: LawRequirements>(&self, lane: usize) -> Gathered<V> {
        let [i, j] = &self.spins;
        let spins = if L::SPIN { [i.get(lane), j.get(lane)] } else { [V::Spin::ZERO; 2] };
        Gathered { relative_velocity: self.relative_velocity.get(lane), spins }
    }
}
