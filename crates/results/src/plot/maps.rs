//! Maps of fields in the last averaging time: solid fraction, speed and granular temperature of `fields.csv`, and the speed of
//! `flow.csv`. Of a grid in three directions the map shows the middle layer along axis 2.

use super::by_height::last_rows;
use crate::run_results::RunResults;
use siloflow_figures::colour::viridis;
use siloflow_figures::diagram::{Axis, Cell, Panel, Scale};
use siloflow_files::table::Table;
use siloflow_text::fault::Fault;

/// A value at a place of a grid: the two coordinates, m, and the value.
type Sample = (f64, f64, f64);

pub(super) fn panels(runs: &[&RunResults]) -> Result<Vec<Panel>, Fault> {
    let mut panels = Vec::new();
    for run in runs {
        let of_run = |title: &str| if runs.len() == 1 { title.to_owned() } else { format!("{}: {title}", run.name) };
        if let Some(fields) = run.table("fields.csv")? {
            panels.extend(of_fields(&fields, &of_run));
        }
        if let Some(flow) = run.table("flow.csv")? {
            let unit = if run.is_lattice() { "m/step" } else { "m/s" };
            panels.extend(of_flow(&flow, unit, &of_run));
        }
    }
    Ok(panels)
}

fn of_flow(table: &Table, unit: &str, title: &dyn Fn(&str) -> String) -> Option<Panel> {
    let velocity = |axis: &str| {
        table.numbers(&format!("v{axis}_m_per_s")).or_else(|| table.numbers(&format!("v{axis}_m_per_step")))
    };
    let x = table.numbers("x_m")?;
    let y = table.numbers("y_m")?;
    let vx = velocity("x")?;
    let vy = velocity("y")?;
    let counts = table.numbers("count")?;
    let samples = (0..table.len()).filter(|&row| counts[row] > 0.0).map(|row| (x[row], y[row], vx[row].hypot(vy[row])));
    map(&samples.collect::<Vec<_>>(), title("Mean speed"), format!("speed, {unit}"), ["x, m", "y, m"])
}

fn of_fields(table: &Table, title: &dyn Fn(&str) -> String) -> Vec<Panel> {
    let mut fields = table.texts("field").unwrap_or_default();
    fields.dedup();
    let axes: Vec<_> = ["x1_m", "x2_m", "x3_m"].into_iter().filter_map(|name| table.numbers(name)).collect();
    let is_plane = axes.len() == 2;
    let mut panels = Vec::new();
    for field in &fields {
        let Some(mut rows) = last_rows(table, "field", field) else { continue };
        let is_resolved =
            |axis: usize| axes.get(axis).is_some_and(|axis| rows.iter().any(|&row| axis[row].is_finite()));
        let (across, up) = match [0, 1, 2].map(is_resolved) {
            [true, true, false] => (0, 1),
            [true, _, true] => (0, 2),
            // A line is no map.
            _ => continue,
        };
        if up == 2 && is_resolved(1) {
            let mut layers: Vec<_> = rows.iter().map(|&row| axes[1][row]).collect();
            layers.sort_by(f64::total_cmp);
            let middle = layers[layers.len() / 2];
            rows.retain(|&row| axes[1][row].total_cmp(&middle).is_eq());
        }
        let labels = match (is_plane, up) {
            (true, _) | (_, 1) => ["x, m", "y, m"],
            _ => ["x or radius, m", "z, m"],
        };
        let number = if fields.len() == 1 { String::new() } else { format!(", field {field}") };
        let squares = ["v1", "v2", "v3"].map(|name| table.numbers(name));
        let speed = |row: usize| squares.iter().flatten().map(|v| v[row] * v[row]).sum::<f64>().sqrt();
        let quantities: [(&str, &str, Option<Vec<f64>>); 3] = [
            ("Solid fraction", "solid fraction", table.numbers("solid_fraction")),
            ("Speed", "speed, m/s", Some((0..table.len()).map(speed).collect())),
            ("Granular temperature", "temperature, m²/s²", table.numbers("temperature")),
        ];
        for (name, label, values) in quantities {
            let Some(values) = values else { continue };
            let samples: Vec<_> = rows.iter().map(|&row| (axes[across][row], axes[up][row], values[row])).collect();
            panels.extend(map(&samples, title(&format!("{name}{number}")), label.to_owned(), labels));
        }
    }
    panels
}

/// Returns a map; `None` if there is no value.
fn map(samples: &[Sample], title: String, label: String, [across, up]: [&'static str; 2]) -> Option<Panel> {
    let seen: Vec<_> = samples.iter().copied().filter(|sample| sample.2.is_finite()).collect();
    let xs = edges(seen.iter().map(|sample| sample.0));
    let ys = edges(seen.iter().map(|sample| sample.1));
    let ends = |edges: &[(f64, f64, f64)]| Some((edges.first()?.1, edges.last()?.2));
    let (x0, x1) = ends(&xs)?;
    let (y0, y1) = ends(&ys)?;
    let scale = Axis::around(label, seen.iter().map(|sample| sample.2).chain([0.0]));
    let cell_of = |edges: &[(f64, f64, f64)], at: f64| edges[edges.partition_point(|edge| edge.0 < at)];
    let cells = seen.iter().map(|&(x, y, value)| {
        let (_, left, right) = cell_of(&xs, x);
        let (_, bottom, top) = cell_of(&ys, y);
        let colour = viridis((value - scale.from) / (scale.to - scale.from));
        Cell { low: (left, bottom), high: (right, top), colour }
    });
    let cells = cells.collect();
    // Equal scales along both axes.
    let wide = 0.5 * ((x1 - x0).max(Panel::ASPECT_WITH_SCALE * (y1 - y0)) - (x1 - x0));
    let high = 0.5 * ((y1 - y0).max((x1 - x0) / Panel::ASPECT_WITH_SCALE) - (y1 - y0));
    let x = Axis::linear(across, x0 - wide, x1 + wide);
    let y = Axis::linear(up, y0 - high, y1 + high);
    Some(Panel { cells, scale: Some(Scale { axis: scale, map: viridis }), ..Panel::new(title, x, y) })
}

/// Returns the cells along an axis from the places of their middles: middle, lower end and upper end, ascending.
fn edges(middles: impl Iterator<Item = f64>) -> Vec<(f64, f64, f64)> {
    let mut middles: Vec<_> = middles.collect();
    middles.sort_by(f64::total_cmp);
    middles.dedup();
    // Cells without a value are absent, so the smallest distance is the size of a cell.
    let size = middles.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let half = if size.is_finite() { 0.5 * size } else { 0.5 };
    middles.into_iter().map(|middle| (middle, middle - half, middle + half)).collect()
}
