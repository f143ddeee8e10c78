//! The frames of a run, from its `frames.bin`.

use std::path::PathBuf;

use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use siloflow::files::frames::reader::FrameReader;
use siloflow::files::frames::{Table, Values};

use crate::set_column;

/// An iterator over the frames of a file.
#[pyclass]
pub struct Frames {
    reader: FrameReader,
}

#[pymethods]
impl Frames {
    #[new]
    fn new(path: PathBuf) -> PyResult<Self> {
        let reader = FrameReader::open(&path)
            .map_err(|error| PyOSError::new_err(format!("could not read {}: {error}", path.display())))?;
        Ok(Self { reader })
    }

    /// The facts that all frames share, as JSON.
    fn header(&self) -> PyResult<String> {
        serde_json::to_string(&self.reader.header).map_err(|error| PyOSError::new_err(error.to_string()))
    }

    fn __iter__(this: PyRef<'_, Self>) -> PyRef<'_, Self> {
        this
    }

    /// The next frame as (step, time, grains released, inside, out and lost, tables); a table is a dictionary of columns.
    #[expect(clippy::type_complexity, reason = "a tuple that Python unpacks")]
    fn __next__<'py>(&mut self, py: Python<'py>) -> PyResult<Option<(u64, f64, [u64; 4], Bound<'py, PyDict>)>> {
        let Some(frame) = py.detach(|| self.reader.next()).transpose()? else { return Ok(None) };
        let tables = PyDict::new(py);
        for table in &frame.tables {
            tables.set_item(&table.name, columns(py, table)?)?;
        }
        Ok(Some((frame.step, frame.time, frame.counts, tables)))
    }
}

fn columns<'py>(py: Python<'py>, table: &Table) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    for column in &table.columns {
        let name = &*column.name;
        let components = column.components;
        match &column.values {
            Values::F64(values) => set_column(&columns, name, "<f8", components, values, |x| x.to_le_bytes()),
            Values::I32(values) => set_column(&columns, name, "<i4", components, values, |x| x.to_le_bytes()),
            Values::U32(values) => set_column(&columns, name, "<u4", components, values, |x| x.to_le_bytes()),
            Values::U16(values) => set_column(&columns, name, "<u2", components, values, |x| x.to_le_bytes()),
            Values::U8(values) => set_column(&columns, name, "|u1", components, values, |x| [x]),
        }?;
    }
    Ok(columns)
}
