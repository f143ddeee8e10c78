//! Which plugins a scene needs: one line a behaviour.
//!
//! Each is added together with the scene key that asks for it, so that `explain` can tell why a system is there.

use std::collections::HashMap;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::SystemKey;

use crate::behaviour::Behaviour;
use crate::columns::ColumnsPlugin;
use crate::contact::assignment::Assignment;
use crate::contact::linear::LinearNormal;
use crate::contact::{Contact, ContactPlugin, PairLaw};
use crate::door::DoorPlugin;
use crate::ending::EndingPlugin;
use crate::energy::{AddedWorkPlugin, EnergyPlugin};
use crate::finite::FinitePlugin;
use crate::grains::spawner::SpawnerPlugin;
use crate::gravity::GravityPlugin;
use crate::integrate::IntegratorPlugin;
use crate::ledger::{CullPlugin, LedgerPlugin, PathsPlugin};
use crate::measure::ObservePlugin;
use crate::measure::bed::BedPlugin;
use crate::messages::MessagesPlugin;
use crate::neighbours::NeighboursPlugin;
use crate::rest::RestPlugin;
use crate::scene::load::Loaded;
use crate::space::Vector;
use crate::step::{Step, StepPlugin};
use crate::walls::outline::Outline;
use crate::walls::surfaces::SurfacesPlugin;

/// Which scene key asked for each system of the schedule [`Step`].
#[derive(Resource, Default)]
pub struct AskedBy(pub HashMap<SystemKey, String>);

/// Adds plugins and notes who asked for their systems.
pub(crate) struct Assembly<'a> {
    app: &'a mut App,
    asked_by: HashMap<SystemKey, String>,
}

impl<'a> Assembly<'a> {
    pub(crate) fn new(app: &'a mut App) -> Self {
        Self { app, asked_by: HashMap::new() }
    }

    pub(crate) fn add(&mut self, key: &str, plugin: impl Plugin) -> &mut Self {
        self.app.add_plugins(plugin);
        self.note(key);
        self
    }

    fn note(&mut self, key: &str) {
        if let Some(schedule) = self.app.get_schedule(Step) {
            for (system, ..) in schedule.graph().systems.iter() {
                self.asked_by.entry(system).or_insert_with(|| key.to_owned());
            }
        }
    }

    pub(crate) fn finish(self) {
        self.app.insert_resource(AskedBy(self.asked_by));
    }
}

/// Adds what the scene asks for to an app that has the resources of a run.
pub(crate) fn add_all(app: &mut Assembly, loaded: &Loaded, behaviours: Vec<(String, Box<dyn Behaviour>)>) {
    let scene = &loaded.scene;
    app.add("step", StepPlugin { dt: scene.step.seconds() })
        .add("always", MessagesPlugin)
        .add("always", ColumnsPlugin)
        .add("always", ObservePlugin)
        .add("neighbours", NeighboursPlugin(loaded.neighbours()))
        .add("integrator", IntegratorPlugin(scene.integrator))
        .add("until", EndingPlugin { until: scene.until.get(), at_rest: scene.rest.is_some_and(|rest| rest.stop) })
        .add("always", FinitePlugin)
        .add("always", EnergyPlugin)
        .add("always", LedgerPlugin(scene.on_loss));
    paths(app, loaded);
    if let Some(line) = scene.cull {
        app.add("cull", CullPlugin(line));
    }
    if !behaviours.is_empty() {
        app.add("behaviours", AddedWorkPlugin);
    }
    match scene.contact {
        _ if behaviours.iter().any(|(_, behaviour)| behaviour.brings_contact_law()) => {}
        Contact::Assignment { k, b } => contacts(app, loaded, Assignment::new(k, b)),
        Contact::Linear { k, damping, attraction } => contacts(app, loaded, LinearNormal::new(k, damping, attraction)),
    }
    if scene.gravity.get() != Vector::ZERO {
        app.add("gravity", GravityPlugin);
    }
    if let (Some(config), Some(mass)) = (scene.spawner.clone(), scene.mass) {
        app.add("spawner", SpawnerPlugin { config, mass, seed: scene.seed, first_id: loaded.first_free_id() });
    }
    if let Some(rest) = scene.rest {
        app.add("rest", RestPlugin(rest));
    }
    if let Some(door) = scene.door {
        app.add("door", DoorPlugin(door));
    }
    if let Some(bed) = scene.bed {
        app.add("bed", BedPlugin(bed));
    }
    for (name, behaviour) in behaviours {
        behaviour.build(app.app);
        app.note(&format!("behaviours.{name}"));
    }
}

/// The law's kernel, and the same law on flat walls if the scene has any.
fn contacts<L: PairLaw>(app: &mut Assembly, loaded: &Loaded, law: L) {
    let law = std::sync::Arc::new(law);
    app.add("contact", ContactPlugin(law.clone()));
    if !loaded.surfaces().is_empty() {
        app.add("walls", SurfacesPlugin(law));
    }
}

/// The watch on paths, asked for by the silo file or else by the scene's walls.
fn paths(app: &mut Assembly, loaded: &Loaded) {
    let smallest_radius = loaded.grain_radii().map_or(0.0, |(smallest, _)| smallest);
    let (walls, surfaces) = (loaded.wall_discs(), loaded.surfaces());
    if walls.is_empty() && surfaces.is_empty() {
        return;
    }
    let outline = Outline::new(&walls, &loaded.silo.door, &surfaces, smallest_radius);
    let key = if loaded.scene.silo.is_some() { "silo" } else { "walls" };
    app.add(key, PathsPlugin { outline, smallest_radius });
}
