//! The rate of a discharge from the amount that is out over time, with its 95 % confidence interval.
//!
//! The rate is a mean over the time in which the amount grows from 10 to 90 % of its end: neither the start of the flow nor
//! its thin end counts. This time is divided into up to sixteen blocks, whose rates are taken as independent; the interval is
//! from Student's distribution. A block has at least two rows.

use siloflow_figures::statistics::rate::Rate;

/// A rate and the line that it makes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Mean rate, per unit of time.
    pub rate: Rate,
    /// Point at the start of the line: time and amount.
    pub start: (f64, f64),
    /// Point at its end.
    pub end: (f64, f64),
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
        Some(Self { rate: Rate::of(&rates), start: (from, 0.1 * all), end: (to, 0.9 * all) })
    }
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
    fn a_flow_that_doubles_half_way_has_a_wide_interval_around_the_mean() {
        let amount = |t: f64| if t < 5.0 { t } else { 5.0 + 2.0 * (t - 5.0) };
        let rows: Vec<_> = (0..=100).map(|n| 0.1 * f64::from(n)).map(|t| (t, amount(t))).collect();
        let Rate { mean, low, high } = Fit::of(&rows).unwrap().rate;
        // From 1.5 out at 1.5 s to 13.5 out at 9.25 s.
        assert!((mean - 12.0 / 7.75).abs() < 1e-9, "{mean}");
        // Blocks have rates of 1 or 2, so the deviation is near 0.5, of 16 blocks: 2.131 * 0.5/4 on each side.
        assert!((0.2..0.35).contains(&(high.unwrap() - mean)) && low.unwrap() < mean);
    }

    #[test]
    fn nothing_that_flows_has_no_rate() {
        assert_eq!(Fit::of(&[]), None);
        assert_eq!(Fit::of(&[(0.0, 0.0), (1.0, 0.0)]), None);
        assert_eq!(Fit::of(&[(0.0, 3.0)]), None);
    }
}
