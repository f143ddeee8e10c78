//! Selects the plugins that a lattice-gas scene needs, and makes the rules of the automaton systems of its [stages](LatticeStage).

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use siloflow_lattice::collide::collide;
use siloflow_lattice::friction::stop_at_rough_walls;
use siloflow_lattice::propagate::{ReflectionRule, propagate};
use siloflow_lattice::scatter::place_surplus;
use siloflow_lattice::stop::stop;
use siloflow_lattice::trickle::trickle;

use crate::assembly::Assembly;
use crate::lattice_silo::door::DoorPlugin;
use crate::lattice_silo::ending::{DischargePlugin, EndingPlugin};
use crate::lattice_silo::enter::{PourPlugin, Start, enter};
use crate::lattice_silo::loaded::LoadedLattice;
use crate::lattice_silo::rest::RestPlugin;
use crate::lattice_silo::step::{LatticeStage, LatticeStagesPlugin};
use crate::measure::ObservePlugin;
use siloflow_dem::messages::{CameToRest, DoorOpened};
use siloflow_dem::persist::PersistApp as _;
use siloflow_dem::step::{Clock, Step, StepPlugin};
use siloflow_dem::threads::Threads;
use siloflow_lattice::collisions::Collisions;
use siloflow_lattice::gas::Gas;
use siloflow_lattice::rules::{Odds, Walls};
use siloflow_lattice::sites::Sites;

/// The collision table.
#[derive(Resource)]
struct CollisionTable(&'static Collisions);

/// Adds the plugins and resources that the scene needs, each with the scene key that requests it.
pub(crate) fn add_all(app: &mut Assembly, loaded: &LoadedLattice) {
    let scene = &loaded.scene;
    let sites = &loaded.sites;
    let mut gas = Gas::new(sites);
    enter(&Start { particles: &scene.particles, fill: scene.fill, seed: scene.seed }, sites, &mut gas);
    // Time is counted in steps of the automaton.
    app.add("step", StepPlugin { dt: 1.0 })
        .add("always", LatticeStagesPlugin)
        .add("always", ObservePlugin)
        .add("always", LatticeMessages)
        .add("method", CollisionsPlugin);
    let rules = &loaded.rules;
    if rules.b.get() > 0.0 && rules.walls == Walls::Stop {
        app.add("method.b", FrictionPlugin);
    }
    if rules.h.get() > 0.0 {
        app.add("method.h", TricklePlugin);
    }
    let is_random = rules.b.get() > 0.0 && rules.walls == Walls::Scatter;
    app.add("method", PropagationPlugin(if is_random { ReflectionRule::Random } else { ReflectionRule::Specular }));
    if let Some(pour) = &scene.pour {
        app.add("pour", PourPlugin::new(pour, sites));
    }
    if let Some(rest) = scene.rest {
        app.add("rest", RestPlugin(rest));
    }
    if let Some(door) = scene.door {
        app.add("door", DoorPlugin(door));
    }
    app.add("until", EndingPlugin { until: scene.until, stop_at_rest: scene.rest.is_some_and(|rest| rest.stop) });
    if let Some(steps) = scene.discharge {
        app.add("discharge", DischargePlugin(steps));
    }
    app.provide(Odds::new(rules, scene.seed));
    app.provide(CollisionTable(Collisions::shared()));
    app.provide(sites.clone());
    app.provide(gas);
    app.add_with("always", |app| {
        app.persist_sound_part::<Gas, _>(|gas| Ok(gas.saved()), |gas, saved| Ok(gas.restore(saved)?));
        // The sites follow from the scene and from whether the door is open.
        app.persist_part::<Sites, bool>(
            |sites| Ok(sites.is_open()),
            |sites, is_open| {
                if is_open {
                    sites.open();
                }
                Ok(())
            },
        );
    });
}

struct LatticeMessages;

impl Plugin for LatticeMessages {
    fn build(&self, app: &mut App) {
        app.add_message::<CameToRest>().add_message::<DoorOpened>();
    }
}

/// Plugin for collisions.
struct CollisionsPlugin;

fn stop_some(
    (clock, threads): (Res<Clock>, Res<Threads>),
    (sites, table, odds): (Res<Sites>, Res<CollisionTable>, Res<Odds>),
    mut gas: ResMut<Gas>,
) {
    stop(&sites, &mut gas, &threads, table.0, &odds, clock.steps);
}

fn place_stopped(clock: Res<Clock>, sites: Res<Sites>, odds: Res<Odds>, mut gas: ResMut<Gas>) {
    place_surplus(&sites, &mut gas, &odds, clock.steps);
}

fn collide_movers(
    (clock, threads): (Res<Clock>, Res<Threads>),
    (sites, table, odds): (Res<Sites>, Res<CollisionTable>, Res<Odds>),
    mut gas: ResMut<Gas>,
) {
    collide(&sites, &mut gas, &threads, table.0, &odds, clock.steps);
}

impl Plugin for CollisionsPlugin {
    fn build(&self, app: &mut App) {
        let collisions = (stop_some, place_stopped, collide_movers).chain();
        app.add_systems(Step, collisions.in_set(LatticeStage::Collide));
    }
}

struct FrictionPlugin;

fn stop_at_walls(clock: Res<Clock>, sites: Res<Sites>, odds: Res<Odds>, mut gas: ResMut<Gas>) {
    stop_at_rough_walls(&sites, &mut gas, &odds, clock.steps);
}

impl Plugin for FrictionPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Step, stop_at_walls.in_set(LatticeStage::Rub));
    }
}

struct TricklePlugin;

fn trickle_down(clock: Res<Clock>, sites: Res<Sites>, odds: Res<Odds>, mut gas: ResMut<Gas>) {
    trickle(&sites, &mut gas, &odds, clock.steps);
}

impl Plugin for TricklePlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Step, trickle_down.in_set(LatticeStage::Trickle));
    }
}

struct PropagationPlugin(ReflectionRule);

fn move_on(
    (clock, threads): (Res<Clock>, Res<Threads>),
    (sites, reflection_rule, odds): (Res<Sites>, Res<ReflectionRule>, Res<Odds>),
    mut gas: ResMut<Gas>,
) {
    propagate(&sites, &mut gas, &threads, &odds, *reflection_rule, clock.steps);
}

impl Plugin for PropagationPlugin {
    fn build(&self, app: &mut App) {
        app.insert_resource(self.0).add_systems(Step, move_on.in_set(LatticeStage::Propagate));
    }
}
