//! Discharge by number and by mass: rates with confidence intervals and fits, from `summary.json` and `series.csv`.
//!
//! | figure | source |
//! |---|---|
//! | rate between 10 % and 90 % of the grains out | `discharge` of the summary |
//! | mean and 95 % confidence interval | `series.csv` between the same moments, in [`BLOCKS`] or fewer blocks of equal time: mean of their rates, with Student's t |
//! | straight line | least squares through the rows between these moments |
//! | window of the scene | `outflow` of the summary |
//!
//! The intervals are sound if the flows of successive blocks are independent. A block has at least two rows.

use crate::measure::outflow::{BLOCKS, Rate};
use crate::report::html::{Section, quantity};
use crate::report::run::Run;
use crate::report::sheet::{Cell, Sheet};

/// Rates between a tenth and nine tenths of all that is out, from rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Start and end of the time between these moments.
    pub window: [f64; 2],
    /// Number of blocks.
    pub blocks: usize,
    /// Mean rate of the blocks, and its confidence interval.
    pub rate: Rate,
    /// Slope of the line of least squares.
    pub slope: f64,
    /// Where the line is zero.
    pub zero: f64,
}

impl Fit {
    /// Fits the rates of `amount`, which is out at each of `times`, between a tenth and nine tenths of the last row of `out`. `None` with
    /// fewer than eight rows between.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "numbers of rows and blocks")]
    pub fn of(times: &[f64], out: &[f64], amount: &[f64]) -> Option<Self> {
        let all = *out.last()?;
        let from = out.iter().position(|&out| out >= 0.1 * all && out > 0.0)?;
        let to = out.iter().position(|&out| out >= 0.9 * all)?;
        if to < from + 8 {
            return None;
        }
        let (times, amount) = (&times[from..=to], &amount[from..=to]);
        let window = [times[0], *times.last()?];
        let blocks = BLOCKS.min((to - from) / 2);
        let length = (window[1] - window[0]) / blocks as f64;
        let edges: Vec<f64> =
            (0..=blocks).map(|block| between(times, amount, window[0] + length * block as f64)).collect();
        let rates: Vec<f64> = edges.windows(2).map(|edge| (edge[1] - edge[0]) / length).collect();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let (t, n) = (mean(times), mean(amount));
        let (mut both, mut square) = (0.0, 0.0);
        for (&time, &amount) in times.iter().zip(amount) {
            both += (time - t) * (amount - n);
            square += (time - t).powi(2);
        }
        let slope = both / square;
        (slope.is_finite() && slope > 0.0).then(|| Self {
            window,
            blocks,
            rate: Rate::of(&rates),
            slope,
            zero: t - n / slope,
        })
    }

    /// The fit of a column of a run's series, such as `out`.
    #[must_use]
    pub fn of_column(run: &Run, column: &str) -> Option<Self> {
        let times = run.series.numbers(time_column(run))?;
        Self::of(&times, &run.series.numbers("out")?, &run.series.numbers(column)?)
    }
}

/// The name of the column of time.
#[must_use]
pub fn time_column(run: &Run) -> &'static str {
    if run.is_lattice() { "step" } else { "time_s" }
}

/// The value of a rising curve at a time, between two rows by a straight line.
fn between(times: &[f64], values: &[f64], time: f64) -> f64 {
    let after = times.partition_point(|&row| row < time).clamp(1, times.len() - 1);
    let share = ((time - times[after - 1]) / (times[after] - times[after - 1])).clamp(0.0, 1.0);
    values[after - 1] + share * (values[after] - values[after - 1])
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
        row(&format!("Mean of blocks, by {name}"), &|run| {
            interval(Fit::of_column(run, column).map(|fit| fit.rate), unit(run))
        });
        row(&format!("Straight line, by {name}"), &|run| {
            Cell::of(Fit::of_column(run, column).map(|fit| fit.slope), unit(run))
        });
    }
    row("From, to", &|run| window(run));
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
    let note = format!(
        "<p class=\"note\">A mean of blocks is that of at most {BLOCKS} equal parts of the time between 10 % and 90 % out, from \
         <code>series.csv</code>, with its 95 % confidence interval (Student's t; sound if successive blocks are independent). \
         The straight line is that of least squares through the rows of the same time.</p>\n"
    );
    Section::of("discharge", "Discharge", sheet.html("Discharge by number and by mass", labels) + &note)
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
    Fit::of_column(run, "out").map_or(Cell::Nothing, |fit| {
        Cell::Html(format!(
            "{} to {}, {} blocks",
            quantity(fit.window[0], unit),
            quantity(fit.window[1], unit),
            fit.blocks
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steady_flow_has_its_rate_and_no_width() {
        // Nothing until 2 s, then 5/s.
        let times: Vec<f64> = (0..=300).map(|row| 0.05 * f64::from(row)).collect();
        let out: Vec<f64> = times.iter().map(|time| 5.0 * (time - 2.0).max(0.0)).collect();
        let fit = Fit::of(&times, &out, &out).unwrap();
        let Rate { mean, low, high } = fit.rate;
        assert!([mean, low.unwrap(), high.unwrap(), fit.slope].iter().all(|rate| (rate - 5.0).abs() < 1e-9), "{fit:?}");
        assert!((fit.zero - 2.0).abs() < 1e-9 && fit.blocks == BLOCKS, "{fit:?}");
        assert_eq!(Fit::of(&times[..5], &out[..5], &out[..5]), None);
        assert_eq!(Fit::of(&[], &[], &[]), None);
    }

    #[test]
    fn the_interval_is_that_of_the_blocks() {
        // Eighty rows of 1 s, in turn 1 and 3 grains in each of sixteen blocks of five: mean 2, deviation sqrt(16/15).
        let rate = |row: i32| if (row / 5) % 2 == 0 { 1.0 } else { 3.0 };
        let times: Vec<f64> = (0..=100).map(f64::from).collect();
        let mut out = vec![20.0];
        (0..100).for_each(|row| out.push(out.last().unwrap() + if row < 80 { rate(row) } else { 0.2 }));
        // From 20 (a tenth of 184 is less) to 0.9 of 184: fewer rows than eighty, so the blocks do not fall on the pattern.
        let fit = Fit::of(&times, &out, &out).unwrap();
        assert!(fit.rate.low.unwrap() < 2.0 && fit.rate.high.unwrap() > 2.0, "{fit:?}");
        assert!((fit.rate.mean - 2.0).abs() < 0.1, "{fit:?}");
    }
}
