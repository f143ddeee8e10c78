//! Work in a step: of dashpots, of moving walls and of forces that behaviours add, J.
//!
//! Sums run in ascending order of slots, separately for each component. Sums of drag power run chunk by chunk.

use std::ops::Add;

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::contact::history::History;
use crate::energy::{Channels, EnergyFlows};
use crate::space::{Linear, Space};
use crate::step::Clock;
use crate::store::{CHUNK, ParticleStore, TOTAL_AND_DISSIPATIVE};
use crate::walls::surfaces::Surfaces;

/// Powers at the end of the last step, W.
#[derive(Resource, Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub(super) struct Powers {
    wall: f64,
    added: f64,
    dissipation: f64,
}

/// Powers of the torques of tangential and rolling dashpots at the end of the last step, W.
#[derive(Resource, Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub(super) struct TurningPowers {
    turning: f64,
    rolling: f64,
}

/// Returns the sum of scalar products, given by component. It runs in ascending order of slots, separately for each
/// component.
fn sum<T: Linear>(products: impl Iterator<Item = T>) -> f64 {
    products.fold(T::ZERO, Add::add).sum_of_components()
}

/// Returns the power of the dissipative accumulators, by component, W. `motion` returns the velocity or spin of a
/// particle.
fn power<T: Linear, M>(sums: &[[T; TOTAL_AND_DISSIPATIVE]], movers: &[M], motion: impl Fn(&M) -> T) -> T {
    sums.iter().zip(movers).map(|([_, drag], mover)| drag.times(motion(mover))).fold(T::ZERO, Add::add)
}

/// Like [`power`], but summed chunk by chunk.
fn power_by_chunks<T: Linear, M>(sums: &[[T; TOTAL_AND_DISSIPATIVE]], movers: &[M], motion: impl Fn(&M) -> T) -> T {
    let chunks = sums.chunks(CHUNK).zip(movers.chunks(CHUNK));
    chunks.map(|(sums, movers)| power(sums, movers, &motion)).fold(T::ZERO, Add::add)
}

/// Adds the work of normal and tangential dashpots and of moving walls.
pub(super) fn add_contact_work<V: Space>(
    clock: Res<Clock>,
    store: Res<ParticleStore<V>>,
    walls: Res<Surfaces<V>>,
    mut flows: ResMut<EnergyFlows>,
    mut last: ResMut<Powers>,
) {
    let (force, on_fixed) = store.loads.force.entries().split_at(store.movable_end);
    let (body, fixed) = store.body.split_at(store.movable_end);
    // The kick's sum is reused if there is one; otherwise the sum runs in the same order.
    let of_grains = store.kick_sum.unwrap_or_else(|| power_by_chunks(force, body, |body| body.velocity));
    let (mut dissipation, mut wall) = (-of_grains.sum_of_components(), 0.0);
    // Most fixed particles do not move.
    for (i, ([force, drag], body)) in
        on_fixed.iter().zip(fixed).enumerate().filter(|(_, (_, body))| body.velocity != V::ZERO)
    {
        dissipation -= drag.dot(body.velocity);
        let added = store.added.get(store.movable_end + i).copied().unwrap_or(V::ZERO);
        wall -= (*force - added).dot(body.velocity);
    }
    for (moving, load) in walls.with_loads() {
        dissipation -= load.drag.dot(moving.velocity) + load.drag_torque.dot(moving.spin);
        wall -= load.force.dot(moving.velocity) + load.torque.dot(moving.spin);
    }
    if !clock.is_step_zero() {
        flows.dissipated += 0.5 * clock.dt * (last.dissipation + dissipation);
        flows.wall_work += 0.5 * clock.dt * (last.wall + wall);
    }
    (last.dissipation, last.wall) = (dissipation, wall);
}

/// Adds the losses of friction and rolling resistance.
pub(super) fn add_friction_loss<V: Space>(
    clock: Res<Clock>,
    store: Res<ParticleStore<V>>,
    history: Res<History<V>>,
    mut flows: ResMut<EnergyFlows>,
    mut channels: ResMut<Channels>,
    mut last: ResMut<TurningPowers>,
) {
    let (torque, on_fixed) = store.loads.torque.entries().split_at(store.movable_end);
    let (rotation, fixed) = store.rotation.split_at(store.movable_end);
    // The kick's sum is reused if there is one; otherwise the sum runs in the same order.
    let of_grains = store.spin_kick_sum.unwrap_or_else(|| power_by_chunks(torque, rotation, |rotation| rotation.spin));
    let turning = -(of_grains + power(on_fixed, fixed, |rotation| rotation.spin)).sum_of_components();
    let rolling =
        -sum(store.loads.rolling_drag.iter().zip(&store.rotation).map(|(drag, rotation)| drag.times(rotation.spin)));
    let losses = history.lost();
    // Step zero counts too: a dashpot beyond the cap loads its spring there, and this energy must have a source.
    channels.tangential += losses.sliding + losses.dashpots;
    channels.rolling += losses.rolling;
    flows.dissipated += losses.sliding + losses.rolling + losses.breaking;
    if !clock.is_step_zero() {
        let half = 0.5 * clock.dt;
        channels.rolling += half * (last.rolling + rolling);
        flows.dissipated += half * (last.turning + turning + last.rolling + rolling);
    }
    *last = TurningPowers { turning, rolling };
}

/// Adds the work of forces that behaviours add. The store has summed their power when they were written.
pub(super) fn add_behaviour_work<V: Space>(
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

/// Adds the potential energy of grains wrapped at periodic sides in this step.
pub(super) fn add_lifted_energy<V: Space>(store: Res<ParticleStore<V>>, mut flows: ResMut<EnergyFlows>) {
    flows.lifted += store.lifted;
}
