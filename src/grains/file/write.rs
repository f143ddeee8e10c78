//! Writing a grain file: row by row, in ascending order of id.

use std::io;

use bevy_ecs::prelude::*;

use crate::particle::{Grain, GrainId, Mass, Position, Radius, Species, Velocity};
use crate::space::{Dimension, Linear, Solid, Space};
use crate::spin::Spin;

type Row<'a, V> = (
    &'a GrainId,
    &'a Radius,
    &'a Mass,
    &'a Position<V>,
    &'a Velocity<V>,
    &'a Species,
    Option<&'a Spin<<V as Space>::Spin>>,
);

/// The grains of a world as such a file, in ascending order of id.
pub fn write<V: Space>(world: &mut World) -> String {
    let mut text = Vec::new();
    // Writing to memory cannot fail, and numbers are ASCII.
    let _ = write_to::<V>(world, &mut text);
    String::from_utf8(text).unwrap_or_default()
}

/// The same, to a file.
///
/// # Errors
/// If that cannot be written to.
pub fn write_to<V: Space>(world: &mut World, out: &mut dyn io::Write) -> io::Result<()> {
    let mut grains = world.query_filtered::<Row<V>, With<Grain>>();
    let spins = grains.iter(world).any(|row| row.6.is_some());
    let is_solid = V::DIMENSION == Dimension::Solid;
    let columns = if is_solid { "id,radius,mass,x,y,z,vx,vy,vz,species" } else { "id,radius,mass,x,y,vx,vy,species" };
    let more = match (spins, is_solid) {
        (false, _) => "",
        (true, true) => ",wx,wy,wz",
        (true, false) => ",wz",
    };
    writeln!(out, "{columns}{more}")?;
    for entity in by_id(world) {
        let Ok((id, radius, mass, x, v, species, spin)) = grains.get(world, entity) else { continue };
        write!(out, "{},{},{}", id.number(), radius.0, mass.0)?;
        for number in x.0.components().into_iter().chain(v.0.components()) {
            write!(out, ",{number}")?;
        }
        write!(out, ",{}", species.0)?;
        let spin = spin.map_or(Solid::ZERO, |spin| spin.0.spread());
        for number in spin.to_array().into_iter().skip(if is_solid { 0 } else { 2 }).filter(|_| spins) {
            write!(out, ",{number}")?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// The grains of a world in ascending order of id.
pub(crate) fn by_id(world: &mut World) -> impl Iterator<Item = Entity> + use<> {
    let mut grains: Vec<_> = world
        .query_filtered::<(&GrainId, Entity), With<Grain>>()
        .iter(world)
        .map(|(id, entity)| (*id, entity))
        .collect();
    grains.sort_unstable_by_key(|grain| grain.0);
    grains.into_iter().map(|(_, entity)| entity)
}
