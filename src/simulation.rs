//! A simulation: an app built from a scene (`build`, `particles`), and the loop that steps it (`stepping`). [`evaluate`] is a whole run as
//! one function call. Between two steps a caller may give grains other numbers ([`assign`]), push them ([`push`]), and save the state in a file
//! (`state_file`).

pub mod assign;
mod build;
pub mod evaluate;
mod particles;
pub mod push;
mod state_file;
mod stepping;

use std::num::NonZeroUsize;

use bevy_app::App;
use bevy_ecs::prelude::*;

pub(crate) use self::build::MOST_THREADS;
use self::build::{app_with_resources, refuse_outputs, restore};
use self::particles::spawn_particles;
use crate::assembly::Assembly;
#[cfg(doc)]
use crate::behaviour::Behaviour;
use crate::behaviour::Registry;
use crate::lattice_silo;
use crate::lattice_silo::loaded::LoadedLattice;
use crate::output::checkpoint::Checkpoints;
use crate::output::cost::RunCost;
use crate::output::frame_recording::writer::FrameWriter;
use crate::output::losses::LossesFile;
use crate::plugins::add_behaviours;
use crate::scene::loaded::Loaded;
use crate::writers::picture_writer::PictureWriter;
use crate::writers::run_path::RunPath;
use siloflow_dem::outcome::Failure;
use siloflow_dem::persist::{self, Problem, Section, UnknownState, Unregistered};
use siloflow_dem::space::{Dimension, Plane, Solid, Space};
use siloflow_dem::store;
use siloflow_files::run_directory::RunDirectory;
use siloflow_text::fault::Fault;

/// A run in progress. It may pass from thread to thread.
pub struct Simulation {
    world: World,
}

/// Plugins that a caller adds. Boxed, because a generic parameter would compile the whole engine again for each calling
/// crate.
pub(crate) type Additions<'a> = Box<dyn FnOnce(&mut Assembly<'_>) -> Result<(), Fault> + 'a>;

/// Returns the plugins of the calling program as additions.
fn plugins_of_program<'a>(more: impl FnOnce(&mut App) + 'a) -> Additions<'a> {
    Box::new(|assembly| {
        assembly.add_with("the program", more);
        Ok(())
    })
}

/// The code that steps a simulation and gets its world between two steps.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Caller {
    /// Code outside siloflow, which may use every component.
    Outside,
    /// The command line, which uses neither forces nor torques as components.
    CommandLine,
}

/// Spawns the particles of the start.
fn spawn<V: Space>(world: &mut World, loaded: &Loaded, caller: Caller) {
    let has_loads = caller == Caller::Outside || store::uses_loads::<V>(world);
    spawn_particles::<V>(world, loaded, has_loads);
}

impl Simulation {
    /// Builds the app that the scene needs; no step has run yet.
    ///
    /// # Errors
    /// * A behaviour is unknown, or its keys are wrong.
    /// * Systems of behaviours conflict or are in no phase.
    /// * The environment selects [`instructions`](siloflow_dem::instruction_set) that this machine lacks.
    pub fn new(loaded: &Loaded, registry: &Registry, threads: NonZeroUsize) -> Result<Self, Fault> {
        Self::with(loaded, registry, threads, Caller::Outside, Box::new(|_| Ok(())), None)
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
        Self::with(loaded, registry, threads, Caller::Outside, plugins_of_program(more), None)
    }

    /// Like [`Simulation::with_plugins`], for plugins that record the scene keys that requested them. With `saved` it continues
    /// a saved state.
    pub(crate) fn with(
        loaded: &Loaded,
        registry: &Registry,
        threads: NonZeroUsize,
        caller: Caller,
        more: Additions<'_>,
        saved: Option<(&[Section], UnknownState)>,
    ) -> Result<Self, Fault> {
        let mut app = Self::assemble(loaded, registry, threads, more)?;
        match (saved, loaded.scene.space) {
            (Some((saved, unknown)), _) => restore(app.world_mut(), saved, unknown)?,
            (None, Dimension::Plane) => spawn::<Plane>(app.world_mut(), loaded, caller),
            (None, Dimension::Solid) => spawn::<Solid>(app.world_mut(), loaded, caller),
        }
        Self::complete_with_store(app, loaded)
    }

    /// Returns the whole state, from which [`Simulation::restored`] continues to the same bits. The format is that of this
    /// version of siloflow.
    ///
    /// # Errors
    /// If a value of the state cannot be encoded.
    pub fn save(&mut self) -> Result<Vec<Section>, Problem> {
        persist::save(self.own_world())
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
        let saved = Some((saved, UnknownState::Refuse));
        Self::with(loaded, registry, threads, Caller::Outside, Box::new(|_| Ok(())), saved)
    }

    /// The cost of a run of the command line.
    pub(crate) fn cost_mut(&mut self) -> Mut<'_, RunCost> {
        self.world.resource_mut::<RunCost>()
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
        self.world.insert_resource(checkpoints);
    }

    /// Returns the state that behaviours write and that no checkpoint would save, as text, with the call that saves it; `None` if there is none.
    pub(crate) fn unsaved_state(&mut self) -> Option<String> {
        let found = persist::unregistered(&mut self.world);
        let words = found.into_iter().map(|(state, Unregistered { writer, is_resource })| {
            let writer = writer.map_or(String::new(), |system| format!(", written by {system}"));
            let call = if is_resource { "persist" } else { "persist_component" };
            let name = state.rsplit("::").next().unwrap_or(&state);
            format!("{state}{writer} (`app.{call}::<{name}>()` saves it)")
        });
        let words: Vec<_> = words.collect();
        (!words.is_empty()).then(|| words.join("; "))
    }

    /// Checks whether [`Simulation::new`] would succeed, without spawning a grain.
    pub(crate) fn check(loaded: &Loaded, registry: &Registry) -> Result<(), Fault> {
        let app = Self::assemble(loaded, registry, NonZeroUsize::MIN, Box::new(|_| Ok(())))?;
        Self::complete_with_store(app, loaded).map(|_| ())
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
        lattice_silo::plugins::add_all(&mut assembly, loaded);
        add_behaviours(&mut assembly, behaviours);
        refuse_outputs(assembly.world(), &loaded.source, &lattice_silo::series::header())?;
        more(&mut assembly)?;
        assembly.finish();
        if let Some((saved, unknown)) = saved {
            restore(app.world_mut(), saved, unknown)?;
        }
        // There are no particles, so no component mirrors the store.
        Self::complete(app, |_, _| Ok(()))
    }

    /// Continues to write pictures and lost grains in a directory to which the caller moves the present files.
    ///
    /// # Errors
    /// If a picture could not be written.
    pub(crate) fn continue_in(&mut self, directory: &RunDirectory) -> Result<(), Failure> {
        let world = &mut self.world;
        if let Some(mut run) = world.get_resource_mut::<RunPath>() {
            directory.current().clone_into(&mut run.now);
        }
        if let Some(mut losses) = world.get_resource_mut::<LossesFile>() {
            losses.place = directory.losses();
        }
        if let Some(mut frames) = world.get_resource_mut::<FrameWriter>() {
            frames.continue_in(directory.current(), directory.guard())?;
        }
        let writer = world.get_resource_mut::<PictureWriter>();
        writer.map_or(Ok(()), |mut writer| writer.continue_in(directory.frames(), directory.guard()))
    }

    /// The world of the app.
    #[must_use]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The world of the app, for siloflow's own code: components are refreshed, and particles have forces and torques as components only
    /// where a system uses them.
    pub(crate) fn own_world(&mut self) -> &mut World {
        let world = &mut self.world;
        store::refresh_world(world);
        world
    }

    /// The world of the app, to be changed. Changes between steps count from the next step on.
    pub fn world_mut(&mut self) -> &mut World {
        let world = &mut self.world;
        store::publish_to_world(world);
        world
    }
}
