//! Frames in the formats of other programs: VTK for ParaView, extended XYZ and LAMMPS dumps for OVITO, CSV and Parquet for notebooks.
//!
//! | format | default name in a run directory | content |
//! |---|---|---|
//! | [`vtk`] | `vtk/` | grains as points, contacts as lines, walls as surfaces, with all columns |
//! | [`xyz`] | `frames.xyz` | all columns of grains |
//! | [`dump`] | `frames.dump` | all columns of grains |
//! | [`csv`] | `csv/` | grains and contacts, a number in each cell |
//! | `parquet`, with the feature of this name | `parquet/` | as CSV, and all CSV files of the run |
//!
//! Every format has the columns of the table `grains`, also ones that it does not know, and `kinetic_energy`. They are the same in every
//! frame of a run, also in one without grains. Floats are written
//! so that reading them gives the same bits.

pub mod csv;
pub mod dump;
pub mod flat;
#[cfg(feature = "parquet")]
pub mod parquet;
pub mod vtk;
pub mod vtp;
pub mod xyz;

use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use siloflow_files::frames::columns::Columns;
use siloflow_files::frames::{Column, Frame, Header, Table, Values};
use siloflow_files::run_directory::PartDirectory;
use siloflow_files::run_files::RunFiles;
use siloflow_files::whole_file;

/// A format of another program that can also be written during a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Format {
    /// VTK XML PolyData, for ParaView.
    Vtk,
    /// Extended XYZ, for OVITO and ASE.
    ExtXyz,
    /// A dump of LAMMPS, for OVITO.
    LammpsDump,
}

impl Format {
    /// All formats with the names that the command line has for them.
    pub const ALL: [(&'static str, Self); 3] =
        [("vtk", Self::Vtk), ("extxyz", Self::ExtXyz), ("dump", Self::LammpsDump)];

    /// Returns the default name in a run directory.
    #[must_use]
    pub fn file_name(self) -> &'static str {
        match self {
            Self::Vtk => "vtk",
            Self::ExtXyz => "frames.xyz",
            Self::LammpsDump => "frames.dump",
        }
    }
}

/// A format that frames are converted to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// One that can also be written during a run.
    Live(Format),
    /// CSV tables.
    Csv,
    /// Parquet tables. They need the feature `parquet` of the package.
    Parquet,
}

impl Target {
    /// All formats with the names that the command line has for them.
    pub const ALL: [(&'static str, Self); 5] = {
        let [vtk, xyz, dump] = Format::ALL;
        [
            (vtk.0, Self::Live(vtk.1)),
            (xyz.0, Self::Live(xyz.1)),
            (dump.0, Self::Live(dump.1)),
            ("csv", Self::Csv),
            ("parquet", Self::Parquet),
        ]
    };

    /// Whether this program can write the format.
    #[must_use]
    pub fn is_available(self) -> bool {
        self != Self::Parquet || cfg!(feature = "parquet")
    }

    /// Returns the default name in a run directory.
    #[must_use]
    pub fn file_name(self) -> &'static str {
        match self {
            Self::Live(format) => format.file_name(),
            Self::Csv => "csv",
            Self::Parquet => "parquet",
        }
    }
}

/// Writes frames of the run in the directory `run` to `target`, which must not exist: all of them or none. Returns their number.
/// Every frame gets all `columns` of the run.
///
/// # Errors
/// If a frame cannot be read, or the target cannot be written. Then there is no target.
pub fn export(
    format: Target,
    header: &Header,
    columns: &Columns,
    frames: impl Iterator<Item = io::Result<Frame>>,
    run: &Path,
    target: &Path,
) -> io::Result<usize> {
    let mut count = 0;
    let mut counted = frames.inspect(|_| count += 1).map(|frame| columns.complete(frame?));
    match format {
        Target::Live(Format::Vtk) => whole_directory(format, target, |part| {
            let mut directory = vtk::Directory::open(part, &RunFiles::default())?;
            counted.try_for_each(|frame| directory.add(header, &frame?))
        }),
        Target::Live(format) => {
            let text = if format == Format::ExtXyz { xyz::text } else { dump::text };
            whole_file::write_with(target, |file| {
                counted.try_for_each(|frame| file.write_all(text(header, &frame?).as_bytes()))
            })
        }
        Target::Csv => whole_directory(format, target, |part| csv::write(header, counted, part)),
        #[cfg(feature = "parquet")]
        Target::Parquet => whole_directory(format, target, |part| parquet::write(header, counted, run, part)),
        #[cfg(not(feature = "parquet"))]
        Target::Parquet => {
            let _ = run;
            Err(io::Error::other("this program was built without Parquet"))
        }
    }?;
    Ok(count)
}

/// Makes a directory with the files that `write` writes: all of them or none.
fn whole_directory(format: Target, target: &Path, write: impl FnOnce(&Path) -> io::Result<()>) -> io::Result<()> {
    let part = PartDirectory::create(target, format.file_name())?;
    write(part.path())?;
    part.publish(false)
}

/// Returns the columns of the grains of a frame with their kinetic energy.
fn grain_columns(header: &Header, frame: &Frame) -> (usize, Vec<Column>) {
    let Some(grains) = frame.table("grains") else { return (0, Vec::new()) };
    let mut columns = grains.columns.clone();
    columns.extend(kinetic_energy(header, grains));
    (grains.rows, columns)
}

/// Returns the kinetic energy of translation of each grain, J: m v^2/2.
fn kinetic_energy(header: &Header, grains: &Table) -> Option<Column> {
    let mass = grains.floats("mass")?;
    let velocity = grains.floats("velocity")?;
    let squares = velocity.chunks(header.dimension.into()).map(|v| v.iter().map(|v| v * v).sum::<f64>());
    let values = Values::F64(mass.iter().zip(squares).map(|(mass, square)| 0.5 * mass * square).collect());
    Some(Column { name: "kinetic_energy".to_owned(), unit: "J".to_owned(), components: 1, values })
}

/// Returns a number of a column as text that reads back to the same bits.
fn number(values: &Values, place: usize) -> String {
    match values {
        Values::F64(numbers) => float(numbers[place]),
        Values::I32(numbers) => numbers[place].to_string(),
        Values::U32(numbers) => numbers[place].to_string(),
        Values::U16(numbers) => numbers[place].to_string(),
        Values::U8(numbers) => numbers[place].to_string(),
    }
}

/// The shortest decimal of a float.
fn float(number: f64) -> String {
    format!("{number:e}")
}

/// Returns lowest and highest corner of the box of a scene, m. A plane is as thick as its largest grain.
fn cell(header: &Header, frame: &Frame) -> [[f64; 3]; 2] {
    let mut ends = header.domain;
    if header.dimension == 2 {
        let radii = frame.table("grains").and_then(|grains| grains.floats("radius"));
        let largest = radii.into_iter().flatten().copied().fold(0.0, f64::max);
        (ends[0][2], ends[1][2]) = (-largest, largest);
    }
    ends
}

/// Returns the columns of these names, as far as they are there, and then all others.
fn in_order(columns: Vec<Column>, names: &[&str]) -> Vec<Column> {
    let place = |column: &Column| names.iter().position(|name| *name == column.name).unwrap_or(names.len());
    let mut columns = columns;
    columns.sort_by_key(place);
    columns
}

#[cfg(test)]
mod tests;
