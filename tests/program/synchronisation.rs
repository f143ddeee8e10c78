//! Component synchronisation. The particle store owns the numbers. Components show the values of the store to every
//! system, for every kind of access. Reading changes no bit. Values that systems write are copied back to the store.

mod loads;
mod reads;
mod writes;

use std::num::NonZeroUsize;

use siloflow::energy::EnergyFlows;
use siloflow::output::state_hash;
use siloflow::prelude::*;

use crate::load;

/// Loads a scene without pictures.
fn scene(name: &str, settings: &[(&str, &str)]) -> Loaded {
    load(name, &[settings, &[("pictures", "None")]].concat())
}

fn with(loaded: &Loaded, more: impl FnOnce(&mut App)) -> Simulation {
    Simulation::with_plugins(loaded, &Registry::default(), NonZeroUsize::MIN, more).unwrap()
}

/// Returns the state hash, the energy flows and the grain counts.
fn state_and_flows(run: &mut Simulation) -> (u64, [u64; 3], usize) {
    let world = run.world_mut();
    let flows = *world.resource::<EnergyFlows>();
    let ledger = world.resource::<Ledger>();
    let counts = ledger.released as usize + ledger.out() as usize;
    let energy_flows = [flows.dissipated, flows.wall_work, flows.lifted].map(f64::to_bits);
    (state_hash::of_world(world), energy_flows, counts)
}

/// In this order: a spawner with a discharge; friction between moving walls and periodic sides, with Verlet and with
/// centred contacts; gravity along periodic sides in solid space, with Verlet and with centred contacts.
const SCENES: [(&str, &[(&str, &str)], u64); 5] = [
    ("silo1.ron", &[("spawner.count", "20"), ("door.opens", "At(2.5)")], 3200),
    ("couette.ron", &[("integrator", "Verlet")], 200),
    ("couette.ron", &[("integrator", "Centred")], 200),
    ("chute3d.ron", &[("integrator", "Verlet")], 300),
    ("chute3d.ron", &[("integrator", "Centred")], 300),
];
