//! Discharge through the orifice, from the grain accounting: duration and rate.
//!
//! The rate is taken between the times at which a tenth and nine tenths of the grains were out. So neither the start of
//! the flow nor its thin end counts.

use serde::Serialize;

use crate::ledger::Ledger;

/// Results of the measurement.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Discharge {
    /// Time from the first grain out to the last, s.
    pub duration_s: f64,
    /// Mean rate between a tenth and nine tenths of the grains, grains/s.
    pub rate_per_s: f64,
    /// The same rate by mass, kg/s.
    pub rate_kg_per_s: f64,
}

impl Discharge {
    /// Returns the discharge; `None` if fewer than ten grains are out, or if they left in one step.
    #[must_use]
    pub fn of(ledger: &Ledger) -> Option<Self> {
        let count = ledger.out();
        if count < 10 {
            return None;
        }
        let first = ledger.departures.first()?;
        let last = ledger.departures.last()?;
        let tenth = ledger.departures.nearest(count / 10)?;
        let nine_tenths = ledger.departures.nearest(count - 1 - count / 10)?;
        let grains = f64::from(nine_tenths.number - tenth.number);
        let mass = nine_tenths.mass_out - tenth.mass_out;
        let interval = nine_tenths.time - tenth.time;
        // Grains that leave in one step have no rate.
        (interval > 0.0).then(|| Self {
            duration_s: last - first,
            rate_per_s: grains / interval,
            rate_kg_per_s: mass / interval,
        })
    }
}
