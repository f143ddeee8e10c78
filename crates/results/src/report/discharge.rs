//! Discharge by number and by mass: rates with confidence intervals, from `summary.json` and `series.csv`.
//!
//! | figure | source |
//! |---|---|
//! | rate between 10 % and 90 % of the grains out | `discharge` of the summary |
//! | mean with its 95 % confidence interval | [`Fit`] to `series.csv`, as drawn in the figure of the discharge |
//! | window of the scene | `outflow` of the summary |

use crate::plot::rate::Fit;
use crate::report::html::{Section, quantity};
use crate::report::run::Run;
use crate::report::sheet::{Cell, Sheet};
use siloflow_figures::statistics::rate::Rate;

/// The fit to a column of a run's series, such as `out`.
fn fit(run: &Run, column: &str) -> Option<Fit> {
    let rows: Vec<_> = run.files.times().into_iter().zip(run.column(column)?).collect();
    Fit::of(&rows)
}

/// The section of the discharge; nothing if no run has one.
#[must_use]
pub fn section_of(runs: &[Run], labels: &[String]) -> Option<Section> {
    let mut sheet = Sheet::default();
    let mut row = |name: &str, of: &dyn Fn(&Run) -> Cell| sheet.add(name, runs.iter().map(of).collect());
    row("Door opened", &|run| moment(run, "door_open"));
    row("First grain to last", &|run| Cell::of(run.number("/discharge/duration_s"), "s"));
    row("Rate by number, 10 to 90 % out", &|run| Cell::of(run.number("/discharge/rate_per_s"), "grains/s"));
    row("Rate by mass, 10 to 90 % out", &|run| Cell::of(run.number("/discharge/rate_kg_per_s"), "kg/s"));
    for (name, column, units) in
        [("number", "out", ["grains/s", "particles/step"]), ("mass", "out_kg", ["kg/s", "kg/step"])]
    {
        let unit = |run: &Run| units[usize::from(run.is_lattice())];
        row(&format!("Mean with 95 % interval, by {name}"), &|run| {
            interval(fit(run, column).map(|fit| fit.rate), unit(run))
        });
    }
    row("Time of this mean", &window);
    row("Window <code>outflow</code>: grains", &|run| Cell::of(run.number("/outflow/grains"), "grains"));
    row("Window <code>outflow</code>: by number", &|run| interval(rate(run, "rate_per_s"), "grains/s"));
    row("Window <code>outflow</code>: by mass", &|run| interval(rate(run, "rate_kg_per_s"), "kg/s"));
    row("Residence time, mean", &|run| Cell::of(run.number("/outflow/residence_s/mean"), "s"));
    row("Residence time, deviation", &|run| Cell::of(run.number("/outflow/residence_s/deviation"), "s"));
    row("Segregation index", &|run| Cell::of(run.number("/outflow/segregation_index"), ""));
    row("Mass-flow index", &|run| Cell::of(run.number("/outflow/mass_flow_index/value"), ""));
    if sheet.is_empty() {
        return None;
    }
    let has_mean = runs.iter().any(|run| fit(run, "out").is_some());
    let note = "<p class=\"note\">The mean with its interval is that of up to 16 equal parts of the time between 10 % and 90 % out, from \
                <code>series.csv</code> (Student's t; sound if successive parts are independent). A rate that falls or rises steadily has no interval. It is the straight line in the figure \
                of the discharge.</p>\n";
    let note = if has_mean { note } else { "" };
    Section::of("discharge", "Discharge", sheet.html("Discharge by number and by mass", labels) + note)
}

/// The time of an event, in the clock of the run.
fn moment(run: &Run, event: &str) -> Cell {
    match run.number(&format!("/{event}_time_s")) {
        None => Cell::of(run.number(&format!("/{event}_step")), "steps"),
        time => Cell::of(time, "s"),
    }
}

/// A rate of the scene's window.
fn rate(run: &Run, key: &str) -> Option<Rate> {
    let number = |end: &str| run.number(&format!("/outflow/{key}/{end}"));
    Some(Rate { mean: number("mean")?, low: number("low"), high: number("high") })
}

/// A mean with its interval. It is a number, so that ratios of means are shown.
fn interval(rate: Option<Rate>, unit: &'static str) -> Cell {
    match rate {
        None => Cell::Nothing,
        Some(Rate { mean, low: Some(low), .. }) => Cell::Interval(mean, mean - low, unit.into()),
        Some(Rate { mean, .. }) => Cell::of(Some(mean), unit),
    }
}

/// Start and end of the time of the fit.
fn window(run: &Run) -> Cell {
    let unit = if run.is_lattice() { "steps" } else { "s" };
    fit(run, "out").map_or(Cell::Nothing, |fit| {
        Cell::Html(format!("{} to {}", quantity(fit.start.0, unit), quantity(fit.end.0, unit)))
    })
}
