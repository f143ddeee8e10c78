//! Reads the CSV tables of a run directory by column. A table of a run that goes on or was killed may end in half a row, which is left
//! out.

use std::path::Path;

use csv::{ReaderBuilder, StringRecord};

use crate::own_files;
use siloflow_text::fault::Fault;
use siloflow_text::file;

/// A CSV file with access by column.
#[derive(Clone, Debug)]
pub struct Table {
    path: String,
    header: StringRecord,
    rows: Vec<StringRecord>,
}

impl Table {
    /// Reads the whole rows of the file at `path`.
    ///
    /// # Errors
    /// If the file cannot be read, or its rows differ in length. The fault has the help text `help` if the file cannot be read.
    pub fn read(path: &Path, help: &str) -> Result<Self, Fault> {
        let shown = path.display().to_string();
        let text = own_files::read_text(path, file::RESULT_BYTES).map_err(|error| {
            Fault::new("results::unreadable", format!("could not read {shown}: {error}")).help(help)
        })?;
        Self::parse(shown, &text)
    }

    /// Reads the whole rows of a text. `name` stands for the text in faults.
    ///
    /// # Errors
    /// If rows differ in length.
    pub fn parse(name: impl Into<String>, text: &str) -> Result<Self, Fault> {
        let path = name.into();
        let whole = text.rfind('\n').map_or(text, |end| &text[..=end]);
        let mut reader = ReaderBuilder::new().trim(csv::Trim::All).from_reader(whole.as_bytes());
        let broken = |error: csv::Error| {
            Fault::new("results::unreadable", format!("{path}: {error}"))
                .help("all rows must have as many columns as the first")
        };
        let header = reader.headers().map_err(broken)?.clone();
        let rows = reader.records().collect::<Result<_, _>>().map_err(broken)?;
        Ok(Self { path, header, rows })
    }

    /// Names of the columns.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.header.iter()
    }

    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Returns the texts of the column `name`; `None` if there is no column with this name.
    #[must_use]
    pub fn texts(&self, name: &str) -> Option<Vec<&str>> {
        let place = self.header.iter().position(|found| found == name)?;
        Some(self.rows.iter().map(|row| row.get(place).unwrap_or_default()).collect())
    }

    /// Returns the numbers of the column `name`, with NaN where the text is no number; `None` if there is no column with this name.
    #[must_use]
    pub fn numbers(&self, name: &str) -> Option<Vec<f64>> {
        let texts = self.texts(name)?;
        Some(texts.into_iter().map(|text| text.parse().unwrap_or(f64::NAN)).collect())
    }

    /// Returns the numbers of the column `name`; `None` if there is no column with this name.
    ///
    /// # Errors
    /// If a text is no finite number. The fault names its line.
    pub fn finite(&self, name: &str) -> Result<Option<Vec<f64>>, Fault> {
        let (Some(numbers), Some(texts)) = (self.numbers(name), self.texts(name)) else { return Ok(None) };
        let Some(wrong) = numbers.iter().position(|number| !number.is_finite()) else { return Ok(Some(numbers)) };
        let line = self.rows[wrong].position().map_or(0, csv::Position::line);
        let message =
            format!("{}, line {line}, column {name}: expected a finite number, got `{}`", self.path, texts[wrong]);
        Err(Fault::new("results::unreadable", message).help("run the scene again"))
    }

    /// Returns the numbers of the column `name`; a missing column is an error.
    ///
    /// # Errors
    /// As [`Table::finite`], and if there is no column with this name.
    pub fn needed(&self, name: &str) -> Result<Vec<f64>, Fault> {
        self.finite(name)?.ok_or_else(|| {
            Fault::new("results::unreadable", format!("{} has no column {name}", self.path))
                .help("run the scene again with this version")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_a_row_at_the_end_is_left_out() {
        let here = tempfile::tempdir().unwrap();
        let path = here.path().join("series.csv");
        std::fs::write(&path, "time_s,out,name\n0,1,a\n1,x,b\n2,3").unwrap();
        let table = Table::read(&path, "").unwrap();
        assert_eq!((table.len(), table.names().count()), (2, 3));
        assert_eq!(table.texts("name").unwrap(), ["a", "b"]);
        let out = table.numbers("out").unwrap();
        assert!((out[0] - 1.0).abs() < 1e-15 && out[1].is_nan() && table.numbers("in").is_none());
        assert!(table.finite("out").unwrap_err().to_string().contains("line 3, column out"));
        assert!(table.needed("in").unwrap_err().to_string().contains("no column in"));
    }
}
