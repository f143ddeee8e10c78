//! Waiting: passes over all particles that need not be made before somebody can have gone far enough to matter.
//!
//! [`Columns::travel`] is the sum over the steps of the longest move of any particle in a step. Whoever has found that
//! nothing happens before somebody has gone a distance d lets its pass rest until travel has grown by d; the result is
//! the same as with a pass in every step. New slots end every wait.

use crate::columns::Columns;
use crate::space::Space;

/// When to look again.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wait {
    generation: u64,
    until: f64,
}

impl Wait {
    /// Until somebody can have gone this far, m.
    #[must_use]
    pub fn for_distance<V: Space>(columns: &Columns<V>, distance: f64) -> Self {
        Self { generation: columns.generation, until: columns.travel + distance }
    }

    /// Whether it is over; `ahead` (m) counts as gone.
    #[must_use]
    pub fn is_over<V: Space>(&self, columns: &Columns<V>, ahead: f64) -> bool {
        // Written so that a travel that is not a number ends it.
        let goes_on = self.generation == columns.generation && columns.travel + ahead < self.until;
        !goes_on
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wait_ends_with_the_way_or_with_the_slots() {
        let mut columns: Columns = Columns { generation: 3, travel: 1.0, ..Columns::default() };
        let wait = Wait::for_distance(&columns, 0.5);
        assert!(!wait.is_over(&columns, 0.4) && wait.is_over(&columns, 0.5));
        columns.travel = f64::NAN;
        assert!(wait.is_over(&columns, 0.0));
        columns.travel = 1.0;
        columns.generation = 4;
        assert!(wait.is_over(&columns, 0.0));
        assert!(Wait::default().is_over(&columns, 0.0));
    }
}
