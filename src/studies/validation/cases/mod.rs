//! The validation cases, one file each.

mod anand_hopper;
mod beverloo;
mod capsule_packing;
mod chung_ooi;
mod chute;
mod clogging;
mod dosta_drum;
mod dosta_impact;
mod dosta_silo;
mod drainage;
mod ellipses_hopper;
mod ellipsoid_discharge;
mod ellipsoid_packing;
mod janssen;
mod orifice_profiles;
mod rice_clogging;
mod turning_base;
mod two_shapes;

use crate::studies::validation::Case;
use siloflow_text::fault::Fault;
use siloflow_text::suggestion::did_you_mean;

/// All cases, in the order of the page.
pub const CASES: [&Case; 17] = [
    &dosta_silo::CASE,
    &dosta_impact::CASE,
    &dosta_drum::CASE,
    &anand_hopper::CASE,
    &orifice_profiles::CASE,
    &drainage::CASE,
    &chute::CASE,
    &clogging::CASE,
    &rice_clogging::CASE,
    &ellipses_hopper::CASE,
    &beverloo::CASE,
    &janssen::CASE,
    &chung_ooi::CASE,
    &ellipsoid_discharge::CASE,
    &turning_base::CASE,
    &ellipsoid_packing::CASE,
    &capsule_packing::CASE,
];

/// Returns the case of this name.
///
/// # Errors
/// If there is none.
pub fn named(name: &str) -> Result<&'static Case, Fault> {
    CASES.into_iter().find(|case| case.name == name).ok_or_else(|| {
        let names: Vec<_> = CASES.iter().map(|case| case.name).collect();
        Fault::new("validate::unknown_case", format!("there is no case `{name}`"))
            .help(did_you_mean("cases", name, &names))
    })
}
