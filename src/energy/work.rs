//! The work of a step: of dashpots, of moving walls and of forces that behaviours add, J.
//!
//! Sums run in ascending order of slots, those of the drag stride by stride, each component for itself.

use std::ops::Add;

use bevy_ecs::prelude::*;

use crate::contact::history::History;
use crate::energy::{Channels, EnergyFlows};
use crate::space::{Linear, Space};
use crate::step::Clock;
use crate::store::{CHUNK, ParticleStore, TOTAL_AND_DISSIPATIVE};
use crate::walls::surfaces::Surfaces;

/// Powers at the end of the last step, W.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(super) struct Powers {
    wall: f64,
    added: f64,
    dissipation: f64,
}

/// Powers of dashpots' torques, tangential and rolling, at the end of the last step, W.
#[derive(Resource, Clone, Copy, Debug, Default)]
pub(super) struct TurningPowers {
    turning: f64,
    rolling: f64,
}

/// The sum of scalar products, given by component: in ascending order of slots, each component for itself.
fn sum<T: Linear>(products: impl Iterator<Item = T>) -> f64 {
    products.fold(T::ZERO, Add::add).sum_of_components()
}

/// The power of the dashpots in these sums, by component, W; `motion` is the velocity or spin of who has them.
fn power<T: Linear, M>(sums: &[[T; TOTAL_AND_DISSIPATIVE]], movers: &[M], motion: impl Fn(&M) -> T) -> T {
    sums.iter().zip(movers).map(|([_, drag], mover)| drag.times(motion(mover))).fold(T::ZERO, Add::add)
}

/// The same, summed stride by stride.
fn power_by_strides<T: Linear, M>(sums: &[[T; TOTAL_AND_DISSIPATIVE]], movers: &[M], motion: impl Fn(&M) -> T) -> T {
    let chunks = sums.chunks(CHUNK).zip(movers.chunks(CHUNK));
    chunks.map(|(sums, movers)| power(sums, movers, &motion)).fold(T::ZERO, Add::add)
}

pub(super) fn book_contact_work<V: Space>(
    clock: Res<Clock>,
    store: Res<ParticleStore<V>>,
    walls: Res<Surfaces<V>>,
    mut flows: ResMut<EnergyFlows>,
    mut last: ResMut<Powers>,
) {
    let (force, on_fixed) = store.loads.force.entries().split_at(store.movable_end);
    let (body, fixed) = store.body.split_at(store.movable_end);
    // As the kick sums them, if it does.
    let of_grains = store.kick_sum.unwrap_or_else(|| power_by_strides(force, body, |body| body.velocity));
    let (mut dissipation, mut wall) = (-of_grains.sum_of_components(), 0.0);
    // Most of what is fixed stands still.
    for (i, ([force, drag], body)) in
        on_fixed.iter().zip(fixed).enumerate().filter(|(_, (_, body))| body.velocity != V::ZERO)
    {
        dissipation -= drag.dot(body.velocity);
        let added = store.added.get(store.movable_end + i).copied().unwrap_or(V::ZERO);
        wall -= (*force - added).dot(body.velocity);
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

pub(super) fn book_friction<V: Space>(
    clock: Res<Clock>,
    store: Res<ParticleStore<V>>,
    history: Res<History<V>>,
    mut flows: ResMut<EnergyFlows>,
    mut channels: ResMut<Channels>,
    mut last: ResMut<TurningPowers>,
) {
    let (torque, on_fixed) = store.loads.torque.entries().split_at(store.movable_end);
    let (rotation, fixed) = store.rotation.split_at(store.movable_end);
    // As the kick sums them, if it does.
    let of_grains = store.spin_kick_sum.unwrap_or_else(|| power_by_strides(torque, rotation, |of| of.spin));
    let turning = -(of_grains + power(on_fixed, fixed, |of| of.spin)).sum_of_components();
    let rolling = -sum(store.loads.rolling_drag.iter().zip(&store.rotation).map(|(drag, of)| drag.times(of.spin)));
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

/// Of the forces of this step, whose power the store has summed when they were written.
pub(super) fn book_added_work<V: Space>(
    clock: Res<Clock>,
    store: Res<ParticleStore<V>>,
    mut flows: ResMut<EnergyFlows>,
    mut last: ResMut<Powers>,
) {
    let added = store.added_power.unwrap_or_default();
    if !clock.is_step_zero() {
        flows.added_work += 0.5 * clock.dt * (last.added + added);
    }
    last.added = added;
}

/// What periodic sides have lifted in this step.
pub(super) fn book_lifted<V: Space>(store: Res<ParticleStore<V>>, mut flows: ResMut<EnergyFlows>) {
    flows.lifted += store.lifted;
}
