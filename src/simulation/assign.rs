//! Numbers that a caller gives to grains between two steps: places, velocities, spins.
//!
//! The energy that this adds or takes, in motion, height and contacts, counts as released in the energy balance. Contacts keep their memories as
//! far as they still exist. A grain that is put elsewhere has not crossed any wall.

use crate::energy::EnergyFlows;
use crate::grain_requests::find_neighbours;
use crate::ledger::forget_ways;
use crate::measure::totals;
use crate::simulation::Simulation;
use siloflow_dem::particle::{Grain, GrainId, Position, Velocity};
use siloflow_dem::space::{Linear, Space};
use siloflow_dem::spin::Spin;
use siloflow_dem::store::{ParticleStore, apply_pending_kick};

/// New numbers of all grains that are present, in the order of their ids.
#[derive(Clone, Copy, Debug)]
pub enum Assigned<'a, V: Space> {
    /// Centres, m.
    Positions(&'a [V]),
    /// Velocities, m/s.
    Velocities(&'a [V]),
    /// Spins, rad/s.
    Spins(&'a [V::Spin]),
}

impl<V: Space> Assigned<'_, V> {
    fn len(&self) -> usize {
        match self {
            Self::Positions(all) | Self::Velocities(all) => all.len(),
            Self::Spins(all) => all.len(),
        }
    }

    fn are_finite(&self) -> bool {
        match self {
            Self::Positions(all) | Self::Velocities(all) => all.iter().all(|vector| Linear::is_finite(*vector)),
            Self::Spins(all) => all.iter().all(|spin| spin.is_finite()),
        }
    }
}

/// Returns the rows of all grains that are present, in the order of their ids.
#[must_use]
pub fn grains_by_id<V: Space>(store: &ParticleStore<V>) -> Vec<usize> {
    let is_grain = |&row: &usize| store.is_whole(row) && store.is_present(row) && !store.id[row].is_wall();
    let mut rows: Vec<_> = (0..store.len()).filter(is_grain).collect();
    rows.sort_unstable_by_key(|&row| store.id[row]);
    rows
}

impl Simulation {
    /// Returns the ids of all grains that are present, ascending.
    #[must_use]
    pub fn grain_ids<V: Space>(&self) -> Vec<GrainId> {
        let store = self.world().resource::<ParticleStore<V>>();
        grains_by_id(store).into_iter().map(|row| store.id[row]).collect()
    }

    /// Gives all grains other numbers.
    ///
    /// # Errors
    /// If there are not as many numbers as grains, one is not finite, or grains of this scene do not spin.
    pub fn assign<V: Space>(&mut self, numbers: Assigned<'_, V>) -> Result<(), String> {
        let world = self.world_mut();
        apply_pending_kick(world);
        let store = world.resource::<ParticleStore<V>>();
        let rows = grains_by_id(store);
        if rows.len() != numbers.len() {
            return Err(format!("there are {} grains, but {} rows", rows.len(), numbers.len()));
        }
        if !numbers.are_finite() {
            return Err("a number is infinite or NaN".to_owned());
        }
        if matches!(numbers, Assigned::Spins(_)) && !store.has_spins() {
            return Err("grains of this scene do not spin: its contact law has no friction".to_owned());
        }
        let entities: Vec<_> = rows.iter().map(|&row| store.entity[row]).collect();
        let periodic = store.periodic;
        // Springs are half a step ahead of positions in some schemes, so that their energy depends on velocities and spins too.
        let before = totals::of_world(world).energy();
        for (place, entity) in entities.into_iter().enumerate() {
            let Ok(mut grain) = world.get_entity_mut(entity) else { continue };
            if !grain.contains::<Grain>() {
                continue;
            }
            match numbers {
                Assigned::Positions(all) => {
                    grain.insert(Position(periodic.map_or(all[place], |periodic| periodic.wrapped(all[place]))))
                }
                Assigned::Velocities(all) => grain.insert(Velocity(all[place])),
                Assigned::Spins(all) => grain.insert(Spin(all[place])),
            };
        }
        if matches!(numbers, Assigned::Positions(_)) {
            forget_ways::<V>(world);
            find_neighbours::<V>(world);
        }
        let gained = totals::of_world(world).energy() - before;
        if let Some(mut flows) = world.get_resource_mut::<EnergyFlows>() {
            flows.released += gained;
        }
        Ok(())
    }
}
