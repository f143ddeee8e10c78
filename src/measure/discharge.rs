//! The discharge through the orifice, from the ledger: how long, and how fast.
//!
//! The rate is taken between the moments when a tenth and nine tenths of the grains were out, so that neither the
//! start of the flow nor its thin end counts.

use serde::Serialize;

use crate::ledger::Ledger;

/// The figures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Discharge {
    /// From the first grain out to the last, s.
    pub duration_s: f64,
    /// Mean rate between a tenth and nine tenths, grains/s.
    pub rate_per_s: f64,
}

impl Discharge {
    /// The figures of a ledger, if at least ten grains are out, and not all at once.
    #[must_use]
    pub fn of(ledger: &Ledger) -> Option<Self> {
        let times = &ledger.out_times;
        if times.len() < 10 {
            return None;
        }
        let (tenth, nine_tenths) = (times.len() / 10, times.len() - 1 - times.len() / 10);
        #[expect(clippy::cast_precision_loss, reason = "grain ids are 31 bits wide")]
        let grains = (nine_tenths - tenth) as f64;
        let between = times[nine_tenths] - times[tenth];
        // Grains that all leave in one step have no rate.
        (between > 0.0).then(|| Self { duration_s: times[times.len() - 1] - times[0], rate_per_s: grains / between })
    }
}
