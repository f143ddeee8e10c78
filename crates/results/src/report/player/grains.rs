//! The table `grains` of a frame, checked, and the quantities by which a page can colour grains.

use std::io;

use siloflow_files::frames::{Frame, ParticleKey, Table, Values};

/// Returns the error of a file that does not keep its own rules.
pub(super) fn damaged(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what.to_owned())
}

/// The grains and wall grains of a frame.
pub(super) struct Grains<'a> {
    pub keys: Vec<ParticleKey>,
    pub kinds: Vec<i64>,
    pub species: Vec<i64>,
    pub radii: &'a [f64],
    positions: &'a [f64],
    dimension: usize,
    table: &'a Table,
}

impl<'a> Grains<'a> {
    /// Returns the grains of a frame; `None` if it has no table of them.
    ///
    /// # Errors
    /// If a column is missing or of another type, or ids are not in ascending order.
    pub fn of(frame: &'a Frame, dimension: u8) -> io::Result<Option<Self>> {
        let Some(table) = frame.table("grains") else { return Ok(None) };
        let dimension = usize::from(dimension);
        let keys = table.particles("id", "sphere");
        let whole = |name: &str| table.whole(name).filter(|numbers| numbers.len() == table.rows);
        let floats = |name: &str, components: usize| {
            table.floats(name).filter(|numbers| Some(numbers.len()) == table.rows.checked_mul(components))
        };
        let (Some(keys), Some(radii), Some(positions)) = (keys, floats("radius", 1), floats("position", dimension))
        else {
            return Err(damaged("grains of a frame have no id, radius or position"));
        };
        if !keys.is_sorted_by(|a, b| a.place() < b.place()) {
            return Err(damaged("the ids of a frame are not in ascending order"));
        }
        let none = || vec![0; keys.len()];
        let kinds = whole("kind").unwrap_or_else(none);
        let species = whole("species").unwrap_or_else(none);
        Ok(Some(Self { keys, kinds, species, radii, positions, dimension, table }))
    }

    /// Returns the position of a row, m.
    pub fn position(&self, row: usize) -> &'a [f64] {
        self.positions.get(row * self.dimension..(row + 1) * self.dimension).unwrap_or_default()
    }

    /// Returns the quantities of the grains: their speed, and all columns with one number for each grain.
    pub fn quantities(&self) -> Vec<Quantity<'a>> {
        let speed = self.table.column("velocity").and_then(|column| match &column.values {
            Values::F64(numbers) if numbers.len() == self.positions.len() => {
                let numbers = Numbers::Length(numbers, self.dimension);
                Some(Quantity { name: "speed", unit: &column.unit, numbers })
            }
            _ => None,
        });
        let is_quantity = |name: &str| !matches!(name, "id" | "kind" | "species" | "speed" | "sphere");
        let columns = self.table.columns.iter().filter(|column| column.components == 1 && is_quantity(&column.name));
        let columns = columns.map(|column| Quantity {
            name: &column.name,
            unit: &column.unit,
            numbers: Numbers::Column(&column.values),
        });
        speed.into_iter().chain(columns).collect()
    }
}

/// A quantity of all grains of a frame.
pub(super) struct Quantity<'a> {
    pub name: &'a str,
    pub unit: &'a str,
    numbers: Numbers<'a>,
}

enum Numbers<'a> {
    Column(&'a Values),
    /// Length of vectors with so many components.
    Length(&'a [f64], usize),
}

impl Quantity<'_> {
    /// Whether all its numbers are whole by their type.
    pub fn is_whole(&self) -> bool {
        matches!(self.numbers, Numbers::Column(Values::I32(_) | Values::U32(_) | Values::U16(_) | Values::U8(_)))
    }

    /// Returns the number of a row; NaN if there is none.
    pub fn number(&self, row: usize) -> f64 {
        let number = match self.numbers {
            Numbers::Column(values) => values.get(row),
            Numbers::Length(numbers, components) => numbers
                .get(row * components..(row + 1) * components)
                .map(|vector| vector.iter().map(|number| number * number).sum::<f64>().sqrt()),
        };
        number.unwrap_or(f64::NAN)
    }
}
