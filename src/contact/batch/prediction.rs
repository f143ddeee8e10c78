//! Velocity predictions of the contacts of a batch.

use crate::contact::LawRequirements;
use crate::contact::centred::VelocityPrediction;
use crate::contact::lanes::{Lanes, Scalars, of_both};
use crate::space::Space;
use crate::store::ParticleStore;

/// [`VelocityPrediction`] in lanes.
#[derive(Clone, Debug, Default)]
pub struct PredictionLanes<V: Space> {
    velocity: Lanes<V>,
    spins: [Lanes<V::Spin>; 2],
    inverse_inertias: [Scalars; 2],
    only_contact: [Scalars; 2],
}

impl<V: Space> PredictionLanes<V> {
    /// Loads the prediction for the particles in two slots.
    #[inline]
    pub fn describe<L: LawRequirements>(&mut self, lane: usize, pair: [usize; 2], store: &ParticleStore<V>) {
        let [i, j] = pair.map(|entry| store.gain[entry]);
        self.velocity.set(lane, i.velocity - j.velocity);
        for (side, entry) in pair.into_iter().enumerate() {
            self.only_contact[side][lane] = store.gain[entry].only_contact;
            if L::SPIN {
                self.spins[side].set(lane, store.spin_gain[entry].spin);
                self.inverse_inertias[side][lane] = store.spin_gain[entry].inverse_inertia;
            }
        }
    }

    /// Sets the prediction of a lane.
    #[inline]
    pub fn set<L: LawRequirements>(&mut self, lane: usize, ahead: &VelocityPrediction<V>) {
        self.velocity.set(lane, ahead.velocity);
        for side in 0..2 {
            self.only_contact[side][lane] = ahead.only_contact[side];
            if L::SPIN {
                self.spins[side].set(lane, ahead.spins[side]);
                self.inverse_inertias[side][lane] = ahead.inverse_inertias[side];
            }
        }
    }

    /// Returns the prediction of a lane; `inverse_masses` of i and j in 1/kg.
    #[inline(always)]
    pub(super) fn get<L: LawRequirements>(&self, lane: usize, inverse_masses: [f64; 2]) -> VelocityPrediction<V> {
        let mut ahead = VelocityPrediction {
            velocity: self.velocity.get(lane),
            inverse_masses,
            only_contact: of_both(&self.only_contact, lane),
            ..VelocityPrediction::default()
        };
        if L::SPIN {
            ahead.spins = [self.spins[0].get(lane), self.spins[1].get(lane)];
            ahead.inverse_inertias = of_both(&self.inverse_inertias, lane);
        }
        ahead
    }
}
