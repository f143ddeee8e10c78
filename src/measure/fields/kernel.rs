//! The Gaussian kernel: its integral along a line, from the error function.
//!
//! The mean of exp(-|p + s d|^2/(2 w^2)) over 0 <= s <= 1 is exp(-q^2/(2 w^2)) w sqrt(pi/2)/L (erf((u + L)/(w sqrt 2)) -
//! erf(u/(w sqrt 2))), with L = |d|, u = p.d/L and the distance q of the line from the origin, q^2 = p^2 - u^2.

use std::f64::consts::{FRAC_2_SQRT_PI, FRAC_PI_2, SQRT_2};

/// Returns erf(x) to about 1e-16.
///
/// Below 2.5 it is the series 2/sqrt(pi) exp(-x^2) sum 2^n x^(2n+1)/(2n+1)!!, whose terms are all positive, beyond it the
/// continued fraction of 1 - erf (Abramowitz and Stegun 7.1.6 and 7.1.14).
pub(super) fn erf(x: f64) -> f64 {
    let (size, square) = (x.abs(), x * x);
    let value = if size < 2.5 {
        let (mut term, mut sum, mut n) = (size, size, 1.0);
        while term > 1e-17 * sum {
            term *= 2.0 * square / (2.0 * n + 1.0);
            sum += term;
            n += 1.0;
        }
        FRAC_2_SQRT_PI * (-square).exp() * sum
    } else if size < 6.0 {
        let fraction = (1..=60).rev().fold(size, |below, n| size + 0.5 * f64::from(n) / below);
        1.0 - 0.5 * FRAC_2_SQRT_PI * (-square).exp() / fraction
    } else {
        1.0
    };
    value.copysign(x)
}

/// Returns the normal density of standard deviation `width` in `axes` dimensions at the squared distance `squared`.
pub(super) fn density(width: f64, axes: i32, squared: f64) -> f64 {
    (-0.5 * squared / (width * width)).exp() / (width * (4.0 * FRAC_PI_2).sqrt()).powi(axes)
}

/// Returns the mean of [`density`] along the line from `start` to `start + way`, relative to the middle of the kernel.
pub(super) fn mean_along(width: f64, axes: i32, start: &[f64], way: &[f64]) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let length = dot(way, way).sqrt();
    if length < 1e-4 * width {
        // The density at the middle is the mean, to a share (length/width)^2/24.
        let middle: Vec<_> = start.iter().zip(way).map(|(start, way)| start + 0.5 * way).collect();
        return density(width, axes, dot(&middle, &middle));
    }
    let along = dot(start, way) / length;
    let aside = (dot(start, start) - along * along).max(0.0);
    let ends = erf((along + length) / (width * SQRT_2)) - erf(along / (width * SQRT_2));
    density(width, axes, aside) * width * FRAC_PI_2.sqrt() / length * ends
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_function_has_the_tabulated_values() {
        // Abramowitz and Stegun, table 7.1, and DLMF 7.23.
        let table = [
            (0.0, 0.0),
            (0.5, 0.520_499_877_813_046_5),
            (1.0, 0.842_700_792_949_714_9),
            (2.0, 0.995_322_265_018_952_7),
            (3.0, 0.999_977_909_503_001_4),
        ];
        for (x, value) in table {
            assert!((erf(x) - value).abs() < 4.0 * f64::EPSILON && (erf(-x) + value).abs() < 4.0 * f64::EPSILON, "{x}");
        }
        // Series and fraction meet.
        let below = erf(2.5 - 1e-13);
        assert!((erf(2.5) - below).abs() < 4.0 * f64::EPSILON + 1e-13);
    }

    #[test]
    fn the_mean_along_a_line_is_that_of_many_points() {
        for way in [[0.3, -0.2, 0.5], [1e-3, 2e-3, 0.0], [1e-6, 0.0, 0.0], [4.0, 0.0, 0.0]] {
            let (start, width, points) = ([0.1, 0.4, -0.3], 0.25, 20_000u32);
            let at = |s: f64| (0..3).map(|axis: usize| (start[axis] + s * way[axis]).powi(2)).sum::<f64>();
            let sum: f64 = (0..points).map(|n| density(width, 3, at((f64::from(n) + 0.5) / f64::from(points)))).sum();
            let (mean, expected) = (mean_along(width, 3, &start, &way), sum / f64::from(points));
            // Midpoint rule: a share of about (L/(width points))^2/24, below 1e-7; short lines: 1e-9.
            assert!((mean - expected).abs() < 1e-7 * expected, "{way:?}: {mean} {expected}");
        }
    }
}
