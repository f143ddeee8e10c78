//! Physical laws. Each test compares siloflow with an independent reference: a closed form, a conserved quantity, an
//! order of convergence or another program. Tolerances are derived from theory beside their assertions.

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

mod accuracy;
mod adhesion;
mod automatic;
mod bodies;
mod bounce;
mod channels;
mod clumps;
mod column;
mod conservation;
mod crowd;
mod fields;
mod free_fall;
mod free_walls;
mod friction;
mod grazing;
mod growth;
mod hertz;
mod hertz_curved;
mod hertz_restitution;
mod jkr;
mod lammps;
mod matrix;
mod mfix;
mod mfix_pair;
mod mfix_rolling;
mod mindlin_damping;
mod momentum;
mod moving_walls;
mod oblique;
mod oracle;
mod periodic_walls;
mod ride;
mod rolling_resistance;
mod same_bits;
mod schemes;
mod seams;
mod shear;
mod sheared_bed;
mod spring_slider;
mod symmetry;
mod twisting;
mod wall_shapes;

use std::num::NonZeroUsize;
use std::path::Path;

use siloflow::dem::space::{Dimension, Linear, Solid as DVec3};
use siloflow::grains::file::GrainRow;
use siloflow::prelude::*;

/// Returns a planar grain with the given id, centre, velocity, radius and mass.
pub fn grain(id: u32, position: Vector, velocity: Vector, radius: f64, mass: f64) -> GrainRow {
    sphere(id, position.extend(0.0), velocity.extend(0.0), radius, mass)
}

/// Returns a sphere in solid space with the given id, centre, velocity, radius and mass.
pub fn sphere(id: u32, position: DVec3, velocity: DVec3, radius: f64, mass: f64) -> GrainRow {
    let id = GrainId::grain(id).unwrap();
    GrainRow { id, radius, mass, position, velocity, spin: DVec3::ZERO, posture: None, species: Species(0) }
}

/// Returns a single-threaded simulation of the scene with the keys `keys` and these grains.
pub fn simulation(keys: &str, grains: Vec<GrainRow>) -> Simulation {
    simulation_on(1, keys, grains)
}

/// Like [`simulation`], but on `threads` threads.
pub fn simulation_on(threads: usize, keys: &str, grains: Vec<GrainRow>) -> Simulation {
    simulation_with(threads, keys, grains, |_| {})
}

/// As [`simulation_on`], with more systems.
pub fn simulation_with(threads: usize, keys: &str, grains: Vec<GrainRow>, more: impl FnOnce(&mut App)) -> Simulation {
    let text = format!("({keys}, pictures: None)");
    let mut loaded =
        load::from_text("test.ron", "test", Path::new(""), text, &[]).unwrap_or_else(|fault| panic!("{fault}\n{keys}"));
    loaded.grains = grains;
    Simulation::with_plugins(&loaded, &Registry::default(), NonZeroUsize::new(threads).unwrap(), more).unwrap()
}

/// Position, velocity and spin of a grain. In the plane z is 0 and the spin is along z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    pub position: DVec3,
    pub velocity: DVec3,
    pub spin: DVec3,
}

/// Returns the motion of each grain, sorted by id, in either space.
pub fn motion(simulation: &mut Simulation) -> Vec<Motion> {
    match Dimension::of_world(simulation.world()) {
        Dimension::Plane => motion_in::<Plane>(simulation),
        Dimension::Solid => motion_in::<Solid>(simulation),
    }
}

fn motion_in<V: Space>(simulation: &mut Simulation) -> Vec<Motion> {
    type Row<'a, V> = (&'a GrainId, &'a Position<V>, &'a Velocity<V>, Option<&'a Spin<<V as Space>::Spin>>);
    let world = simulation.world_mut();
    let mut query = world.query_filtered::<Row<V>, With<Grain>>();
    let mut rows: Vec<_> = query.iter(world).map(|(id, x, v, w)| (*id, x.0, v.0, w.copied())).collect();
    rows.sort_unstable_by_key(|row| row.0);
    let spread = |w: Option<Spin<V::Spin>>| w.map_or(DVec3::ZERO, |w| w.0.spread());
    let all = rows.into_iter();
    all.map(|(_, x, v, w)| Motion { position: x.spread(), velocity: v.spread(), spin: spread(w) }).collect()
}

/// Returns position and velocity of each grain of a planar scene, sorted by id.
pub fn state(simulation: &mut Simulation) -> Vec<(Vector, Vector)> {
    let world = simulation.world_mut();
    let mut query = world.query_filtered::<(&GrainId, &Position, &Velocity), With<Grain>>();
    let mut rows: Vec<_> = query.iter(world).map(|(id, x, v)| (*id, x.0, v.0)).collect();
    rows.sort_unstable_by_key(|row| row.0);
    rows.into_iter().map(|(_, x, v)| (x, v)).collect()
}

/// Returns the root mean square.
pub fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}
