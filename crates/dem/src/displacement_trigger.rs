//! Displacement trigger: skips a pass over all particles until a particle may have moved far enough to matter.
//!
//! [`TravelMeter`] holds the sum over the steps of the longest move of any particle in a step. A pass that has found
//! that nothing can happen before a particle moves a distance d sets the trigger to d. It is skipped until the sum has
//! grown by d. Results are the same as with a pass in every step. A renumbering fires every trigger.

use serde::{Deserialize, Serialize};

/// The distance that particles can have moved; see
/// [`Particles::travel_meter`](crate::particles::Particles::travel_meter).
#[derive(Clone, Copy, Debug)]
pub struct TravelMeter {
    /// Number of renumberings.
    pub(crate) generation: u64,
    /// Sum over the steps of the longest move of any particle in a step, m.
    pub(crate) travel: f64,
}

/// Fires when a particle may have moved a given distance.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub struct DisplacementTrigger {
    generation: u64,
    fires_at: f64,
}

impl DisplacementTrigger {
    /// Creates a trigger that fires once a particle may have moved `distance` (m) from now on.
    #[must_use]
    #[inline]
    pub fn for_distance(now: TravelMeter, distance: f64) -> Self {
        Self { generation: now.generation, fires_at: now.travel + distance }
    }

    /// Whether the trigger has fired; `ahead` (m) is added to the distance moved.
    #[must_use]
    #[inline]
    pub fn has_fired(&self, now: TravelMeter, ahead: f64) -> bool {
        // Written so that a NaN travel fires the trigger.
        let is_armed = self.generation == now.generation && now.travel + ahead < self.fires_at;
        !is_armed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trigger_fires_after_the_distance_or_a_renumbering() {
        let now = TravelMeter { generation: 3, travel: 1.0 };
        let trigger = DisplacementTrigger::for_distance(now, 0.5);
        assert!(!trigger.has_fired(now, 0.4) && trigger.has_fired(now, 0.5));
        assert!(trigger.has_fired(TravelMeter { travel: f64::NAN, ..now }, 0.0));
        assert!(trigger.has_fired(TravelMeter { generation: 4, ..now }, 0.0));
        assert!(DisplacementTrigger::default().has_fired(now, 0.0));
    }
}
