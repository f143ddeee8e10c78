//! Energy that entering and leaving grains and doors add to the balance, J.

use bevy_ecs::prelude::*;

use crate::energy::EnergyFlows;
use siloflow_dem::contact::Memory;
use siloflow_dem::gravity::Gravity;
use siloflow_dem::particle::Grain;
use siloflow_dem::space::Space;
use siloflow_dem::store::{ParticleStore, Slot};
use siloflow_dem::survey::{Partner, SurveyParam};
use siloflow_dem::walls::leaving::LeavingWalls;

/// Returns the kinetic and gravitational energy of a particle, J.
fn mechanical<V: Space>(mass: f64, x: V, v: V, gravity: V) -> f64 {
    0.5 * mass * v.length_squared() - mass * gravity.dot(x)
}

/// Returns the kinetic and gravitational energy of the grain in row `i`, J; zero if it is fixed.
pub(crate) fn energy_of<V: Space>(store: &ParticleStore<V>, i: usize, gravity: V) -> f64 {
    if !store.integrated_rows().contains(&i) {
        return 0.0;
    }
    mechanical(store.mass[i], store.body[i].position, store.body[i].velocity, gravity) + store.rotational_energy(i)
}

/// Adds the energy of removed particles and their contacts. The store still holds their last state.
pub(super) fn add_removed_energy<V: Space>(
    survey_param: SurveyParam<V>,
    store: Res<ParticleStore<V>>,
    gravity: Res<Gravity<V>>,
    mut flows: ResMut<EnergyFlows>,
) {
    if store.vacated().is_empty() {
        return;
    }
    let is_gone = |i: usize| !store.is_present(i);
    for i in store.integrated_rows().filter(|&i| is_gone(i)) {
        flows.removed += mechanical(store.mass[i], store.body[i].position, store.body[i].velocity, gravity.0);
        flows.removed += store.rotational_energy(i);
    }
    flows.removed += survey_param
        .survey()
        .elastic_energy(|i, partner| is_gone(i) || matches!(partner, Partner::Particle(j) if is_gone(j)));
}

/// Adds the energy of grains that have just received their first slots.
pub(super) fn add_released_energy<V: Space>(
    store: Res<ParticleStore<V>>,
    gravity: Res<Gravity<V>>,
    grains: Query<(), With<Grain>>,
    mut flows: ResMut<EnergyFlows>,
) {
    let is_new =
        |&i: &usize| store.former[i] == Slot::default() && store.is_whole(i) && grains.contains(store.entity[i]);
    let mut new: Vec<_> = (0..store.len()).filter(is_new).collect();
    new.sort_unstable_by_key(|&i| store.id[i]);
    for i in new {
        let body = &store.body[i];
        flows.released += mechanical(store.mass[i], body.position, body.velocity, gravity.0);
        flows.released += store.rotational_energy(i);
    }
}

/// Adds the elastic energy of overlaps at the start. All other springs start relaxed.
pub(super) fn add_initial_overlap_energy<V: Space>(survey_param: SurveyParam<V>, mut flows: ResMut<EnergyFlows>) {
    let survey = survey_param.survey();
    survey.contacts(|_, _, pair, _| flows.released += survey.law.elastic_energy(pair, &Memory::default()));
}

/// Adds the elastic energy of contacts with walls that are about to be removed.
pub(super) fn add_leaving_wall_energy<V: Space>(
    survey_param: SurveyParam<V>,
    leaving: Res<LeavingWalls>,
    mut flows: ResMut<EnergyFlows>,
) {
    let survey = survey_param.survey();
    // The contacts of a removed grain are already counted with the grain.
    flows.removed += survey.elastic_energy(|i, partner| {
        matches!(partner, Partner::Wall(wall) if leaving.0.contains(&wall)) && survey.store.is_present(i)
    });
}
