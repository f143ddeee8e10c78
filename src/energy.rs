//! The energy balance: kinetic + gravitational + elastic
//! = released + work of moving walls + work of added forces - dissipated - removed + error, in J.
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
//! Sums run over the columns, so in ascending order of id. Limit: a grain that a behaviour fixes or frees takes its
//! kinetic energy out of or into the balance, which then shows as error.

use bevy_app::{App, Plugin};
use bevy_ecs::prelude::*;
use serde::Serialize;

use crate::columns::{BeforeRenumbering, Columns, GatheredVelocities, Renumbering};
use crate::contact::{AnyLaw, survey};
use crate::gravity::Gravity;
use crate::neighbours::Search;
use crate::particle::{Force, Grain, GrainId, Mass, Position, Velocity};
use crate::space::Vector;
use crate::step::{Clock, Phase, Step, is_step_zero};
use crate::walls::surfaces::Surfaces;

/// The flows of energy so far, J.
#[derive(Resource, Clone, Copy, Debug, Default, Serialize)]
pub struct EnergyFlows {
    /// Brought in by grains that entered.
    pub released: f64,
    /// Done on grains by fixed particles that move.
    pub wall_work: f64,
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
        self.released + self.wall_work + self.added_work - self.dissipated - self.removed
    }
}

/// Powers at the end of the last step, W.
#[derive(Resource, Clone, Copy, Debug, Default)]
struct Powers {
    wall: f64,
    added: f64,
    dissipation: f64,
}

fn mechanical(mass: f64, x: Vector, v: Vector, gravity: Vector) -> f64 {
    0.5 * mass * v.length_squared() - mass * gravity.dot(x)
}

/// Everything whose entity is gone takes its energy with it. The columns still hold the state it had.
fn book_removed(
    columns: Res<Columns>,
    search: Res<Search>,
    walls: Res<Surfaces>,
    law: Res<AnyLaw>,
    gravity: Res<Gravity>,
    present: Query<(), With<GrainId>>,
    mut flows: ResMut<EnergyFlows>,
) {
    let gone: Vec<bool> = columns.entity.iter().map(|&entity| !present.contains(entity)).collect();
    if !gone.contains(&true) {
        return;
    }
    for i in (0..columns.movable_end).filter(|&i| gone[i] && !columns.is_fixed(i)) {
        flows.removed += mechanical(columns.mass[i], columns.body[i].position, columns.body[i].velocity, gravity.0);
    }
    flows.removed += survey::elastic_energy(&columns, &search, &walls.0, &*law.0, |i, partner| {
        gone[i] || matches!(partner, survey::Partner::Particle(j) if gone[j])
    });
}

fn book_released(
    gravity: Res<Gravity>,
    new: Query<(&GrainId, &Position, &Velocity, &Mass), Added<Grain>>,
    mut flows: ResMut<EnergyFlows>,
) {
    let mut new: Vec<_> = new.iter().collect();
    new.sort_unstable_by_key(|(id, ..)| **id);
    for (_, x, v, mass) in new {
        flows.released += mechanical(mass.0, x.0, v.0, gravity.0);
    }
}

/// Grains that start in contact bring that elastic energy too.
fn book_initial_overlaps(
    columns: Res<Columns>,
    search: Res<Search>,
    walls: Res<Surfaces>,
    law: Res<AnyLaw>,
    mut flows: ResMut<EnergyFlows>,
) {
    flows.released += survey::elastic_energy(&columns, &search, &walls.0, &*law.0, |_, _| true);
}

fn book_contact_work(
    clock: Res<Clock>,
    columns: Res<Columns>,
    mut flows: ResMut<EnergyFlows>,
    mut last: ResMut<Powers>,
) {
    let (mut dissipation, mut wall) = (0.0, 0.0);
    for (load, body) in columns.load.iter().zip(&columns.body) {
        dissipation -= load.drag.dot(body.velocity);
    }
    for i in (0..columns.len()).filter(|&i| columns.is_fixed(i)) {
        wall -= columns.load[i].force.dot(columns.body[i].velocity);
    }
    if !clock.is_step_zero() {
        flows.dissipated += 0.5 * clock.dt * (last.dissipation + dissipation);
        flows.wall_work += 0.5 * clock.dt * (last.wall + wall);
    }
    (last.dissipation, last.wall) = (dissipation, wall);
}

fn book_added_work(
    clock: Res<Clock>,
    columns: Res<Columns>,
    forces: Query<&Force>,
    mut flows: ResMut<EnergyFlows>,
    mut last: ResMut<Powers>,
) {
    let mut added = 0.0;
    for i in (0..columns.movable_end).filter(|&i| !columns.is_fixed(i)) {
        if let Ok(total) = forces.get(columns.entity[i]) {
            added += (total.0 - columns.load[i].force).dot(columns.body[i].velocity);
        }
    }
    if !clock.is_step_zero() {
        flows.added_work += 0.5 * clock.dt * (last.added + added);
    }
    last.added = added;
}

/// Keeps the energy balance.
pub struct EnergyPlugin;

impl Plugin for EnergyPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<EnergyFlows>().init_resource::<Powers>().add_systems(
            Step,
            (
                book_removed.in_set(BeforeRenumbering),
                book_released.in_set(Renumbering),
                book_contact_work.in_set(Phase::Control).after(GatheredVelocities),
                book_initial_overlaps.in_set(Phase::Cull).run_if(is_step_zero),
            ),
        );
    }
}

/// Books the work of forces that behaviours add.
pub struct AddedWorkPlugin;

impl Plugin for AddedWorkPlugin {
    fn build(&self, app: &mut App) {
        app.add_systems(Step, book_added_work.in_set(Phase::Control).after(book_contact_work));
    }
}
