//! Selects the plugins that a scene needs, one line per plugin.
//!
//! Each plugin is added together with the scene key that requests it, so that `explain` can print why a system exists.

use std::marker::PhantomData;
use std::sync::Arc;

use bevy_ecs::prelude::*;

use crate::assembly::Assembly;
use crate::behaviour::Behaviour;
use crate::door::{DoorControl, DoorMotion, DoorPlugin, Orifice};
use crate::ending::finite::FinitePlugin;
use crate::ending::regular::EndingPlugin;
use crate::ending::stop::clog::ClogPlugin;
use crate::ending::stop::conditions::{StopCondition, StopPlugin};
use crate::ending::stop::kick::KickPlugin;
use crate::ending::watchdog::WatchdogPlugin;
use crate::energy::{AddedWorkPlugin, EnergyPlugin, LeavingWallsEnergyPlugin, LiftPlugin, SpinEnergyPlugin};
use crate::grain_requests::RequestsPlugin;
use crate::grains::feed::FeedPlugin;
use crate::grains::free_id::FreeId;
use crate::grains::spawner::SpawnerPlugin;
use crate::ledger::{CullPlugin, LedgerPlugin, PathsPlugin};
use crate::measure::ObservePlugin;
use crate::measure::bed::BedPlugin;
use crate::measure::outputs::BehaviourOutputs;
use crate::rest::RestPlugin;
use crate::scene::check::Estimates;
use crate::scene::loaded::Loaded;
use siloflow_dem::contact::centred::velocity_prediction::VelocityPredictionPlugin;
use siloflow_dem::contact::history::History;
use siloflow_dem::engine::Engine;
use siloflow_dem::integrate::IntegratorPlugin;
use siloflow_dem::integrate::rigid::BodiesPlugin;
use siloflow_dem::integrate::rotation::SpinPlugin;
use siloflow_dem::integrate::wrap::PeriodicPlugin;
use siloflow_dem::messages::MessagesPlugin;
use siloflow_dem::neighbours::NeighboursPlugin;
use siloflow_dem::periodic::Periodic;
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::space::{Solid, Space};
use siloflow_dem::step::{ForceStage, Step, StepPlugin};
use siloflow_dem::store::{StorePlugin, clear_forces};
use siloflow_dem::table_sort::TableSortPlugin;
use siloflow_dem::walls::config::Wall;
use siloflow_dem::walls::conveyor::ConveyorPlugin;
use siloflow_dem::walls::enclosure::Enclosure;
use siloflow_dem::walls::free::plugin::FreeWallsPlugin;
use siloflow_dem::walls::leaving::LeavingWallsPlugin;
use siloflow_dem::walls::moving::MovingWallsPlugin;
use siloflow_dem::walls::paths::SolidEnclosure;
use siloflow_dem::walls::surfaces::Surfaces;

/// Adds the end by a clog. If several are asked for, the first to hold is the one of the shortest time.
fn add_end_by_clog<V: Space>(app: &mut Assembly, loaded: &Loaded, conditions: &[StopCondition], space: PhantomData<V>) {
    let clogs = conditions.iter().filter_map(|condition| match condition {
        StopCondition::Clogged { still } => Some(still.get()),
        _ => None,
    });
    if let Some(still) = clogs.reduce(f64::min) {
        app.add("stop", ClogPlugin { still, boxes: loaded.outlets(), space });
    }
}

/// Adds the plugins that the scene needs to an app that has the resources of a run.
pub(crate) fn add_all<V: Engine>(
    app: &mut Assembly,
    loaded: &Loaded,
    behaviours: Vec<(String, Box<dyn Behaviour>)>,
    paths: AddPaths,
) {
    let scene = &loaded.scene;
    let space = PhantomData::<V>;
    let periodic = Periodic::<V>::new(&scene.periodic);
    let largest_radius = loaded.grain_radii().map_or(0.0, |(_, largest)| largest);
    let own_contacts = behaviours.iter().any(|(_, behaviour)| behaviour.brings_contact_law());
    let has_behaviours = !behaviours.is_empty();
    let neighbours =
        NeighboursPlugin { kind: loaded.neighbours(), periodic, largest_radius, range: loaded.adhesive_range() };
    let integrator = IntegratorPlugin { kind: scene.integrator, space };
    app.add("step", StepPlugin { dt: loaded.step() })
        .add("always", MessagesPlugin(space))
        .add_with("always", |app| V::add_store(app, StorePlugin(space)))
        .add("always", TableSortPlugin)
        .add("always", ObservePlugin)
        .add_with("neighbours", |app| V::add_neighbours(app, neighbours))
        .add_with("integrator", |app| V::add_integrator(app, integrator))
        .add("until", EndingPlugin { until: scene.until.get() })
        .add("always", FinitePlugin(space))
        .add("always", LedgerPlugin(scene.on_loss, space));
    let conditions = scene.stop_conditions();
    add_end_by_clog(app, loaded, &conditions, space);
    if let Some(kick) = scene.kick {
        app.add("kick", KickPlugin { kick, boxes: loaded.outlets(), space });
    }
    if !conditions.is_empty() {
        app.add(if scene.stop.is_empty() { "rest.stop" } else { "stop" }, StopPlugin(conditions));
    }
    if scene.energy_balance {
        app.add("energy_balance", EnergyPlugin { every: scene.energy_balance_every, space });
    }
    if let Some(mut watchdog) = scene.watchdog {
        // Without the energy balance the expected energy is unknown.
        watchdog.energy = watchdog.energy.filter(|_| scene.energy_balance);
        app.add("watchdog", WatchdogPlugin(watchdog, space));
    }
    if let Some(periodic) = periodic {
        let plugin = PeriodicPlugin { periodic, tracks_energy: scene.energy_balance };
        app.add_with("periodic", |app| V::add_periodic(app, plugin));
        if scene.energy_balance && periodic.lifts(scene.gravity.get()) {
            app.add("periodic", LiftPlugin(space));
        }
    }
    paths(app, loaded);
    if let Some(line) = scene.cull {
        app.add("cull", CullPlugin(line, space));
    }
    if scene.energy_balance && (has_behaviours || scene.kick.is_some()) {
        app.add(if has_behaviours { "behaviours" } else { "kick" }, AddedWorkPlugin(space));
    }
    add_rotation::<V>(app, loaded);
    if !own_contacts {
        if loaded.is_centred() {
            let (damping_rates, springs_exact) = Estimates::of(loaded)
                .map_or(([0.0; 2], scene.contact.spins()), |e| (e.damping_rates, e.has_exact_springs()));
            let prediction = VelocityPredictionPlugin { damping_rates, springs_exact, space };
            app.add_with("integrator", |app| V::add_velocity_prediction(app, prediction));
        }
        app.add_with("contact", |app| V::add_contacts(app, &loaded.contacts()));
    }
    if loaded.fixed.iter().any(|grain| grain.velocity != Solid::ZERO) {
        app.add("fill", ConveyorPlugin(space));
    }
    if let (Some(config), Some(mass)) = (scene.spawner.clone(), scene.mass) {
        let first_id = loaded.first_free_id();
        app.add("spawner", SpawnerPlugin { config, mass, seed: scene.seed, first_id, space });
    }
    if has_behaviours || !scene.feed.is_empty() {
        let of_spawner = scene.spawner.as_ref().map_or(0, |spawner| spawner.count);
        app.provide(FreeId(loaded.first_free_id().saturating_add(of_spawner)));
        app.add_with(if has_behaviours { "behaviours" } else { "feed" }, |app| {
            app.persist::<FreeId>();
        });
    }
    if let Some(mass) = scene.mass.filter(|_| !scene.feed.is_empty()) {
        let inertia = loaded.grains_spin().then(|| loaded.inertia());
        app.add("feed", FeedPlugin { feeds: scene.feed.clone(), mass, inertia, seed: scene.seed, space });
    }
    if has_behaviours {
        app.add("behaviours", RequestsPlugin { mass: scene.mass, space });
    }
    if let Some(rest) = scene.rest {
        app.add("rest", RestPlugin(rest, space));
    }
    add_doors_and_motions::<V>(app, loaded, has_behaviours);
    if let Some(bed) = scene.bed {
        app.add("bed", BedPlugin(bed));
    }
    add_behaviours(app, behaviours);
    app.add_with("behaviours", |app| {
        // A behaviour that replaces the contact law may add a force of its own without contacts.
        if own_contacts && !app.world().contains_resource::<History>() {
            app.add_systems(Step, clear_forces::<V>.in_set(ForceStage::Contacts));
        }
    });
    app.add_with("contact.tangential", |app| {
        // A behaviour's law may rotate grains even if the scene's own law does not.
        if scene.energy_balance
            && app.is_plugin_added::<SpinPlugin<V>>()
            && !app.is_plugin_added::<SpinEnergyPlugin<V>>()
        {
            app.add_plugins(SpinEnergyPlugin(space));
        }
    });
}

/// Adds the rotation of grains, and their shapes.
fn add_rotation<V: Engine>(app: &mut Assembly, loaded: &Loaded) {
    let scene = &loaded.scene;
    let space = PhantomData::<V>;
    if loaded.grains_spin() {
        let spins = SpinPlugin { inertia: loaded.inertia(), space };
        app.add_with("contact.tangential", |app| V::add_spins(app, spins));
        if scene.energy_balance {
            app.add("contact.tangential", SpinEnergyPlugin(space));
        }
    }
    if !loaded.shapes.is_empty() {
        let bodies = BodiesPlugin { shapes: loaded.shapes.rigid::<V>() };
        app.add_with("shapes", |app| V::add_bodies(app, bodies));
    }
}

/// Adds what opens doors, moves walls and removes them.
fn add_doors_and_motions<V: Space>(app: &mut Assembly, loaded: &Loaded, has_behaviours: bool) {
    let scene = &loaded.scene;
    let space = PhantomData::<V>;
    let doors = scene.door_controls();
    if let Some((_, key, _)) = doors.first() {
        let controls = doors.iter().map(|(number, _, control)| (*number, control.clone())).collect();
        app.add(key.trim_end_matches("[0]"), DoorPlugin::<V>(controls, space));
    }
    let moves = |(_, _, control): &(u16, String, DoorControl)| matches!(control.how, DoorMotion::Move { .. });
    if !scene.free_walls.is_empty() {
        app.add("free_walls", FreeWallsPlugin(space));
    }
    if !scene.motions.is_empty() || !scene.free_walls.is_empty() || doors.iter().any(moves) {
        let key = if !scene.motions.is_empty() {
            "motions"
        } else if !scene.free_walls.is_empty() {
            "free_walls"
        } else if scene.doors.is_empty() {
            "door"
        } else {
            "doors"
        };
        app.add(key, MovingWallsPlugin { is_predicted: loaded.is_centred(), space });
    }
    let has_surfaces = scene.walls.iter().any(Wall::is_surface);
    if has_surfaces && (has_behaviours || loaded.has_door_surface()) {
        app.add("walls", LeavingWallsPlugin(space));
        if scene.energy_balance {
            app.add("walls", LeavingWallsEnergyPlugin(space));
        }
    }
}

/// Adds the behaviours of a scene, in the order of their names.
pub(crate) fn add_behaviours(app: &mut Assembly, behaviours: Vec<(String, Box<dyn Behaviour>)>) {
    for (name, behaviour) in behaviours {
        app.add_with(&format!("behaviours.{name}"), |app| BehaviourOutputs::begin(app, &name));
        app.add_with(&format!("behaviours.{name}"), |app| behaviour.build(app));
    }
}

/// Function that [`add_all`] calls to add the path check, the only part that differs between plane and solid space.
pub(crate) type AddPaths = fn(&mut Assembly, &Loaded);

/// Adds the check of grain paths in the plane. The key is the silo file, or else the scene's walls.
pub(crate) fn planar_paths(app: &mut Assembly, loaded: &Loaded) {
    let smallest_radius = loaded.grain_radii().map_or(0.0, |(smallest, _)| smallest);
    let walls = loaded.wall_discs();
    let surfaces = loaded.still_surfaces();
    if walls.is_empty() && !loaded.scene.walls.iter().any(Wall::is_surface) {
        return;
    }
    let outline = Enclosure::new(&walls, &loaded.silo.door, &surfaces, smallest_radius);
    let walls_stay = loaded.scene.motions.is_empty() && loaded.scene.free_walls.is_empty();
    let is_bounded = loaded.scene.periodic.is_open() && walls_stay;
    let outline = if is_bounded { outline } else { outline.unbounded() };
    if let Some(orifice) = outline.orifice() {
        app.provide(Orifice(orifice));
    }
    let key = if loaded.scene.silo.is_some() { "silo" } else { "walls" };
    app.add(key, PathsPlugin { paths: Arc::new(outline), smallest_radius });
}

/// Adds the check of grain paths in solid space.
pub(crate) fn solid_paths(app: &mut Assembly, loaded: &Loaded) {
    let smallest_radius = loaded.grain_radii().map_or(0.0, |(smallest, _)| smallest);
    let walls = loaded.still_surfaces_and_images();
    if loaded.scene.walls.iter().any(Wall::is_surface) {
        app.add(
            "walls",
            PathsPlugin { paths: Arc::new(SolidEnclosure(Surfaces::new(walls, smallest_radius))), smallest_radius },
        );
    }
}
