//! The columns of all frames of a run: their union.
//!
//! This siloflow writes the same columns in every frame of a run. Earlier versions left the spin out of frames without grains, and a file may
//! come from another program, so no single frame decides: a reader that needs the columns of a run takes the union of those of all frames,
//! and [completes](Columns::complete) each frame. A frame without rows has a say in names alone, because it has no numbers.
//!
//! A column that a frame lacks is NaN in its rows. A column that some frame lacks, or that has another type in another frame, has floats.
//!
//! Limit: a column with another number of components in another frame is an error, because no number would be right.

use std::io;

use super::codec::damaged;
use super::{Column, Frame, Table, Values};

/// The columns of the tables of a run.
#[derive(Clone, Debug, Default)]
pub struct Columns(Vec<TableColumns>);

#[derive(Clone, Debug, Default)]
struct TableColumns {
    name: String,
    known: Vec<Known>,
    /// Number of frames with rows.
    frames: u64,
}

/// A column without rows.
#[derive(Clone, Debug)]
struct Known {
    column: Column,
    /// Number of frames with rows that have it.
    frames: u64,
}

impl Columns {
    /// Reads all frames.
    ///
    /// # Errors
    /// If a frame cannot be read, or a column changes its number of components.
    pub fn of(mut frames: impl Iterator<Item = io::Result<Frame>>) -> io::Result<Self> {
        let mut columns = Self::default();
        frames.try_for_each(|frame| columns.add(&frame?))?;
        Ok(columns)
    }

    /// Adds the columns of a frame.
    ///
    /// # Errors
    /// If a column changes its number of components.
    pub fn add(&mut self, frame: &Frame) -> io::Result<()> {
        for table in &frame.tables {
            if !self.0.iter().any(|own| own.name == table.name) {
                self.0.push(TableColumns { name: table.name.clone(), ..TableColumns::default() });
            }
            self.0.iter_mut().filter(|own| own.name == table.name).try_for_each(|own| own.add(table))?;
        }
        Ok(())
    }

    /// Returns a frame without rows that has every table and column.
    #[must_use]
    pub fn frame(&self) -> Frame {
        Frame { tables: self.0.iter().map(TableColumns::table).collect(), ..Frame::default() }
    }

    /// Returns a frame with every table and column, in an order that all frames share.
    ///
    /// # Errors
    /// If a column has another number of components than in other frames.
    pub fn complete(&self, mut frame: Frame) -> io::Result<Frame> {
        let mut found = std::mem::take(&mut frame.tables);
        for own in self.0.iter().map(TableColumns::table) {
            let place = found.iter().position(|table| table.name == own.name);
            frame.tables.push(match place {
                Some(place) => completed(found.swap_remove(place), own)?,
                None => own,
            });
        }
        Ok(frame)
    }
}

impl TableColumns {
    fn add(&mut self, table: &Table) -> io::Result<()> {
        let counts = table.rows > 0;
        self.frames += u64::from(counts);
        let mut next = 0;
        for column in &table.columns {
            let place = self.known.iter().position(|known| known.column.name == column.name);
            let place = place.unwrap_or_else(|| {
                self.known.insert(next, Known { column: without_rows(column), frames: 0 });
                next
            });
            let known = &mut self.known[place];
            if counts {
                known.column = if known.frames > 0 { joined(&known.column, column)? } else { without_rows(column) };
                known.frames += 1;
            }
            next = place + 1;
        }
        Ok(())
    }

    /// Returns the table without rows.
    fn table(&self) -> Table {
        let column = |known: &Known| {
            // Some frame with rows lacks it.
            let is_lacking = known.frames < self.frames;
            let column = &known.column;
            if is_lacking { Column { values: Values::F64(Vec::new()), ..column.clone() } } else { column.clone() }
        };
        Table { name: self.name.clone(), rows: 0, columns: self.known.iter().map(column).collect() }
    }
}

/// Returns a table of a frame with the columns of `wanted`, which has no rows.
fn completed(mut table: Table, wanted: Table) -> io::Result<Table> {
    // Rows without a number are no rows, however many a damaged file claims.
    let rows = if table.columns.iter().any(|column| column.components > 0) { table.rows } else { 0 };
    let mut columns = Vec::with_capacity(wanted.columns.len());
    for column in wanted.columns {
        let place = table.columns.iter().position(|own| own.name == column.name);
        columns.push(match place.filter(|_| rows > 0).map(|place| table.columns.swap_remove(place)) {
            _ if rows == 0 => column,
            None => Column { values: Values::F64(vec![f64::NAN; rows * usize::from(column.components)]), ..column },
            Some(own) if own.components != column.components => return Err(changed(&own)),
            Some(own) if is_same_type(&own, &column) => own,
            Some(own) => Column { values: Values::F64((0..).map_while(|at| own.values.get(at)).collect()), ..own },
        });
    }
    Ok(Table { name: wanted.name, rows, columns })
}

/// Returns the column, without rows, of frames in which it is as the one or the other.
fn joined(known: &Column, other: &Column) -> io::Result<Column> {
    if known.components != other.components {
        return Err(changed(other));
    }
    let is_same = is_same_type(known, other);
    Ok(if is_same { known.clone() } else { Column { values: Values::F64(Vec::new()), ..known.clone() } })
}

fn changed(column: &Column) -> io::Error {
    damaged(format!("the column `{}` has another number of components in another frame", column.name))
}

fn is_same_type(a: &Column, b: &Column) -> bool {
    std::mem::discriminant(&a.values) == std::mem::discriminant(&b.values)
}

fn without_rows(column: &Column) -> Column {
    let values = match column.values {
        Values::F64(_) => Values::F64(Vec::new()),
        Values::I32(_) => Values::I32(Vec::new()),
        Values::U32(_) => Values::U32(Vec::new()),
        Values::U16(_) => Values::U16(Vec::new()),
        Values::U8(_) => Values::U8(Vec::new()),
    };
    let Column { name, unit, components, .. } = column;
    Column { name: name.clone(), unit: unit.clone(), components: *components, values }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(name: &str, components: u8, values: Values) -> Column {
        Column { name: name.to_owned(), unit: String::new(), components, values }
    }

    fn frame(rows: usize, columns: Vec<Column>) -> Frame {
        Frame { tables: vec![Table { name: "grains".to_owned(), rows, columns }], ..Frame::default() }
    }

    fn names(frame: &Frame) -> Vec<&str> {
        frame.tables[0].columns.iter().map(|column| column.name.as_str()).collect()
    }

    #[test]
    fn a_frame_without_rows_gets_the_columns_of_the_others_in_their_order() {
        let floats = |numbers: &[f64]| Values::F64(numbers.to_vec());
        let empty = frame(0, vec![column("id", 1, Values::U8(vec![])), column("force", 2, floats(&[]))]);
        let whole = frame(
            1,
            vec![
                column("id", 1, Values::I32(vec![7])),
                column("spin", 1, floats(&[0.5])),
                column("force", 2, floats(&[1.0, 2.0])),
            ],
        );
        for frames in [[&empty, &whole], [&whole, &empty]] {
            let columns = Columns::of(frames.into_iter().cloned().map(Ok)).unwrap();
            assert_eq!(columns.complete(whole.clone()).unwrap(), whole);
            let completed = columns.complete(empty.clone()).unwrap();
            assert_eq!(names(&completed), ["id", "spin", "force"]);
            assert_eq!(completed.tables[0].columns[0].values, Values::I32(Vec::new()));
            // A frame without any table too.
            assert_eq!(columns.complete(Frame::default()).unwrap(), columns.frame());
        }
    }

    #[test]
    fn a_column_that_rows_lack_or_that_changes_its_type_has_floats() {
        let first = frame(1, vec![column("a", 1, Values::U8(vec![3])), column("b", 1, Values::U8(vec![4]))]);
        let second =
            frame(2, vec![column("b", 1, Values::F64(vec![0.5, 1.5])), column("c", 2, Values::U16(vec![1; 4]))]);
        let columns = Columns::of([first.clone(), second.clone()].map(Ok).into_iter()).unwrap();
        let [first, second] = [first, second].map(|frame| columns.complete(frame).unwrap().tables.remove(0));
        assert_eq!([&first, &second].map(|table| table.columns.len()), [3, 3]);
        assert_eq!((first.floats("a"), first.floats("b")), (Some(&[3.0][..]), Some(&[4.0][..])));
        assert!(first.floats("c").unwrap().iter().all(|number| number.is_nan()));
        assert_eq!(first.floats("c").unwrap().len(), 2);
        assert!(second.floats("a").unwrap()[1].is_nan());
        assert_eq!((second.floats("b"), second.floats("c")), (Some(&[0.5, 1.5][..]), Some(&[1.0; 4][..])));
    }

    #[test]
    fn other_components_are_an_error_and_rows_without_numbers_are_none() {
        let [one, two] = [1, 2].map(|n| frame(1, vec![column("spin", n, Values::F64(vec![0.0; usize::from(n)]))]));
        assert!(Columns::of([Ok(one.clone()), Ok(two.clone())].into_iter()).is_err());
        let columns = Columns::of(std::iter::once(Ok(one))).unwrap();
        assert!(columns.complete(two).is_err());
        assert_eq!(columns.complete(frame(usize::MAX, Vec::new())).unwrap().tables[0].rows, 0);
    }
}
