//! A simulation: an app built from a scene, and the loop that steps it.

use std::num::NonZeroUsize;

use bevy_app::App;
use bevy_ecs::message::message_update_system;
use bevy_ecs::prelude::*;

use crate::behaviour::Registry;
use crate::fault::Fault;
use crate::grains::file::GrainRow;
use crate::grains::spawner::Pending;
use crate::gravity::Gravity;
use crate::messages::GrainReleased;
use crate::outcome::{End, Outcome};
use crate::particle::{Door, GrainId, wall_grain};
use crate::plugins::{Assembly, add_all};
use crate::scene::load::Loaded;
use crate::step::{Clock, Phase, Step};
use crate::threads::Threads;
use crate::walls::surfaces::Surfaces;

/// A run in progress.
pub struct Simulation {
    app: App,
}

impl Simulation {
    /// Builds the app that the scene asks for; nothing has run yet.
    ///
    /// # Errors
    /// If a behaviour is unknown or its keys are wrong, or systems of behaviours conflict.
    pub fn new(loaded: &Loaded, registry: &Registry, threads: NonZeroUsize) -> Result<Self, Fault> {
        Self::with(loaded, registry, threads, |_| {})
    }

    /// The same, with plugins of the caller's on top.
    pub(crate) fn with(
        loaded: &Loaded,
        registry: &Registry,
        threads: NonZeroUsize,
        more: impl FnOnce(&mut Assembly<'_>),
    ) -> Result<Self, Fault> {
        let behaviours = registry.of_scene(loaded)?;
        let threads = Threads::new(threads).map_err(|error| {
            Fault::new("call::threads", format!("could not start the threads: {error}"))
                .help("ask for fewer with --threads")
        })?;
        let mut app = App::empty();
        app.insert_resource(threads)
            .insert_resource(Gravity(loaded.scene.gravity.get()))
            .insert_resource(Surfaces(loaded.surfaces()))
            .init_resource::<Outcome>()
            .init_resource::<Pending>()
            // Several systems may end a run; whichever says so first in the step's fixed order is heard.
            .allow_ambiguous_resource::<Outcome>();
        let mut assembly = Assembly::new(&mut app);
        add_all(&mut assembly, loaded, behaviours);
        more(&mut assembly);
        assembly.finish();
        app.add_systems(Step, message_update_system.after(Phase::Observe));
        populate(app.world_mut(), loaded);
        let mut simulation = Self { app };
        simulation.initialize_schedule()?;
        Ok(simulation)
    }

    /// Builds the schedule now, so that conflicting systems are an error of the input and not a panic later.
    fn initialize_schedule(&mut self) -> Result<(), Fault> {
        self.app.world_mut().schedule_scope(Step, |world, schedule| {
            schedule.initialize(world).map(|_| ()).map_err(|error| {
                let message = error.to_string(schedule.graph(), world);
                Fault::new("behaviour::schedule", format!("the systems of this scene cannot be ordered: {message}"))
                    .help("order the systems of behaviours with `.after(...)`, `.before(...)` or `.chain()`")
            })
        })
    }

    /// Runs step zero if it has not run, else one step. Returns the end once there is one, and then does nothing.
    pub fn step(&mut self) -> Option<End> {
        let world = self.app.world_mut();
        if world.resource::<Outcome>().end().is_none() {
            world.run_schedule(Step);
            world.resource_mut::<Clock>().start();
            world.clear_trackers();
            world.check_change_ticks();
        }
        world.resource::<Outcome>().end().cloned()
    }

    /// Steps to the end.
    pub fn run(&mut self) -> End {
        loop {
            if let Some(end) = self.step() {
                return end;
            }
        }
    }

    /// Steps until the clock shows `steps` steps, or to the end.
    pub fn run_steps(&mut self, steps: u64) -> Option<End> {
        loop {
            let clock = self.world().resource::<Clock>();
            if !clock.is_step_zero() && clock.steps >= steps {
                return self.world().resource::<Outcome>().end().cloned();
            }
            if let Some(end) = self.step() {
                return Some(end);
            }
        }
    }

    /// Everything there is.
    #[must_use]
    pub fn world(&self) -> &World {
        self.app.world()
    }

    /// Everything there is, to be changed; what is changed between steps counts from the next step on.
    pub fn world_mut(&mut self) -> &mut World {
        self.app.world_mut()
    }
}

fn populate(world: &mut World, loaded: &Loaded) {
    let mut discs = 0;
    let mut next_id = || {
        discs += 1;
        GrainId::wall(discs)
    };
    for disc in &loaded.silo.wall {
        world.spawn(wall_grain(next_id(), disc.centre, disc.radius));
    }
    for disc in &loaded.silo.door {
        world.spawn((wall_grain(next_id(), disc.centre, disc.radius), Door));
    }
    for disc in &loaded.wall_discs()[loaded.silo.wall.len()..] {
        world.spawn(wall_grain(next_id(), disc.centre, disc.radius));
    }
    world.spawn_batch(loaded.grains.iter().map(GrainRow::bundle).collect::<Vec<_>>());
    for grain in &loaded.grains {
        world.write_message(GrainReleased { id: grain.id });
    }
}
