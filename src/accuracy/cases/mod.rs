//! The canonical cases, a file each.

mod bed;
mod bounce;
mod chain;
mod column;
mod free_flight;
mod gas;
mod oblique;
mod roll;
mod stacked;

pub use self::bed::bed;
use super::case::Case;

/// The next of a row of numbers between 0 and 1 that look random and are the same everywhere (a 64-bit congruential
/// generator, Knuth's constants; the upper bits).
fn draw(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    #[expect(clippy::cast_precision_loss, reason = "53 bits")]
    let share = (*state >> 11) as f64 / (1u64 << 53) as f64;
    share
}

/// All of them, in the order in which they are shown.
#[must_use]
pub fn all() -> Vec<Case> {
    let mut cases = vec![free_flight::case()];
    cases.extend(bounce::cases());
    cases.extend(chain::cases());
    cases.extend(oblique::cases());
    cases.extend([stacked::case(), roll::case(), gas::case(), column::case(), bed()]);
    cases
}
