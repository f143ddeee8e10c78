//! `state_hash`: a hash of the state of a run, for bitwise comparison of runs.
//!
//! The hash is 64-bit FNV-1a over the grains (not the walls) in ascending order of id. For each grain it covers the
//! following values in this order, all little-endian:
//!
//! * the id, 4 bytes;
//! * x, y, v_x, v_y, radius and mass (in solid space x, y, z, v_x, v_y, v_z, radius, mass), 8 bytes each;
//! * the spin, if grains spin (one component in the plane, three in solid space), 8 bytes each.
//!
//! Positions and velocities are the values after the last full step.

use std::convert::Infallible;

use bevy_ecs::prelude::*;

use crate::grains::grain_snapshot;
use siloflow_dem::space::{Dimension, Linear, Plane, Solid, Space};
use siloflow_files::fnv::Fnv;

/// Returns the hash of a world's grains.
pub fn of_world(world: &mut World) -> u64 {
    match Dimension::of_world(world) {
        Dimension::Plane => of::<Plane>(world),
        Dimension::Solid => of::<Solid>(world),
    }
}

fn of<V: Space>(world: &mut World) -> u64 {
    let mut hash = Fnv::default();
    let Ok(()) = grain_snapshot::take::<V, Infallible>(world, |grain| {
        hash.update(&grain.id.number().to_le_bytes());
        let mut numbers = grain.position.components();
        numbers.extend(grain.velocity.components());
        numbers.extend([grain.radius, grain.mass]);
        if let Some(spin) = grain.spin {
            let components = spin.spread().to_array();
            numbers.extend(if V::DIMENSION == Dimension::Plane { &components[2..] } else { &components[..] });
        }
        for number in numbers {
            hash.update(&number.to_le_bytes());
        }
        Ok(())
    });
    hash.value()
}
