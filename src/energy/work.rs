//! Work in a step: of dashpots, of moving walls and of forces that behaviours add, J.
//!
//! Sums run in ascending order of slots, separately for each component. Sums of drag power run chunk by chunk. Some
//! steps do not sum dissipation ([`sampling`](super::sampling)).

use std::array;
use std::ops::Add;

use bevy_ecs::prelude::*;
use serde::{Deserialize, Serialize};

use crate::energy::activity::Activity;
use crate::energy::sampled_sum::SampledSum;
use crate::energy::{Channels, EnergyFlows};
use siloflow_dem::contact::history::{ContactLosses, History};
use siloflow_dem::space::{Linear, Space};
use siloflow_dem::step::Clock;
use siloflow_dem::store::{CHUNK, ParticleStore, TOTAL_AND_DISSIPATIVE};
use siloflow_dem::walls::surfaces::Surfaces;

/// Powers at the end of the last step, W.
#[derive(Resource, Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub(super) struct Powers {
    wall: f64,
    added: f64,
    dissipation: SampledSum,
}

impl Powers {
    /// Returns the sums that have samples in some steps only.
    pub(super) fn sampled(&self) -> impl Iterator<Item = &SampledSum> {
        std::iter::once(&self.dissipation)
    }
}

/// Powers of the torques of tangential and rolling dashpots, W, and losses of contacts, J: by sliding, by rolling, by
/// tangential dashpots, and where contacts break.
#[derive(Resource, Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub(super) struct TurningPowers {
    turning: SampledSum,
    rolling: SampledSum,
    losses: [SampledSum; 4],
}

impl TurningPowers {
    /// Returns the sums that have samples in some steps only, of the parts of the dissipated energy.
    pub(super) fn sampled(&self) -> impl Iterator<Item = &SampledSum> {
        // The losses by tangential dashpots are in the powers.
        let [sliding, rolling, _, breaking] = &self.losses;
        [&self.turning, &self.rolling, sliding, rolling, breaking].into_iter()
    }
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

/// Returns the power of normal and tangential dashpots, W, if the last force pass has summed dissipation.
fn dissipation<V: Space>(store: &ParticleStore<V>, walls: &Surfaces<V>) -> Option<f64> {
    if !store.tracks_energy {
        return None;
    }
    let grains = store.integrated_rows();
    let fixed = store.fixed_rows();
    let force = store.loads.force.entries();
    // The kick's sum is reused if there is one; otherwise the sum runs in the same order.
    let of_grains = store
        .kick_sum
        .unwrap_or_else(|| power_by_chunks(&force[grains.clone()], &store.body[grains], |body| body.velocity));
    let mut dissipation = -of_grains.sum_of_components();
    // Most fixed particles do not move.
    for ([_, drag], body) in
        force[fixed.clone()].iter().zip(&store.body[fixed]).filter(|(_, body)| body.velocity != V::ZERO)
    {
        dissipation -= drag.dot(body.velocity);
    }
    for (moving, load) in walls.with_loads() {
        dissipation -= load.drag.dot(moving.velocity) + load.drag_torque.dot(moving.spin);
    }
    Some(dissipation)
}

/// Adds the work of normal and tangential dashpots and of moving walls.
pub(super) fn add_contact_work<V: Space>(
    clock: Res<Clock>,
    activity: Res<Activity>,
    store: Res<ParticleStore<V>>,
    walls: Res<Surfaces<V>>,
    mut flows: ResMut<EnergyFlows>,
    mut last: ResMut<Powers>,
) {
    let mut wall = 0.0;
    let fixed = store.fixed_rows();
    for (i, body) in fixed.clone().zip(&store.body[fixed]).filter(|(_, body)| body.velocity != V::ZERO) {
        let added = store.added.get(i).copied().unwrap_or(V::ZERO);
        wall -= (store.loads.force.of(i) - added).dot(body.velocity);
    }
    for (moving, load) in walls.with_loads() {
        wall -= load.force.dot(moving.velocity) + load.torque.dot(moving.spin);
    }
    let dissipated = last.dissipation.integrate(dissipation(&store, &walls), clock.dt, activity.weight());
    if !clock.is_step_zero() {
        flows.dissipated += dissipated;
        flows.wall_work += 0.5 * clock.dt * (last.wall + wall);
    }
    last.wall = wall;
}

/// Returns the powers of the torques of tangential dashpots and of rolling dashpots, W, if the last force pass has
/// summed dissipation.
fn turning_powers<V: Space>(store: &ParticleStore<V>) -> Option<[f64; 2]> {
    if !store.tracks_energy {
        return None;
    }
    let grains = store.integrated_rows();
    let fixed = store.fixed_rows();
    let torque = store.loads.torque.entries();
    // The kick's sum is reused if there is one; otherwise the sum runs in the same order.
    let of_grains = store
        .spin_kick_sum
        .unwrap_or_else(|| power_by_chunks(&torque[grains.clone()], &store.rotation[grains], |rotation| rotation.spin));
    let turning = -(of_grains + power(&torque[fixed.clone()], &store.rotation[fixed], |rotation| rotation.spin))
        .sum_of_components();
    let rolling = store.loads.rolling_drag.iter().zip(&store.rotation);
    Some([turning, -sum(rolling.map(|(drag, rotation)| drag.times(rotation.spin)))])
}

/// Adds the losses of friction and rolling resistance.
pub(super) fn add_friction_loss<V: Space>(
    clock: Res<Clock>,
    activity: Res<Activity>,
    store: Res<ParticleStore<V>>,
    history: Res<History>,
    mut flows: ResMut<EnergyFlows>,
    mut channels: ResMut<Channels>,
    mut last: ResMut<TurningPowers>,
) {
    let powers = turning_powers(&store);
    let losses = powers.map(|_| {
        let ContactLosses { sliding, rolling, dashpots, breaking } = history.lost();
        [sliding, rolling, dashpots, breaking]
    });
    let [sliding, rolled, dashpots, breaking] =
        array::from_fn(|channel| last.losses[channel].sum(losses.map(|losses| losses[channel]), activity.weight()));
    // Step zero counts too: a dashpot beyond the cap loads its spring there, and this energy must have a source.
    channels.tangential += sliding + dashpots;
    channels.rolling += rolled;
    flows.dissipated += sliding + rolled + breaking;
    let turning = last.turning.integrate(powers.map(|[turning, _]| turning), clock.dt, activity.weight());
    let rolling = last.rolling.integrate(powers.map(|[_, rolling]| rolling), clock.dt, activity.weight());
    if !clock.is_step_zero() {
        channels.rolling += rolling;
        flows.dissipated += turning + rolling;
    }
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
