//! Estimates from a scene before a run, and warnings where they predict trouble.
//!
//! * The step ([`step`]): over all pairs of species that can meet ([`species_pairs`]), the lowest stability limit of a single
//!   contact and of a dense bed, along the normal, along the tangent and in rolling. Hertz's stiffness is taken at the
//!   deepest point of the fastest impact.
//! * The walls: a grain that fell all the way has the energy m v^2/2. Squeezing it between two wall grains at distance d
//!   takes 2 (k/2) (R + R_w - d/2)^2. [`leaks`] searches for gaps between rigid walls.
//! * The bed: its weight over its base area is a pressure p. A contact at the bottom carries 2 R p (in solid space 4 R^2 p)
//!   and is compressed by that force over k.
//! * Adhesion: the overlap that it causes in two bodies that touch at rest.
//! * The door (`check/doors.rs`): without wall discs on both sides it has no orifice through which a grain could count as out.
//!   Between the spheres of a door (`check/door_gaps.rs`) there must be no gap.
//! * The path (`check/tunnelling.rs`): a grain that moves farther than a wall is thick, or than a grain is wide, in one step may pass it undetected.
//! * The start (`check/start.rs`) and the fall (`check/falling.rs`): overlaps, places inside and outside of walls, grains that fall for ever.
//! * The silo (`check/silo.rs`): gravity upwards, a feed outside, another unit, an outlet that clogs, a step that is far too short.
//! * The heights (`check/heights.rs`): keys that read heights, while gravity points along another axis.
//! * The output: a warning if the run would write more than [`MOST_BYTES`] up to `until`.
//!
//! All checks of a scene together have a [`Budget`] of time. One that needs more ends, and a last warning says what was not examined. No result of a
//! run depends on a check, so none depends on the budget.

pub mod automatic;
mod bed;
pub mod crowd;
mod door_gaps;
mod doors;
pub mod estimates;
mod falling;
mod free_walls;
mod heights;
pub mod leaks;
mod lightest;
mod meshes;
pub mod quantities;
mod silo;
mod softness;
mod sources;
pub mod species_pairs;
mod start;
pub mod step;
mod tunnelling;

pub use self::estimates::hardest;
pub use self::quantities::Estimates;
use std::cell::LazyCell;
use std::fmt::Write as _;

use crate::scene::expected;
use crate::scene::loaded::Loaded;
use crate::writers::volume::{self, MOST_BYTES};
use siloflow_dem::budget::Budget;
use siloflow_text::fault::Warning;

/// Warnings about effects that the author of the scene may not want, within the usual budget of time.
#[must_use]
pub fn warnings(loaded: &Loaded) -> Vec<Warning> {
    warnings_within(loaded, &Budget::usual())
}

/// Like [`warnings`], with another budget.
#[must_use]
pub fn warnings_within(loaded: &Loaded, budget: &Budget) -> Vec<Warning> {
    let mut warnings = examined(loaded, budget);
    let unfinished = budget.take_unfinished();
    if !unfinished.is_empty() {
        let mut message =
            format!("the checks gave up, for they have {} s in all; not examined:", budget.time().as_secs_f64());
        for (number, what) in unfinished.iter().enumerate() {
            // Writing to a string cannot fail.
            let _ = write!(message, "{} {what}", if number == 0 { "" } else { ";" });
        }
        warnings.push(Warning {
            code: "check::unfinished",
            message,
            help: "what was not examined may have faults without a warning; `siloflow check SCENE --patience SECONDS` takes more time"
                .to_owned(),
        });
    }
    warnings
}

fn examined(loaded: &Loaded, budget: &Budget) -> Vec<Warning> {
    let mut warnings = loaded.source.unused_parameters();
    warnings.extend(loaded.notes.iter().cloned());
    renamed_keys(loaded, &mut warnings);
    sources::stop(loaded, &mut warnings);
    let estimates = Estimates::of(loaded);
    heights::examine(loaded, &mut warnings);
    silo::examine(loaded, &mut warnings);
    budget.share(0.5, || start::examine(loaded, estimates.as_ref(), budget, &mut warnings));
    budget.share(0.5, || meshes::examine(loaded, budget, &mut warnings));
    let Some(estimates) = estimates else { return warnings };
    step(&estimates, &mut warnings);
    sources::examine(loaded, estimates.dt, &mut warnings);
    softness::examine(loaded, &estimates, &mut warnings);
    tunnelling::examine(loaded, &estimates, &mut warnings);
    free_walls::examine(loaded, &estimates, &mut warnings);
    let way_out = LazyCell::new(|| leaks::way_out(loaded, budget));
    falling::examine(loaded, || way_out.is_some(), &mut warnings);
    output(loaded, &estimates, &mut warnings);
    if let Some(place) = *way_out {
        warnings.push(Warning {
            code: "check::leaky_walls",
            message: format!(
                "a grain of radius {} m finds a way out of the walls near ({:.2}, {:.2}) m",
                estimates.radius, place.x, place.y
            ),
            help: "close the gap, or release larger grains".to_owned(),
        });
    }
    doors::examine(loaded, estimates.radius, &mut warnings);
    door_gaps::examine(loaded, &mut warnings);
    silo::examine_with(loaded, &estimates, &mut warnings);
    warnings
}

/// Keys that still have an old name.
fn renamed_keys(loaded: &Loaded, warnings: &mut Vec<Warning>) {
    if loaded.source.value_of("energy_books").is_some() {
        warnings.push(Warning {
            code: "check::renamed_key",
            message: "the key `energy_books` is now called `energy_balance`".to_owned(),
            help: "write `energy_balance`: the next release does not know the old name".to_owned(),
        });
    }
}

fn step(estimates: &Estimates, warnings: &mut Vec<Warning>) {
    let Estimates { dt, pair_limit, bed_limit, .. } = *estimates;
    if dt >= bed_limit.min(pair_limit) {
        let (code, what, limit) = if dt >= pair_limit {
            ("check::unstable_step", "of a single contact", pair_limit)
        } else {
            ("check::unstable_bed", "of a dense bed", bed_limit)
        };
        warnings.push(Warning {
            code,
            message: format!(
                "the step of {dt:.3e} s is beyond the stability limit {what}, {limit:.3e} s: energy may grow"
            ),
            help: format!("lower `step` below {:.2e} s, or soften the contacts", bed_limit.min(pair_limit)),
        });
    }
}

/// Warns if a run that lasts to `until` would write very much. Shorter runs are judged by the rules.
fn output(loaded: &Loaded, estimates: &Estimates, warnings: &mut Vec<Warning>) {
    let steps = loaded.scene.until.get() / estimates.dt;
    let bytes = volume::total(&expected::outputs(loaded, estimates.dt), steps).bytes;
    if bytes > MOST_BYTES {
        warnings.push(Warning {
            code: "check::much_output",
            message: format!("a run that lasts to `until` would write about {:.1e} GB", bytes / 1e9),
            help: "lengthen `pictures.interval` or `series.interval`, or lower `until`".to_owned(),
        });
    }
}
