//! `siloflow check`: bad input, an unstable step and leaky walls, before a run.

use std::fmt::Write as _;

use clap::Args;

use crate::behaviour::Registry;
use crate::check::{Estimates, warnings};
use crate::cli::{ONE_THREAD, SceneArgs, Verdict, say};
use crate::fault::Fault;
use crate::simulation::Simulation;

/// Arguments of `check`.
#[derive(Args, Debug)]
pub(super) struct CheckArgs {
    #[command(flatten)]
    scene: SceneArgs,
}

pub(super) fn check(args: &CheckArgs, registry: &Registry) -> Result<Verdict, Fault> {
    let loaded = args.scene.load()?;
    Simulation::new(&loaded, registry, ONE_THREAD)?;
    let mut text = format!("{}: the input is valid\n", loaded.name);
    // Writing to a string cannot fail.
    if let Some(e) = Estimates::of(&loaded) {
        let _ = write!(
            text,
            "smallest grain    radius {} m, mass {} kg\n\
             contact           {:.3e} s long, restitution {:.3}\n\
             step              {:.3e} s = contact/{:.1}; limit {:.3e} s for one contact, {:.3e} s in a dense bed\n\
             impact            up to {:.2} m/s, overlap up to {:.2} of the radius\n\
             weight of the bed overlap about {:.3} of the radius\n",
            e.radius,
            e.mass,
            e.contact_duration,
            e.restitution,
            e.dt,
            e.contact_duration / e.dt,
            e.pair_limit,
            e.bed_limit,
            e.impact_speed,
            e.impact_overlap,
            e.static_overlap,
        );
    }
    let warnings = warnings(&loaded);
    for warning in &warnings {
        let _ = write!(text, "warning {}\n  {}\n  {}\n", warning.code, warning.message, warning.help);
    }
    let _ = writeln!(
        text,
        "{}",
        match warnings.len() {
            0 => "no warnings".to_owned(),
            1 => "1 warning".to_owned(),
            n => format!("{n} warnings"),
        }
    );
    say(&text);
    Ok(Verdict::Done)
}
