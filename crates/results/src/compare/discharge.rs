//! Discharge curves: the fraction of the grains that are out, as a function of the time since the door opened.
//!
//! A curve is linear between two rows of `series.csv`. The disagreement of two curves, each in its own unit of time, is
//! the largest difference of their fractions over the times that both cover. Both curves are piecewise linear, so the
//! largest difference occurs at a point of one of them.

/// A discharge curve: points (time, fraction out) in order of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve(Vec<(f64, f64)>);

impl Curve {
    /// Returns the curve through the points (time, fraction), which must be in order of time.
    #[must_use]
    pub fn new(points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        Self(points.into_iter().collect())
    }

    /// Builds the curve from rows (time, grains out) of a run that released `released` grains and opened its door at
    /// the time `opened`.
    #[must_use]
    pub fn of_rows(rows: &[(f64, f64)], released: f64, opened: f64) -> Self {
        let before = rows.iter().rev().find(|row| row.0 <= opened).map_or(0.0, |row| row.1);
        let after = rows.iter().filter(|row| row.0 > opened).map(|row| (row.0 - opened, row.1));
        Self::new(std::iter::once((0.0, before)).chain(after).map(|(time, out)| (time, out / released)))
    }

    /// Returns the points (time, fraction out).
    #[must_use]
    pub fn points(&self) -> &[(f64, f64)] {
        &self.0
    }

    /// Returns the largest fraction of the curve.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.0.iter().map(|point| point.1).fold(0.0, f64::max)
    }

    /// Returns the time at which the curve first reaches the fraction `share`; `None` if it never does.
    #[must_use]
    pub fn time_of(&self, share: f64) -> Option<f64> {
        let after = self.0.iter().position(|point| point.1 >= share)?;
        let (t, s) = self.0[after];
        let Some(&(t_before, s_before)) = after.checked_sub(1).and_then(|before| self.0.get(before)) else {
            return Some(t);
        };
        Some(t_before + (t - t_before) * (share - s_before) / (s - s_before))
    }

    /// Returns the fraction at `time`. Before the first and after the last point it is constant.
    fn share_at(&self, time: f64) -> f64 {
        let after = self.0.partition_point(|point| point.0 < time);
        let Some(&(t, s)) = self.0.get(after) else { return self.0.last().map_or(0.0, |point| point.1) };
        let Some(&(t_before, s_before)) = after.checked_sub(1).and_then(|before| self.0.get(before)) else { return s };
        s_before + (s - s_before) * (time - t_before) / (t - t_before)
    }

    /// Returns the curve with its times divided by `unit`.
    #[must_use]
    pub fn in_units(&self, unit: f64) -> Self {
        Self::new(self.0.iter().map(|&(time, share)| (time / unit, share)))
    }

    /// Returns the largest difference of the fractions over the times that both curves cover.
    #[must_use]
    pub fn largest_difference(&self, other: &Self) -> f64 {
        let last = |curve: &Self| curve.0.last().map_or(0.0, |point| point.0);
        let end = last(self).min(last(other));
        let times = self.0.iter().chain(&other.0).map(|point| point.0).filter(|&time| time <= end);
        times.map(|time| (self.share_at(time) - other.share_at(time)).abs()).fold(0.0, f64::max)
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use super::*;

    #[test]
    fn time_starts_at_the_opening_and_fractions_refer_to_released_grains() {
        let rows = [(0.0, 0.0), (1.0, 0.0), (2.0, 10.0), (3.0, 40.0)];
        let curve = Curve::of_rows(&rows, 40.0, 1.5);
        assert_eq!(curve.points(), [(0.0, 0.0), (0.5, 0.25), (1.5, 1.0)]);
        assert_eq!((curve.time_of(0.25), curve.time_of(0.625), curve.time_of(1.1)), (Some(0.5), Some(1.0), None));
        assert_eq!(curve.largest(), 1.0);
        assert_eq!((curve.share_at(-1.0), curve.share_at(0.25), curve.share_at(9.0)), (0.0, 0.125, 1.0));
    }

    #[test]
    fn largest_difference_is_taken_between_linear_segments() {
        let straight = Curve::new([(0.0, 0.0), (2.0, 1.0)]);
        let bent = Curve::new([(0.0, 0.0), (0.5, 0.5), (3.0, 1.0)]);
        // At the bend the fractions are 0.5 and 0.25.
        assert_eq!(straight.largest_difference(&bent), 0.25);
        assert_eq!(bent.largest_difference(&straight), 0.25);
        assert_eq!(straight.in_units(2.0).largest_difference(&Curve::new([(0.0, 0.0), (1.0, 1.0)])), 0.0);
    }
}
