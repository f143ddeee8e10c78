//! Writes grain files row by row, in ascending order of ids.

use std::io;

use bevy_ecs::prelude::*;

use crate::grains::grain_snapshot;
use crate::space::{Dimension, Linear, Solid, Space};

/// Returns the grains of a world as the text of a grain file, in ascending order of ids.
pub fn write<V: Space>(world: &mut World) -> String {
    let mut text = Vec::new();
    // Writing to memory cannot fail, and numbers are ASCII.
    let _ = write_to::<V>(world, &mut text);
    String::from_utf8(text).unwrap_or_default()
}

/// Writes the grains of a world to `out` as a grain file, in ascending order of ids.
///
/// # Errors
/// If `out` cannot be written to.
pub fn write_to<V: Space>(world: &mut World, out: &mut dyn io::Write) -> io::Result<()> {
    let spins = grain_snapshot::has_spins::<V>(world);
    let is_solid = V::DIMENSION == Dimension::Solid;
    let columns = if is_solid { "id,radius,mass,x,y,z,vx,vy,vz,species" } else { "id,radius,mass,x,y,vx,vy,species" };
    let more = match (spins, is_solid) {
        (false, _) => "",
        (true, true) => ",wx,wy,wz",
        (true, false) => ",wz",
    };
    writeln!(out, "{columns}{more}")?;
    grain_snapshot::take::<V, _>(world, |grain| {
        write!(out, "{},{},{}", grain.id.number(), grain.radius, grain.mass)?;
        for number in grain.position.components().into_iter().chain(grain.velocity.components()) {
            write!(out, ",{number}")?;
        }
        write!(out, ",{}", grain.species.0)?;
        let spin = grain.spin.map_or(Solid::ZERO, Linear::spread);
        for number in spin.to_array().into_iter().skip(if is_solid { 0 } else { 2 }).filter(|_| spins) {
            write!(out, ",{number}")?;
        }
        writeln!(out)
    })
}
