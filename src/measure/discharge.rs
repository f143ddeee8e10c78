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
}

impl Discharge {
    /// Returns the discharge; `None` if fewer than ten grains are out, or if they left in one step.
    #[must_use]
    pub fn of(ledger: &Ledger) -> Option<Self> {
        let times = &ledger.out_times;
        if times.len() < 10 {
            return None;
        }
        let (tenth, nine_tenths) = (times.len() / 10, times.len() - 1 - times.len() / 10);
        #[expect(clippy::cast_precision_loss, reason = "grain ids are 31 bits wide")]
        let grains = (nine_tenths - tenth) as f64;
        let interval = times[nine_tenths] - times[tenth];
        // Grains that leave in one step have no rate.
        (interval > 0.0).then(|| Self { duration_s: times[times.len() - 1] - times[0], rate_per_s: grains / interval })
    }
}
