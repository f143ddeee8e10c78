//! The validation cases, one file each.

mod anand_hopper;
mod beverloo;
mod chung_ooi;
mod chute;
mod clogging;
mod dosta_drum;
mod dosta_impact;
mod dosta_silo;
mod drainage;
mod janssen;
mod orifice_profiles;

use crate::studies::validation::Case;

/// All cases, in the order of the page.
pub const CASES: [&Case; 11] = [
    &dosta_silo::CASE,
    &dosta_impact::CASE,
    &dosta_drum::CASE,
    &anand_hopper::CASE,
    &orifice_profiles::CASE,
    &drainage::CASE,
    &chute::CASE,
    &clogging::CASE,
    &beverloo::CASE,
    &janssen::CASE,
    &chung_ooi::CASE,
];
