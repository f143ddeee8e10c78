//! A directory of CSV tables: `grains.csv`, and where frames hold contacts `contacts.csv` and `wall_contacts.csv`.
//!
//! A row has the time and step of its frame, and one number for each component of a column ([`flat`](super::flat)). Floats are
//! written so that reading them gives the same bits.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::flat::FlatTable;
use super::float;
use siloflow_files::frames::{Frame, Header};

/// Writes frames into an empty directory.
///
/// # Errors
/// If a frame cannot be read, or a file cannot be written.
pub fn write(header: &Header, frames: impl Iterator<Item = io::Result<Frame>>, directory: &Path) -> io::Result<()> {
    let mut files: HashMap<&str, BufWriter<File>> = HashMap::new();
    for frame in frames {
        let frame = frame?;
        for table in FlatTable::of(header, &frame) {
            let columns = table.columns();
            if !files.contains_key(table.name) {
                let mut file = BufWriter::new(File::create_new(directory.join(format!("{}.csv", table.name)))?);
                let names: Vec<_> = columns.iter().map(|(name, _)| name.as_str()).collect();
                writeln!(file, "time_s,step,{}", names.join(","))?;
                files.insert(table.name, file);
            }
            let Some(file) = files.get_mut(table.name) else { continue };
            let start = format!("{},{}", float(frame.time), frame.step);
            for row in 0..table.rows {
                write!(file, "{start}")?;
                columns.iter().try_for_each(|(_, column)| write!(file, ",{}", column.text(row)))?;
                writeln!(file)?;
            }
        }
    }
    files.values_mut().try_for_each(BufWriter::flush)
}
