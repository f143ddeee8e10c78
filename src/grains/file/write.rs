//! Writes grain files row by row, in ascending order of ids.

use std::io;

use bevy_ecs::prelude::*;

use crate::grains::file::SPIN;
use crate::grains::grain_snapshot;
use siloflow_dem::space::{Dimension, Linear, Solid, Space};
use siloflow_text::fault::Fault;

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

/// Returns the text of a grain file without its columns of spins, and the number of grains that spin.
///
/// # Errors
/// If the text is not CSV.
pub fn without_spin(text: &str) -> Result<(String, usize), Fault> {
    let failed = |error: csv::Error| Fault::new("grain_file::syntax", format!("this is not CSV: {error}"));
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let of_spin: Vec<_> = reader.headers().map_err(failed)?.iter().map(|column| SPIN.contains(&column)).collect();
    let is_spin = |column: usize| of_spin.get(column).copied().unwrap_or(false);
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut spinning = 0;
    for (number, record) in std::iter::once(reader.headers().cloned()).chain(reader.records()).enumerate() {
        let record = record.map_err(failed)?;
        let turns = |(column, value): (usize, &str)| is_spin(column) && value.parse::<f64>() != Ok(0.0);
        spinning += usize::from(number > 0 && record.iter().enumerate().any(turns));
        let rest = record.iter().enumerate().filter(|&(column, _)| !is_spin(column)).map(|(_, value)| value);
        writer.write_record(rest).map_err(failed)?;
    }
    let bytes = writer.into_inner().unwrap_or_default();
    Ok((String::from_utf8(bytes).unwrap_or_default(), spinning))
}
