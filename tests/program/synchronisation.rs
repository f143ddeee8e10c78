//! One owner of the numbers: components show what the store holds, whatever system looks at them and however; looking changes no bit; and
//! what systems write is taken over.

mod looks;
mod writes;

use std::num::NonZeroUsize;

use siloflow::energy::EnergyFlows;
use siloflow::output::state_hash;
use siloflow::prelude::*;

use crate::load;

/// A scene without pictures.
fn scene(name: &str, settings: &[(&str, &str)]) -> Loaded {
    load(name, &[settings, &[("pictures", "None")]].concat())
}

fn with(loaded: &Loaded, more: impl FnOnce(&mut App)) -> Simulation {
    Simulation::with_plugins(loaded, &Registry::default(), NonZeroUsize::MIN, more).unwrap()
}

/// State and books.
fn look(run: &mut Simulation) -> (u64, [u64; 3], usize) {
    let world = run.world_mut();
    let flows = *world.resource::<EnergyFlows>();
    let ledger = world.resource::<Ledger>();
    let counts = ledger.released as usize + ledger.out() as usize;
    let books = [flows.dissipated, flows.wall_work, flows.lifted].map(f64::to_bits);
    (state_hash::of_world(world), books, counts)
}

/// A spawner, with a discharge; friction between moving walls and periodic sides; gravity along those, in solid space; and
/// centred contacts with all of it, and without.
const SCENES: [(&str, &[(&str, &str)], u64); 5] = [
    ("silo1.ron", &[("spawner.count", "20"), ("door.opens", "At(2.5)")], 3200),
    ("couette.ron", &[("integrator", "Verlet")], 200),
    ("couette.ron", &[("integrator", "Centred")], 200),
    ("chute3d.ron", &[("integrator", "Verlet")], 300),
    ("chute3d.ron", &[("integrator", "Centred")], 300),
];
