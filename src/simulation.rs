//! A simulation: an app built from a scene, and the loop that steps it.

use std::collections::HashSet;
use std::num::NonZeroUsize;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

use bevy_app::App;
use bevy_ecs::message::message_update_system;
use bevy_ecs::prelude::*;

use crate::assembly::{AskedBy, Assembly};
use crate::behaviour::{Behaviour, Registry};
use crate::contact::ContactsAtStart;
use crate::ending::StopRequest;
use crate::engine::Engine;
use crate::fault::Fault;
use crate::grains::file::GrainRow;
use crate::grains::spawner::Pending;
use crate::gravity::Gravity;
use crate::instructions::Instructions;
use crate::lattice;
use crate::lattice::load::LoadedLattice;
use crate::measure::outputs::{self, Reserved};
use crate::messages::GrainReleased;
use crate::outcome::{End, Failure, Outcome};
use crate::output::checkpoint::{self, Checkpoints};
use crate::output::cost::RunCost;
use crate::output::frame_data::TAKEN_NAMES;
use crate::output::frame_data::writer::FrameDataWriter;
use crate::output::losses::LossesFile;
use crate::output::run_directory::{self, RunDirectory, RunPath};
use crate::output::series;
use crate::particle::{Door, GrainBundle, GrainId, Species, wall_grain};
use crate::periodic::Periodic;
use crate::persist::{self, PersistApp as _, Problem, Section, UnknownState};
use crate::plugins::{AddPaths, add_all, add_behaviours, planar_paths, solid_paths};
use crate::scene::load::Loaded;
use crate::source::Source;
use crate::space::{Dimension, Linear, Plane, Solid, Space};
use crate::step::{Clock, Part, Step};
use crate::store::{self, ParticleStore};
use crate::table_sort::sort_newcomers;
use crate::threads::Threads;
use crate::walls::conveyor::Conveyed;
use crate::walls::silo_file::Disc;
use crate::walls::surfaces::{LeavingWalls, Surfaces, WallIndex};
use crate::writers::frame_writer::FrameWriter;

/// A run in progress.
pub struct Simulation {
    app: App,
}

/// Plugins that a caller adds. Boxed, because a generic parameter would compile the whole engine again for each calling
/// crate.
pub(crate) type Additions<'a> = Box<dyn FnOnce(&mut Assembly<'_>) -> Result<(), Fault> + 'a>;

impl Simulation {
    /// Builds the app that the scene needs; no step has run yet.
    ///
    /// # Errors
    /// * A behaviour is unknown, or its keys are wrong.
    /// * Systems of behaviours conflict or are in no phase.
    /// * The environment selects [`instructions`](crate::instructions) that this machine lacks.
    pub fn new(loaded: &Loaded, registry: &Registry, threads: NonZeroUsize) -> Result<Self, Fault> {
        Self::with(loaded, registry, threads, Box::new(|_| Ok(())), None)
    }

    /// Like [`Simulation::new`], with plugins of the calling program: outputs, for example, which read and do not
    /// change physics. (Plugins that change physics are [`Behaviour`]s.)
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn with_plugins(
        loaded: &Loaded,
        registry: &Registry,
        threads: NonZeroUsize,
        more: impl FnOnce(&mut App),
    ) -> Result<Self, Fault> {
        Self::with(
            loaded,
            registry,
            threads,
            Box::new(|assembly| {
                assembly.add_with("the program", more);
                Ok(())
            }),
            None,
        )
    }

    /// Like [`Simulation::with_plugins`], for plugins that record the scene keys that requested them. With `saved` it continues
    /// a saved state.
    pub(crate) fn with(
        loaded: &Loaded,
        registry: &Registry,
        threads: NonZeroUsize,
        more: Additions<'_>,
        saved: Option<(&[Section], UnknownState)>,
    ) -> Result<Self, Fault> {
        let mut app = Self::assemble(loaded, registry, threads, more)?;
        match (saved, loaded.scene.space) {
            (Some((saved, unknown)), _) => restore(app.world_mut(), saved, unknown)?,
            (None, Dimension::Plane) => spawn_particles::<Plane>(app.world_mut(), loaded),
            (None, Dimension::Solid) => spawn_particles::<Solid>(app.world_mut(), loaded),
        }
        Self::complete_with_store(app, loaded)
    }

    /// Returns the whole state, from which [`Simulation::restored`] continues to the same bits. The format is that of this
    /// version of siloflow.
    ///
    /// # Errors
    /// If a value of the state cannot be encoded.
    pub fn save(&mut self) -> Result<Vec<Section>, Problem> {
        self.refresh();
        persist::save(self.app.world_mut())
    }

    /// Builds the app that the scene needs, with the state that [`Simulation::save`] returned for the same scene.
    ///
    /// # Errors
    /// * As [`Simulation::new`].
    /// * The state is that of another scene.
    pub fn restored(
        loaded: &Loaded,
        registry: &Registry,
        threads: NonZeroUsize,
        saved: &[Section],
    ) -> Result<Self, Fault> {
        Self::with(loaded, registry, threads, Box::new(|_| Ok(())), Some((saved, UnknownState::Refuse)))
    }

    /// The cost of a run of the command line.
    pub(crate) fn cost_mut(&mut self) -> Mut<'_, RunCost> {
        self.app.world_mut().resource_mut::<RunCost>()
    }

    /// Like [`Simulation::restored`], for the lattice gas.
    ///
    /// # Errors
    /// As [`Simulation::restored`].
    pub fn restored_lattice(
        loaded: &LoadedLattice,
        registry: &Registry,
        threads: NonZeroUsize,
        saved: &[Section],
    ) -> Result<Self, Fault> {
        Self::of_lattice_with(loaded, registry, threads, Box::new(|_| Ok(())), Some((saved, UnknownState::Refuse)))
    }

    /// Takes checkpoints from now on.
    pub(crate) fn take_checkpoints(&mut self, checkpoints: Checkpoints) {
        self.app.insert_resource(checkpoints);
    }

    /// Returns the state that behaviours write and that no checkpoint would save, as text; `None` if there is none.
    pub(crate) fn unsaved_state(&mut self) -> Option<String> {
        let found = persist::unregistered(self.app.world_mut());
        let words = found.into_iter().map(|(state, system)| match system {
            Some(system) => format!("{state}, written by {system}"),
            None => state,
        });
        let words: Vec<_> = words.collect();
        (!words.is_empty()).then(|| words.join("; "))
    }

    /// Checks whether [`Simulation::new`] would succeed, without spawning a grain.
    pub(crate) fn check(loaded: &Loaded, registry: &Registry) -> Result<(), Fault> {
        let app = Self::assemble(loaded, registry, NonZeroUsize::MIN, Box::new(|_| Ok(())))?;
        Self::complete_with_store(app, loaded).map(|_| ())
    }

    fn complete_with_store(app: App, loaded: &Loaded) -> Result<Self, Fault> {
        match loaded.scene.space {
            Dimension::Plane => Self::complete(app, store::plan::<Plane>),
            Dimension::Solid => Self::complete(app, store::plan::<Solid>),
        }
    }

    /// Returns the app with all plugins, without particles and walls.
    fn assemble(
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

    /// Builds the app of a lattice gas scene; no step has run yet.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn of_lattice(loaded: &LoadedLattice, registry: &Registry, threads: NonZeroUsize) -> Result<Self, Fault> {
        Self::of_lattice_with(loaded, registry, threads, Box::new(|_| Ok(())), None)
    }

    /// Like [`Simulation::of_lattice`], with plugins of the caller.
    pub(crate) fn of_lattice_with(
        loaded: &LoadedLattice,
        registry: &Registry,
        threads: NonZeroUsize,
        more: Additions<'_>,
        saved: Option<(&[Section], UnknownState)>,
    ) -> Result<Self, Fault> {
        let behaviours = registry.of_lattice(loaded)?;
        let mut app = app_with_resources(threads)?;
        let mut assembly = Assembly::new(&mut app);
        lattice::plugins::add_all(&mut assembly, loaded);
        add_behaviours(&mut assembly, behaviours);
        refuse_outputs(assembly.world(), &loaded.source, lattice::series::HEADER)?;
        more(&mut assembly)?;
        assembly.finish();
        if let Some((saved, unknown)) = saved {
            restore(app.world_mut(), saved, unknown)?;
        }
        // There are no particles, so no component mirrors the store.
        Self::complete(app, |_, _| Ok(()))
    }

    /// Completes an app that has all its plugins. `plan` adds the systems that depend on all plugins.
    fn complete(mut app: App, plan: fn(&mut Schedule, &mut World) -> Result<(), Fault>) -> Result<Self, Fault> {
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
                Fault::new("behaviour::schedule", format!("the systems of this scene cannot be ordered: {message}"))
                    .help("order the systems of behaviours with `.after(...)`, `.before(...)` or `.chain()`")
            })
        })?;
        Ok(Self { app })
    }

    /// Runs step zero if it has not run, else one step. Returns the end of the run once there is one; from then on it
    /// does nothing.
    ///
    /// For many steps, [`Simulation::run_steps`] is faster, because this function refreshes all components after each
    /// step.
    pub fn step(&mut self) -> Option<End> {
        let end = self.advance_while(|_| false);
        self.refresh();
        end
    }

    /// Steps until the run ends or `each` returns false. `each` receives the world after every step, with components
    /// that may be out of date.
    fn advance_while(&mut self, mut each: impl FnMut(&mut World) -> bool + Send) -> Option<End> {
        Threads::run(self.app.world_mut(), |world| {
            loop {
                let end = advance(world);
                if !each(world) || end.is_some() {
                    return end;
                }
            }
        })
    }

    /// Ends the run with [`End::Interrupted`] once `flag` holds a number other than zero. The flag is read before each step
    /// after step zero, and that step is then the last one. Signal handlers and other threads may set it.
    pub fn stop_on(&mut self, flag: Arc<AtomicUsize>) {
        self.app.world_mut().resource_mut::<StopRequest>().watch(flag);
    }

    /// Runs step zero, if no step has run yet. Returns the end of the run, if it has ended.
    pub(crate) fn step_zero(&mut self) -> Option<End> {
        if self.world().resource::<Clock>().is_step_zero() {
            return self.advance_while(|_| false);
        }
        self.world().resource::<Outcome>().end().cloned()
    }

    /// Continues to write pictures and lost grains in a directory to which the caller moves the present files.
    ///
    /// # Errors
    /// If a picture could not be written.
    pub(crate) fn continue_in(&mut self, directory: &RunDirectory) -> Result<(), Failure> {
        let world = self.app.world_mut();
        if let Some(mut run) = world.get_resource_mut::<RunPath>() {
            directory.current().clone_into(&mut run.now);
        }
        if let Some(mut losses) = world.get_resource_mut::<LossesFile>() {
            losses.path = directory.losses();
        }
        if let Some(mut frames) = world.get_resource_mut::<FrameDataWriter>() {
            frames.continue_in(directory.current(), directory.guard())?;
        }
        let writer = world.get_resource_mut::<FrameWriter>();
        writer.map_or(Ok(()), |mut writer| writer.continue_in(directory.frames(), directory.guard()))
    }

    /// Steps until the run ends. `each` receives the world after every step, with components that may be out of date.
    pub(crate) fn advance_to_end(&mut self, mut each: impl FnMut(&mut World) + Send) -> End {
        loop {
            let continues = |world: &mut World| {
                each(world);
                true
            };
            if let Some(end) = self.advance_while(continues) {
                return end;
            }
        }
    }

    /// Refreshes all components.
    fn refresh(&mut self) {
        store::refresh_world(self.app.world_mut());
    }

    /// Steps until the run ends.
    pub fn run(&mut self) -> End {
        let end = self.advance_to_end(|_| {});
        self.refresh();
        end
    }

    /// Steps until the clock shows `steps` steps, or the run ends.
    pub fn run_steps(&mut self, steps: u64) -> Option<End> {
        let continues = |world: &World| {
            let clock = world.resource::<Clock>();
            clock.is_step_zero() || clock.steps < steps
        };
        if !continues(self.world()) {
            return self.world().resource::<Outcome>().end().cloned();
        }
        let end = self.advance_while(|world| continues(world));
        self.refresh();
        end
    }

    /// The world of the app.
    #[must_use]
    pub fn world(&self) -> &World {
        self.app.world()
    }

    /// The world of the app, to be changed. Changes between steps count from the next step on.
    pub fn world_mut(&mut self) -> &mut World {
        let world = self.app.world_mut();
        store::publish_to_world(world);
        world
    }
}

/// Refuses outputs of behaviours whose names are not allowed or taken. `header` is the one of `series.csv`.
fn refuse_outputs(world: &World, source: &Source, header: &str) -> Result<(), Fault> {
    let (grains, series) = (TAKEN_NAMES.split_whitespace().collect(), header.split(',').collect());
    let reserved = Reserved { grains, series, is_file: run_directory::is_reserved };
    outputs::refuse(world, &reserved).map_err(|(behaviour, problem)| {
        let key = if behaviour.is_empty() { "behaviours".to_owned() } else { format!("behaviours.{behaviour}") };
        source
            .fault("behaviour::output", &key, problem)
            .help("the `build` of the behaviour registers it: choose another name there")
    })
}

fn restore(world: &mut World, saved: &[Section], unknown: UnknownState) -> Result<(), Fault> {
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

/// Runs step zero if it has not run, else one step. Returns the end of the run once there is one; from then on it does
/// nothing.
fn advance(world: &mut World) -> Option<End> {
    if world.resource::<Outcome>().end().is_none() {
        world.resource_mut::<StopRequest>().read();
        store::collect_from_world(world);
        checkpoint::at_border(world);
        world.run_schedule(Step);
        world.resource_mut::<Clock>().start();
        world.clear_trackers();
        world.check_change_ticks();
    }
    world.resource::<Outcome>().end().cloned()
}

/// Largest number of threads of a run. Many more than there are cores would occupy the machine without doing work.
const MOST_THREADS: usize = 1024;

/// Returns an app with the resources of every run.
fn app_with_resources(threads: NonZeroUsize) -> Result<App, Fault> {
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
        .insert_resource(Instructions::of_environment()?)
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

fn add_plugins<V: Engine>(
    assembly: &mut Assembly,
    loaded: &Loaded,
    behaviours: Vec<(String, Box<dyn Behaviour>)>,
    paths: AddPaths,
) {
    assembly.provide(Gravity(loaded.scene.gravity.get::<V>()));
    let largest = loaded.grain_radii().map_or(0.0, |(_, largest)| largest);
    assembly.provide(Surfaces::new(loaded.surfaces_in_scene::<V>(), largest).with_movers(loaded.movers()));
    assembly.provide(LeavingWalls::default());
    if !loaded.contacts_at_start.is_empty() {
        assembly.provide(ContactsAtStart(loaded.contacts_at_start.clone()));
    }
    assembly.add_with("walls", |app| {
        app.persist_component::<WallIndex>()
            .persist::<LeavingWalls>()
            .persist_part::<Surfaces<V>, _>(|walls| Ok(walls.saved()), |walls, saved| Ok(walls.restore(saved)?));
    });
    add_all::<V>(assembly, loaded, behaviours, paths);
}

fn spawn_particles<V: Space>(world: &mut World, loaded: &Loaded) {
    let mut discs = 0;
    let mut next_id = || {
        discs += 1;
        GrainId::wall(discs)
    };
    let at_rest = V::ZERO;
    let silo = loaded.scene.silo.as_ref().map_or(Species(0), |silo| Species(silo.species));
    // A particle that starts outside a periodic box is replaced by its image inside.
    let periodic = Periodic::<V>::new(&loaded.scene.periodic);
    let in_box = |x: V| periodic.map_or(x, |periodic| periodic.wrapped(x));
    let centre = |disc: &Disc| in_box(V::narrow(disc.centre.spread()));
    for disc in &loaded.silo.wall {
        world.spawn(wall_grain(next_id(), centre(disc), disc.radius, at_rest, silo));
    }
    for disc in &loaded.silo.door {
        world.spawn((wall_grain(next_id(), centre(disc), disc.radius, at_rest, silo), Door(0)));
    }
    for wall in &loaded.scene.walls {
        if let Some((centre, radius, species)) = wall.wall_grain() {
            world.spawn(wall_grain(next_id(), in_box(centre.get::<V>()), radius, at_rest, species));
        }
    }
    for grain in &loaded.fixed {
        let (x, v) = (in_box(V::narrow(grain.position)), V::narrow(grain.velocity));
        let mut spawned = world.spawn(wall_grain(next_id(), x, grain.radius, v, grain.species));
        if v != V::ZERO {
            spawned.insert(Conveyed);
        }
    }
    let doors: Vec<_> = world.resource::<Surfaces<V>>().all.iter().map(|wall| wall.door).collect();
    for (index, door) in doors.into_iter().enumerate() {
        let mut entity = world.spawn(WallIndex(index));
        if let Some(number) = door {
            entity.insert(Door(number));
        }
    }
    world.write_message_batch(loaded.grains.iter().map(|grain| GrainReleased { id: grain.id }));
    let newcomer = |row: &GrainRow| {
        let mut grain = row.bundle::<V>();
        grain.particle.position.0 = in_box(grain.particle.position.0);
        (grain, V::narrow_spin(row.spin))
    };
    let mut newcomers: Vec<_> = loaded.grains.iter().map(newcomer).collect();
    sort_newcomers(&mut newcomers);
    // Spawned in one batch, so that tables are allocated once.
    match world.resource::<ParticleStore<V>>().inertia {
        None => world.spawn_batch(newcomers.into_iter().map(|(grain, _)| grain)).for_each(drop),
        Some(law) => {
            let turning = |grain: &GrainBundle<V>, spin| law.turning::<V>(grain.mass.0, grain.particle.radius.0, spin);
            world
                .spawn_batch(newcomers.into_iter().map(move |(grain, spin)| (turning(&grain, spin), grain)))
                .for_each(drop);
        }
    }
}
