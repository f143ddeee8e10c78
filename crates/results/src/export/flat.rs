//! Tables of frames in which every column has one number a row, for CSV and Parquet.
//!
//! Each row begins with `time_s` and `step` of its frame. A vector has a column for each component, `position_x` and so on; a planar
//! spin is `spin_z`. Other names are those of `frames.bin`.

use super::grain_columns;
use siloflow_files::frames::{Column, Frame, Header, Values};

/// Names of the tables that frames have.
pub const TABLES: [&str; 4] = ["grains", "contacts", "wall_contacts", "bodies"];

/// One of the tables of a frame.
#[derive(Debug)]
pub struct FlatTable {
    /// One of [`TABLES`].
    pub name: &'static str,
    /// Number of rows.
    pub rows: usize,
    columns: Vec<Column>,
}

/// A column with one number a row.
#[derive(Clone, Copy, Debug)]
pub struct FlatColumn<'a> {
    values: &'a Values,
    component: usize,
    components: usize,
}

impl FlatTable {
    /// Returns the name and unit of each column that has a unit.
    #[must_use]
    pub fn units(&self) -> Vec<(String, String)> {
        let parts = self.columns.iter().flat_map(|column| names(column).into_iter().map(|name| (name, &column.unit)));
        let with_unit = parts.filter(|(_, unit)| !unit.is_empty()).map(|(name, unit)| (name, unit.clone()));
        std::iter::once(("time_s".to_owned(), "s".to_owned())).chain(with_unit).collect()
    }

    /// Returns the tables of a frame; those that it does not hold are left out.
    #[must_use]
    pub fn of(header: &Header, frame: &Frame) -> Vec<Self> {
        let (rows, columns) = grain_columns(header, frame);
        let mut tables = vec![Self { name: TABLES[0], rows, columns }];
        for name in &TABLES[1..] {
            tables.extend(frame.table(name).map(|table| Self {
                name,
                rows: table.rows,
                columns: table.columns.clone(),
            }));
        }
        tables
    }

    /// Returns the columns with their names, without time and step.
    #[must_use]
    pub fn columns(&self) -> Vec<(String, FlatColumn<'_>)> {
        self.columns.iter().flat_map(parts).collect()
    }
}

/// Returns the components of a column.
fn parts(column: &Column) -> impl Iterator<Item = (String, FlatColumn<'_>)> {
    let components = column.components.into();
    let part = move |component| FlatColumn { values: &column.values, component, components };
    names(column).into_iter().enumerate().map(move |(component, name)| (name, part(component)))
}

/// Returns the names of the components of a column.
fn names(column: &Column) -> Vec<String> {
    let part = |axis: &str| format!("{}_{axis}", column.name);
    match (column.components, column.name.as_str()) {
        (1, "spin") => vec![part("z")],
        (1, name) => vec![name.to_owned()],
        (components, _) => ["x", "y", "z"].into_iter().take(components.into()).map(part).collect(),
    }
}

impl FlatColumn<'_> {
    /// The number of a row as text that reads back to the same bits.
    #[must_use]
    pub fn text(&self, row: usize) -> String {
        super::number(self.values, row * self.components + self.component)
    }

    /// The numbers, if they are floats.
    #[must_use]
    pub fn floats(&self) -> Option<Vec<f64>> {
        match self.values {
            Values::F64(all) => Some(self.part(all, |number| number)),
            _ => None,
        }
    }

    /// The numbers, if they are whole. They fit into 4 bytes with a sign, except for large `U32`s, which count as the largest.
    #[must_use]
    pub fn whole(&self) -> Option<Vec<i32>> {
        match self.values {
            Values::F64(_) => None,
            Values::I32(all) => Some(self.part(all, |number| number)),
            Values::U32(all) => Some(self.part(all, |number| i32::try_from(number).unwrap_or(i32::MAX))),
            Values::U16(all) => Some(self.part(all, i32::from)),
            Values::U8(all) => Some(self.part(all, i32::from)),
        }
    }

    /// Returns the numbers of this component.
    fn part<T: Copy, U>(&self, all: &[T], of: impl Fn(T) -> U) -> Vec<U> {
        all.iter().skip(self.component).step_by(self.components.max(1)).map(|&number| of(number)).collect()
    }
}
