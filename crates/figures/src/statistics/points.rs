//! Curves given as points (x, y).

use super::fit::Law;

/// Returns the points with an abscissa between `from` and `to`.
#[must_use]
pub fn between(points: &[(f64, f64)], from: f64, to: f64) -> Vec<(f64, f64)> {
    points.iter().copied().filter(|(x, _)| (from..=to).contains(x)).collect()
}

/// Returns the slope of the straight line of least squares through points; `None` without two places.
#[must_use]
pub fn slope(points: &[(f64, f64)]) -> Option<f64> {
    Law::Line.fit(points)?.value("slope")
}

/// Returns the value at `x` of the line through points in ascending order of x; `None` outside.
#[must_use]
pub fn interpolated(points: &[(f64, f64)], x: f64) -> Option<f64> {
    let two = points.windows(2).find(|two| two[0].0 <= x && x <= two[1].0 && two[0].0 < two[1].0)?;
    let share = (x - two[0].0) / (two[1].0 - two[0].0);
    Some(two[0].1 + share * (two[1].1 - two[0].1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_and_values_between_points_are_those_of_a_line() {
        let points = [(0.0, 1.0), (1.0, 3.0), (2.0, 5.0), (9.0, 0.0)];
        // Round-off of a sum of a few numbers of order one.
        assert!((slope(&between(&points, 0.0, 2.0)).unwrap() - 2.0).abs() < 1e-14);
        assert!((interpolated(&points, 1.25).unwrap() - 3.5).abs() < 1e-14);
        assert_eq!((interpolated(&points, 9.5), slope(&points[..1])), (None, None));
    }
}
