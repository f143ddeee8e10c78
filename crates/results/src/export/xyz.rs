//! Extended XYZ: a line with the number of grains, a line with the cell, the columns and the time, then one line for each grain.
//!
//! OVITO and ASE read it. Names of columns that OVITO knows are its own: `pos`, `velo`, `type` (the species). A plane has the
//! z of its vectors left out, except for positions. Source: the format as ASE documents it
//! (<https://ase-lib.org/ase/io/formatoptions.html#extxyz>).

use std::fmt::Write as _;

use super::{cell, float, grain_columns, in_order, number};
use siloflow_files::frames::{Frame, Header, Values};

/// Returns the text of a frame.
#[must_use]
pub fn text(header: &Header, frame: &Frame) -> String {
    let (rows, columns) = grain_columns(header, frame);
    let columns = in_order(columns, &["id", "species", "position", "radius", "mass", "velocity"]);
    let [low, high] = cell(header, frame);
    let side = |axis: usize| float(high[axis] - low[axis]);
    let zero = float(0.0);
    let lattice = (0..9).map(|place| if place % 4 == 0 { side(place / 4) } else { zero.clone() });
    let origin = low.map(float).join(" ");
    let periodic = header.periodic.map(|side| if side.is_some() { "T" } else { "F" }).join(" ");
    let properties = columns.iter().map(|column| {
        let name = match column.name.as_str() {
            "position" => "pos",
            "velocity" => "velo",
            "species" => "type",
            other => other,
        };
        let kind = if matches!(column.values, Values::F64(_)) { 'R' } else { 'I' };
        let components = if column.name == "position" { 3 } else { column.components };
        format!("{}:{kind}:{components}", plain(name))
    });
    let properties = properties.collect::<Vec<_>>().join(":");
    let lattice = lattice.collect::<Vec<_>>().join(" ");
    let time = float(frame.time);
    let step = frame.step;
    let mut text = format!(
        "{rows}\nLattice=\"{lattice}\" Origin=\"{origin}\" Properties={properties} Time={time} Step={step} pbc=\"{periodic}\"\n"
    );
    for row in 0..rows {
        for (place, column) in columns.iter().enumerate() {
            let components = usize::from(column.components);
            for component in 0..components {
                let space = if place + component > 0 { " " } else { "" };
                // Writing to a string cannot fail.
                let _ = write!(text, "{space}{}", number(&column.values, row * components + component));
            }
            if column.name == "position" && components == 2 {
                let _ = write!(text, " {zero}");
            }
        }
        text.push('\n');
    }
    text
}

/// Returns a name with letters, digits and underscores only.
pub(super) fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
}
