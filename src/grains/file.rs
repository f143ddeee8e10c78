//! Grain files: CSV with one grain a row, read by the scene's `grains` and written as `state.csv`.
//!
//! Columns, found by name: `id` (whole, unique), `radius` (m), `mass` (kg), `x`, `y` (m), `vx`, `vy` (m/s), and, if
//! wanted, `species` (whole, default 0). Files of programs in three dimensions are accepted as they are if `z`, `vz`,
//! `wx`, `wy` and `wz` are zero throughout. Numbers are written with as many digits as they need to be read back to
//! the same bits.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::PathBuf;

use bevy_ecs::prelude::*;
use csv::{ReaderBuilder, StringRecord};
use serde::{Deserialize, Serialize};

use crate::fault::Fault;
use crate::particle::{Force, Grain, GrainBundle, GrainId, Mass, Particle, Position, Radius, Species, Velocity};
use crate::space::Vector;

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
    /// Centre, m.
    pub position: Vector,
    /// Velocity, m/s.
    pub velocity: Vector,
    /// Kind.
    pub species: Species,
}

impl GrainRow {
    /// The grain as an entity's components; its force is evaluated in step zero.
    #[must_use]
    pub fn bundle(&self) -> GrainBundle {
        GrainBundle {
            particle: Particle {
                id: self.id,
                position: Position(self.position),
                velocity: Velocity(self.velocity),
                force: Force::default(),
                radius: Radius(self.radius),
            },
            mass: Mass(self.mass),
            species: self.species,
            grain: Grain,
        }
    }
}

const NEEDED: [&str; 7] = ["id", "radius", "mass", "x", "y", "vx", "vy"];
const MUST_BE_ZERO: [&str; 5] = ["z", "vz", "wx", "wy", "wz"];

/// Reads a grain file's text. `name` is the file's name in messages.
///
/// # Errors
/// If a column is missing or unknown, or a value not in range; the fault points at line and column.
pub fn parse(name: &str, text: &str) -> Result<Vec<GrainRow>, Fault> {
    let mut reader = ReaderBuilder::new().trim(csv::Trim::All).flexible(true).from_reader(text.as_bytes());
    let header = reader.headers().map_err(|error| broken(name, text, &error))?.clone();
    check_header(name, text, &header)?;
    let mut seen = BTreeSet::new();
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| broken(name, text, &error))?;
        let line = Line { name, text, header: &header, record: &record };
        let row = line.grain()?;
        if !seen.insert(row.id) {
            return Err(line.fault(
                "grain_file::duplicate_id",
                "id",
                format!("the id {} occurs twice", row.id.number()),
            ));
        }
        rows.push(row);
    }
    Ok(rows)
}

fn check_header(name: &str, text: &str, header: &StringRecord) -> Result<(), Fault> {
    let first_line = 0..text.find('\n').unwrap_or(text.len());
    let fault = |code, message: String| {
        let help = format!("the columns are {} and, if wanted, species", NEEDED.join(", "));
        Err(Fault::new(code, message).help(help).at(name, text, first_line.clone()))
    };
    if let Some(missing) = NEEDED.iter().find(|&&column| !header.iter().any(|found| found == column)) {
        return fault("grain_file::missing_column", format!("the column `{missing}` is missing"));
    }
    let known = |column: &str| NEEDED.contains(&column) || MUST_BE_ZERO.contains(&column) || column == "species";
    if let Some(unknown) = header.iter().find(|column| !known(column)) {
        return fault("grain_file::unknown_column", format!("there is no column `{unknown}`"));
    }
    Ok(())
}

fn broken(name: &str, text: &str, error: &csv::Error) -> Fault {
    let at = error.position().and_then(|position| usize::try_from(position.byte()).ok()).unwrap_or(0);
    Fault::new("grain_file::syntax", format!("this is not CSV: {error}")).help("separate values by commas").at(
        name,
        text,
        at..at,
    )
}

struct Line<'a> {
    name: &'a str,
    text: &'a str,
    header: &'a StringRecord,
    record: &'a StringRecord,
}

impl Line<'_> {
    fn value(&self, column: &str) -> Option<&str> {
        self.record.get(self.header.iter().position(|found| found == column)?)
    }

    fn fault(&self, code: &'static str, column: &str, message: String) -> Fault {
        let from = self.record.position().and_then(|position| usize::try_from(position.byte()).ok()).unwrap_or(0);
        // A record starts where the one before it ended; skip the line break in between.
        let from = from + self.text[from..].len() - self.text[from..].trim_start().len();
        let line = &self.text[from..from + self.text[from..].find('\n').unwrap_or(self.text.len() - from)];
        let index = self.header.iter().position(|found| found == column).unwrap_or(0);
        let start: usize = line.split(',').take(index).map(|cell| cell.len() + 1).sum();
        let start = start.min(line.len());
        let length = line[start..].find(',').unwrap_or(line.len() - start);
        Fault::new(code, format!("column `{column}`: {message}")).help("one grain a row; numbers in SI units").at(
            self.name,
            self.text,
            from + start..from + start + length,
        )
    }

    fn number(&self, column: &str, holds: impl Fn(f64) -> bool, expected: &str) -> Result<f64, Fault> {
        let found = self.value(column).unwrap_or("");
        match found.parse::<f64>() {
            Ok(number) if number.is_finite() && holds(number) => Ok(number),
            _ => Err(self.fault("grain_file::value", column, format!("expected {expected}, got `{found}`"))),
        }
    }

    fn grain(&self) -> Result<GrainRow, Fault> {
        let any = |column| self.number(column, |_| true, "a finite number");
        let positive = |column| self.number(column, |x| x > 0.0, "a number greater than 0");
        let id = self.value("id").and_then(|id| id.parse().ok()).and_then(GrainId::grain).ok_or_else(|| {
            let found = self.value("id").unwrap_or("");
            let message = format!("expected a whole number from 0 to {}, got `{found}`", GrainId::MAX_GRAIN);
            self.fault("grain_file::value", "id", message)
        })?;
        for column in MUST_BE_ZERO.into_iter().filter(|&column| self.value(column).is_some()) {
            self.number(column, |x| x == 0.0, "0, for scenes are planar and grains do not spin")?;
        }
        let species = match self.value("species") {
            None => 0,
            Some(found) => found.parse().map_err(|_| {
                let message = format!("expected a whole number from 0 to 255, got `{found}`");
                self.fault("grain_file::value", "species", message)
            })?,
        };
        Ok(GrainRow {
            id,
            radius: positive("radius")?,
            mass: positive("mass")?,
            position: Vector::new(any("x")?, any("y")?),
            velocity: Vector::new(any("vx")?, any("vy")?),
            species: Species(species),
        })
    }
}

/// The grains of a world as such a file, in ascending order of id.
pub fn write(world: &mut World) -> String {
    type Row<'a> = (&'a GrainId, &'a Radius, &'a Mass, &'a Position, &'a Velocity, &'a Species);
    let mut grains = world.query_filtered::<Row, With<Grain>>();
    let mut rows: Vec<_> = grains.iter(world).collect();
    rows.sort_unstable_by_key(|row| *row.0);
    let mut text = "id,radius,mass,x,y,vx,vy,species\n".to_owned();
    for (id, radius, mass, x, v, species) in rows {
        let (x, v) = (x.0, v.0);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{},{},{},{},{},{},{},{}", id.number(), radius.0, mass.0, x.x, x.y, v.x, v.y, species.0);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_back_to_the_same_bits() {
        let text =
            "id,radius,mass,x,y,vx,vy,species\n1,0.1,0.3,0.30000000000000004,-1e-300,5e-324,-0,0\n7,1,2,3,4,5,6,255\n";
        let mut world = World::new();
        world.spawn_batch(parse("a.csv", text).unwrap().iter().rev().map(GrainRow::bundle).collect::<Vec<_>>());
        let again = parse("b.csv", &write(&mut world)).unwrap();
        assert_eq!(again, parse("a.csv", text).unwrap());
        assert!(again[0].velocity.y.is_sign_negative());
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
            let fault = parse("bad.csv", text).unwrap_err();
            assert_eq!((fault.code(), fault.line_and_column()), (code, Some(place)), "{text:?}: {fault}");
        }
    }
}
