//! Grain files: CSV with one grain a row, read by the scene's `grains` and written as `state.csv`.
//!
//! Columns, found by name: `id` (whole, unique), `radius` (m), `mass` (kg), `x`, `y` (m), `vx`, `vy` (m/s), in solid space
//! `z` and `vz` as well; and, if wanted, `species` (whole, default 0) and the spin (rad/s, default 0), `wz` in the plane,
//! `wx`, `wy` and `wz` in space. A planar scene accepts the other columns of solid space if they are zero throughout, and
//! one without friction those of the spin. Numbers are written with as many digits as they need to be read back to the
//! same bits.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use bevy_ecs::prelude::*;
use csv::{ReaderBuilder, StringRecord};
use serde::{Deserialize, Serialize};

use crate::fault::Fault;
use crate::particle::{Force, Grain, GrainBundle, GrainId, Mass, Particle, Position, Radius, Species, Velocity};
use crate::space::{Dimension, Linear, Solid, Space};
use crate::spin::Spin;

/// The scene's `grains`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct GrainFile {
    /// Path of the CSV file, relative to the scene file.
    pub file: PathBuf,
}

/// One row, SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrainRow {
    /// Name.
    pub id: GrainId,
    /// Radius, m.
    pub radius: f64,
    /// Mass, kg.
    pub mass: f64,
    /// Centre, m; in the plane, z is 0.
    pub position: Solid,
    /// Velocity, m/s.
    pub velocity: Solid,
    /// Spin, rad/s; in the plane, along z.
    pub spin: Solid,
    /// Kind.
    pub species: Species,
}

impl GrainRow {
    /// The grain as an entity's components; its force is evaluated in step zero.
    #[must_use]
    pub fn bundle<V: Space>(&self) -> GrainBundle<V> {
        GrainBundle {
            particle: Particle {
                id: self.id,
                position: Position(V::narrow(self.position)),
                velocity: Velocity(V::narrow(self.velocity)),
                force: Force(V::ZERO),
                radius: Radius(self.radius),
            },
            mass: Mass(self.mass),
            species: self.species,
            grain: Grain,
        }
    }
}

const ALWAYS: [&str; 7] = ["id", "radius", "mass", "x", "y", "vx", "vy"];
const IN_SPACE: [&str; 2] = ["z", "vz"];
const SPIN: [&str; 3] = ["wx", "wy", "wz"];

/// What the scene has, and so what a file may have.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Plane or solid.
    pub dimension: Dimension,
    /// Whether grains spin.
    pub spins: bool,
}

impl Kind {
    fn is_solid(self) -> bool {
        self.dimension == Dimension::Solid
    }

    fn needed(self) -> impl Iterator<Item = &'static str> {
        ALWAYS.into_iter().chain(IN_SPACE.into_iter().filter(move |_| self.is_solid()))
    }

    /// Columns that may be there, but say nothing.
    fn must_be_zero(self, column: &str) -> bool {
        match column {
            "z" | "vz" => !self.is_solid(),
            "wx" | "wy" => !(self.is_solid() && self.spins),
            "wz" => !self.spins,
            _ => false,
        }
    }
}

/// Reads a grain file's text. `name` is the file's name in messages.
///
/// # Errors
/// If a column is missing or unknown, or a value not in range; the fault points at line and column.
pub fn parse(name: &str, text: &str, kind: Kind) -> Result<Vec<GrainRow>, Fault> {
    rows(text.as_bytes(), kind).map_err(|misfit| misfit.fault(name, text))
}

/// The same of the file at `path`, whose text is never held as a whole: it is longer than the grains that it tells of.
///
/// # Errors
/// If it cannot be read; within that, as [`parse`].
pub fn read(name: &str, path: &Path, kind: Kind) -> io::Result<Result<Vec<GrainRow>, Fault>> {
    match rows(File::open(path)?, kind) {
        Ok(rows) => Ok(Ok(rows)),
        Err(Misfit { at: At::Nowhere(error), .. }) => Err(error),
        // Read again, to show the place.
        Err(misfit) => Ok(Err(misfit.fault(name, &String::from_utf8_lossy(&fs::read(path)?)))),
    }
}

fn rows(source: impl io::Read, kind: Kind) -> Result<Vec<GrainRow>, Misfit> {
    let mut reader = ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_reader(source);
    let header = reader.headers().map_err(Misfit::syntax)?.clone();
    check_header(&header, kind)?;
    let (mut seen, mut rows, mut record) = (BTreeSet::new(), Vec::new(), StringRecord::new());
    while reader.read_record(&mut record).map_err(Misfit::syntax)? {
        let line = Line { header: &header, record: &record, kind };
        let row = line.grain()?;
        if !seen.insert(row.id) {
            return Err(line.misfit(
                "grain_file::duplicate_id",
                "id",
                format!("the id {} occurs twice", row.id.number()),
            ));
        }
        rows.push(row);
    }
    rows.shrink_to_fit();
    Ok(rows)
}

fn check_header(header: &StringRecord, kind: Kind) -> Result<(), Misfit> {
    let misfit = |code, message: String| {
        let needed: Vec<_> = kind.needed().collect();
        let help = format!("the columns are {} and, if wanted, species, wx, wy, wz", needed.join(", "));
        Err(Misfit { code, message, help, at: At::Header })
    };
    if let Some(missing) = kind.needed().find(|&column| !header.iter().any(|found| found == column)) {
        return misfit("grain_file::missing_column", format!("the column `{missing}` is missing"));
    }
    let known = |column: &str| {
        ALWAYS.contains(&column) || IN_SPACE.contains(&column) || SPIN.contains(&column) || column == "species"
    };
    if let Some(unknown) = header.iter().find(|column| !known(column)) {
        return misfit("grain_file::unknown_column", format!("there is no column `{unknown}`"));
    }
    Ok(())
}

/// What is wrong with a file: a fault, once its text is at hand to show the place.
struct Misfit {
    code: &'static str,
    message: String,
    help: String,
    at: At,
}

enum At {
    /// The file cannot be read.
    Nowhere(io::Error),
    Header,
    /// Counted from the beginning.
    Byte(usize),
    /// A column, in the order of the file, of the record that begins at this byte.
    Cell(usize, usize),
}

impl Misfit {
    fn syntax(error: csv::Error) -> Self {
        let at = position(error.position());
        let message = format!("this is not CSV: {error}");
        let at = match error.into_kind() {
            csv::ErrorKind::Io(error) => At::Nowhere(error),
            _ => At::Byte(at),
        };
        Self { code: "grain_file::syntax", message, help: "separate values by commas".to_owned(), at }
    }

    fn fault(self, name: &str, text: &str) -> Fault {
        let place = match self.at {
            At::Nowhere(_) => 0..0,
            At::Header => 0..text.find('\n').unwrap_or(text.len()),
            At::Byte(at) => {
                let at = text.floor_char_boundary(at);
                at..at
            }
            At::Cell(record, column) => cell(text, text.floor_char_boundary(record), column),
        };
        Fault::new(self.code, self.message).help(self.help).at(name, text, place)
    }
}

fn position(position: Option<&csv::Position>) -> usize {
    position.and_then(|position| usize::try_from(position.byte()).ok()).unwrap_or(0)
}

/// The place of a column in the record that begins at `from`.
fn cell(text: &str, from: usize, column: usize) -> Range<usize> {
    // A record starts where the one before it ended; skip the line break in between.
    let from = from + text[from..].len() - text[from..].trim_start().len();
    let line = &text[from..from + text[from..].find('\n').unwrap_or(text.len() - from)];
    let start: usize = line.split(',').take(column).map(|cell| cell.len() + 1).sum();
    let start = start.min(line.len());
    let length = line[start..].find(',').unwrap_or(line.len() - start);
    from + start..from + start + length
}

struct Line<'a> {
    header: &'a StringRecord,
    record: &'a StringRecord,
    kind: Kind,
}

impl Line<'_> {
    fn value(&self, column: &str) -> Option<&str> {
        self.record.get(self.header.iter().position(|found| found == column)?)
    }

    fn misfit(&self, code: &'static str, column: &str, message: String) -> Misfit {
        let index = self.header.iter().position(|found| found == column).unwrap_or(0);
        Misfit {
            code,
            message: format!("column `{column}`: {message}"),
            help: "one grain a row; numbers in SI units".to_owned(),
            at: At::Cell(position(self.record.position()), index),
        }
    }

    fn number(&self, column: &str, holds: impl Fn(f64) -> bool, expected: &str) -> Result<f64, Misfit> {
        let found = self.value(column).unwrap_or("");
        match found.parse::<f64>() {
            Ok(number) if number.is_finite() && holds(number) => Ok(number),
            _ => Err(self.misfit("grain_file::value", column, format!("expected {expected}, got `{found}`"))),
        }
    }

    fn grain(&self) -> Result<GrainRow, Misfit> {
        let any = |column| self.number(column, |_| true, "a finite number");
        let positive = |column| self.number(column, |x| x > 0.0, "a number greater than 0");
        let id = self.value("id").and_then(|id| id.parse().ok()).and_then(GrainId::grain).ok_or_else(|| {
            let found = self.value("id").unwrap_or("");
            let message = format!("expected a whole number from 0 to {}, got `{found}`", GrainId::MAX_GRAIN);
            self.misfit("grain_file::value", "id", message)
        })?;
        let has = |column: &str| self.value(column).is_some();
        for column in IN_SPACE.into_iter().chain(SPIN).filter(|column| self.kind.must_be_zero(column) && has(column)) {
            self.number(column, |x| x == 0.0, "0, for this scene is planar or its grains do not spin")?;
        }
        let or_zero = |column: &'static str| if has(column) { any(column) } else { Ok(0.0) };
        let species = match self.value("species") {
            None => 0,
            Some(found) => found.parse().map_err(|_| {
                let message = format!("expected a whole number from 0 to 255, got `{found}`");
                self.misfit("grain_file::value", "species", message)
            })?,
        };
        Ok(GrainRow {
            id,
            radius: positive("radius")?,
            mass: positive("mass")?,
            position: Solid::new(any("x")?, any("y")?, or_zero("z")?),
            velocity: Solid::new(any("vx")?, any("vy")?, or_zero("vz")?),
            spin: Solid::new(or_zero("wx")?, or_zero("wy")?, or_zero("wz")?),
            species: Species(species),
        })
    }
}

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
///
/// # Panics
/// Never: a text can be written to.
pub fn write<V: Space>(world: &mut World) -> String {
    let mut text = Vec::new();
    write_to::<V>(world, &mut text).expect("memory can be written to");
    String::from_utf8(text).expect("numbers are ASCII")
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Plane;

    const PLANE: Kind = Kind { dimension: Dimension::Plane, spins: false };

    #[test]
    fn what_is_written_is_read_back_to_the_same_bits() {
        let text =
            "id,radius,mass,x,y,vx,vy,species\n1,0.1,0.3,0.30000000000000004,-1e-300,5e-324,-0,0\n7,1,2,3,4,5,6,255\n";
        let mut world = World::new();
        let rows = parse("a.csv", text, PLANE).unwrap();
        world.spawn_batch(rows.iter().rev().map(GrainRow::bundle::<Plane>).collect::<Vec<_>>());
        let again = parse("b.csv", &write::<Plane>(&mut world), PLANE).unwrap();
        assert_eq!(again, rows);
        assert!(again[0].velocity.y.is_sign_negative());
    }

    #[test]
    fn so_are_spinning_spheres() {
        let kind = Kind { dimension: Dimension::Solid, spins: true };
        let text = "id,radius,mass,x,y,z,vx,vy,vz,species,wx,wy,wz\n4,0.1,0.3,1,2,3,4,5,6,1,7,8,0.1\n";
        let mut world = World::new();
        for row in parse("a.csv", text, kind).unwrap() {
            world.spawn((row.bundle::<Solid>(), Spin(row.spin)));
        }
        assert_eq!(write::<Solid>(&mut world), text);
    }

    #[test]
    fn names_the_place_of_what_is_wrong() {
        let cases = [
            ("id,radius,mass,x,y,vx\n", "grain_file::missing_column", (1, 1)),
            ("id,radius,mass,x,y,vx,vy,spin\n", "grain_file::unknown_column", (1, 1)),
            ("id,radius,mass,x,y,vx,vy\n1,1,1,0,0,0,0\n2,-1,1,0,0,0,0\n", "grain_file::value", (3, 3)),
            ("id,radius,mass,x,y,vx,vy\n1,1,1,0,0,0,inf\n", "grain_file::value", (2, 13)),
            ("id,radius,mass,x,y,vx,vy\n1,1,1,0,0\n", "grain_file::value", (2, 10)),
            ("id,radius,mass,x,y,vx,vy\n-1,1,1,0,0,0,0\n", "grain_file::value", (2, 1)),
            ("id,radius,mass,x,y,vx,vy,wz\n1,1,1,0,0,0,0,2\n", "grain_file::value", (2, 15)),
            ("id,radius,mass,x,y,vx,vy\n3,1,1,0,0,0,0\n3,1,1,9,0,0,0\n", "grain_file::duplicate_id", (3, 1)),
        ];
        for (text, code, place) in cases {
            let fault = parse("bad.csv", text, PLANE).unwrap_err();
            assert_eq!((fault.code(), fault.line_and_column()), (code, Some(place)), "{text:?}: {fault}");
        }
        let spinning = Kind { spins: true, ..PLANE };
        assert!(parse("good.csv", cases[6].0, spinning).is_ok());
        let solid = Kind { dimension: Dimension::Solid, ..PLANE };
        assert_eq!(parse("flat.csv", cases[7].0, solid).unwrap_err().code(), "grain_file::missing_column");
    }
}
