//! The validation cases, one file each.

mod anand_hopper;
mod dosta_silo;

use crate::validation::Case;

/// All cases, in the order of the page.
pub static CASES: [&Case; 2] = [&dosta_silo::CASE, &anand_hopper::CASE];
