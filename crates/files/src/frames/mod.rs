//! Frames as data, `frames.bin`: the grains, contacts and walls of a run over time, in full precision.
//!
//! A file has a [`Header`] and any number of [`Frame`]s. A frame consists of [`Table`]s, and a table of named columns of one
//! type each, so a table may get further columns without a new format. [`FrameReader`](reader::FrameReader) reads a file:
//!
//! ```no_run
//! use siloflow_files::frames::reader::FrameReader;
//!
//! let frames = FrameReader::open("out/silo1/frames.bin".as_ref())?;
//! for frame in frames {
//!     let frame = frame?;
//!     let grains = frame.table("grains").map_or(0, |grains| grains.rows);
//!     println!("{} s: {grains} grains and wall grains", frame.time);
//! }
//! # Ok::<(), std::io::Error>(())
//! ```
//!
//! | part | content |
//! |---|---|
//! | `codec.rs`, `check.rs` | the bytes of a record, and whether they make one |
//! | `reader.rs`, `file.rs` | reading, and adding records |
//! | `columns.rs` | the columns of all frames of a run |
//!
//! Units are SI. Numbers of vectors are x, y, and in solid space z; a planar spin is one number.

mod check;
mod codec;
pub mod columns;
pub mod file;
pub mod reader;
pub mod scale;

use serde::{Deserialize, Serialize};

use self::scale::Scale;

/// Version of the format.
///
/// Format 2 added the last field of the [`Header`]. Files of format 1 are read as if it were empty.
pub const FORMAT: u32 = 2;

/// Names of the columns of `grains`, and names that exports and viewers derive from them. A column that a behaviour registers has
/// another one.
pub const TAKEN_NAMES: &str = "id kind species radius mass position velocity spin force pressure coordination kinetic_energy \
    age speed time_s step type pos velo x y z vx vy vz fx fy fz position_x position_y position_z velocity_x velocity_y velocity_z \
    spin_x spin_y spin_z force_x force_y force_z sphere inclination";

/// Facts about a run that all its frames share.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Header {
    /// [`FORMAT`] of the program that wrote the file.
    pub format: u32,
    /// Version of that program.
    pub version: String,
    /// Name of the scene.
    pub scene: String,
    /// Title of the scene.
    pub title: String,
    /// Number of components of a vector: 2 in the plane, 3 in solid space.
    pub dimension: u8,
    /// Name and colour (red, green, blue) of each species.
    pub species: Vec<(String, [u8; 3])>,
    /// Lower and upper end of each periodic axis, m; `None` where the axis is open.
    pub periodic: [Option<(f64, f64)>; 3],
    /// Lowest and highest corner of the periodic box, of the walls and of the places where grains start, m.
    pub domain: [[f64; 3]; 2],
    /// Wall surfaces at the start, in the order of their numbers.
    pub walls: Vec<WallGeometry>,
    /// Columns of `grains` that behaviours register.
    pub columns: Vec<RegisteredColumn>,
}

/// A column of `grains` that a behaviour registers.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct RegisteredColumn {
    /// Name of the column.
    pub name: String,
    /// Unit; empty for a number without one.
    pub unit: String,
    /// Label of axes and colour bars.
    pub label: String,
    /// The behaviour.
    pub behaviour: String,
    /// Colours that the behaviour suggests.
    pub scale: Option<Scale>,
}

/// A wall surface as points with lines or triangles between them.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct WallGeometry {
    /// Number of the wall among the scene's `walls`, from 1, not counting discs.
    pub number: u32,
    /// Material.
    pub species: u8,
    /// Whether the wall is a door.
    pub is_door: bool,
    /// Points, m; z is 0 in the plane. A wall that has been removed has none.
    pub points: Vec<[f64; 3]>,
    /// Lines between two points, given by their places in `points`.
    pub lines: Vec<[u32; 2]>,
    /// Triangles between three points.
    pub triangles: Vec<[u32; 3]>,
}

/// The state of a run at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Frame {
    /// Number of completed steps.
    pub step: u64,
    /// Simulated time, s.
    pub time: f64,
    /// Grains that were released, are inside, are out, and are lost.
    pub counts: [u64; 4],
    /// Walls that differ from those of the header; each replaces the wall of its number.
    pub changed_walls: Vec<WallGeometry>,
    /// `grains`, and if the scene wants them `contacts` and `wall_contacts`.
    pub tables: Vec<Table>,
}

impl Frame {
    /// Returns the table of this name.
    #[must_use]
    pub fn table(&self, name: &str) -> Option<&Table> {
        self.tables.iter().find(|table| table.name == name)
    }

    /// Returns the walls at the time of the frame, without those that have been removed.
    #[must_use]
    pub fn walls<'a>(&'a self, header: &'a Header) -> Vec<&'a WallGeometry> {
        let changed = |number| self.changed_walls.iter().find(|wall| wall.number == number);
        let now = header.walls.iter().map(|wall| changed(wall.number).unwrap_or(wall));
        now.filter(|wall| !wall.points.is_empty()).collect()
    }
}

/// Columns with the same number of rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Name.
    pub name: String,
    /// Number of rows.
    pub rows: usize,
    /// Columns.
    pub columns: Vec<Column>,
}

/// A particle of a frame: a grain, or one of the spheres of a grain with a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ParticleKey {
    /// The id of the grain; that of wall grain 3 is -3.
    pub id: i32,
    /// The number of the sphere in the grain's shape, 0 if the grain is one sphere.
    pub sphere: u16,
}

impl ParticleKey {
    /// Returns what frames are sorted by: grains by their numbers, then wall grains by theirs; spheres of a grain by theirs.
    #[must_use]
    pub fn place(self) -> impl Ord + Copy + use<> {
        (self.id < 0, self.id.unsigned_abs(), self.sphere)
    }
}

impl Table {
    /// Returns the particles that the columns `id` and `sphere` name; `None` if there is no such column of whole numbers of four bytes. Without
    /// the column `sphere` all spheres have the number 0.
    #[must_use]
    pub fn particles(&self, id: &str, sphere: &str) -> Option<Vec<ParticleKey>> {
        let ids = self.whole(id).filter(|ids| ids.len() == self.rows)?;
        let spheres = self.whole(sphere).filter(|spheres| spheres.len() == self.rows);
        let sphere = |row: usize| spheres.as_ref().map_or(Some(0), |spheres| u16::try_from(spheres[row]).ok());
        let keys = ids.into_iter().enumerate();
        keys.map(|(row, id)| Some(ParticleKey { id: i32::try_from(id).ok()?, sphere: sphere(row)? })).collect()
    }

    /// Returns the column of this name.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// Returns the numbers of a column of this name, row by row; `None` if there is no such column, or it has whole numbers.
    #[must_use]
    pub fn floats(&self, name: &str) -> Option<&[f64]> {
        match &self.column(name)?.values {
            Values::F64(numbers) => Some(numbers),
            _ => None,
        }
    }

    /// Returns the numbers of a column of this name with one number for each row, whatever their type; `None` if there is none.
    #[must_use]
    pub fn numbers(&self, name: &str) -> Option<Vec<f64>> {
        let column = self.column(name).filter(|column| column.components == 1)?;
        (0..self.rows).map(|row| column.values.get(row)).collect()
    }

    /// Returns the whole numbers of a column of this name; `None` if there is no such column, or it has floats.
    #[must_use]
    pub fn whole(&self, name: &str) -> Option<Vec<i64>> {
        match &self.column(name)?.values {
            Values::F64(_) => None,
            Values::I32(numbers) => Some(numbers.iter().map(|&number| number.into()).collect()),
            Values::U32(numbers) => Some(numbers.iter().map(|&number| number.into()).collect()),
            Values::U16(numbers) => Some(numbers.iter().map(|&number| number.into()).collect()),
            Values::U8(numbers) => Some(numbers.iter().map(|&number| number.into()).collect()),
        }
    }
}

/// A named quantity of every row of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name.
    pub name: String,
    /// Unit, for example `m/s`; empty for a number without one.
    pub unit: String,
    /// Numbers of a row.
    pub components: u8,
    /// The numbers, row by row.
    pub values: Values,
}

/// Numbers of one type.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Doubles.
    F64(Vec<f64>),
    /// Whole numbers of 4 bytes, with a sign.
    I32(Vec<i32>),
    /// Whole numbers of 4 bytes.
    U32(Vec<u32>),
    /// Whole numbers of 2 bytes.
    U16(Vec<u16>),
    /// Whole numbers of 1 byte.
    U8(Vec<u8>),
}

impl Values {
    /// Returns the number at a place; `None` beyond the end.
    #[must_use]
    pub fn get(&self, place: usize) -> Option<f64> {
        match self {
            Self::F64(numbers) => numbers.get(place).copied(),
            Self::I32(numbers) => numbers.get(place).map(|&number| number.into()),
            Self::U32(numbers) => numbers.get(place).map(|&number| number.into()),
            Self::U16(numbers) => numbers.get(place).map(|&number| number.into()),
            Self::U8(numbers) => numbers.get(place).map(|&number| number.into()),
        }
    }
}
