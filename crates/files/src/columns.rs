//! The columns of a CSV file: one list has the name, unit, meaning and cell of each. The header and the rows of the file follow from it, and
//! a test compares it with the table in the documentation.
//!
//! A number is written in the shortest form that reads back to the same bits. [`Cell`] has the forms.

use std::fmt::{self, Display, Formatter};

/// A column of a file whose rows show values of the type `T`.
#[derive(Debug)]
pub struct Column<T> {
    /// Name in the header.
    pub name: &'static str,
    /// Unit, as in `m^2/s^2`; empty for a number without one, and for a text.
    pub unit: &'static str,
    /// Meaning, as in the documentation.
    pub meaning: &'static str,
    /// The space of the scenes whose files have the column.
    pub space: Spaces,
    /// The cell in the row of a value.
    pub cell: fn(&T) -> Cell<'_>,
}

/// The spaces of scenes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spaces {
    /// The plane, and solid space.
    Both,
    /// The plane only.
    Plane,
    /// Solid space only.
    Solid,
}

impl<T> Column<T> {
    /// Makes a column of all scenes.
    #[must_use]
    pub const fn new(name: &'static str, unit: &'static str, meaning: &'static str, cell: fn(&T) -> Cell<'_>) -> Self {
        Self { name, unit, meaning, space: Spaces::Both, cell }
    }

    /// Makes a column of scenes in the plane.
    #[must_use]
    pub const fn planar(
        name: &'static str,
        unit: &'static str,
        meaning: &'static str,
        cell: fn(&T) -> Cell<'_>,
    ) -> Self {
        Self { name, unit, meaning, space: Spaces::Plane, cell }
    }

    /// Makes a column of scenes in solid space.
    #[must_use]
    pub const fn solid(
        name: &'static str,
        unit: &'static str,
        meaning: &'static str,
        cell: fn(&T) -> Cell<'_>,
    ) -> Self {
        Self { name, unit, meaning, space: Spaces::Solid, cell }
    }
}

/// A cell of a row.
#[derive(Clone, Copy, Debug)]
pub enum Cell<'a> {
    /// A whole number.
    Whole(u64),
    /// A time, a place or a mean of counts. It has an exponent only below 1e-5 and from 1e16 on.
    Decimal(f64),
    /// Any other number, with an exponent.
    Scientific(f64),
    /// A number without an exponent.
    Plain(f64),
    /// A text without commas and quotes.
    Text(&'a str),
    /// A text in quotes.
    Quoted(&'a str),
    /// No value.
    Empty,
}

impl Display for Cell<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Whole(number) => write!(f, "{number}"),
            Self::Decimal(number) => write!(f, "{number:?}"),
            Self::Scientific(number) => write!(f, "{number:e}"),
            Self::Plain(number) => write!(f, "{number}"),
            Self::Text(text) => f.write_str(text),
            Self::Quoted(text) => write!(f, "\"{}\"", text.replace('"', "\"\"")),
            Self::Empty => Ok(()),
        }
    }
}

/// The columns of one file.
#[derive(Debug)]
pub struct Columns<T: 'static>(Vec<&'static Column<T>>);

impl<T> Columns<T> {
    /// Returns the columns of these lists, one list after the other, without those of the other space.
    #[must_use]
    pub fn of(is_solid: bool, lists: &[&'static [Column<T>]]) -> Self {
        let other = if is_solid { Spaces::Plane } else { Spaces::Solid };
        Self(lists.iter().copied().flatten().filter(|column| column.space != other).collect())
    }

    /// Returns the names, separated by commas.
    #[must_use]
    pub fn header(&self) -> String {
        self.0.iter().map(|column| column.name).collect::<Vec<_>>().join(",")
    }

    /// Returns the cells of a row, separated by commas and without a line break.
    #[must_use]
    pub fn cells<'a>(&'a self, row: &'a T) -> impl Display + 'a {
        Cells { columns: &self.0, row }
    }
}

struct Cells<'a, T: 'static> {
    columns: &'a [&'static Column<T>],
    row: &'a T,
}

impl<T> Display for Cells<'_, T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        for (place, column) in self.columns.iter().enumerate() {
            if place > 0 {
                f.write_str(",")?;
            }
            (column.cell)(self.row).fmt(f)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::Cell::{Decimal, Empty, Plain, Quoted, Scientific, Text, Whole};
    use super::*;

    struct Row {
        time: f64,
        place: [f64; 3],
        word: String,
    }

    const BEFORE: &[Column<Row>] = &[
        Column::new("time_s", "s", "", |row| Decimal(row.time)),
        Column::new("x_m", "m", "", |row| Scientific(row.place[0])),
        Column::planar("length_m", "m", "", |row| Plain(row.place[1])),
        Column::solid("z_m", "m", "", |row| Scientific(row.place[2])),
    ];
    const AFTER: &[Column<Row>] = &[
        Column::new("number", "", "", |_| Whole(7)),
        Column::new("none", "", "", |_| Empty),
        Column::new("kind", "", "", |_| Text("all")),
        Column::new("word", "", "", |row| Quoted(&row.word)),
    ];

    #[test]
    fn header_and_rows_follow_from_one_list() {
        let row = Row { time: 0.25, place: [1.5e-7, 2.5e-7, 3.0], word: "a \"b\", c".to_owned() };
        let plane = Columns::of(false, &[BEFORE, AFTER]);
        assert_eq!(plane.header(), "time_s,x_m,length_m,number,none,kind,word");
        assert_eq!(plane.cells(&row).to_string(), "0.25,1.5e-7,0.00000025,7,,all,\"a \"\"b\"\", c\"");
        let solid = Columns::of(true, &[BEFORE]);
        assert_eq!(solid.header(), "time_s,x_m,z_m");
        assert_eq!(solid.cells(&row).to_string(), "0.25,1.5e-7,3e0");
    }
}
