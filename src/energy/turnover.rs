//! What grains and doors bring into the balance and take out of it, J.

use bevy_ecs::prelude::*;

use crate::columns::{Columns, Slot, Turnover};
use crate::contact::Memory;
use crate::contact::survey::{Partner, Scenery};
use crate::energy::EnergyFlows;
use crate::gravity::Gravity;
use crate::messages::DoorOpened;
use crate::particle::{Grain, GrainBundle, GrainId, Mass, Position, Velocity};
use crate::space::{Linear, Space};
use crate::spin::{Inertia, Spin};

fn mechanical<V: Space>(mass: f64, x: V, v: V, gravity: V) -> f64 {
    0.5 * mass * v.length_squared() - mass * gravity.dot(x)
}

/// Everything whose entity is gone takes its energy with it. The columns still hold the state it had.
pub(super) fn book_removed<V: Space>(
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

pub(super) fn book_released<V: Space>(
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
pub(super) fn book_initial_overlaps<V: Space>(scenery: Scenery<V>, mut flows: ResMut<EnergyFlows>) {
    let survey = scenery.survey();
    survey.contacts(|_, _, pair, _| flows.released += survey.law.elastic_energy(pair, &Memory::default()));
}

/// A door of panels that is about to go takes its elastic energy with it.
pub(super) fn book_panel_door<V: Space>(
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
