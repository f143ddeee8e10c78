//! Elastic energy of the contacts of grains that requests concern, J.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;
use rustc_hash::FxHashMap;

use crate::energy::EnergyFlows;
use crate::grain_requests::accounts::Accounts;
use siloflow_dem::contact::history::History;
use siloflow_dem::particle::GrainId;
use siloflow_dem::space::Space;
use siloflow_dem::survey::{Partner, Survey, SurveyParam};

/// Grains that have come or moved in this step, with the reason.
#[derive(Resource, Default)]
pub(super) struct NewOverlaps(pub(super) FxHashMap<GrainId, String>);

/// Sums the elastic energy of contacts of these grains, by reason. A contact of two of them counts for the one with the lower slot. Contacts with
/// a grain that `is_left_out` do not count.
pub(super) fn elastic_energies<V: Space>(
    world: &World,
    grains: &FxHashMap<GrainId, String>,
    is_left_out: impl Fn(GrainId) -> bool,
) -> BTreeMap<String, f64> {
    let mut energies = BTreeMap::new();
    if !grains.is_empty() && world.contains_resource::<History>() {
        add_energies(Survey::<V>::of_world(world), grains, is_left_out, &mut energies);
    }
    energies
}

/// Adds the energies to those of the reasons.
fn add_energies<V: Space>(
    survey: Survey<'_, V>,
    grains: &FxHashMap<GrainId, String>,
    is_left_out: impl Fn(GrainId) -> bool,
    energies: &mut BTreeMap<String, f64>,
) {
    let id = |row: usize| survey.store.id[row];
    let of_partner = |partner: Partner| match partner {
        Partner::Particle(row) => Some(id(row)),
        Partner::Wall(_) => None,
    };
    let accepts = |row: usize, partner: Partner| {
        let other = of_partner(partner);
        let concerns = grains.contains_key(&id(row)) || other.is_some_and(|other| grains.contains_key(&other));
        concerns && !is_left_out(id(row)) && !other.is_some_and(&is_left_out)
    };
    survey.contacts_among(accepts, |row, partner, pair, memory| {
        let reason = grains.get(&id(row)).or_else(|| grains.get(&of_partner(partner)?));
        if let Some(reason) = reason {
            *energies.entry(reason.clone()).or_insert(0.0) += survey.law.elastic_energy(pair, memory);
        }
    });
}

/// Run condition: grains have come or moved in this step, in a scene with contacts.
pub(super) fn are_new(overlaps: Res<NewOverlaps>, history: Option<Res<History>>) -> bool {
    !overlaps.0.is_empty() && history.is_some()
}

/// Books the elastic energy of the contacts in which new and moved grains find themselves. Runs after the first force pass.
pub(super) fn book_new_overlaps<V: Space>(
    survey: SurveyParam<V>,
    mut new: ResMut<NewOverlaps>,
    mut accounts: ResMut<Accounts<V>>,
    flows: Option<ResMut<EnergyFlows>>,
) {
    let grains = std::mem::take(&mut new.0);
    let mut energies = BTreeMap::new();
    add_energies(survey.survey(), &grains, |_| false, &mut energies);
    for (reason, energy) in &energies {
        let account = accounts.of(reason);
        account.energy += energy;
        account.elastic += energy;
    }
    if let Some(mut flows) = flows {
        flows.released += energies.values().sum::<f64>();
    }
}
