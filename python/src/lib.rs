//! The compiled module `siloflow._siloflow`: the command line, a stepped simulation, and the frames of a run. Columns of numbers are
//! passed as bytes; the Python part of the package makes NumPy arrays of them.

mod columns;
mod frames;
mod simulation;

use std::ffi::OsString;
use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use siloflow::behaviour::Registry;

pyo3::create_exception!(siloflow, SceneError, pyo3::exceptions::PyValueError, "A scene, setting or file is wrong.");

/// Runs the program with these arguments, of which the first is its name, and returns its exit status. `program` is the file that starts it.
#[pyfunction]
fn command_line(py: Python<'_>, arguments: Vec<OsString>, program: Option<PathBuf>) -> u8 {
    if let Some(program) = program {
        siloflow::cli::set_program(program);
    }
    py.detach(|| siloflow::cli::status_of(&Registry::default(), arguments))
}

/// A column: type of its numbers, numbers of a row, bytes.
type Column<'py> = (&'static str, u8, Bound<'py, PyBytes>);

/// Makes a column of numbers.
fn column<'py, T: Copy, const N: usize>(
    py: Python<'py>,
    dtype: &'static str,
    components: u8,
    values: &[T],
    bytes_of: impl Fn(T) -> [u8; N],
) -> Column<'py> {
    let bytes: Vec<u8> = values.iter().copied().flat_map(bytes_of).collect();
    (dtype, components, PyBytes::new(py, &bytes))
}

/// Adds a column to a table.
fn set_column<T: Copy, const N: usize>(
    columns: &Bound<'_, PyDict>,
    name: &str,
    dtype: &'static str,
    components: u8,
    values: &[T],
    bytes_of: impl Fn(T) -> [u8; N],
) -> PyResult<()> {
    columns.set_item(name, column(columns.py(), dtype, components, values, bytes_of))
}

#[pymodule]
fn _siloflow(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("SceneError", module.py().get_type::<SceneError>())?;
    module.add_function(wrap_pyfunction!(command_line, module)?)?;
    module.add_class::<simulation::Simulation>()?;
    module.add_class::<frames::Frames>()
}
