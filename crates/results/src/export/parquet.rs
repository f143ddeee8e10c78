//! A directory of Parquet tables: those of the [frames](super::flat), and every CSV file of the run.
//!
//! Columns are doubles, whole numbers of 4 or 8 bytes, or text. A column of a CSV file is whole if all its cells are, and text if a
//! cell is no number; an empty cell of a column of numbers is NaN. Pages are compressed by Snappy. The metadata of a file has the unit of
//! each column of frames, under the key `unit:COLUMN`. Source: <https://parquet.apache.org/docs/file-format>.

use std::collections::HashMap;
use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int32Type, Int64Type};
use parquet::errors::Result;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{Type, TypePtr};

use super::flat::FlatTable;
use siloflow_files::frames::{Frame, Header};
use siloflow_files::run_directory::tables_of;

/// Rows after which the rows so far are written as a group.
const GROUP: usize = 1 << 18;

/// Numbers of a column.
#[derive(Debug, PartialEq)]
enum Cells {
    F64(Vec<f64>),
    I32(Vec<i32>),
    I64(Vec<i64>),
    Text(Vec<String>),
}

/// A file that grows by groups of rows.
struct Table {
    file: SerializedFileWriter<File>,
    cells: Vec<Cells>,
    rows: usize,
}

/// Writes frames and the CSV files of a run into an empty directory.
///
/// # Errors
/// If a frame or a CSV file cannot be read, or a file cannot be written.
pub fn write(
    header: &Header,
    frames: impl Iterator<Item = io::Result<Frame>>,
    run: &Path,
    directory: &Path,
) -> io::Result<()> {
    let mut tables: HashMap<&str, Table> = HashMap::new();
    for frame in frames {
        let frame = frame?;
        for flat in FlatTable::of(header, &frame) {
            let table = match tables.remove(flat.name) {
                Some(table) => table,
                None => {
                    Table::create(&directory.join(format!("{}.parquet", flat.name)), &columns_of(&flat), flat.units())?
                }
            };
            tables.insert(flat.name, table.with(&frame, &flat)?);
        }
    }
    tables.into_values().try_for_each(Table::close)?;
    let mut tables = tables_of(run).into_iter();
    tables.try_for_each(|(name, path)| convert(&path, &directory.join(format!("{name}.parquet"))))
}

/// Returns empty columns for a table of frames, with their names.
fn columns_of(flat: &FlatTable) -> Vec<(String, Cells)> {
    let start = [("time_s".to_owned(), Cells::F64(Vec::new())), ("step".to_owned(), Cells::I64(Vec::new()))];
    let rest = flat.columns().into_iter().map(|(name, column)| match column.floats() {
        Some(_) => (name, Cells::F64(Vec::new())),
        None => (name, Cells::I32(Vec::new())),
    });
    start.into_iter().chain(rest).collect()
}

/// Converts a CSV file. `to` must not exist.
///
/// # Errors
/// If a file cannot be read or written.
pub fn convert(from: &Path, to: &Path) -> io::Result<()> {
    let mut rows = csv::Reader::from_path(from).map_err(io::Error::other)?;
    let names = rows.headers().map_err(io::Error::other)?.clone();
    let mut texts = vec![Vec::new(); names.len()];
    for row in rows.records() {
        let row = row.map_err(io::Error::other)?;
        texts.iter_mut().zip(&row).for_each(|(column, cell)| column.push(cell.to_owned()));
    }
    let columns: Vec<_> = names.iter().map(str::to_owned).zip(texts.into_iter().map(Cells::of_text)).collect();
    let mut table = Table::create(to, &columns, Vec::new())?;
    table.rows = columns.first().map_or(0, |(_, cells)| cells.len());
    table.cells = columns.into_iter().map(|(_, cells)| cells).collect();
    table.close()
}

impl Cells {
    fn of_text(cells: Vec<String>) -> Self {
        // A minus sign of a zero would be lost.
        let whole = |cell: &String| cell.parse().ok().filter(|_| cell != "-0");
        let float = |cell: &String| if cell.is_empty() { Some(f64::NAN) } else { cell.parse().ok() };
        if let Some(numbers) = cells.iter().map(whole).collect() {
            return Self::I64(numbers);
        }
        cells.iter().map(float).collect::<Option<_>>().map_or(Self::Text(cells), Self::F64)
    }

    fn len(&self) -> usize {
        match self {
            Self::F64(numbers) => numbers.len(),
            Self::I32(numbers) => numbers.len(),
            Self::I64(numbers) => numbers.len(),
            Self::Text(texts) => texts.len(),
        }
    }

    fn field(&self, name: &str) -> Result<TypePtr> {
        let (physical, logical) = match self {
            Self::F64(_) => (Physical::DOUBLE, None),
            Self::I32(_) => (Physical::INT32, None),
            Self::I64(_) => (Physical::INT64, None),
            Self::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let field = Type::primitive_type_builder(name, physical);
        Ok(Arc::new(field.with_repetition(Repetition::REQUIRED).with_logical_type(logical).build()?))
    }
}

impl Table {
    fn create(path: &Path, columns: &[(String, Cells)], units: Vec<(String, String)>) -> io::Result<Self> {
        let open = |file| {
            let fields = columns.iter().map(|(name, cells)| cells.field(name)).collect::<Result<_>>()?;
            let schema = Arc::new(Type::group_type_builder("siloflow").with_fields(fields).build()?);
            let units = units.into_iter().map(|(name, unit)| KeyValue::new(format!("unit:{name}"), unit)).collect();
            let properties = WriterProperties::builder()
                .set_compression(Compression::SNAPPY)
                .set_created_by(format!("siloflow {}", env!("CARGO_PKG_VERSION")))
                .set_key_value_metadata(Some(units));
            SerializedFileWriter::new(file, schema, Arc::new(properties.build()))
        };
        let file = open(File::create_new(path)?).map_err(io::Error::other)?;
        let empty = columns.iter().map(|(_, cells)| match cells {
            Cells::F64(_) => Cells::F64(Vec::new()),
            Cells::I32(_) => Cells::I32(Vec::new()),
            Cells::I64(_) => Cells::I64(Vec::new()),
            Cells::Text(_) => Cells::Text(Vec::new()),
        });
        Ok(Self { file, cells: empty.collect(), rows: 0 })
    }

    /// Adds the rows of a frame.
    fn with(mut self, frame: &Frame, flat: &FlatTable) -> io::Result<Self> {
        let step = i64::try_from(frame.step).unwrap_or(i64::MAX);
        let columns = flat.columns();
        if self.cells.len() != columns.len() + 2 {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "a frame has other columns than the first one"));
        }
        for (place, cells) in self.cells.iter_mut().enumerate() {
            let column = place.checked_sub(2).map(|place| columns[place].1);
            match cells {
                Cells::F64(all) => match column {
                    Some(column) => all.extend(column.floats().unwrap_or_default()),
                    None => all.extend(std::iter::repeat_n(frame.time, flat.rows)),
                },
                Cells::I32(all) => all.extend(column.and_then(|column| column.whole()).unwrap_or_default()),
                Cells::I64(all) => all.extend(std::iter::repeat_n(step, flat.rows)),
                Cells::Text(_) => {}
            }
        }
        self.rows += flat.rows;
        if self.rows >= GROUP {
            self.write_group()?;
        }
        Ok(self)
    }

    /// Writes the rows so far.
    fn write_group(&mut self) -> io::Result<()> {
        self.try_write_group().map_err(io::Error::other)?;
        self.rows = 0;
        for cells in &mut self.cells {
            match cells {
                Cells::F64(all) => all.clear(),
                Cells::I32(all) => all.clear(),
                Cells::I64(all) => all.clear(),
                Cells::Text(all) => all.clear(),
            }
        }
        Ok(())
    }

    fn try_write_group(&mut self) -> Result<()> {
        let mut group = self.file.next_row_group()?;
        for cells in &self.cells {
            let Some(mut column) = group.next_column()? else { break };
            match cells {
                Cells::F64(all) => column.typed::<DoubleType>().write_batch(all, None, None)?,
                Cells::I32(all) => column.typed::<Int32Type>().write_batch(all, None, None)?,
                Cells::I64(all) => column.typed::<Int64Type>().write_batch(all, None, None)?,
                Cells::Text(all) => {
                    let texts: Vec<_> = all.iter().map(|text| ByteArray::from(text.as_str())).collect();
                    column.typed::<ByteArrayType>().write_batch(&texts, None, None)?
                }
            };
            column.close()?;
        }
        group.close().map(|_| ())
    }

    fn close(mut self) -> io::Result<()> {
        if self.rows > 0 {
            self.write_group()?;
        }
        self.file.close().map(|_| ()).map_err(io::Error::other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_csv_files_get_the_narrowest_type_that_keeps_them() {
        let of = |cells: &[&str]| Cells::of_text(cells.iter().map(|cell| (*cell).to_owned()).collect());
        assert_eq!(of(&["1", "-2"]), Cells::I64(vec![1, -2]));
        assert_eq!(of(&["1", "2.5e0"]), Cells::F64(vec![1.0, 2.5]));
        assert_eq!(of(&["over the top", "1"]), Cells::Text(vec!["over the top".to_owned(), "1".to_owned()]));
        let Cells::F64(numbers) = of(&["-0", "0", "", "NaN"]) else { panic!("no floats") };
        assert!(numbers[0].is_sign_negative() && numbers[2].is_nan() && numbers[3].is_nan());
    }
}
