//! The validation cases, one file each.

mod anand_hopper;
mod chung_ooi;
mod clogging;
mod dosta_silo;
mod drainage;
mod orifice_profiles;

use crate::validation::Case;

/// All cases, in the order of the page.
pub static CASES: [&Case; 6] = [
    &dosta_silo::CASE,
    &anand_hopper::CASE,
    &orifice_profiles::CASE,
    &drainage::CASE,
    &clogging::CASE,
    &chung_ooi::CASE,
];
