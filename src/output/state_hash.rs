//! `state_hash`: one number for the state of a run, to compare runs to the last bit.
//!
//! FNV-1a, 64 bits, over the grains (not the walls) in ascending order of id; for each, in this order, the id as 4
//! bytes and then, as the 8 bytes of the double, x, y, v_x, v_y, radius and mass (in solid space x, y, z, v_x, v_y, v_z,
//! radius, mass), and where grains spin the spin (one component in the plane, three in space), all little-endian.
//! Positions and velocities are those of the last full step.

use bevy_ecs::prelude::*;

use crate::grains::file::by_id;
use crate::particle::{Grain, GrainId, Mass, Position, Radius, Velocity};
use crate::space::{Dimension, Linear, Plane, Solid, Space};
use crate::spin::Spin;

/// The hash of a world's grains.
pub fn of_world(world: &mut World) -> u64 {
    match Dimension::of_world(world) {
        Dimension::Plane => of::<Plane>(world),
        Dimension::Solid => of::<Solid>(world),
    }
}

type Row<'a, V> =
    (&'a GrainId, &'a Position<V>, &'a Velocity<V>, &'a Radius, &'a Mass, Option<&'a Spin<<V as Space>::Spin>>);

fn of<V: Space>(world: &mut World) -> u64 {
    let mut grains = world.query_filtered::<Row<V>, With<Grain>>();
    let mut hash = Fnv::default();
    for entity in by_id(world) {
        let Ok((id, x, v, radius, mass, spin)) = grains.get(world, entity) else { continue };
        hash.eat(&id.number().to_le_bytes());
        let mut numbers = x.0.components();
        numbers.extend(v.0.components());
        numbers.extend([radius.0, mass.0]);
        if let Some(spin) = spin {
            let components = spin.0.spread().to_array();
            numbers.extend(if V::DIMENSION == Dimension::Plane { &components[2..] } else { &components[..] });
        }
        for number in numbers {
            hash.eat(&number.to_le_bytes());
        }
    }
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
