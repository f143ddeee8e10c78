//! Physical laws, each against something that is not siloflow: a closed form, a conserved quantity, an order of
//! convergence, another program. Tolerances come from theory and stand beside their assertion.

#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    clippy::float_cmp,
    clippy::missing_panics_doc,
    clippy::must_use_candidate,
    clippy::unwrap_used,
    clippy::similar_names,
    missing_docs,
    reason = "tests count in small numbers and compare exact values"
)]

mod bounce;
mod column;
mod conservation;
mod free_fall;
mod lammps;

use std::num::NonZeroUsize;
use std::path::Path;

use siloflow::grains::file::GrainRow;
use siloflow::prelude::*;

/// A grain of a test: id, centre, velocity, radius, mass.
pub fn grain(id: u32, position: Vector, velocity: Vector, radius: f64, mass: f64) -> GrainRow {
    GrainRow { id: GrainId::grain(id).unwrap(), radius, mass, position, velocity, species: Species(0) }
}

/// A simulation of the scene whose keys are `keys`, with these grains.
pub fn simulation(keys: &str, grains: Vec<GrainRow>) -> Simulation {
    let text = format!("({keys}, pictures: None)");
    let mut loaded =
        load::from_text("test.ron", "test", Path::new(""), text, &[]).unwrap_or_else(|fault| panic!("{fault}\n{keys}"));
    loaded.grains = grains;
    Simulation::new(&loaded, &Registry::default(), NonZeroUsize::MIN).unwrap()
}

/// Position and velocity of each grain, by id.
pub fn state(simulation: &mut Simulation) -> Vec<(Vector, Vector)> {
    let world = simulation.world_mut();
    let mut query = world.query_filtered::<(&GrainId, &Position, &Velocity), With<Grain>>();
    let mut rows: Vec<_> = query.iter(world).map(|(id, x, v)| (*id, x.0, v.0)).collect();
    rows.sort_unstable_by_key(|row| row.0);
    rows.into_iter().map(|(_, x, v)| (x, v)).collect()
}

/// Root of the mean of squares.
pub fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}
