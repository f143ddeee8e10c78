//! Least squares of a law with a few numbers that it does not depend on linearly: Levenberg's and Marquardt's method.
//!
//! The sum of (y - f(x, p))^2 over the points is lowered step by step; derivatives by p are differences. Standard errors follow from the residuals and the
//! linearised law at the minimum, to first order, and need more points than numbers.

/// A fitted law with `N` numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit<const N: usize> {
    /// The numbers.
    pub values: [f64; N],
    /// Their standard errors; NaN without more points than numbers.
    pub errors: [f64; N],
    /// Root of the mean square of the residuals.
    pub rms: f64,
}

/// Largest number of steps; a law with a clear minimum needs about ten.
const STEPS: usize = 200;

/// A law: its value at an abscissa with these numbers.
type Function<'a, const N: usize> = &'a dyn Fn(f64, &[f64; N]) -> f64;

/// Fits a law to points (x, y), beginning at `start`. `None` if the law has no value at the start, if there are fewer points than numbers, or if the points
/// do not determine the numbers.
#[must_use]
pub fn fit<const N: usize>(law: Function<N>, points: &[(f64, f64)], start: [f64; N]) -> Option<Fit<N>> {
    let sum = |p: &[f64; N]| points.iter().map(|(x, y)| (y - law(*x, p)).powi(2)).sum::<f64>();
    let mut p = start;
    let mut damping = 1e-3;
    let mut least = sum(&p);
    if points.len() < N || !least.is_finite() {
        return None;
    }
    for _ in 0..STEPS {
        let (normal, gradient) = linearised(law, points, &p);
        let mut damped = normal;
        (0..N).for_each(|i| damped[i][i] *= 1.0 + damping);
        let step = solve(damped, gradient)?;
        let next: [f64; N] = std::array::from_fn(|i| p[i] + step[i]);
        let found = sum(&next);
        // A step outside the range of the law has no finite sum.
        if found < least {
            let gain = least - found;
            (p, least, damping) = (next, found, 0.1 * damping);
            if gain <= 1e-14 * least {
                break;
            }
        } else {
            damping *= 10.0;
            if damping > 1e12 {
                break;
            }
        }
    }
    let (normal, _) = linearised(law, points, &p);
    #[expect(clippy::cast_precision_loss, reason = "numbers of points")]
    let [count, free] = [points.len(), points.len() - N].map(|n| n as f64);
    let mut errors = [f64::NAN; N];
    for (i, error) in errors.iter_mut().enumerate() {
        // Column i of the inverse.
        let column = solve(normal, std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }))?;
        if free > 0.0 {
            *error = (column[i] * least / free).sqrt();
        }
    }
    Some(Fit { values: p, errors, rms: (least / count).sqrt() })
}

/// Returns J^T J and J^T r with the derivatives J of the law by its numbers and the residuals r.
fn linearised<const N: usize>(law: Function<N>, points: &[(f64, f64)], p: &[f64; N]) -> ([[f64; N]; N], [f64; N]) {
    let mut normal = [[0.0; N]; N];
    let mut gradient = [0.0; N];
    for (x, y) in points {
        let value = law(*x, p);
        let slopes: [f64; N] = std::array::from_fn(|i| {
            // The best width of a one-sided difference is of the order of the root of the round-off.
            let width = 1e-7 * p[i].abs().max(1e-3);
            let mut moved = *p;
            moved[i] += width;
            (law(*x, &moved) - value) / width
        });
        for i in 0..N {
            gradient[i] += slopes[i] * (y - value);
            (0..N).for_each(|j| normal[i][j] += slopes[i] * slopes[j]);
        }
    }
    (normal, gradient)
}

/// Solves A x = b by Gauss's elimination with pivots; `None` for a singular A.
fn solve<const N: usize>(mut a: [[f64; N]; N], mut b: [f64; N]) -> Option<[f64; N]> {
    for i in 0..N {
        let pivot = (i..N).max_by(|&j, &k| a[j][i].abs().total_cmp(&a[k][i].abs()))?;
        a.swap(i, pivot);
        b.swap(i, pivot);
        if !(a[i][i].abs() > 0.0 && a[i][i].is_finite()) {
            return None;
        }
        for j in i + 1..N {
            let share = a[j][i] / a[i][i];
            let row = a[i];
            a[j].iter_mut().zip(row).for_each(|(number, above)| *number -= share * above);
            b[j] -= share * b[i];
        }
    }
    let mut x = [0.0; N];
    for i in (0..N).rev() {
        let known: f64 = (i + 1..N).map(|j| a[i][j] * x[j]).sum();
        x[i] = (b[i] - known) / a[i][i];
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::noise::Noise;

    /// A power of the distance from an offset, as its logarithm.
    fn power(x: f64, [log, offset, exponent]: &[f64; 3]) -> f64 {
        log + exponent * (x - offset).ln()
    }

    #[test]
    fn the_numbers_of_exact_data_are_recovered() {
        let points = [4.0, 5.0, 6.5, 8.0, 11.0].map(|x| (x, power(x, &[0.3, 1.4, 2.5])));
        let found = fit(&power, &points, [0.0, 1.0, 2.0]).unwrap();
        // Differences limit the last digits.
        for (value, expected) in found.values.into_iter().zip([0.3, 1.4, 2.5]) {
            assert!((value - expected).abs() < 1e-5, "{found:?}");
        }
        assert!(found.rms < 1e-6);
    }

    #[test]
    fn errors_of_a_straight_line_are_those_of_the_textbook() {
        // Residuals 1, -2, 1 of the line through (0, 1), (1, -2), (2, 1): variance 6/1, sum of squares of x 2.
        let line = |x: f64, [a, b]: &[f64; 2]| a + b * x;
        let found = fit(&line, &[(0.0, 1.0), (1.0, -2.0), (2.0, 1.0)], [5.0, 5.0]).unwrap();
        assert!((found.errors[1] - 3f64.sqrt()).abs() < 1e-5 && found.values[1].abs() < 1e-5, "{found:?}");
    }

    #[test]
    fn scattered_data_lie_within_the_errors() {
        let mut noise = Noise::new(1);
        let mut outside = 0u32;
        for _ in 0..300 {
            let points: Vec<_> = (0..15u8)
                .map(|n| 5.0 + f64::from(n / 3) * 1.5)
                .map(|x| (x, power(x, &[0.3, 1.4, 1.5]) + 0.005 * noise.gaussian()))
                .collect();
            let found = fit(&power, &points, [0.0, 1.0, 2.0]).unwrap();
            outside += u32::from((found.values[2] - 1.5).abs() > 2.179 * found.errors[2]);
        }
        // With 12 degrees of freedom 5 % are beyond 2.179 errors: 15 of 300, with a standard deviation of 3.8. The bounds are 4 of them.
        assert!((1..=30).contains(&outside), "{outside}");
    }

    #[test]
    fn points_that_do_not_determine_the_numbers_have_no_fit() {
        let line = |x: f64, [a, b]: &[f64; 2]| a + b * x;
        assert_eq!(fit(&line, &[(1.0, 1.0)], [0.0, 0.0]), None);
        assert_eq!(fit(&line, &[(0.0, 1.0), (0.0, 2.0)], [0.0, 0.0]), None);
        assert_eq!(fit(&power, &[(1.0, 1.0), (2.0, 2.0), (3.0, 3.0)], [0.0, 1.5, 1.0]), None);
    }
}
