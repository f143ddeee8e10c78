//! Elastic energy of the contacts of grains that requests concern, J, before and after they are carried out.

use std::collections::BTreeMap;

use bevy_ecs::prelude::*;
use bevy_ecs::system::RunSystemOnce as _;
use rustc_hash::FxHashMap;

use siloflow_dem::contact::history::History;
use siloflow_dem::neighbours::Search;
use siloflow_dem::outcome::Outcome;
use siloflow_dem::particle::GrainId;
use siloflow_dem::space::Space;
use siloflow_dem::step::Clock;
use siloflow_dem::store::ParticleStore;
use siloflow_dem::survey::{Partner, Survey};
use siloflow_dem::threads::Threads;

/// Sums the elastic energy of contacts of these grains, by reason. A contact of two of them counts for the one with the lower slot. Contacts with
/// a grain that `is_left_out` do not count.
pub(super) fn elastic_energies<V: Space>(
    world: &World,
    grains: &FxHashMap<GrainId, String>,
    is_left_out: impl Fn(GrainId) -> bool,
) -> BTreeMap<String, f64> {
    let mut energies = BTreeMap::new();
    if grains.is_empty() || !world.contains_resource::<History>() {
        return energies;
    }
    let survey = Survey::<V>::of_world(world);
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
    energies
}

/// Brings the neighbour list up to date, so that the contacts of this moment can be found.
pub(crate) fn find_neighbours<V: Space>(world: &mut World) {
    let updated = world.run_system_once(
        |search: Option<ResMut<Search<V>>>, store: Res<ParticleStore<V>>, clock: Res<Clock>, threads: Res<Threads>| {
            search.map_or(Ok(false), |mut search| search.update(&store, clock.dt, &threads))
        },
    );
    if let Ok(Err(failure)) = updated {
        world.resource_mut::<Outcome>().fail(failure);
    }
}
