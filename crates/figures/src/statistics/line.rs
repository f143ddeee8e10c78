//! The straight line y = a + b x of least squares through points.
//!
//! Standard errors follow from the residuals, to first order, and need three points. All points have the same weight.

/// A straight line with the covariances of its numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// a.
    pub intercept: f64,
    /// b.
    pub slope: f64,
    /// Share of the variance of y that the line explains.
    pub r_squared: f64,
    /// Number of points beyond the two that a line needs.
    pub freedom: usize,
    covariance: Option<Covariance>,
}

/// Variances of intercept and slope, and their covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Covariance {
    intercept: f64,
    slope: f64,
    both: f64,
}

/// The derivatives of a function of the numbers of a line.
#[derive(Clone, Copy, Debug)]
pub struct Gradient {
    /// Derivative by the intercept.
    pub by_intercept: f64,
    /// Derivative by the slope.
    pub by_slope: f64,
}

impl Line {
    /// Fits a line; `None` without two different places.
    #[must_use]
    pub fn through(points: &[(f64, f64)]) -> Option<Self> {
        #[expect(clippy::cast_precision_loss, reason = "a number of points")]
        let n = points.len() as f64;
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
        let x = mean(&|p| p.0);
        let y = mean(&|p| p.1);
        let sum = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>();
        let xx = sum(&|p| (p.0 - x).powi(2));
        let xy = sum(&|p| (p.0 - x) * (p.1 - y));
        let yy = sum(&|p| (p.1 - y).powi(2));
        if !(xx > 0.0 && xx.is_finite() && yy.is_finite()) {
            return None;
        }
        let slope = xy / xx;
        let intercept = y - slope * x;
        let residual = sum(&|p| (p.1 - intercept - slope * p.0).powi(2));
        let covariance = (points.len() > 2).then(|| {
            let variance = residual / (n - 2.0) / xx;
            Covariance { intercept: variance * (xx / n + x * x), slope: variance, both: -variance * x }
        });
        let r_squared = if yy > 0.0 { 1.0 - residual / yy } else { 1.0 };
        Some(Self { intercept, slope, r_squared, freedom: points.len().saturating_sub(2), covariance })
    }

    /// Returns the standard error of a function of the numbers with these derivatives; `None` with fewer than three points.
    #[must_use]
    pub fn error(&self, Gradient { by_intercept, by_slope }: Gradient) -> Option<f64> {
        let Covariance { intercept, slope, both } = self.covariance?;
        let variance =
            by_intercept.powi(2) * intercept + by_slope.powi(2) * slope + 2.0 * by_intercept * by_slope * both;
        Some(variance.max(0.0).sqrt())
    }
}
