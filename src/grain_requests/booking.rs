//! Books what requests change: mass, momentum and energy before and after, in the accounts of their reasons and in the energy balance.
//!
//! The balance itself counts grains that come and go, with the contacts of those that go (`energy::energy_flows`). Here it gets what changes in grains that stay.

use bevy_ecs::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::energy::{EnergyFlows, energy_of};
use crate::grain_requests::accounts::Accounts;
use crate::grain_requests::contacts::elastic_energies;
use crate::grain_requests::plan::Plan;
use siloflow_dem::gravity::Gravity;
use siloflow_dem::particle::GrainId;
use siloflow_dem::space::Space;
use siloflow_dem::store::ParticleStore;

/// A grain that has come or changed.
pub(super) struct Present {
    pub(super) reason: String,
    pub(super) is_new: bool,
}

/// Books grains that go, and the old state of grains that change.
pub(super) fn book_before<V: Space>(world: &mut World, plan: &Plan<V>) {
    let going = plan.leaving.iter().map(|one| (one.id, one.reason.clone()));
    let changing = || plan.changes.iter().map(|one| (one.id, one.reason.clone()));
    let elastic = elastic_energies::<V>(world, &going.chain(changing()).collect(), |_| false);
    // The balance itself counts grains that go, contacts included.
    let leaving: FxHashSet<_> = plan.leaving.iter().map(|one| one.id).collect();
    let of_changes = elastic_energies::<V>(world, &changing().collect(), |id| leaving.contains(&id));
    let of_changes: f64 = of_changes.values().sum();
    let rows = plan.leaving.iter().map(|one| (one.row, one.reason.as_str(), true));
    let rows = rows.chain(plan.changes.iter().map(|one| (one.row, one.reason.as_str(), false)));
    let figures: Vec<_> = {
        let store = world.resource::<ParticleStore<V>>();
        let gravity = world.resource::<Gravity<V>>().0;
        rows.map(|(row, reason, goes)| {
            let mass = store.mass[row];
            (reason, goes, mass, store.body[row].velocity * mass, energy_of(store, row, gravity))
        })
        .collect()
    };
    let mut removed = of_changes;
    let mut accounts = world.resource_mut::<Accounts<V>>();
    for (reason, goes, mass, momentum, energy) in figures {
        let account = accounts.of(reason);
        account.removed += u32::from(goes);
        account.resized += u32::from(!goes);
        account.mass -= mass;
        account.momentum -= momentum;
        account.energy -= energy;
        removed += if goes { 0.0 } else { energy };
    }
    for (reason, energy) in elastic {
        let account = accounts.of(&reason);
        account.energy -= energy;
        account.elastic -= energy;
    }
    for reason in &plan.dropped {
        accounts.of(reason).dropped += 1;
    }
    if let Some(mut flows) = world.get_resource_mut::<EnergyFlows>() {
        flows.removed += removed;
    }
}

/// Books grains that have come, and the new state of grains that have changed, in the order of ids.
pub(super) fn book_after<V: Space>(world: &mut World, present: &FxHashMap<GrainId, Present>) {
    let mut figures: Vec<_> = {
        let store = world.resource::<ParticleStore<V>>();
        let gravity = world.resource::<Gravity<V>>().0;
        let rows = (0..store.len()).filter(|&row| store.is_whole(row));
        rows.filter_map(|row| {
            let grain = present.get(&store.id[row])?;
            let mass = store.mass[row];
            let momentum = store.body[row].velocity * mass;
            Some((store.id[row], grain, mass, momentum, energy_of(store, row, gravity)))
        })
        .collect()
    };
    figures.sort_unstable_by_key(|figure| figure.0);
    let names = present.iter().map(|(id, grain)| (*id, grain.reason.clone())).collect();
    let elastic = elastic_energies::<V>(world, &names, |_| false);
    let mut released = 0.0;
    let mut accounts = world.resource_mut::<Accounts<V>>();
    for (_, grain, mass, momentum, energy) in figures {
        let account = accounts.of(&grain.reason);
        account.made += u32::from(grain.is_new);
        account.mass += mass;
        account.momentum += momentum;
        account.energy += energy;
        // The balance itself counts grains that come.
        released += if grain.is_new { 0.0 } else { energy };
    }
    for (reason, energy) in elastic {
        let account = accounts.of(&reason);
        account.energy += energy;
        account.elastic += energy;
        released += energy;
    }
    if let Some(mut flows) = world.get_resource_mut::<EnergyFlows>() {
        flows.released += released;
    }
}
