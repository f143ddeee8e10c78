//! `siloflow check`: finds bad input, an unstable step and leaky walls before a run.

use std::fmt::Write as _;
use std::time::Duration;

use clap::Args;

use crate::behaviour::Registry;
use crate::cli::exit_status::ExitStatus;
use crate::cli::signals::Signals;
use crate::cli::{ONE_THREAD, SceneArgs, say};
use crate::lattice_silo;
use crate::lattice_silo::loaded::LoadedLattice;
use crate::scene::TimeStep;
use crate::scene::check::automatic::automatic;
use crate::scene::check::{self, Estimates};
use crate::scene::expected::{self, BYTES_PER_GRAIN, Work};
use crate::scene::loaded::{AnyScene, Loaded};
use crate::simulation::Simulation;
use crate::writers::volume::{self, Output, Volume};
use siloflow_dem::budget::{self, Budget};
use siloflow_dem::values::NonNegative;
use siloflow_dem::walls::config::shape::WallShape;
use siloflow_dem::walls::mesh::open_and_crowded_edges;
use siloflow_dem::walls::mesh_faults;
use siloflow_lattice::sites::Sites;
use siloflow_text::fault::{Fault, Warning};

/// Arguments of `check`.
#[derive(Args, Debug)]
pub(super) struct CheckArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Time for the checks, s. A check that needs more ends, and a warning names it.
    #[arg(long, value_name = "SECONDS", default_value_t = budget::USUAL.as_secs_f64(), value_parser = seconds)]
    patience: f64,
}

fn seconds(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| "expected a number of seconds, for example 60")?;
    NonNegative::try_from(number).map(NonNegative::get)
}

pub(super) fn check(args: &CheckArgs, registry: &Registry) -> Result<ExitStatus, Fault> {
    // A signal ends the command at once: there is nothing to finish.
    let _signals = Signals::catch();
    let scene = args.scene.load()?;
    let budget = Budget::of(Duration::try_from_secs_f64(args.patience).unwrap_or(Duration::MAX));
    let Findings { estimates, warnings, .. } = examine(&scene, registry, &budget)?;
    let mut text = format!("{}: the input is valid\n{estimates}", scene.source().name);
    // Writing to a string cannot fail.
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
    Ok(ExitStatus::Done)
}

/// The findings of a check in a scene that can be run.
#[derive(Clone, Debug)]
pub struct Findings {
    /// Estimates, a line for each: a name and a value.
    pub estimates: String,
    /// Expected trouble.
    pub warnings: Vec<Warning>,
    /// Most spheres or discs in a step: of grains, released ones too, and of walls; or sites of the lattice gas.
    pub bodies: usize,
    /// Bytes of all outputs up to `until`, or in the first million steps; 0 if the step is not known.
    pub bytes: f64,
}

/// Examines a scene as the command `check` does.
///
/// # Errors
/// If the scene cannot be run.
pub fn examine(scene: &AnyScene, registry: &Registry, budget: &Budget) -> Result<Findings, Fault> {
    let mut estimates = String::new();
    let bytes = |outputs: &[Output], steps: f64| volume::total(outputs, steps.min(volume::HORIZON)).bytes;
    Ok(match scene {
        AnyScene::Grains(loaded) => {
            Simulation::new(loaded, registry, ONE_THREAD)?;
            describe(loaded, &mut estimates);
            let until = loaded.scene.until.get();
            Findings {
                estimates,
                warnings: check::warnings_within(loaded, budget),
                bodies: expected::shapes(loaded),
                bytes: expected::known_step(loaded).map_or(0.0, |dt| bytes(&expected::outputs(loaded, dt), until / dt)),
            }
        }
        AnyScene::Lattice(loaded) => {
            Simulation::of_lattice(loaded, registry, ONE_THREAD)?;
            describe_lattice(loaded, &mut estimates);
            #[expect(clippy::cast_precision_loss, reason = "a number of steps")]
            let steps = loaded.scene.until as f64;
            Findings {
                estimates,
                warnings: lattice_silo::check::warnings(loaded),
                bodies: loaded.sites.fluid_count(),
                bytes: bytes(&lattice_silo::limits::outputs(loaded), steps),
            }
        }
    })
}

/// Adds a line for each mesh. An edge of one triangle alone is the rim of an opening, or a gap.
fn describe_meshes(loaded: &Loaded, text: &mut String) {
    for (number, wall) in loaded.scene.walls.iter().enumerate() {
        let WallShape::Mesh { triangles, .. } = &wall.shape else { continue };
        let [open, crowded] = open_and_crowded_edges(triangles);
        let count = triangles.len();
        let reversed = mesh_faults::reversed(triangles);
        let _ = writeln!(
            text,
            "mesh of walls[{number}]  {count} triangles; {open} edges of one triangle alone, {crowded} of more than two, {reversed} \
             of two that are turned against each other"
        );
    }
}

/// Adds the estimates of a scene of grains. Writing to a string cannot fail.
fn describe(loaded: &Loaded, text: &mut String) {
    let grains = loaded.grains.len();
    let fixed = loaded.fixed.len();
    #[expect(clippy::cast_precision_loss, reason = "a number of grains")]
    let megabytes = (grains + fixed) as f64 * BYTES_PER_GRAIN / 1e6;
    let _ = writeln!(
        text,
        "start             {grains} grains, {fixed} wall grains of `fill`, about {megabytes:.1} MB of memory"
    );
    let bodies = loaded.scene.fill.iter().filter(|fill| fill.fixed && fill.shape.is_some());
    let bodies: u32 = bodies.filter_map(|fill| fill.size(loaded.scene.space)).sum();
    if bodies > 0 {
        let _ = writeln!(text, "fixed shapes      {bodies} grains, each sphere of which is a wall grain or a wall");
    }
    describe_meshes(loaded, text);
    if let Some(dt) = expected::known_step(loaded) {
        let steps = loaded.scene.until.get() / dt;
        describe_output(&expected::outputs(loaded, dt), steps, text);
        describe_work(Work::of_grains(loaded, dt), "particle-steps", text);
    }
    let Some(e) = Estimates::of(loaded) else { return };
    let _ = write!(
        text,
        "smallest grain    radius {:.3e} m, mass {:.3e} kg\n\
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
    if e.adhesive_overlap > 0.0 {
        let _ = writeln!(
            text,
            "adhesion          overlap up to {:.2e} of the radius in bodies that touch at rest",
            e.adhesive_overlap
        );
    }
    if let TimeStep::Auto { error } = loaded.scene.step {
        let _ = writeln!(text, "automatic step    {}", automatic(&e, error.get()).reason);
    }
}

/// Adds what a run writes, if it lasts to `until`. Writing to a string cannot fail.
fn describe_output(outputs: &[Output], steps: f64, text: &mut String) {
    let Volume { rows, pictures, bytes } = volume::total(outputs, steps);
    let figure = |x: f64| if x < 1e6 { format!("{x:.0}") } else { format!("{x:.1e}") };
    let _ = writeln!(
        text,
        "output to `until` {} steps: about {} rows, {} pictures, {} MB",
        figure(steps),
        figure(rows),
        figure(pictures),
        figure((bytes / 1e6).ceil())
    );
}

fn describe_lattice(loaded: &LoadedLattice, text: &mut String) {
    let sites = &loaded.sites;
    let (columns, rows) = Sites::extent(&loaded.outline(), sites.spacing);
    let _ = write!(
        text,
        "lattice           {} sites in {columns} columns of up to {rows}, {} m apart\n\
         outlet            {} sites\n\
         upper layer       {}\n",
        sites.fluid_count(),
        sites.spacing,
        sites.doorway.len(),
        lattice_silo::check::diffuse_layer(loaded)
            .map_or("none: no gravity".to_owned(), |layer| format!("about {layer:.2} m thick (12/g sites)")),
    );
    #[expect(clippy::cast_precision_loss, reason = "a number of steps")]
    describe_output(&lattice_silo::limits::outputs(loaded), loaded.scene.until as f64, text);
    describe_work(Work::of_lattice(loaded.scene.until, sites.fluid_count()), "site updates", text);
}

/// Adds the time that a run takes, if it lasts to `until`. Writing to a string cannot fail.
fn describe_work(work: Work, updates: &str, text: &mut String) {
    let _ = writeln!(
        text,
        "time to `until`   {} on one core, for {:.1e} {updates}; most runs end earlier",
        work.words(),
        work.updates
    );
}
