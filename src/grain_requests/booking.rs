//! Books what requests change: mass, momentum and energy before and after, in the accounts of their reasons and in the energy balance.
//!
//! The balance itself counts grains that come and go, with the contacts of those that go (`energy::energy_flows`). Here it gets what changes in grains that stay.

use bevy_ecs::prelude::*;
use rustc_hash::FxHashMap;

use crate::energy::{EnergyFlows, energy_of};
use crate::grain_requests::accounts::Accounts;
use crate::grain_requests::overlaps::elastic_energies;
use crate::grain_requests::resolve::{Change, Plan};
use siloflow_dem::gravity::Gravity;
use siloflow_dem::particle::GrainId;
use siloflow_dem::space::Space;
use siloflow_dem::store::ParticleStore;

/// A grain that has come or changed.
pub(super) struct Present {
    pub(super) reason: String,
    pub(super) is_new: bool,
    /// Whether it is in another place than before.
    pub(super) moves: bool,
}

/// Books what goes, and the old state of what changes.
pub(super) fn book_before<V: Space>(world: &mut World, plan: &Plan<V>) {
    let going = plan.leaving.iter().map(|one| (one.id, one.reason.clone()));
    let changing = plan.changes.iter().filter(|one| one.moved.is_some()).map(|one| (one.id, one.reason.clone()));
    let elastic = elastic_energies::<V>(world, &going.chain(changing).collect(), |_| false);
    // What goes is counted by the balance itself, contacts included.
    let leaves = |id: GrainId| plan.leaving.iter().any(|one| one.id == id);
    let moving = plan.changes.iter().filter(|one| one.moved.is_some()).map(|one| (one.id, one.reason.clone()));
    let of_changes: f64 = elastic_energies::<V>(world, &moving.collect(), leaves).values().sum();
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

/// Books the elastic energy that another radius gives to the contacts of a grain in its place.
pub(super) fn book_resized<V: Space>(world: &mut World, changes: &[Change<V>]) {
    let resized = || changes.iter().filter(|one| one.moved.is_none());
    let names: FxHashMap<GrainId, String> = resized().map(|one| (one.id, one.reason.clone())).collect();
    if names.is_empty() {
        return;
    }
    let before = elastic_energies::<V>(world, &names, |_| false);
    let rescale = |world: &mut World, radius: &dyn Fn(&Change<V>) -> f64| -> Vec<f64> {
        let mut store = world.resource_mut::<ParticleStore<V>>();
        resized().map(|one| std::mem::replace(&mut store.body[one.row].radius, radius(one))).collect()
    };
    // The rows get the new radii for this sum alone: the renumbering compares both.
    let old = rescale(world, &|one| one.radius);
    let after = elastic_energies::<V>(world, &names, |_| false);
    let mut old = old.into_iter();
    let mut store = world.resource_mut::<ParticleStore<V>>();
    for one in resized() {
        store.body[one.row].radius = old.next().unwrap_or(one.radius);
    }
    let mut gained = 0.0;
    let mut accounts = world.resource_mut::<Accounts<V>>();
    let mut book = |reason: &str, energy: f64| {
        let account = accounts.of(reason);
        account.energy += energy;
        account.elastic += energy;
        gained += energy;
    };
    for (reason, energy) in before
        .iter()
        .map(|(reason, energy)| (reason, -energy))
        .chain(after.iter().map(|(reason, energy)| (reason, *energy)))
    {
        book(reason, energy);
    }
    if let Some(mut flows) = world.get_resource_mut::<EnergyFlows>() {
        flows.released += gained;
    }
}

/// Books the new state of what has come or changed, in the order of ids.
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
    if let Some(mut flows) = world.get_resource_mut::<EnergyFlows>() {
        flows.released += released;
    }
}
