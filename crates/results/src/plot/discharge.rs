//! The figure of the discharge: number and mass of the grains that are out over time, each with its mean rate, and the rate over
//! time.
//!
//! If several runs all have a door that opened, their times count from the opening. The figure of one run begins a little before the opening.

use super::over_time::{marks, thinned};
use super::rate::{Change, Fit};
use crate::run_results::RunResults;
use siloflow_figures::diagram::{Axis, Clock, Curve, Key, Panel, colour};
use siloflow_figures::statistics::digits::digits;

/// A quantity that leaves.
struct Quantity {
    column: &'static str,
    title: &'static str,
    label: &'static str,
    /// Unit of the rate without the unit of time.
    unit: &'static str,
}

const QUANTITIES: [Quantity; 2] = [
    Quantity { column: "out", title: "Grains that are out", label: "grains", unit: "grains" },
    Quantity { column: "out_kg", title: "Mass that is out", label: "mass, kg", unit: "kg" },
];

pub(super) fn panels(runs: &[&RunResults]) -> Vec<Panel> {
    let openings: Option<Vec<_>> = runs.iter().map(|run| run.opening()).collect();
    let starts = openings.filter(|_| runs.len() > 1);
    let rows = |number: usize, column: &str| -> Option<Vec<(f64, f64)>> {
        let start = starts.as_ref().map_or(0.0, |starts| starts[number]);
        let rows = runs[number].times().into_iter().zip(runs[number].series.numbers(column)?);
        let rows = rows.map(|(time, amount)| (time - start, amount)).filter(|row| row.1.is_finite());
        // Rows from the opening on, or of one run from a little before it.
        let from = if starts.is_some() {
            0.0
        } else {
            runs[number].opening().map_or(f64::NEG_INFINITY, |open| lead(open, runs[number]))
        };
        Some(rows.filter(|row| row.0 >= from).collect())
    };
    let mut panels = Vec::new();
    for quantity in &QUANTITIES {
        let mut curves = Vec::new();
        for (number, run) in runs.iter().enumerate() {
            let Some(rows) = rows(number, quantity.column).filter(|rows| rows.iter().any(|row| row.1 > 0.0)) else {
                continue;
            };
            let name = if runs.len() == 1 { String::new() } else { run.name.clone() };
            curves.extend(with_fit(run, quantity, number, name, &rows));
        }
        if !curves.is_empty() {
            panels.push(panel(runs, quantity.title, quantity.label, curves, starts.is_some()));
        }
    }
    let mut rates = Vec::new();
    for (number, run) in runs.iter().enumerate() {
        let Some(rows) = rows(number, "out").filter(|rows| rows.iter().any(|row| row.1 > 0.0)) else { continue };
        let name = if runs.len() == 1 { String::new() } else { run.name.clone() };
        rates.push(Curve { name, colour: colour(number), points: rates_of(&rows), has_line: true, ..Curve::default() });
    }
    if !rates.is_empty() {
        let label = if runs.iter().any(|run| run.is_lattice()) { "grains/step" } else { "grains/s" };
        panels.push(panel(runs, "Rate of discharge", label, rates, starts.is_some()));
    }
    panels
}

/// Returns the time at which the figure of a run begins: before the opening by a twentieth of the time after it.
fn lead(open: f64, run: &RunResults) -> f64 {
    let last = run.times().last().copied().unwrap_or(open);
    open - 0.05 * (last - open)
}

/// Intervals of the rate over time.
const INTERVALS: usize = 50;

/// Returns the rate in fifty equal intervals between the first departure and the end, or between rows if they are fewer, at the middle
/// of each interval.
fn rates_of(rows: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let first = rows.iter().position(|row| row.1 > 0.0).unwrap_or(0).saturating_sub(1);
    let rows = &rows[first..];
    let (Some(start), Some(end)) = (rows.first(), rows.last()) else { return Vec::new() };
    #[expect(clippy::cast_precision_loss, reason = "few intervals")]
    let length = (end.0 - start.0) / INTERVALS.min(rows.len() - 1).max(1) as f64;
    let mut rates = Vec::new();
    let mut before = *start;
    for &row in &rows[1..] {
        // A hundredth of an interval is left for rounding.
        if row.0 - before.0 >= 0.99 * length {
            rates.push((0.5 * (before.0 + row.0), (row.1 - before.1) / (row.0 - before.0)));
            before = row;
        }
    }
    rates
}

/// Returns the curve of an amount, and the line of its mean rate.
fn with_fit(run: &RunResults, quantity: &Quantity, number: usize, name: String, rows: &[(f64, f64)]) -> Vec<Curve> {
    // Among several runs, the line has the colour of its run.
    let line_colour = if name.is_empty() { colour(2) } else { colour(number) };
    let curve = Curve { name, colour: colour(number), points: thinned(rows), has_line: true, ..Curve::default() };
    let Some(fit) = Fit::of(rows) else { return vec![curve] };
    let per = if run.is_lattice() { "step" } else { "s" };
    let line = Curve {
        name: in_words(&fit, &format!("{}/{per}", quantity.unit)),
        colour: line_colour,
        points: vec![fit.start, fit.end],
        has_line: true,
        is_dashed: true,
        ..Curve::default()
    };
    vec![curve, line]
}

/// Returns a rate with its interval, for example `mean rate 184 grains/s (95 %: 180 to 188)`, or with its change, for example `mean rate 52.8 grains/s,
/// falls from 62 to 43`.
fn in_words(Fit { rate, change, .. }: &Fit, unit: &str) -> String {
    if let Some(Change { from, to }) = change {
        let way = if to < from { "falls" } else { "rises" };
        return format!(
            "mean rate {} {unit}, {way} from {} to {}",
            digits(rate.mean, 3),
            digits(*from, 2),
            digits(*to, 2)
        );
    }
    // Two digits of the half of the interval, but not more than five of the mean.
    let size = rate.high.map_or(0.0, |high| high - rate.mean).max(1e-3 * rate.mean.abs());
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let decimals = (1.0 - size.log10().floor()).clamp(0.0, 9.0) as usize;
    match (rate.low, rate.high) {
        (Some(low), Some(high)) => {
            format!("mean rate {:.decimals$} {unit} (95 %: {low:.decimals$} to {high:.decimals$})", rate.mean)
        }
        _ => format!("mean rate {:.decimals$} {unit}", rate.mean),
    }
}

fn panel(runs: &[&RunResults], title: &str, label: &'static str, curves: Vec<Curve>, is_since_opening: bool) -> Panel {
    let all = || curves.iter().flat_map(|curve| curve.points.iter());
    let last = all().map(|point| point.0).fold(0.0, f64::max);
    let time = match (is_since_opening, runs.iter().any(|run| run.is_lattice())) {
        (false, _) => runs.first().map_or("", |run| run.time_label()),
        (true, false) => "time since the door opened, s",
        (true, true) => "time since the door opened, steps",
    };
    let first = match runs {
        [run] => run.opening().map_or(0.0, |open| lead(open, run).max(0.0)),
        _ => 0.0,
    };
    let x = Axis::linear(time, first, if last > first { last } else { first + 1.0 });
    let y = Axis::around(label, all().map(|point| point.1).chain([0.0]));
    let clock = Some(if is_since_opening { Clock::Opening } else { Clock::Run });
    let marks = if is_since_opening { Vec::new() } else { marks(runs) };
    Panel { curves, marks, key: Key::Above, clock, ..Panel::new(title, x, y) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use siloflow_figures::statistics::rate::Rate;

    #[test]
    fn the_rate_of_a_steady_flow_is_constant_and_starts_with_the_flow() {
        let rows: Vec<_> = (0..=1000).map(|n| 0.01 * f64::from(n)).map(|t| (t, (7.0 * (t - 5.0)).max(0.0))).collect();
        let rates = rates_of(&rows);
        assert!((45..=55).contains(&rates.len()) && rates[0].0 > 5.0, "{rates:?}");
        assert!(rates.iter().all(|rate| (rate.1 - 7.0).abs() < 1e-9), "{rates:?}");
        assert_eq!(rates_of(&[(0.0, 0.0), (1.0, 4.0)]), [(0.5, 4.0)]);
    }

    #[test]
    fn a_rate_has_the_digits_of_its_interval() {
        let fit = |mean: f64, half: f64| {
            let rate = Rate { mean, low: Some(mean - half), high: Some(mean + half) };
            Fit { rate, change: None, start: (0.0, 0.0), end: (1.0, 1.0) }
        };
        let rate = |mean, half| in_words(&fit(mean, half), "kg/s");
        let falls = Fit { change: Some(Change { from: 61.7, to: 43.2 }), ..fit(52.82, 1.0) };
        assert_eq!(in_words(&falls, "kg/s"), "mean rate 52.8 kg/s, falls from 62 to 43");
        assert_eq!(rate(51.6234, 3.61), "mean rate 51.6 kg/s (95 %: 48.0 to 55.2)");
        assert_eq!(rate(0.012_34, 0.0002), "mean rate 0.01234 kg/s (95 %: 0.01214 to 0.01254)");
        let alone = Fit { rate: Rate { mean: 3.0, low: None, high: None }, ..falls };
        assert_eq!(in_words(&Fit { change: None, ..alone }, "grains/s"), "mean rate 3.0000 grains/s");
    }
}
