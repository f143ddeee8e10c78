//! Writes grain files row by row, in ascending order of ids.

use std::io;

use bevy_ecs::prelude::*;

use crate::grains::file::{self, GrainRow};
use crate::grains::grain_snapshot;
use siloflow_dem::math;
use siloflow_dem::space::{Dimension, Linear, Quaternion, Rotor, Solid, Space};
use siloflow_dem::store::ParticleStore;
use siloflow_files::columns::Cell::{Empty, Plain, Text, Whole};
use siloflow_files::columns::{Cell, Column, Columns};
use siloflow_text::fault::Fault;

/// The columns of a grain file. A scene reads them.
pub(crate) const COLUMNS: &[Column<GrainRow>] = &[
    Column::new("id", "", "id, unique", |grain| Whole(grain.id.number().into())),
    Column::new("radius", "m", "radius", |grain| Plain(grain.radius)),
    Column::new("mass", "kg", "mass", |grain| Plain(grain.mass)),
    Column::new("x", "m", "centre", |grain| Plain(grain.position.x)),
    Column::new("y", "m", "centre", |grain| Plain(grain.position.y)),
    Column::solid("z", "m", "centre", |grain| Plain(grain.position.z)),
    Column::new("vx", "m/s", "velocity", |grain| Plain(grain.velocity.x)),
    Column::new("vy", "m/s", "velocity", |grain| Plain(grain.velocity.y)),
    Column::solid("vz", "m/s", "velocity", |grain| Plain(grain.velocity.z)),
    Column::new("species", "", "species", |grain| Whole(grain.species.0.into())),
];

const SPIN: &str = "spin; absent if grains do not spin";

/// The columns of the spin, which follow if grains spin.
pub(crate) const SPINS: &[Column<GrainRow>] = &[
    Column::solid("wx", "rad/s", SPIN, |grain| Plain(grain.spin.x)),
    Column::solid("wy", "rad/s", SPIN, |grain| Plain(grain.spin.y)),
    Column::new("wz", "rad/s", SPIN, |grain| Plain(grain.spin.z)),
];

/// The shape of a grain in a row.
pub(crate) struct ShapeCells {
    name: String,
    /// The orientation of the shape as the scene describes it.
    rotor: Quaternion,
}

const NAME: &str = "name of the shape, empty for a sphere (disc); these columns are absent in a scene without `shapes`";
const ORIENTATION: &str = "orientation of the shape as the scene describes it, empty for a sphere (disc)";

/// The columns of shapes, which follow if the scene has shapes.
pub(crate) const SHAPES: &[Column<Option<ShapeCells>>] = &[
    Column::new("shape", "", NAME, |shape| shape.as_ref().map_or(Empty, |shape| Text(&shape.name))),
    Column::planar("angle", "rad", ORIENTATION, |shape| of(shape.as_ref(), |q| 2.0 * math::atan2(q.z, q.w))),
    Column::solid("qw", "", ORIENTATION, |shape| of(shape.as_ref(), |q| q.w)),
    Column::solid("qx", "", ORIENTATION, |shape| of(shape.as_ref(), |q| q.x)),
    Column::solid("qy", "", ORIENTATION, |shape| of(shape.as_ref(), |q| q.y)),
    Column::solid("qz", "", ORIENTATION, |shape| of(shape.as_ref(), |q| q.z)),
];

fn of(shape: Option<&ShapeCells>, number: fn(Quaternion) -> f64) -> Cell<'static> {
    shape.map_or(Empty, |shape| Plain(number(shape.rotor)))
}

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
    let spins = if grain_snapshot::has_spins::<V>(world) { SPINS } else { &[] };
    let is_solid = V::DIMENSION == Dimension::Solid;
    let columns = Columns::of(is_solid, &[COLUMNS, spins]);
    let of_shapes = Columns::of(is_solid, &[SHAPES]);
    let shapes = world.get_resource::<ParticleStore<V>>().map(|store| store.bodies.shapes.clone()).unwrap_or_default();
    let header = columns.header();
    if shapes.is_empty() {
        writeln!(out, "{header}")?;
    } else {
        writeln!(out, "{header},{}", of_shapes.header())?;
    }
    grain_snapshot::take::<V, _>(world, |grain| {
        let row = GrainRow {
            id: grain.id,
            radius: grain.radius,
            mass: grain.mass,
            position: grain.position.spread(),
            velocity: grain.velocity.spread(),
            spin: grain.spin.map_or(Solid::ZERO, Linear::spread),
            posture: None,
            species: grain.species,
        };
        if shapes.is_empty() {
            return writeln!(out, "{}", columns.cells(&row));
        }
        let shape = grain.shape.and_then(|(shape, rotor)| {
            let shape = shapes.get(shape.index())?;
            let rotor = rotor.to_quaternion() * shape.axes.to_quaternion().conjugate();
            Some(ShapeCells { name: shape.name.clone(), rotor })
        });
        writeln!(out, "{},{}", columns.cells(&row), of_shapes.cells(&shape))
    })
}

/// Returns the text of a grain file without its columns of spins, and the number of grains that spin.
///
/// # Errors
/// If the text is not CSV.
pub fn without_spin(text: &str) -> Result<(String, usize), Fault> {
    let failed = |error: csv::Error| Fault::new("grain_file::syntax", format!("this is not CSV: {error}"));
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let of_spin: Vec<_> = reader.headers().map_err(failed)?.iter().map(|column| file::SPIN.contains(&column)).collect();
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
