//! Numbers that several cases need.

use crate::studies::study::results::Mean;
use crate::studies::sweep::fit::{Fitted, Law};
use crate::studies::validation::runs::Run;

/// Returns the mean of some values with its standard error; `None` without values.
#[must_use]
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<Mean> {
    Mean::of(&values.into_iter().collect::<Vec<_>>())
}

/// Returns runs by a number of theirs, in ascending order; runs without the number are left out.
#[must_use]
pub fn groups_by(runs: &[Run], number: impl Fn(&Run) -> Option<f64>) -> Vec<(f64, Vec<&Run>)> {
    let mut groups: Vec<(f64, Vec<&Run>)> = Vec::new();
    for (run, number) in runs.iter().filter_map(|run| Some((run, number(run)?))) {
        match groups.iter_mut().find(|(of_group, _)| of_group.to_bits() == number.to_bits()) {
            Some((_, group)) => group.push(run),
            None => groups.push((number, vec![run])),
        }
    }
    groups.sort_by(|a, b| a.0.total_cmp(&b.0));
    groups
}

/// Returns the mean of a number over runs, with its standard error; runs without the number do not count.
#[must_use]
pub fn mean_of<'a>(runs: impl IntoIterator<Item = &'a Run>, number: impl Fn(&Run) -> Option<f64>) -> Option<Mean> {
    mean(runs.into_iter().filter_map(number))
}

/// Returns the points with an abscissa between `from` and `to`.
#[must_use]
pub fn between(points: &[(f64, f64)], from: f64, to: f64) -> Vec<(f64, f64)> {
    points.iter().copied().filter(|(x, _)| (from..=to).contains(x)).collect()
}

/// Returns the slope of the straight line through points; `None` without two places.
#[must_use]
pub fn slope(points: &[(f64, f64)]) -> Option<f64> {
    named(&Law::Line.fit(points)?, "slope").map(|(value, _)| value)
}

/// Returns a number of a fit and its standard error.
#[must_use]
pub fn named(fitted: &Fitted, name: &str) -> Option<(f64, Option<f64>)> {
    fitted.parameters.iter().find(|parameter| parameter.name == name).map(|it| (it.value, it.error))
}

/// Returns the value at `x` of the line through points in ascending order of x; `None` outside.
#[must_use]
pub fn interpolated(points: &[(f64, f64)], x: f64) -> Option<f64> {
    let two = points.windows(2).find(|two| two[0].0 <= x && x <= two[1].0 && two[0].0 < two[1].0)?;
    let share = (x - two[0].0) / (two[1].0 - two[0].0);
    Some(two[0].1 + share * (two[1].1 - two[0].1))
}

/// Fits y = a + b f(x, q) by least squares over a, b and the candidates of q. Returns the best q and the line; `None` without a line.
pub fn best_line(
    points: &[(f64, f64)],
    candidates: impl IntoIterator<Item = f64>,
    f: impl Fn(f64, f64) -> f64,
) -> Option<(f64, Fitted)> {
    let fit = |q: f64| {
        let fitted = Law::Line.fit(&points.iter().map(|(x, y)| (f(*x, q), *y)).collect::<Vec<_>>())?;
        Some((q, fitted))
    };
    let explained = |fitted: &Fitted| named(fitted, "r_squared").map_or(f64::NEG_INFINITY, |(share, _)| share);
    candidates.into_iter().filter_map(fit).max_by(|a, b| explained(&a.1).total_cmp(&explained(&b.1)))
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

    #[test]
    fn the_best_line_recovers_an_exponent() {
        let points: Vec<_> = (1..20).map(|n| (f64::from(n), 3.0 - 0.5 * f64::from(n).powf(1.5))).collect();
        let (exponent, fitted) = best_line(&points, (50..300).map(|n| 0.01 * f64::from(n)), f64::powf).unwrap();
        assert!((exponent - 1.5).abs() < 1e-9 && (named(&fitted, "slope").unwrap().0 + 0.5).abs() < 1e-9);
    }
}
