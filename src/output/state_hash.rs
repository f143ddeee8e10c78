//! `state_hash`: one number for the state of a run, to compare runs to the last bit.
//!
//! FNV-1a, 64 bits, over the grains (not the walls) in ascending order of id; for each, in this order, the id as 4
//! bytes and then, as the 8 bytes of the double, x, y, v_x, v_y, radius and mass (in solid space x, y, z, v_x, v_y, v_z,
//! radius, mass), and where grains spin the spin (one component in the plane, three in space), all little-endian.
//! Positions and velocities are those of the last full step.

use std::convert::Infallible;

use bevy_ecs::prelude::*;

use crate::grains::grain_snapshot;
use crate::space::{Dimension, Linear, Plane, Solid, Space};
use crate::writers::fnv::Fnv;

/// The hash of a world's grains.
pub fn of_world(world: &mut World) -> u64 {
    match Dimension::of_world(world) {
        Dimension::Plane => of::<Plane>(world),
        Dimension::Solid => of::<Solid>(world),
    }
}

fn of<V: Space>(world: &mut World) -> u64 {
    let mut hash = Fnv::default();
    let Ok(()) = grain_snapshot::take::<V, Infallible>(world, |grain| {
        hash.eat(&grain.id.number().to_le_bytes());
        let mut numbers = grain.position.components();
        numbers.extend(grain.velocity.components());
        numbers.extend([grain.radius, grain.mass]);
        if let Some(spin) = grain.spin {
            let components = spin.spread().to_array();
            numbers.extend(if V::DIMENSION == Dimension::Plane { &components[2..] } else { &components[..] });
        }
        for number in numbers {
            hash.eat(&number.to_le_bytes());
        }
        Ok(())
    });
    hash.value()
}
