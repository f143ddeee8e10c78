//! `state_hash`: one number for the state of a run, to compare runs to the last bit.
//!
//! FNV-1a, 64 bits, over the grains (not the walls) in ascending order of id; for each, in this order, the id as 4
//! bytes and then, as the 8 bytes of the double, x, y, v_x, v_y, radius and mass (in solid space x, y, z, v_x, v_y, v_z,
//! radius, mass), and where grains spin the spin (one component in the plane, three in space), all little-endian.
//! Positions and velocities are those of the last full step.

use std::convert::Infallible;

use bevy_ecs::prelude::*;

use crate::grains::census;
use crate::space::{Dimension, Linear, Plane, Solid, Space};

/// The hash of a world's grains.
pub fn of_world(world: &mut World) -> u64 {
    match Dimension::of_world(world) {
        Dimension::Plane => of::<Plane>(world),
        Dimension::Solid => of::<Solid>(world),
    }
}

fn of<V: Space>(world: &mut World) -> u64 {
    let mut hash = Fnv::default();
    let Ok(()) = census::take::<V, Infallible>(world, |grain| {
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
    hash.0
}

/// FNV-1a, 64 bits.
pub struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    /// The hash so far.
    #[must_use]
    pub fn value(&self) -> u64 {
        self.0
    }

    /// Takes more bytes.
    pub fn eat(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fnv_1a_gives_its_published_values() {
        for (text, expected) in
            [("", 0xcbf2_9ce4_8422_2325), ("a", 0xaf63_dc4c_8601_ec8c), ("foobar", 0x8594_4171_f739_67e8)]
        {
            let mut hash = Fnv::default();
            hash.eat(text.as_bytes());
            assert_eq!(hash.0, expected);
        }
    }
}
