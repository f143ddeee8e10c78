//! The standard test cases, one per file.

mod bed;
mod bounce;
mod chain;
mod clump;
mod column;
mod draw;
mod free_flight;
mod gas;
mod oblique;
mod piston;
mod roll;
mod stacked;
mod vibrating_floor;

pub use self::bed::bed;
use super::case::Case;

/// Returns all cases in the order of the report.
#[must_use]
pub fn all() -> Vec<Case> {
    let mut cases = vec![free_flight::case()];
    cases.extend(bounce::cases());
    cases.extend(chain::cases());
    cases.extend(oblique::cases());
    cases.extend(clump::cases());
    cases.extend([stacked::case(), roll::case(), vibrating_floor::case()]);
    cases.extend(piston::cases());
    cases.extend([gas::case(), column::case(), bed()]);
    cases
}
