//! Draws time and memory against size, from the table that docs/speed/scaling.py writes.

use std::error::Error;
use std::path::Path;

use siloflow::figures::diagram::{Axis, Curve, Key, Panel, colour, sheet};

/// Size, ns, bytes.
type Row = (f64, f64, f64);

/// The size to which larger ones are compared, and the allowed factors of time and memory.
const BASE: f64 = 1e5;
const BOUNDS: (f64, f64) = (2.5, 1.2);

fn rows(table: &str, method: &str) -> Result<Vec<Row>, Box<dyn Error>> {
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let headers = reader.headers()?.clone();
    let place = |name: &str| headers.iter().position(|header| header == name).ok_or(format!("no column {name}"));
    let kind = place("method")?;
    let places = [place("count")?, place("ns")?, place("bytes")?];
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record?;
        if &record[kind] == method {
            let [count, ns, bytes] = places.map(|place| record[place].parse::<f64>());
            rows.push((count?, ns?, bytes?));
        }
    }
    Ok(rows)
}

/// Returns the dots of one method, and a line from the base on at `bound` times the value of the base.
fn curves(name: &str, number: usize, points: Vec<(f64, f64)>, bound: f64) -> Vec<Curve> {
    let colour = colour(number);
    let largest = points.iter().map(|point| point.0).fold(BASE, f64::max);
    // The actual number of grains of a bed differs slightly from its nominal number.
    let base = points.iter().find(|point| (point.0 / BASE - 1.0).abs() < 0.1).map(|point| bound * point.1);
    let line = base.map(|limit| Curve {
        name: format!("{bound} times the value at 1e5"),
        colour,
        points: vec![(BASE, limit), (largest, limit)],
        has_line: true,
        ..Curve::default()
    });
    let dots = Curve { name: name.to_owned(), colour, points, has_dots: true, ..Curve::default() };
    std::iter::once(dots).chain(line).collect()
}

/// Draws the figure.
pub fn figure() -> Result<String, Box<dyn Error>> {
    let table = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/speed/scaling.csv"))?;
    let grains = rows(&table, "grains")?;
    let sites = rows(&table, "lattice")?;
    let panel = |title, label, value: fn(&Row) -> f64, bound| {
        let points = |rows: &[Row]| rows.iter().map(|row| (row.0, value(row))).collect::<Vec<_>>();
        let mut all = curves("grains: settled bed, plane, no friction", 1, points(&grains), bound);
        all.extend(curves("sites of the lattice gas", 2, points(&sites), bound));
        let within = |axis: fn(&(f64, f64)) -> f64| all.iter().flat_map(move |curve| curve.points.iter().map(axis));
        let mut y = Axis::logarithmic(label, within(|point| point.1));
        // Space for the names of the curves at the bottom.
        y.from /= 10.0;
        let x = Axis::logarithmic("grains, sites", within(|point| point.0));
        Panel { curves: all, key: Key::LowerLeft, ..Panel::new(title, x, y) }
    };
    let time = panel("One core: time of a step", "ns per particle-step or site-step", |row| row.1, BOUNDS.0);
    let memory = panel("Largest memory of the run", "bytes per grain or site", |row| row.2, BOUNDS.1);
    Ok(sheet(&[time, memory], 2))
}
