//! The energy balance: kinetic (of rotation too) + gravitational + elastic
//! = released + work of moving walls + lifted by periodic sides + work of added forces - dissipated - removed + error, in J.
//!
//! *Released* is what grains bring with them, *removed* what goes with whatever leaves the world: culled grains with
//! their contacts, the elastic energy held by a removed door. *Dissipated* is the work of the drag forces. Work is
//! the time integral of power by the trapezoidal rule, with the force as it acts and the full-step velocity:
//!
//! In velocity Verlet m (v(t+dt/2)^2 - v(t-dt/2)^2)/2 = dt F(t).v(t) exactly, so dt F_d(t).v(t) is just what the drag
//! takes from the scheme's own kinetic energy, and the balance is second order in dt although the drag force itself
//! is evaluated at a velocity half a step old. What remains (`balance_error`) is the error of the elastic and
//! gravitational part, plus k v^2 dt^2 or so for each contact that opens or closes within a step.
//!
//! Where grains spin, [`SpinEnergyPlugin`] books what friction takes: the work of the tangential and the
//! rolling dashpots in the same way, and what sliding and rolling beyond their caps take out of the springs as
//! [`crate::contact::spring`] says. How it divides into [`Channels`] is told contact by contact: there the work of tangential
//! dashpots is force times sliding velocity times dt, with the velocity that the force was evaluated with. It differs from what
//! the whole counts by an error of the scheme's own order: c v^2 dt/4 or so for each contact of plain velocity Verlet.
//!
//! Sums run over the columns, so in ascending order of slots (those of the drag stride by stride), each component for itself.
//! A scene with `energy_books: false` has none of this: no plugin of this file, no resource, and no room in the columns.
//!
//! Limit: a grain that a behaviour fixes or frees takes its
//! kinetic energy out of or into the balance, which then shows as error; so does the work of one that is fixed and spins.

use std::marker::PhantomData;
use std::ops::Add;

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::Serialize;

use crate::columns::{
    self, BOOKED, BeforeRenumbering, Body, Columns, Entering, Renumbering, Rotation, STRIDE, Settled, Slot, Turnover,
    after_kicks, looks_when,
};
use crate::contact::Memory;
use crate::contact::history::History;
use crate::contact::survey::{Partner, Scenery};
use crate::gravity::Gravity;
use crate::messages::DoorOpened;
use crate::particle::{Force, Grain, GrainBundle, GrainId, Mass, Position, Velocity};
use crate::space::{Linear, Space};
use crate::spin::{Inertia, Spin};
use crate::step::{Clock, Phase, Step, is_step_zero};
use crate::walls::surfaces::Surfaces;

/// The flows of energy so far, J; a resource where books are kept.
#[derive(Resource, Clone, Copy, Debug, Default, Serialize)]
pub struct EnergyFlows {
    /// Brought in by grains that entered.
    pub released: f64,
    /// Done on grains by fixed particles and belts that move.
    pub wall_work: f64,
    /// Potential energy of grains that a periodic side has set back along gravity.
    pub lifted: f64,
    /// Done on grains by forces that behaviours added.
    pub added_work: f64,
    /// Taken by the drag of contacts.
    pub dissipated: f64,
    /// Gone with what left the world.
    pub removed: f64,
}

impl EnergyFlows {
    /// What the energy of the system should be now, J.
    #[must_use]
    pub fn expected(&self) -> f64 {
        self.released + self.wall_work + self.lifted + self.added_work - self.dissipated - self.removed
    }
}

/// Powers at the end of the last step, W.
#[derive(Resource, Clone, Copy, Debug, Default)]
struct Powers {
    wall: f64,
    added: f64,
    dissipation: f64,
}

/// What of `dissipated` went otherwise than by the damping of normal forces, in scenes with spin, J.
#[derive(Resource, Clone, Copy, Debug, Default, Serialize)]
pub struct Channels {
    /// By friction: tangential dashpots, and sliding.
    pub tangential: f64,
    /// By rolling resistance.
    pub rolling: f64,
}

/// Powers of dashpots' torques, tangential and rolling, at the end of the last step, W.
#[derive(Resource, Clone, Copy, Debug, Default)]
struct TurningPowers {
    turning: f64,
    rolling: f64,
}

fn mechanical<V: Space>(mass: f64, x: V, v: V, gravity: V) -> f64 {
    0.5 * mass * v.length_squared() - mass * gravity.dot(x)
}

/// Everything whose entity is gone takes its energy with it. The columns still hold the state it had.
fn book_removed<V: Space>(
    (columns, turnover): (Res<Columns<V>>, Res<Turnover<V>>),
    scenery: Scenery<V>,
    gravity: Res<Gravity<V>>,
    present: Query<(), With<GrainId>>,
    mut flows: ResMut<EnergyFlows>,
) {
    let is_gone = |i| turnover.is_leaving(i) || !columns.is_somebody(i, |entity| present.contains(entity));
    let gone: Vec<_> = (0..columns.len()).map(is_gone).collect();
    if !gone.contains(&true) {
        return;
    }
    for i in (0..columns.movable_end).filter(|&i| gone[i] && !columns.is_fixed(i)) {
        flows.removed += mechanical(columns.mass[i], columns.body[i].position, columns.body[i].velocity, gravity.0);
        flows.removed += columns.rotational_energy(i);
    }
    flows.removed +=
        scenery.survey().elastic_energy(|i, partner| gone[i] || matches!(partner, Partner::Particle(j) if gone[j]));
}

type Energetic<V> = (
    &'static Slot,
    &'static GrainId,
    &'static Position<V>,
    &'static Velocity<V>,
    &'static Mass,
    Option<(&'static Spin<<V as Space>::Spin>, &'static Inertia)>,
);

fn book_released<V: Space>(
    (columns, turnover, gravity): (Res<Columns<V>>, Res<Turnover<V>>, Res<Gravity<V>>),
    entities: Query<Energetic<V>, With<Grain>>,
    mut flows: ResMut<EnergyFlows>,
) {
    let energies = |id, x: V, v: V, mass: Mass, turning: Option<(V::Spin, f64)>| {
        let rotation = turning.map_or(0.0, |(spin, inertia)| 0.5 * inertia * spin.length_squared());
        (id, mechanical(mass.0, x, v, gravity.0), rotation)
    };
    let bare = turnover.entering.iter().map(|new| {
        let GrainBundle { particle, mass, .. } = &new.grain;
        let turning = columns.inertia.map(|law| new.turning(law)).map(|(spin, _, inertia)| (spin.0, inertia.0));
        energies(particle.id, particle.position.0, particle.velocity.0, *mass, turning)
    });
    // Whose mass the columns do not know yet.
    let is_new = |slot: &Slot| columns.mass.get(slot.index()).is_none_or(|&mass| mass <= 0.0);
    let entities = entities.iter().filter(|(slot, ..)| is_new(slot)).map(|(_, id, x, v, mass, turning)| {
        energies(*id, x.0, v.0, *mass, turning.map(|(spin, inertia)| (spin.0, inertia.0)))
    });
    let mut new: Vec<_> = bare.chain(entities).collect();
    new.sort_unstable_by_key(|&(id, ..)| id);
    for (_, mechanical, rotation) in new {
        flows.released += mechanical;
        flows.released += rotation;
    }
}

/// Grains that start in contact bring the elastic energy of their overlap too; their other springs start relaxed.
fn book_initial_overlaps<V: Space>(scenery: Scenery<V>, mut flows: ResMut<EnergyFlows>) {
    let survey = scenery.survey();
    survey.contacts(|_, _, pair, _| flows.released += survey.law.elastic_energy(pair, &Memory::default()));
}

/// A door of panels that is about to go takes its elastic energy with it.
fn book_panel_door<V: Space>(
    mut opened: MessageReader<DoorOpened>,
    (scenery, turnover): (Scenery<V>, Res<Turnover<V>>),
    present: Query<(), With<GrainId>>,
    mut flows: ResMut<EnergyFlows>,
) {
    if opened.read().next().is_some() {
        let survey = scenery.survey();
        // What was culled meanwhile takes its contacts with it already.
        flows.removed += survey.elastic_energy(|i, partner| {
            let is_door = matches!(partner, Partner::Wall(wall) if survey.walls[wall].is_door);
            is_door && !turnover.is_leaving(i) && survey.columns.is_somebody(i, |entity| present.contains(entity))
        });
    }
}

/// The sum of scalar products, given by component: in ascending order of slots, each component for itself.
fn sum<T: Linear>(products: impl Iterator<Item = T>) -> f64 {
    products.fold(T::ZERO, Add::add).sum_of_components()
}

fn book_contact_work<V: Space>(
    clock: Res<Clock>,
    columns: Res<Columns<V>>,
    walls: Res<Surfaces<V>>,
    mut flows: ResMut<EnergyFlows>,
    mut last: ResMut<Powers>,
) {
    let power = |forces: &[[V; BOOKED]], bodies: &[Body<V>]| {
        let powers = forces.iter().zip(bodies).map(|([_, drag], body)| drag.times(body.velocity));
        powers.fold(V::ZERO, Add::add)
    };
    let (force, on_fixed) = columns.loads.force.entries().split_at(columns.movable_end);
    let (body, fixed) = columns.body.split_at(columns.movable_end);
    // As the kick sums them, if it does.
    let by_strides = || force.chunks(STRIDE).zip(body.chunks(STRIDE)).map(|(force, body)| power(force, body));
    let of_grains = columns.kick_sum.unwrap_or_else(|| by_strides().fold(V::ZERO, Add::add));
    let (mut dissipation, mut wall) = (-of_grains.sum_of_components(), 0.0);
    // Most of what is fixed stands still.
    for ([force, drag], body) in on_fixed.iter().zip(fixed).filter(|(_, body)| body.velocity != V::ZERO) {
        dissipation -= drag.dot(body.velocity);
        wall -= force.dot(body.velocity);
    }
    for belt in &walls.0 {
        dissipation -= belt.load.drag.dot(belt.velocity);
        wall -= belt.load.force.dot(belt.velocity);
    }
    if !clock.is_step_zero() {
        flows.dissipated += 0.5 * clock.dt * (last.dissipation + dissipation);
        flows.wall_work += 0.5 * clock.dt * (last.wall + wall);
    }
    (last.dissipation, last.wall) = (dissipation, wall);
}

fn book_friction<V: Space>(
    clock: Res<Clock>,
    columns: Res<Columns<V>>,
    history: Res<History<V>>,
    mut flows: ResMut<EnergyFlows>,
    mut channels: ResMut<Channels>,
    mut last: ResMut<TurningPowers>,
) {
    let power = |torques: &[[V::Spin; BOOKED]], rotations: &[Rotation<V>]| {
        let powers = torques.iter().zip(rotations).map(|([_, drag], rotation)| drag.times(rotation.spin));
        powers.fold(V::Spin::ZERO, Add::add)
    };
    let (torque, on_fixed) = columns.loads.torque.entries().split_at(columns.movable_end);
    let (rotation, fixed) = columns.rotation.split_at(columns.movable_end);
    // As the kick sums them, if it does.
    let by_strides = || torque.chunks(STRIDE).zip(rotation.chunks(STRIDE)).map(|(torque, of)| power(torque, of));
    let of_grains = columns.spin_kick_sum.unwrap_or_else(|| by_strides().fold(V::Spin::ZERO, Add::add));
    let turning = -(of_grains + power(on_fixed, fixed)).sum_of_components();
    let rolling = -sum(columns.loads.rolling_drag.iter().zip(&columns.rotation).map(|(drag, of)| drag.times(of.spin)));
    let taken = history.lost();
    // In step zero too: there a dashpot beyond the cap loads its spring, and what that stores is not to be had for nothing.
    channels.tangential += taken.sliding + taken.dashpots;
    channels.rolling += taken.rolling;
    flows.dissipated += taken.sliding + taken.rolling;
    if !clock.is_step_zero() {
        let half = 0.5 * clock.dt;
        channels.rolling += half * (last.rolling + rolling);
        flows.dissipated += half * (last.turning + turning + last.rolling + rolling);
    }
    *last = TurningPowers { turning, rolling };
}

fn book_added_work<V: Space>(
    clock: Res<Clock>,
    columns: Res<Columns<V>>,
    forces: Query<&Force<V>>,
    mut flows: ResMut<EnergyFlows>,
    mut last: ResMut<Powers>,
) {
    let mut added = 0.0;
    for i in (0..columns.movable_end).filter(|&i| !columns.is_fixed(i)) {
        if let Ok(total) = forces.get(columns.entity[i]) {
            added += (total.0 - columns.loads.force.of(i)).dot(columns.body[i].velocity);
        }
    }
    if !clock.is_step_zero() {
        flows.added_work += 0.5 * clock.dt * (last.added + added);
    }
    last.added = added;
}

/// The books of the step are kept after this set, in [`Phase::Control`] or with the second kick (`columns/settle.rs`).
#[derive(SystemSet, Clone, Debug, PartialEq, Eq, Hash)]
pub struct EnergyBooked;

/// Keeps the energy balance.
pub struct EnergyPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for EnergyPlugin<V> {
    fn build(&self, app: &mut App) {
        app.world_mut().resource_mut::<Columns<V>>().has_books = true;
        app.init_resource::<EnergyFlows>().init_resource::<Powers>().add_systems(
            Step,
            (
                book_removed::<V>.in_set(BeforeRenumbering),
                book_released::<V>.in_set(Renumbering).before(columns::renumber::<V>),
                book_initial_overlaps::<V>.in_set(Phase::Cull).run_if(is_step_zero),
            ),
        );
        after_kicks(app, || book_contact_work::<V>.in_set(EnergyBooked).into_configs());
    }
}

/// Books what friction and rolling resistance take, where grains spin.
pub struct SpinEnergyPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for SpinEnergyPlugin<V> {
    fn build(&self, app: &mut App) {
        app.init_resource::<Channels>().init_resource::<TurningPowers>();
        after_kicks(app, || book_friction::<V>.in_set(EnergyBooked).after(book_contact_work::<V>).into_configs());
        // What rolling resistance takes goes by spins that no kick has summed.
        looks_when(app, |columns: Res<Columns<V>>| !columns.loads.rolling_drag.is_empty());
    }
}

/// Books the elastic energy that a door of panels held.
pub struct PanelDoorEnergyPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for PanelDoorEnergyPlugin<V> {
    fn build(&self, app: &mut App) {
        app.add_systems(Step, book_panel_door::<V>.in_set(Phase::Spawn).before(Entering).before(Settled));
    }
}

/// Books the work of forces that behaviours add.
pub struct AddedWorkPlugin<V: Space>(pub PhantomData<V>);

impl<V: Space> Plugin for AddedWorkPlugin<V> {
    fn build(&self, app: &mut App) {
        app.add_systems(
            Step,
            book_added_work::<V>
                .in_set(Phase::Control)
                .in_set(EnergyBooked)
                .after(book_contact_work::<V>)
                .after(book_friction::<V>),
        );
    }
}
