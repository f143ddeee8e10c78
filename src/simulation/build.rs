//! Builds the app of a simulation: resources, plugins, and the schedule of a step.

use std::collections::HashSet;
use std::num::NonZeroUsize;

use bevy_app::App;
use bevy_ecs::message::message_update_system;
use bevy_ecs::prelude::*;

use crate::assembly::{AskedBy, Assembly};
use crate::behaviour::{Behaviour, Registry};
use crate::ending::request::StopRequest;
use crate::grains::pending::Pending;
use crate::measure::outputs::{self, Reserved};
use crate::output::series;
use crate::plugins::{AddPaths, add_all, planar_paths, solid_paths};
use crate::scene::loaded::Loaded;
use crate::simulation::{Additions, Simulation};
use siloflow_dem::contact::ContactsAtStart;
use siloflow_dem::engine::Engine;
use siloflow_dem::gravity::Gravity;
use siloflow_dem::instruction_set::InstructionSet;
use siloflow_dem::outcome::Outcome;
use siloflow_dem::persist::{self, PersistApp as _, Section, UnknownState};
use siloflow_dem::space::{Dimension, Plane, Solid};
use siloflow_dem::step::{Clock, Part, Step};
use siloflow_dem::store;
use siloflow_dem::threads::Threads;
use siloflow_dem::walls::leaving::{self, LeavingWalls, WallIndex};
use siloflow_dem::walls::surfaces::Surfaces;
use siloflow_files::frames::TAKEN_NAMES;
use siloflow_files::run_directory;
use siloflow_text::fault::Fault;
use siloflow_text::source::Source;

impl Simulation {
    /// Completes the app of a scene of grains.
    pub(super) fn complete_with_store(app: App, loaded: &Loaded) -> Result<Self, Fault> {
        match loaded.scene.space {
            Dimension::Plane => Self::complete(app, store::plan::<Plane>),
            Dimension::Solid => Self::complete(app, store::plan::<Solid>),
        }
    }

    /// Returns the app with all plugins, without particles and walls.
    pub(super) fn assemble(
        loaded: &Loaded,
        registry: &Registry,
        threads: NonZeroUsize,
        more: Additions<'_>,
    ) -> Result<App, Fault> {
        let behaviours = registry.of_scene(loaded)?;
        let mut app = app_with_resources(threads)?;
        let mut assembly = Assembly::new(&mut app);
        match loaded.scene.space {
            Dimension::Plane => add_plugins::<Plane>(&mut assembly, loaded, behaviours, planar_paths),
            Dimension::Solid => add_plugins::<Solid>(&mut assembly, loaded, behaviours, solid_paths),
        }
        refuse_outputs(assembly.world(), &loaded.source, &series::header(true))?;
        more(&mut assembly)?;
        assembly.finish();
        Ok(app)
    }

    /// Completes an app that has all its plugins. `plan` adds the systems that depend on all plugins.
    pub(super) fn complete(
        mut app: App,
        plan: fn(&mut Schedule, &mut World) -> Result<(), Fault>,
    ) -> Result<Self, Fault> {
        app.add_systems(Step, message_update_system.in_set(Part::End));
        // Initialised here, so that conflicting systems are an input error and not a later panic.
        app.world_mut().schedule_scope(Step, |world, schedule| {
            let known: HashSet<_> = schedule.graph().systems.iter().map(|(system, ..)| system).collect();
            plan(schedule, world)?;
            let new =
                schedule.graph().systems.iter().map(|(system, ..)| system).filter(|system| !known.contains(system));
            let asked_by = new.map(|system| ((schedule.label(), system), "components in use".to_owned()));
            world.resource_mut::<AskedBy>().0.extend(asked_by);
            if !world.resource::<Clock>().is_step_zero() {
                forget_restoration(schedule, world);
            }
            schedule.initialize(world).map(|_| ()).map_err(|error| {
                let message = error.to_string(schedule.graph(), world);
                let help = if ["particle::Force", "spin::Torque"].iter().any(|sum| message.contains(sum)) {
                    "a system that only adds to `Force` or `Torque` takes the parameter `AddForce` or `AddTorque` in place of a query with \
                     `&mut`: siloflow orders such systems itself"
                } else {
                    "order the systems of behaviours with `.after(...)`, `.before(...)` or `.chain()`"
                };
                Fault::new("behaviour::schedule", format!("the systems of this scene cannot be ordered: {message}"))
                    .help(help)
            })
        })?;
        Ok(Self { world: std::mem::take(app.world_mut()) })
    }
}

/// Refuses outputs of behaviours whose names are not allowed or taken. `header` is the one of `series.csv`.
pub(super) fn refuse_outputs(world: &World, source: &Source, header: &str) -> Result<(), Fault> {
    let grains = TAKEN_NAMES.split_whitespace().collect();
    let series = header.split(',').collect();
    let reserved = Reserved { grains, series, is_file: run_directory::is_reserved };
    outputs::refuse(world, &reserved).map_err(|(behaviour, problem)| {
        let key = if behaviour.is_empty() { "behaviours".to_owned() } else { format!("behaviours.{behaviour}") };
        source
            .fault("behaviour::output", &key, problem)
            .help("the `build` of the behaviour registers it: choose another name there")
    })
}

/// Restores saved state in an app that has all its plugins.
pub(super) fn restore(world: &mut World, saved: &[Section], unknown: UnknownState) -> Result<(), Fault> {
    persist::restore(world, saved, unknown).map_err(|problem| {
        Fault::new("checkpoint::state", format!("the saved state does not fit this scene: {problem}"))
            .help("continue it with the program and the scene that saved it")
    })
}

/// Lets the systems see the restored state as old: it was added and changed before the run was saved.
fn forget_restoration(schedule: &mut Schedule, world: &mut World) {
    let now = world.increment_change_tick();
    let graph = schedule.graph_mut();
    graph.initialize(world);
    let systems: Vec<_> = graph.systems.iter().map(|(system, ..)| system).collect();
    for system in systems {
        if let Some(system) = graph.systems.get_mut(system) {
            system.set_last_run(now);
        }
    }
}

/// Largest number of threads of a run. Many more than there are cores would occupy the machine without doing work.
pub(crate) const MOST_THREADS: usize = 1024;

/// Returns an app with the resources of every run.
pub(super) fn app_with_resources(threads: NonZeroUsize) -> Result<App, Fault> {
    if threads.get() > MOST_THREADS {
        let message = format!("{threads} threads are more than the limit of {MOST_THREADS}");
        return Err(Fault::new("call::threads", message).help("ask for fewer with --threads, at most one per core"));
    }
    let threads = Threads::new(threads).map_err(|error| {
        Fault::new("call::threads", format!("could not start the threads: {error}"))
            .help("ask for fewer with --threads")
    })?;
    let mut app = App::empty();
    app.insert_resource(threads)
        .insert_resource(InstructionSet::of_environment()?)
        .init_resource::<Outcome>()
        .init_resource::<StopRequest>()
        .init_resource::<Pending>()
        .persist::<Pending>()
        .derived::<Outcome>()
        .derived::<StopRequest>()
        // Several systems may end a run. The first one in the fixed order of the step takes effect.
        .allow_ambiguous_resource::<Outcome>();
    Ok(app)
}

/// Adds walls, gravity and all plugins of a scene of grains.
fn add_plugins<V: Engine>(
    assembly: &mut Assembly,
    loaded: &Loaded,
    behaviours: Vec<(String, Box<dyn Behaviour>)>,
    paths: AddPaths,
) {
    assembly.provide(Gravity(loaded.scene.gravity.get::<V>()));
    let largest = loaded.grain_radii().map_or(0.0, |(_, largest)| largest);
    let surfaces = loaded.surfaces_in_scene::<V>();
    let movers = loaded.movers_of(&surfaces);
    assembly.provide(Surfaces::new(surfaces, largest).with_movers(movers));
    assembly.provide(LeavingWalls::default());
    if !loaded.contacts_at_start.rows.is_empty() {
        assembly.provide(ContactsAtStart(loaded.contacts_at_start.clone()));
    }
    assembly.add_with("walls", |app| {
        app.persist_component::<WallIndex>()
            .persist::<LeavingWalls>()
            .persist_sound_part::<Surfaces<V>, _>(|walls| Ok(walls.saved()), |walls, saved| Ok(walls.restore(saved)?))
            .check_restored(leaving::check_restored::<V>);
    });
    add_all::<V>(assembly, loaded, behaviours, paths);
}
