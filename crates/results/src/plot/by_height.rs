//! Figures over a place: profiles in bins (`profiles.csv`). They show the last averaging time.

use crate::run_results::RunResults;
use siloflow_figures::diagram::{Axis, Curve, Key, Panel, colour};
use siloflow_files::table::Table;
use siloflow_text::fault::Fault;

/// Columns of `profiles.csv`.
const PROFILES: [(&str, &str, &str); 5] = [
    ("packing_fraction", "Packing fraction", "packing fraction"),
    ("vx_m_per_s", "Velocity along x", "velocity, m/s"),
    ("vy_m_per_s", "Velocity along y", "velocity, m/s"),
    ("vz_m_per_s", "Velocity along z", "velocity, m/s"),
    ("temperature_m2_per_s2", "Granular temperature", "temperature, m²/s²"),
];

pub(super) fn profiles(runs: &[&RunResults]) -> Result<Vec<Panel>, Fault> {
    let tables = tables(runs, "profiles.csv")?;
    let mut panels = Vec::new();
    for number in numbers(&tables, "profile") {
        for (column, title, label) in PROFILES {
            let mut curves = Vec::new();
            for (place, table) in &tables {
                curves.extend(by_species(runs, *place, table, &number, column));
            }
            if curves.iter().any(|curve| curve.points.iter().any(|point| point.1 != 0.0 && point.1.is_finite())) {
                let points = || curves.iter().flat_map(|curve| curve.points.iter());
                let x = Axis::around("place along the axis of the profile, m", points().map(|point| point.0));
                let y = Axis::around(label, points().map(|point| point.1));
                let title = numbered(title, &number, &tables, "profile");
                panels.push(Panel { curves, key: Key::Above, ..Panel::new(title, x, y) });
            }
        }
    }
    Ok(panels)
}

/// Returns a curve for each species of a profile, or of several runs one for all grains.
fn by_species(runs: &[&RunResults], place: usize, table: &Table, number: &str, column: &str) -> Vec<Curve> {
    let found =
        (last_rows(table, "profile", number), table.texts("species"), table.numbers("place_m"), table.numbers(column));
    let (Some(rows), Some(species), Some(places), Some(values)) = found else { return Vec::new() };
    let mut names: Vec<&str> = Vec::new();
    for &row in &rows {
        if !names.contains(&species[row]) {
            names.push(species[row]);
        }
    }
    // One species and all grains are the same.
    let only =
        if names.len() == 2 || runs.len() > 1 { names.iter().find(|name| **name == "all").copied() } else { None };
    names.retain(|name| only.is_none_or(|only| only == *name));
    let curves = names.iter().enumerate().map(|(place_of_species, name)| {
        let points = rows.iter().filter(|&&row| species[row] == *name).map(|&row| (places[row], values[row])).collect();
        let label = match (names.len(), *name) {
            (1, _) => String::new(),
            (_, "all") => "all grains".to_owned(),
            (_, name) => format!("species {name}"),
        };
        curve(runs, if runs.len() == 1 { place_of_species } else { place }, label, points)
    });
    curves.collect()
}

/// Returns a curve of a run, named after the run if there are several.
fn curve(runs: &[&RunResults], place: usize, name: String, points: Vec<(f64, f64)>) -> Curve {
    let name = if runs.len() == 1 { name } else { runs[place].name.clone() };
    Curve { name, colour: colour(place), points, has_line: true, has_dots: true, ..Curve::default() }
}

/// Returns the tables of the runs that have one, with the place of the run.
pub(super) fn tables(runs: &[&RunResults], file: &str) -> Result<Vec<(usize, Table)>, Fault> {
    let read = runs.iter().enumerate().map(|(place, run)| Ok(run.table(file)?.map(|table| (place, table))));
    read.filter_map(Result::transpose).collect()
}

/// Returns the numbers of the entries of the scene that tables have, in order.
pub(super) fn numbers(tables: &[(usize, Table)], column: &str) -> Vec<String> {
    let mut numbers: Vec<String> = Vec::new();
    for text in tables.iter().filter_map(|(_, table)| table.texts(column)).flatten() {
        if !numbers.iter().any(|known| known == text) {
            numbers.push(text.to_owned());
        }
    }
    numbers
}

/// Returns a title, with the number of the entry if there are several.
pub(super) fn numbered(title: &str, number: &str, tables: &[(usize, Table)], column: &str) -> String {
    if numbers(tables, column).len() == 1 { title.to_owned() } else { format!("{title}, {column} {number}") }
}

/// Returns the rows of an entry in its last averaging time.
pub(super) fn last_rows(table: &Table, column: &str, number: &str) -> Option<Vec<usize>> {
    let entries = table.texts(column)?;
    let ends = table.numbers("to_s")?;
    let of_entry = || (0..table.len()).filter(|&row| entries[row] == number);
    let last = of_entry().map(|row| ends[row]).fold(f64::NEG_INFINITY, f64::max);
    Some(of_entry().filter(|&row| ends[row] >= last).collect())
}
