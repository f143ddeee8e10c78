//! The Gaussian kernel, and its mean along a line by Gauss-Legendre quadrature.
//!
//! With six points on each part of a line, of at most one standard deviation, the error of the mean is below 1e-11 of the largest
//! density: it is (6!)^4/(13 (12!)^3) = 2e-16 times the twelfth derivative, which is at most 1.1 sqrt(12!) = 2.4e4 times that density
//! (Cramer's bound). Limit: lines of up to a thousand standard deviations.

use std::f64::consts::PI;

use siloflow_dem::math;

/// Nodes on (-1, 1) and their weights, whose sum is 2 (Abramowitz and Stegun, table 25.4).
const LEGENDRE: [(f64, f64); 6] = [
    (-0.932_469_514_203_152, 0.171_324_492_379_170_4),
    (-0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (-0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.238_619_186_083_196_9, 0.467_913_934_572_691),
    (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (0.932_469_514_203_152, 0.171_324_492_379_170_4),
];

/// Returns the normal density of standard deviation `width` at `x`.
pub(super) fn density(width: f64, x: f64) -> f64 {
    let x = x / width;
    math::exp(-0.5 * x * x) / (width * (2.0 * PI).sqrt())
}

/// Returns the number of parts of a line of this length, m.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
pub(super) fn parts_of_line(length: f64, width: f64) -> u32 {
    (length / width).ceil().clamp(1.0, 1000.0) as u32
}

/// Returns the points of a part, as shares of the line, with their weights in a mean along the line. The sum of the weights over all parts
/// is 1.
pub(super) fn points_of_part(part: u32, parts: u32) -> [(f64, f64); 6] {
    let share = 1.0 / f64::from(parts);
    LEGENDRE.map(|(x, weight)| ((f64::from(part) + 0.5 + 0.5 * x) * share, 0.5 * weight * share))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns erf(x) to about 1e-16, by the series 2/sqrt(pi) exp(-x^2) sum 2^n x^(2n+1)/(2n+1)!! (Abramowitz and Stegun 7.1.6).
    fn erf(x: f64) -> f64 {
        let mut term = x;
        let mut sum = x;
        let mut n = 1.0;
        while term.abs() > 1e-17 * sum.abs() {
            term *= 2.0 * x * x / (2.0 * n + 1.0);
            sum += term;
            n += 1.0;
        }
        2.0 / PI.sqrt() * (-x * x).exp() * sum
    }

    #[test]
    fn the_mean_along_a_line_is_a_difference_of_error_functions() {
        let width = 0.25;
        for length in [1e-9, 0.1, 0.2499, 0.25, 0.6, 1.3, 4.0] {
            for start in [-2.0, -0.7, -0.05, 0.0, 0.3, 1.1] {
                let parts = parts_of_line(length, width);
                let points: Vec<_> = (0..parts).flat_map(|part| points_of_part(part, parts)).collect();
                assert!((points.iter().map(|(_, weight)| weight).sum::<f64>() - 1.0).abs() < 1e-14);
                let mean: f64 = points.iter().map(|(x, weight)| weight * density(width, start + x * length)).sum();
                let ends = [start, start + length].map(|x| erf(x / (width * 2f64.sqrt())));
                let expected = 0.5 * (ends[1] - ends[0]) / length;
                // A short line takes the digits of the difference.
                let rounding = 4.0 * f64::EPSILON / length;
                assert!(
                    (mean - expected).abs() < 1e-11 * density(width, 0.0) + rounding,
                    "{length} {start}: {mean} {expected}"
                );
            }
        }
    }
}
