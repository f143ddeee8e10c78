//! Pressure and friction on walls by height (`wall_bands.csv`), at rest and in flow.
//!
//! | curve | averaging time |
//! |---|---|
//! | at rest | the last one with contacts that ends before the door opens; without a door the last one with contacts |
//! | in flow | the first one with contacts that begins when the door has opened |
//! | Janssen | a fit to the pressure at rest |
//!
//! Janssen's law for the pressure at the depth z below the top of the bed is p = P (1 - exp(-z / L)): P is the pressure far down, and L the depth over which it is
//! reached (H. A. Janssen, Z. VDI 39, 1045, 1895). Both are fitted by least squares; the top is the upper end of the highest bin with contacts. The law is
//! one of a vertical wall: bins of a hopper do not follow it.
//!
//! Of several runs each has its curve at rest, and no fit.

use siloflow_figures::diagram::{Axis, Curve, Key, Panel, colour};
use siloflow_figures::statistics::digits::digits;
use siloflow_figures::statistics::least_squares;
use siloflow_files::table::Table;
use siloflow_text::fault::Fault;

use super::by_height::{numbered, numbers, tables};
use crate::run_results::RunResults;

/// Columns of `wall_bands.csv`: name, title and label.
const COLUMNS: [(&str, &str, &str); 4] = [
    ("pressure_pa", "Pressure on walls", "pressure, Pa"),
    ("downward_traction_pa", "Friction on walls", "downward traction, Pa"),
    ("pressure_n_per_m", "Pressure on walls", "pressure, N/m"),
    ("downward_traction_n_per_m", "Friction on walls", "downward traction, N/m"),
];

/// Least number of bins with contacts of a fit.
const LEAST_BINS: usize = 5;

/// Points of the curve of the law.
const POINTS: u16 = 60;

/// An averaging time of one entry, with the rows of its bins.
struct Average {
    from: f64,
    to: f64,
    rows: Vec<usize>,
}

/// The averaging times of an entry that show the bed.
struct Shown {
    rest: Option<Average>,
    flow: Option<Average>,
}

pub(super) fn panels(runs: &[&RunResults]) -> Result<Vec<Panel>, Fault> {
    let tables = tables(runs, "wall_bands.csv")?;
    let mut panels = Vec::new();
    for number in numbers(&tables, "bands") {
        for (column, title, label) in COLUMNS {
            let of_run = |(place, table): &(usize, Table)| curves(runs, *place, table, &number, column);
            let curves: Vec<Curve> = tables.iter().filter_map(of_run).flatten().collect();
            if curves.iter().any(|curve| curve.points.iter().any(|point| point.0.is_finite())) {
                let points = || curves.iter().flat_map(|curve| curve.points.iter());
                let x = Axis::around(label, points().map(|point| point.0).chain([0.0]));
                let y = Axis::around("height, m", points().map(|point| point.1));
                let title = numbered(title, &number, &tables, "bands");
                panels.push(Panel { curves, key: Key::Above, ..Panel::new(title, x, y) });
            }
        }
    }
    Ok(panels)
}

/// Returns the curves of a run.
fn curves(runs: &[&RunResults], place: usize, table: &Table, number: &str, column: &str) -> Option<Vec<Curve>> {
    let values = table.numbers(column)?;
    let ends = table.numbers("low_m")?.into_iter().zip(table.numbers("high_m")?);
    let heights: Vec<_> = ends.map(|(low, high)| 0.5 * (low + high)).collect();
    let points = |average: &Average| average.rows.iter().map(|&row| (values[row], heights[row])).collect::<Vec<_>>();
    let line = |name: String, number: usize, points: Vec<(f64, f64)>| Curve {
        name,
        colour: colour(number),
        points,
        has_line: true,
        has_dots: true,
        ..Curve::default()
    };
    let Shown { rest, flow } = shown(table, number, runs[place].opening())?;
    if runs.len() > 1 {
        return Some(vec![line(runs[place].name.clone(), place, points(&rest.or(flow)?))]);
    }
    let named =
        |what: &str, average: &Average| format!("{what}, {} to {} s", digits(average.from, 3), digits(average.to, 3));
    let mut curves = Vec::new();
    if let Some(rest) = &rest {
        let what = if runs[place].opening().is_some() { "at rest" } else { "mean" };
        curves.push(line(named(what, rest), 1, points(rest)));
        let unit = if column.ends_with("_pa") { "Pa" } else { "N/m" };
        curves.extend(column.starts_with("pressure").then(|| janssen(table, rest, &values, unit)).flatten());
    }
    curves.extend(flow.iter().map(|flow| line(named("in flow", flow), 2, points(flow))));
    Some(curves)
}

/// Returns the averaging times of an entry that show the bed.
fn shown(table: &Table, number: &str, opening: Option<f64>) -> Option<Shown> {
    let entries = table.texts("bands")?;
    let [starts, ends, contacts] = ["from_s", "to_s", "contacts"].map(|name| table.numbers(name));
    let (starts, ends, contacts) = (starts?, ends?, contacts?);
    let mut all: Vec<Average> = Vec::new();
    for row in (0..table.len()).filter(|&row| entries[row] == number) {
        match all.iter_mut().find(|average| average.to.to_bits() == ends[row].to_bits()) {
            Some(average) => average.rows.push(row),
            None => all.push(Average { from: starts[row], to: ends[row], rows: vec![row] }),
        }
    }
    all.retain(|average| average.rows.iter().any(|&row| contacts[row] > 0.0));
    let open = opening.unwrap_or(f64::INFINITY);
    let flow = all.iter().position(|average| average.from >= open).map(|place| all.swap_remove(place));
    let before = |average: &Average| average.to <= open;
    let last = all.iter().enumerate().filter(|(_, it)| before(it)).max_by(|a, b| a.1.to.total_cmp(&b.1.to));
    // One average over the whole run lies neither before nor after the opening.
    let place = last.map(|(place, _)| place).or((flow.is_none() && !all.is_empty()).then_some(0));
    Some(Shown { rest: place.map(|place| all.swap_remove(place)), flow })
}

/// Returns the curve of Janssen's law through the pressures at rest; `None` if they do not determine it.
fn janssen(table: &Table, rest: &Average, pressures: &[f64], unit: &str) -> Option<Curve> {
    let [lows, highs, contacts] = ["low_m", "high_m", "contacts"].map(|name| table.numbers(name));
    let (lows, highs, contacts) = (lows?, highs?, contacts?);
    let bins: Vec<usize> =
        rest.rows.iter().copied().filter(|&row| contacts[row] > 0.0 && pressures[row].is_finite()).collect();
    let top = bins.iter().map(|&row| highs[row]).fold(f64::NEG_INFINITY, f64::max);
    let bottom = bins.iter().map(|&row| lows[row]).fold(f64::INFINITY, f64::min);
    let points: Vec<_> = bins.iter().map(|&row| (top - 0.5 * (lows[row] + highs[row]), pressures[row])).collect();
    let most = points.iter().map(|point| point.1).fold(0.0, f64::max);
    let law = |depth: f64, [far, length]: &[f64; 2]| {
        if *length > 0.0 { far * (1.0 - (-depth / length).exp()) } else { f64::NAN }
    };
    let fit =
        (points.len() >= LEAST_BINS).then(|| least_squares::fit(&law, &points, [most, 0.3 * (top - bottom)]))??;
    let [far, length] = fit.values;
    // A straight line has no length, and noise has no law.
    if !(far > 0.0 && length > 0.0 && length < 10.0 * (top - bottom)) || fit.rms > 0.5 * most {
        return None;
    }
    let height = |n| bottom + (top - bottom) * f64::from(n) / f64::from(POINTS);
    Some(Curve {
        name: format!("Janssen: P = {} {unit}, L = {} m", digits(far, 3), digits(length, 2)),
        colour: colour(0),
        points: (0..=POINTS).map(|n| (law(top - height(n), &fit.values), height(n))).collect(),
        has_line: true,
        is_dashed: true,
        ..Curve::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two averaging times before the opening at 2 s, two after it; the last one is of an empty silo.
    fn table() -> Table {
        let mut text = String::from("bands,from_s,to_s,low_m,high_m,contacts,pressure_pa\n");
        for (from, factor) in [(0.0, 0.1), (1.0, 1.0), (2.0, 2.0), (3.0, 0.0)] {
            for bin in 0..10u8 {
                let low = 0.1 * f64::from(bin);
                let pressure = factor * 500.0 * (1.0 - (-(0.95 - low) / 0.2).exp());
                let contacts = if factor > 0.0 { 5 } else { 0 };
                let (to, high) = (from + 1.0, low + 0.1);
                text.extend([format!("1,{from},{to},{low},{high},{contacts},{pressure}\n")]);
            }
        }
        Table::parse("wall_bands.csv", &text).unwrap()
    }

    #[test]
    fn rest_is_before_the_opening_and_flow_after_it() {
        let table = table();
        let Shown { rest, flow } = shown(&table, "1", Some(2.0)).unwrap();
        assert!((rest.unwrap().from - 1.0).abs() < 1e-12 && (flow.unwrap().from - 2.0).abs() < 1e-12);
        // Without a door the last average with contacts is shown.
        let Shown { rest, flow } = shown(&table, "1", None).unwrap();
        assert!((rest.unwrap().from - 2.0).abs() < 1e-12 && flow.is_none());
    }

    #[test]
    fn the_fit_finds_the_numbers_of_janssen_s_law() {
        let table = table();
        let rest = shown(&table, "1", Some(2.0)).unwrap().rest.unwrap();
        let curve = janssen(&table, &rest, &table.numbers("pressure_pa").unwrap(), "Pa").unwrap();
        assert_eq!(curve.name, "Janssen: P = 500 Pa, L = 0.20 m");
    }
}
