//! `siloflow run` for a scene of grains.

use std::fmt::Write as _;
use std::io::{self, Write};
use std::marker::PhantomData;

use bevy_ecs::prelude::*;

use crate::assembly::Assembly;
use crate::behaviour::Registry;
use crate::cli::progress::Pace;
use crate::cli::run_path::{Call, Method, Outline};
use crate::grains::file;
use crate::ledger::Ledger;
use crate::measure::outputs::BehaviourOutputs;
use crate::output::cost::CostPlugin;
use crate::output::fields::FieldsPlugin;
use crate::output::flow::FlowPlugin;
use crate::output::frame_recording::FrameDataPlugin;
use crate::output::losses::LossesPlugin;
use crate::output::outflow::OutflowPlugin;
use crate::output::parent::ParentPlugin;
use crate::output::pictures::PicturesPlugin;
use crate::output::profiles::ProfilesPlugin;
use crate::output::run_path::RunPath;
use crate::output::series::SeriesPlugin;
use crate::output::summary::{Cost, Energy, Summary, free_grains};
use crate::output::wall_bands::WallBandsPlugin;
use crate::output::walls::WallForcesPlugin;
use crate::scene::TimeStep;
use crate::scene::check::automatic::{Automatic, automatic};
use crate::scene::check::{self, Estimates};
use crate::scene::loaded::Loaded;
use crate::simulation::{Caller, Simulation};
use crate::writers::provenance::Provenance;
use siloflow_dem::outcome::End;
use siloflow_dem::persist::{CheckpointConfig, Section, UnknownState};
use siloflow_dem::space::{Dimension, Plane, Solid, Space};
use siloflow_dem::step::Clock;
use siloflow_dem::store::ParticleStore;
use siloflow_dem::walls::config::Wall;
use siloflow_files::hashes::SummaryFiles;
use siloflow_files::run_directory::{RunDirectory, names};
use siloflow_files::run_files::Damage;
use siloflow_text::fault::Fault;
use siloflow_text::source::Source;

impl Method for Loaded {
    type Summary = Summary;

    fn source(&self) -> &Source {
        &self.source
    }

    fn check(&self, registry: &Registry) -> Result<(), Fault> {
        for warning in check::warnings(self) {
            tracing::warn!("{warning}");
        }
        if let (TimeStep::Auto { error }, Some(estimates)) = (self.scene.step, Estimates::of(self)) {
            let Automatic { dt, reason } = automatic(&estimates, error.get());
            tracing::info!("step {dt:.1e} s: {reason}");
        }
        Simulation::check(self, registry)
    }

    fn build(&mut self, call: &Call, directory: &RunDirectory, saved: Option<&[Section]>) -> Result<Simulation, Fault> {
        let simulation = match self.scene.space {
            Dimension::Plane => build_in::<Plane>(self, call, directory, saved),
            Dimension::Solid => build_in::<Solid>(self, call, directory, saved),
        }?;
        // The grains are in the world now.
        self.grains = Vec::new();
        Ok(simulation)
    }

    fn checkpoint(&self) -> Option<CheckpointConfig> {
        self.scene.checkpoint
    }

    fn updates(&self, world: &World, before: u64) -> u64 {
        before + free_grains(world) as u64
    }

    fn line(&self, world: &World, pace: Pace) -> String {
        line(world, self.scene.until.get(), pace)
    }

    fn summary(&self, world: &mut World, end: &End, cost: Cost) -> Summary {
        Summary::of(world, self, end, cost)
    }

    fn write_state(&self, world: &mut World, file: &mut dyn Write) -> io::Result<()> {
        match self.scene.space {
            Dimension::Plane => file::write_to::<Plane>(world, file),
            Dimension::Solid => file::write_to::<Solid>(world, file),
        }
    }
}

impl Outline for Summary {
    fn failure(&self) -> Option<&str> {
        self.failure.as_deref()
    }

    fn fail(&mut self, reason: String) {
        self.status = "failed";
        self.failure.get_or_insert(reason);
    }

    fn record(&mut self, provenance: Provenance) {
        self.provenance = Some(provenance);
    }

    fn record_files(&mut self, files: SummaryFiles, damaged: Vec<Damage>) {
        (self.files, self.damaged) = (Some(files), damaged);
    }

    fn is_done(&self) -> bool {
        Self::is_done(self)
    }

    fn words(&self) -> String {
        words(self)
    }
}

fn build_in<V: Space>(
    loaded: &Loaded,
    call: &Call,
    directory: &RunDirectory,
    saved: Option<&[Section]>,
) -> Result<Simulation, Fault> {
    let more = Box::new(|app: &mut Assembly<'_>| {
        // The behaviours have registered their columns.
        let outputs = Outputs::<V>::create(loaded, app.world(), directory);
        let outputs = outputs.map_err(|error| directory.unwritable(&error))?;
        declare_files(app.world(), directory)?;
        app.provide(RunPath::of(directory));
        app.add("always", CostPlugin);
        app.add("always", ParentPlugin(call.parent.clone()));
        app.add("series", outputs.series);
        app.add("on_loss", LossesPlugin { place: directory.losses(), space: V::DIMENSION });
        if let Some(walls) = outputs.walls {
            app.add("walls", walls);
        }
        if let Some(bands) = outputs.wall_bands {
            app.add("wall_bands", bands);
        }
        if let Some(profiles) = outputs.profiles {
            app.add("profiles", profiles);
        }
        if let Some(fields) = outputs.fields {
            app.add("fields", fields);
        }
        if let Some(window) = loaded.scene.outflow {
            app.add("outflow", OutflowPlugin::<V> { window, species: loaded.largest_species(), space: PhantomData });
        }
        if let Some(flow) = outputs.flow {
            app.add("flow", flow);
        }
        if let Some(frame_data) = outputs.frame_data {
            app.add(
                if loaded.source.value_of("data_frames").is_some() { "data_frames" } else { "pictures" },
                frame_data,
            );
        }
        if let Some(pictures) = PicturesPlugin::<V>::of(loaded, app.world(), directory.frames())? {
            app.add("pictures", pictures);
        }
        Ok(())
    });
    let saved = saved.map(|saved| (saved, UnknownState::Refuse));
    Simulation::with(loaded, call.registry, call.threads, Caller::CommandLine, more, saved)
}

/// Records the files that behaviours will write.
pub(super) fn declare_files(world: &World, directory: &RunDirectory) -> Result<(), Fault> {
    directory.declare(&BehaviourOutputs::files(world)).map_err(|error| directory.unwritable(&error))
}

/// The files that grow while a scene runs.
struct Outputs<V: Space> {
    series: SeriesPlugin<V>,
    walls: Option<WallForcesPlugin<V>>,
    wall_bands: Option<WallBandsPlugin<V>>,
    profiles: Option<ProfilesPlugin<V>>,
    fields: Option<FieldsPlugin<V>>,
    flow: Option<FlowPlugin>,
    frame_data: Option<FrameDataPlugin<V>>,
}

impl<V: Space> Outputs<V> {
    fn create(loaded: &Loaded, world: &World, directory: &RunDirectory) -> std::io::Result<Self> {
        let names: Vec<_> = loaded.scene.walls.iter().filter(|wall| wall.is_surface()).map(Wall::name).collect();
        let bands = loaded.wall_bands::<V>();
        let profiles = loaded.profiles();
        let species = u8::try_from(loaded.largest_species()).unwrap_or(u8::MAX);
        let tracks_energy = loaded.scene.energy_balance;
        Ok(Self {
            series: SeriesPlugin::create(loaded.scene.series, tracks_energy, world, &directory.rows(names::SERIES))?,
            walls: if names.is_empty() {
                None
            } else {
                Some(WallForcesPlugin::create(
                    &names,
                    &directory.rows(names::WALLS),
                    &directory.rows(names::WALL_GROUPS),
                )?)
            },
            wall_bands: if bands.is_empty() {
                None
            } else {
                Some(WallBandsPlugin::create(bands, &directory.rows(names::WALL_BANDS))?)
            },
            profiles: if profiles.is_empty() {
                None
            } else {
                Some(ProfilesPlugin::create(
                    &profiles,
                    species,
                    &directory.rows(names::PROFILES),
                    &directory.rows(names::CENTRES),
                )?)
            },
            fields: if loaded.scene.fields.is_empty() {
                None
            } else {
                Some(FieldsPlugin::create(loaded.fields(), &directory.rows(names::FIELDS))?)
            },
            flow: loaded.scene.flow.map(|flow| FlowPlugin::create(flow, &directory.rows(names::FLOW))).transpose()?,
            frame_data: FrameDataPlugin::create(loaded, world, &directory.rows(names::FRAME_DATA))?,
        })
    }
}

fn line(world: &World, until: f64, pace: Pace) -> String {
    let time = world.resource::<Clock>().time();
    let ledger = world.resource::<Ledger>();
    let kinetic = match Dimension::of_world(world) {
        Dimension::Plane => kinetic::<Plane>(world),
        Dimension::Solid => kinetic::<Solid>(world),
    };
    format!(
        "t = {time:.2} s of at most {until} s | {:.1} M particle-steps/s | at most {:.0} s to go | inside {}, out {}, \
         lost {} | kinetic {kinetic:.3e} J",
        pace.millions_per_s,
        pace.left(time, until - time),
        ledger.inside(),
        ledger.out(),
        ledger.lost()
    )
}

/// Kinetic energy of translation, J, from velocities that may be half a step old.
fn kinetic<V: Space>(world: &World) -> f64 {
    let columns = world.resource::<ParticleStore<V>>();
    columns.integrated_rows().map(|i| columns.kinetic_energy(i)).sum()
}

fn words(summary: &Summary) -> String {
    let grains = &summary.grains;
    let performance = &summary.performance;
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{name:<12} {value}");
    };
    line(&summary.scene, format!("{}, {} steps, {:.3} s simulated", summary.status, summary.steps, summary.time_s));
    line(
        "grains",
        format!("{} released, {} inside, {} out, {} lost", grains.released, grains.inside, grains.out, grains.lost),
    );
    if let Some(stop) = &summary.stop {
        line("stopped", format!("{stop}; {} grains inside, {:.4} kg", grains.inside, grains.inside_kg));
    }
    for feed in summary.feed.iter().flat_map(|feeds| &feeds.0) {
        let value = format!(
            "{} grains, {:.4} kg, {:.1} % short of the rate",
            feed.grains,
            feed.mass_kg,
            100.0 * feed.shortfall
        );
        line("feed", value);
    }
    let moments =
        [("at rest", summary.rest_time_s), ("door opened", summary.door_open_time_s), ("empty", summary.empty_time_s)];
    for (name, time) in moments {
        if let Some(time) = time {
            line(name, format!("{time:.3} s"));
        }
    }
    if let Some(bed) = summary.bed {
        line("bed", format!("height {:.3} m, packing fraction {:.4}", bed.fill_height_m, bed.packing_fraction));
    }
    if let Some(flow) = summary.discharge {
        line("discharge", format!("{:.2} s, {:.1} grains/s from 10 to 90 % out", flow.duration_s, flow.rate_per_s));
    }
    if let Some(outflow) = &summary.outflow
        && let (Some(number), Some(mass)) = (outflow.rate_per_s, outflow.rate_kg_per_s)
    {
        let from = outflow.from_s;
        let to = outflow.to_s;
        let value = format!("{:.1} grains/s, {:.4} kg/s from {from:.2} to {to:.2} s", number.mean, mass.mean);
        line("outflow", value);
    }
    line("overlap", format!("largest {:.4} of the radius", summary.max_overlap_ratio));
    if let Energy { flows: Some(flows), balance_error: Some(error), .. } = &summary.energy {
        line("energy", format!("{:.3e} J dissipated, balance error {error:.3e} J", flows.dissipated));
    }
    line("contacts", format!("{:.3} a grain at the end", summary.coordination));
    let nanoseconds = 1e9 / performance.particle_steps_per_s;
    line(
        "wall clock",
        format!("{:.2} s, {nanoseconds:.1} ns a particle-step, threads: {}", performance.wall_s, performance.threads),
    );
    line("state hash", summary.state_hash.clone());
    text
}
