//! How soft the grains of a scene may be made, and how its figures then err.
//!
//! A bed of soft grains is a bed of slightly smaller ones. At given load the overlap of a contact, over the radius, grows as s^(2/3) with Hertz's law and
//! as s with linear springs, and figures of the bed follow it. Figures that depend on the duration of contacts follow s^(1/2), with Hertz's law s^(2/5).
//! So the power lies between 2/5 and 1 (linear laws: 1/2 and 1), and 2/3 (1) is to be expected.
//!
//! Limits: the grains at the bottom of the bed overlap by at most [`DEEPEST_AT_REST`] of their radius, and the fastest impact, that of a grain that falls
//! freely to the bottom, by at most [`DEEPEST_IMPACT`]. A scene that exceeds one of them is not softened.
//!
//! The rungs are half powers of ten: a run takes 1.78 times as long as one of the next softer rung.

use crate::scene::check::Estimates;
use siloflow_dem::contact::config::Contact;
use siloflow_figures::statistics::extrapolation::Powers;

/// Largest overlap over radius at the bottom of the bed.
pub const DEEPEST_AT_REST: f64 = 0.1;

/// Largest overlap over radius of an impact.
pub const DEEPEST_IMPACT: f64 = 0.5;

/// Most rungs above that of the scene: softness 10,000.
const MOST_RUNGS: u8 = 8;

/// Returns the powers of a law.
#[must_use]
pub fn powers(law: &Contact) -> Powers {
    match law {
        Contact::Hertz { .. } => Powers { low: 0.4, usual: 2.0 / 3.0, high: 1.0 },
        _ => Powers { low: 0.5, usual: 1.0, high: 1.0 },
    }
}

/// Returns the softnesses from 1 to the softest one whose estimates, which `estimates` returns, keep the limits.
pub fn softnesses(mut estimates: impl FnMut(f64) -> Option<Estimates>) -> Vec<f64> {
    let mut is_hard = |softness: f64| {
        estimates(softness)
            .is_some_and(|it| it.static_overlap <= DEEPEST_AT_REST && it.impact_overlap <= DEEPEST_IMPACT)
    };
    let softer = (1..=MOST_RUNGS).map(|rung| rounded(10f64.powf(0.5 * f64::from(rung))));
    std::iter::once(1.0).chain(softer.take_while(|&softness| is_hard(softness))).collect()
}

/// Three digits: 3.16 rather than the root of ten.
fn rounded(softness: f64) -> f64 {
    format!("{softness:.2e}").parse().unwrap_or(softness)
}
