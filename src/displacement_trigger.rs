//! Waiting: passes over all particles that need not be made before somebody can have gone far enough to matter.
//!
//! [`TravelMeter`] counts the sum over the steps of the longest move of any particle in a step. Whoever has found that
//! nothing happens before somebody has gone a distance d lets its pass rest until travel has grown by d; the result is
//! the same as with a pass in every step. New slots end every wait.

/// How far particles can have moved, of [`Particles::travel_meter`](crate::particles::Particles::odometer).
#[derive(Clone, Copy, Debug)]
pub struct TravelMeter {
    /// Counts how often slots have been dealt out.
    pub(crate) generation: u64,
    /// The sum over the steps of the longest move of any particle in a step, m.
    pub(crate) travel: f64,
}

/// When to look again.
#[derive(Clone, Copy, Debug, Default)]
pub struct DisplacementTrigger {
    generation: u64,
    until: f64,
}

impl DisplacementTrigger {
    /// Until any particle can have gone this far, m.
    #[must_use]
    #[inline]
    pub fn for_distance(now: TravelMeter, distance: f64) -> Self {
        Self { generation: now.generation, until: now.travel + distance }
    }

    /// Whether it is over; `ahead` (m) counts as gone.
    #[must_use]
    #[inline]
    pub fn has_fired(&self, now: TravelMeter, ahead: f64) -> bool {
        // Written so that a travel that is not a number ends it.
        let goes_on = self.generation == now.generation && now.travel + ahead < self.until;
        !goes_on
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wait_ends_with_the_way_or_with_the_slots() {
        let now = TravelMeter { generation: 3, travel: 1.0 };
        let wait = DisplacementTrigger::for_distance(now, 0.5);
        assert!(!wait.has_fired(now, 0.4) && wait.has_fired(now, 0.5));
        assert!(wait.has_fired(TravelMeter { travel: f64::NAN, ..now }, 0.0));
        assert!(wait.has_fired(TravelMeter { generation: 4, ..now }, 0.0));
        assert!(DisplacementTrigger::default().has_fired(now, 0.0));
    }
}
