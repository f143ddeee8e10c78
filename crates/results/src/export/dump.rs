//! Dump of LAMMPS, custom style: time, step, number of grains and box, then one line for each grain.
//!
//! Columns have the names of LAMMPS where it has one. `type` is the species plus one, because LAMMPS counts from 1. Other vectors
//! have one column for each component: `name[1]` and so on. Source: <https://docs.lammps.org/dump.html>.

use std::fmt::Write as _;

use super::xyz::plain;
use super::{cell, float, grain_columns, in_order, number};
use siloflow_files::frames::{Frame, Header, Values};

/// Returns the text of a frame.
#[must_use]
pub fn text(header: &Header, frame: &Frame) -> String {
    let (rows, columns) = grain_columns(header, frame);
    let columns = in_order(columns, &["id", "species", "radius", "mass", "position", "velocity", "spin", "force"]);
    let [low, high] = cell(header, frame);
    let sides = header.periodic.map(|side| if side.is_some() { "pp" } else { "ff" }).join(" ");
    let mut text = format!(
        "ITEM: TIME\n{}\nITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n{rows}\nITEM: BOX BOUNDS {sides}\n",
        float(frame.time),
        frame.step
    );
    // Writing to a string cannot fail.
    for axis in 0..3 {
        let _ = writeln!(text, "{} {}", float(low[axis]), float(high[axis]));
    }
    text.push_str("ITEM: ATOMS");
    for column in &columns {
        for name in names(&column.name, column.components) {
            let _ = write!(text, " {name}");
        }
    }
    text.push('\n');
    for row in 0..rows {
        for (place, column) in columns.iter().enumerate() {
            let components = usize::from(column.components);
            for component in 0..components {
                let space = if place + component > 0 { " " } else { "" };
                let cell = match &column.values {
                    Values::U8(species) if column.name == "species" => (u16::from(species[row]) + 1).to_string(),
                    values => number(values, row * components + component),
                };
                let _ = write!(text, "{space}{cell}");
            }
            // Every atom of LAMMPS has a z.
            if column.name == "position" && components == 2 {
                let _ = write!(text, " {}", float(0.0));
            }
        }
        text.push('\n');
    }
    text
}

/// Returns the names of the components of a column.
fn names(name: &str, components: u8) -> Vec<String> {
    let known: &[&str] = match (name, components) {
        ("species", 1) => &["type"],
        ("position", _) => &["x", "y", "z"],
        ("velocity", 2) => &["vx", "vy"],
        ("velocity", 3) => &["vx", "vy", "vz"],
        ("spin", 1) => &["omegaz"],
        ("spin", 3) => &["omegax", "omegay", "omegaz"],
        ("force", 2) => &["fx", "fy"],
        ("force", 3) => &["fx", "fy", "fz"],
        _ => &[],
    };
    let name = plain(name);
    match (known, components) {
        ([], 1) => vec![name],
        ([], _) => (1..=components).map(|component| format!("{name}[{component}]")).collect(),
        (known, _) => known.iter().map(|name| (*name).to_owned()).collect(),
    }
}
