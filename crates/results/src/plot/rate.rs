//! The rate of a discharge from the amount that is out over time, with its 95 % confidence interval.
//!
//! The rate is a mean over the time in which the amount grows from 10 to 90 % of its end: neither the start of the flow nor
//! its thin end counts. This time is divided into up to sixteen blocks, whose rates are taken as independent; the interval is
//! from Student's distribution. A block has at least two rows.
//!
//! A rate that changes steadily has no such interval: its blocks are no sample of one rate. If the slope of a straight line through the rates of the blocks
//! differs from zero (Student's test, 1 %), the fit has the rates at the ends of that line in its place.

use siloflow_figures::statistics::line::{Gradient, Line};
use siloflow_figures::statistics::quantile::student;
use siloflow_figures::statistics::rate::Rate;

/// A rate and the line that it makes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Mean rate, per unit of time; without an interval if it changes.
    pub rate: Rate,
    /// The rates at both ends of the time, if the rate changes steadily.
    pub change: Option<Change>,
    /// Point at the start of the line: time and amount.
    pub start: (f64, f64),
    /// Point at its end.
    pub end: (f64, f64),
}

/// A steady change of a rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Change {
    /// The rate at the start, per unit of time.
    pub from: f64,
    /// The rate at the end.
    pub to: f64,
}

/// Most blocks.
const BLOCKS: usize = 16;

impl Fit {
    /// Returns the fit to rows (time, amount out), which are in order of time; `None` if nothing flows, or in less than two rows.
    #[must_use]
    #[expect(clippy::cast_precision_loss, reason = "few blocks")]
    pub fn of(rows: &[(f64, f64)]) -> Option<Self> {
        let all = rows.last()?.1;
        let from = time_of(rows, 0.1 * all)?;
        let to = time_of(rows, 0.9 * all)?;
        if to <= from {
            return None;
        }
        let inside = rows.iter().filter(|row| (from..=to).contains(&row.0)).count();
        let blocks = (inside / 2).clamp(1, BLOCKS);
        let length = (to - from) / blocks as f64;
        let edge = |number: usize| amount_at(rows, from + number as f64 * length);
        let rates: Vec<_> = (0..blocks).map(|block| (edge(block + 1) - edge(block)) / length).collect();
        let change = change(&rates);
        let mut rate = Rate::of(&rates);
        if change.is_some() {
            (rate.low, rate.high) = (None, None);
        }
        Some(Self { rate, change, start: (from, 0.1 * all), end: (to, 0.9 * all) })
    }
}

/// Returns the change of the rates of successive blocks; `None` if chance explains it.
#[expect(clippy::cast_precision_loss, reason = "few blocks")]
fn change(rates: &[f64]) -> Option<Change> {
    let points: Vec<_> = rates.iter().enumerate().map(|(block, rate)| (block as f64 + 0.5, *rate)).collect();
    let line = Line::through(&points)?;
    let error = line.error(Gradient { by_intercept: 0.0, by_slope: 1.0 })?;
    let limit = student(0.99, rates.len().checked_sub(2)?);
    // Rounding of a steady flow is no change.
    let least = (limit * error).max(1e-6 * line.intercept.abs());
    let at = |block: f64| line.intercept + line.slope * block;
    (line.slope.abs() > least).then(|| Change { from: at(0.0), to: at(rates.len() as f64) })
}

/// Returns the time at which the amount reaches `amount`, linear between rows.
fn time_of(rows: &[(f64, f64)], amount: f64) -> Option<f64> {
    let after = rows.iter().position(|row| row.1 >= amount && row.1 > 0.0)?;
    let (t, m) = rows[after];
    let Some(&(t_before, m_before)) = after.checked_sub(1).map(|before| &rows[before]) else { return Some(t) };
    Some(t_before + (t - t_before) * (amount - m_before) / (m - m_before))
}

/// Returns the amount at a time, linear between rows.
fn amount_at(rows: &[(f64, f64)], time: f64) -> f64 {
    let after = rows.partition_point(|row| row.0 < time);
    let Some(&(t, m)) = rows.get(after) else { return rows.last().map_or(0.0, |row| row.1) };
    let Some(&(t_before, m_before)) = after.checked_sub(1).map(|before| &rows[before]) else { return m };
    m_before + (m - m_before) * (time - t_before) / (t - t_before)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_steady_flow_has_its_rate_and_no_uncertainty() {
        // Nothing until 2 s, then 5 a second.
        let rows: Vec<_> = (0..=100).map(|n| 0.1 * f64::from(n)).map(|t| (t, (5.0 * (t - 2.0)).max(0.0))).collect();
        let fit = Fit::of(&rows).unwrap();
        let Rate { mean, low, high } = fit.rate;
        assert!((mean - 5.0).abs() < 1e-9 && high.unwrap() - low.unwrap() < 1e-9, "{fit:?}");
        assert!((fit.start.0 - 2.8).abs() < 1e-9 && (fit.end.0 - 9.2).abs() < 1e-9, "{fit:?}");
    }

    #[test]
    fn a_flow_with_pauses_has_an_interval_around_the_mean() {
        // A unit each second, in the first half of each second.
        let amount = |t: f64| t.floor() + (2.0 * t.fract()).min(1.0);
        let rows: Vec<_> = (0..=2500).map(|n| 0.01 * f64::from(n)).map(|t| (t, amount(t))).collect();
        let fit = Fit::of(&rows).unwrap();
        let Rate { mean, low, high } = fit.rate;
        assert!((mean - 1.0).abs() < 0.05 && fit.change.is_none(), "{fit:?}");
        assert!(low.unwrap() < mean && mean < high.unwrap(), "{fit:?}");
    }

    #[test]
    fn a_rate_that_falls_has_its_ends_and_no_interval() {
        // The rate falls from 10 at 0 s to 0 at 20 s: at 10 % out, 1.03 s, it is 9.49, at 90 %, 13.7 s, 3.16.
        let rows: Vec<_> = (0..=2000).map(|n| 0.01 * f64::from(n)).map(|t| (t, 10.0 * t - 0.25 * t * t)).collect();
        let fit = Fit::of(&rows).unwrap();
        let Change { from, to } = fit.change.unwrap();
        assert!((from - 10.0 * 0.9f64.sqrt()).abs() < 0.02 && (to - 10.0 * 0.1f64.sqrt()).abs() < 0.02, "{fit:?}");
        assert_eq!((fit.rate.low, fit.rate.high), (None, None));
    }

    #[test]
    fn nothing_that_flows_has_no_rate() {
        assert_eq!(Fit::of(&[]), None);
        assert_eq!(Fit::of(&[(0.0, 0.0), (1.0, 0.0)]), None);
        assert_eq!(Fit::of(&[(0.0, 3.0)]), None);
    }
}
