//! Fits of a law to points: least squares of a straight line, after a transformation that makes the law straight.
//!
//! | law | formula | straight line |
//! |---|---|---|
//! | `Line` | y = a + b x | y against x |
//! | `Power` | y = A x^m | ln y against ln x |
//! | `Beverloo` | y = A (x - D0)^p | y^(1/p) against x |
//!
//! Beverloo's law gives the discharge rate W of an orifice of width D: W = C rho sqrt(g) (D - k d)^p, with the diameter d of the grains, the
//! density rho of the bed and p = 5/2 for a hole in solid space, 3/2 for a slot in the plane (Beverloo, Leniger and van de Velde, Chem. Eng. Sci.
//! 15, 260, 1961). So A = C rho sqrt(g) and D0 = k d. For a rate in grains per second rho is the number of grains per volume or area.
//!
//! Standard errors follow from the residuals of the line, to first order. They need three points. All points have the same weight in
//! the transformed figure.

use serde::Deserialize;

use super::digits::short;
use super::line::{Gradient, Line};
use super::student::{MOST_95, t_95};

/// A law that is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Law {
    /// y = a + b x.
    Line,
    /// y = A x^m.
    Power,
    /// y = A (x - D0)^p.
    Beverloo {
        /// The exponent p, dimensionless: 1.5 in the plane, 2.5 in solid space.
        power: f64,
        /// Diameter of the grains, m. With it k = D0/d is given.
        #[serde(default)]
        grain: Option<f64>,
        /// Density of the bed in the unit of the figure. With it C is given.
        #[serde(default)]
        density: Option<f64>,
        /// Acceleration of gravity, m/s^2. Default 9.81.
        #[serde(default = "earth")]
        gravity: f64,
    },
}

fn earth() -> f64 {
    9.81
}

/// A fitted number with its standard error, which needs three points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name.
    pub name: &'static str,
    /// Value.
    pub value: f64,
    /// Standard error.
    pub error: Option<f64>,
}

/// A fitted law.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    law: Law,
    line: Line,
    /// Numbers of the law, and at last the share `r_squared` of the variance of the transformed figure that the line explains.
    pub parameters: Vec<Parameter>,
}

impl Law {
    /// Checks the numbers of the law.
    ///
    /// # Errors
    /// The key of a wrong number, and a message.
    pub fn check(&self) -> Result<(), (&'static str, String)> {
        let Self::Beverloo { power, grain, density, gravity } = *self else { return Ok(()) };
        let all = [("power", Some(power)), ("grain", grain), ("density", density), ("gravity", Some(gravity))];
        let wrong = all.into_iter().find(|(_, value)| value.is_some_and(|value| !(value > 0.0 && value.is_finite())));
        wrong.map_or(Ok(()), |(key, _)| Err((key, "expected a positive number".to_owned())))
    }

    /// Returns a point as a point of the straight line; `None` if the law does not apply there.
    fn transformed(&self, (x, y): (f64, f64)) -> Option<(f64, f64)> {
        let point = match *self {
            Self::Line => (x, y),
            Self::Power if x > 0.0 && y > 0.0 => (x.ln(), y.ln()),
            Self::Beverloo { power, .. } if y > 0.0 => (x, y.powf(1.0 / power)),
            _ => return None,
        };
        (point.0.is_finite() && point.1.is_finite()).then_some(point)
    }

    /// Fits the law to points; `None` if there are not two different places where the law applies, or if no curve of the law rises
    /// through them.
    #[must_use]
    pub fn fit(self, points: &[(f64, f64)]) -> Option<Fitted> {
        let points: Vec<_> = points.iter().filter_map(|&point| self.transformed(point)).collect();
        let line = Line::through(&points)?;
        let a = line.intercept;
        let b = line.slope;
        let of = |name: &'static str, value: f64, by_intercept: f64, by_slope: f64| Parameter {
            name,
            value,
            error: line.error(Gradient { by_intercept, by_slope }),
        };
        let mut parameters = match self {
            Self::Line => vec![of("intercept", a, 1.0, 0.0), of("slope", b, 0.0, 1.0)],
            Self::Power => vec![of("prefactor", a.exp(), a.exp(), 0.0), of("exponent", b, 0.0, 1.0)],
            Self::Beverloo { power, grain, density, gravity } => {
                if b <= 0.0 {
                    return None;
                }
                let amplitude = b.powf(power);
                let steep = power * b.powf(power - 1.0);
                let offset = -a / b;
                let by_intercept = -1.0 / b;
                let by_slope = a / (b * b);
                let scale = density.map(|density| density * gravity.sqrt());
                let c = scale.map(|scale| of("C", amplitude / scale, 0.0, steep / scale));
                let k = grain.map(|d| of("k", offset / d, by_intercept / d, by_slope / d));
                let own = [of("amplitude", amplitude, 0.0, steep), of("offset", offset, by_intercept, by_slope)];
                own.into_iter().chain(c).chain(k).collect()
            }
        };
        parameters.push(Parameter { name: "r_squared", value: line.r_squared, error: None });
        Some(Fitted { law: self, line, parameters })
    }
}

impl Fitted {
    /// Returns the value of the law; `None` where it has none.
    #[must_use]
    pub fn at(&self, x: f64) -> Option<f64> {
        self.figure(self.straight(x)?)
    }

    /// Returns the 95 % confidence interval of the law's value, by the scatter about the straight line; `None` with fewer than three points, and
    /// where the law has no value.
    #[must_use]
    pub fn band(&self, x: f64) -> Option<[f64; 2]> {
        let freedom = self.line.freedom;
        let straight = self.straight(x)?;
        let by_slope = self.place(x)?;
        let half = self.line.error(Gradient { by_intercept: 1.0, by_slope })? * t_95(freedom.min(MOST_95));
        let low = straight - half;
        let is_rate = matches!(self.law, Law::Beverloo { .. });
        Some([self.figure(if is_rate { low.max(0.0) } else { low })?, self.figure(straight + half)?])
    }

    /// Returns the place on the straight line.
    fn place(&self, x: f64) -> Option<f64> {
        match self.law {
            Law::Power => (x > 0.0).then(|| x.ln()),
            _ => Some(x),
        }
    }

    /// Returns the transformed figure.
    fn straight(&self, x: f64) -> Option<f64> {
        Some(self.line.intercept + self.line.slope * self.place(x)?)
    }

    /// Returns the figure from the transformed one; `None` where it has none.
    fn figure(&self, straight: f64) -> Option<f64> {
        match self.law {
            Law::Line => Some(straight),
            Law::Power => Some(straight.exp()),
            Law::Beverloo { power, .. } => (straight >= 0.0).then(|| straight.powf(power)),
        }
    }

    /// Returns a number of the law.
    #[must_use]
    pub fn parameter(&self, name: &str) -> Option<Parameter> {
        self.parameters.iter().copied().find(|parameter| parameter.name == name)
    }

    /// Returns the value of a number of the law.
    #[must_use]
    pub fn value(&self, name: &str) -> Option<f64> {
        self.parameter(name).map(|it| it.value)
    }

    /// Returns the place where the law begins, if it has one.
    #[must_use]
    pub fn start(&self) -> Option<f64> {
        matches!(self.law, Law::Beverloo { .. }).then(|| -self.line.intercept / self.line.slope)
    }

    /// Returns the law with its numbers, for example `12.3 (x - 0.045)^1.5`.
    #[must_use]
    pub fn in_words(&self) -> String {
        let [first, second] = [0, 1].map(|n| self.parameters.get(n).map_or(f64::NAN, |parameter| parameter.value));
        let sign = |x: f64| if x < 0.0 { '-' } else { '+' };
        match self.law {
            Law::Line => format!("{} {} {} x", short(first), sign(second), short(second.abs())),
            Law::Power => format!("{} x^{}", short(first), short(second)),
            Law::Beverloo { power, .. } => {
                format!("{} (x {} {})^{power}", short(first), sign(-second), short(second.abs()))
            }
        }
    }
}

/// The straight line that fits best of several.
#[derive(Clone, Debug, PartialEq)]
pub struct BestLine {
    /// The candidate that makes the line.
    pub candidate: f64,
    /// The line.
    pub fitted: Fitted,
}

/// Fits y = a + b f(x, q) by least squares over a, b and the candidates of q. Returns the best q and the line; `None` without a line.
pub fn best_line(
    points: &[(f64, f64)],
    candidates: impl IntoIterator<Item = f64>,
    f: impl Fn(f64, f64) -> f64,
) -> Option<BestLine> {
    let fit = |candidate: f64| {
        let fitted = Law::Line.fit(&points.iter().map(|(x, y)| (f(*x, candidate), *y)).collect::<Vec<_>>())?;
        Some(BestLine { candidate, fitted })
    };
    let explained = |it: &BestLine| it.fitted.value("r_squared").unwrap_or(f64::NEG_INFINITY);
    candidates.into_iter().filter_map(fit).max_by(|a, b| explained(a).total_cmp(&explained(b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::noise::Noise;

    /// Whether a fitted number is within a relative round-off of 1e-9.
    fn is(fitted: &Fitted, name: &str, expected: f64) -> bool {
        (fitted.value(name).unwrap() - expected).abs() < 1e-9 * expected.abs()
    }

    #[test]
    fn beverloo_recovers_the_constants_of_exact_data() {
        for power in [1.5, 2.5] {
            let c = 0.58;
            let k = 1.4;
            let d = 0.01;
            let density = 1600.0;
            let law = Law::Beverloo { power, grain: Some(d), density: Some(density), gravity: 9.81 };
            let rate = |x: f64| c * density * 9.81f64.sqrt() * (x - k * d).powf(power);
            let points = [0.04, 0.05, 0.07, 0.1, 0.15].map(|x| (x, rate(x)));
            let fitted = law.fit(&points).unwrap();
            assert!(is(&fitted, "C", c) && is(&fitted, "k", k) && is(&fitted, "r_squared", 1.0), "{fitted:?}");
            assert!((fitted.at(0.08).unwrap() / rate(0.08) - 1.0).abs() < 1e-9);
            assert_eq!(fitted.at(0.01), None);
        }
    }

    #[test]
    fn beverloo_recovers_the_constants_of_scattered_data_within_its_errors() {
        let (c, k, d): (f64, f64, f64) = (0.58, 1.4, 0.01);
        let law = Law::Beverloo { power: 1.5, grain: Some(d), density: Some(1.0), gravity: 1.0 };
        let mut noise = Noise::new(1);
        let mut outside = [0u32; 2];
        for _ in 0..400 {
            let points: Vec<_> = (0..12u8)
                .map(|n| 0.04 + 0.01 * f64::from(n))
                .map(|x| (x, noise.gaussian()))
                // Two percent of the straight line's figure at its middle.
                .map(|(x, noise)| {
                    (x, ((c.powf(2.0 / 3.0) * (x - k * d)) + 0.002 * c.powf(2.0 / 3.0) * noise).powf(1.5))
                })
                .collect();
            let fitted = law.fit(&points).unwrap();
            for (count, (name, expected)) in outside.iter_mut().zip([("C", c), ("k", k)]) {
                let Parameter { value, error, .. } = fitted.parameter(name).unwrap();
                *count += u32::from((value - expected).abs() > 2.228 * error.unwrap());
            }
        }
        // With 10 degrees of freedom 5 % are beyond 2.228 errors: 20 of 400, with a standard deviation of 4.4. The bounds are 4 of them.
        assert!(outside.iter().all(|count| (3..=37).contains(count)), "{outside:?}");
    }

    #[test]
    fn lines_and_powers_are_recovered_and_too_few_points_have_no_fit() {
        let line = Law::Line.fit(&[(0.0, 1.0), (1.0, 3.0), (2.0, 5.0)]).unwrap();
        assert!(is(&line, "intercept", 1.0) && is(&line, "slope", 2.0));
        let power = Law::Power.fit(&[(1.0, 3.0), (2.0, 12.0), (4.0, 48.0), (-1.0, 5.0)]).unwrap();
        assert!(is(&power, "prefactor", 3.0) && is(&power, "exponent", 2.0));
        let of_two = Law::Line.fit(&[(0.0, 1.0), (1.0, 3.0)]).unwrap();
        assert_eq!(of_two.parameter("slope").unwrap().error, None);
        assert!(Law::Line.fit(&[(0.0, 1.0)]).is_none() && Law::Line.fit(&[]).is_none());
        let law = Law::Beverloo { power: 1.5, grain: None, density: None, gravity: 9.81 };
        assert!(law.fit(&[(1.0, 2.0), (2.0, 1.0)]).is_none());
    }

    #[test]
    fn the_error_of_a_slope_is_that_of_the_textbook() {
        // Residuals 1, -2, 1 of the line through (0, 1), (1, -2), (2, 1): variance 6/1, sum of squares of x 2.
        let line = Law::Line.fit(&[(0.0, 1.0), (1.0, -2.0), (2.0, 1.0)]).unwrap();
        assert!((line.parameter("slope").unwrap().error.unwrap() - 3f64.sqrt()).abs() < 1e-12);
        assert!((line.parameter("intercept").unwrap().error.unwrap() - 5f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn the_band_of_a_line_is_that_of_the_textbook_and_follows_the_law() {
        // Variance 6, at x = 1 over three points, at x = 2 with (x - 1)^2/2 more; t of one degree of freedom.
        let points = [(0.0, 1.0), (1.0, -2.0), (2.0, 1.0)];
        let line = Law::Line.fit(&points).unwrap();
        for (x, variance) in [(1.0, 2.0f64), (2.0, 5.0)] {
            let half = 12.706 * variance.sqrt();
            let [low, high] = line.band(x).unwrap();
            assert!((low + half).abs() < 1e-9 && (high - half).abs() < 1e-9, "{low} {high} {half}");
        }
        assert!(Law::Line.fit(&points[..2]).unwrap().band(1.0).is_none());
        // A power law is a line of logarithms.
        let power = Law::Power.fit(&points.map(|(x, y)| (x.exp(), y.exp()))).unwrap();
        let [low, high] = power.band(1.0f64.exp()).unwrap();
        assert!((low.ln() + high.ln()).abs() < 1e-9 && (high.ln() / (12.706 * 2f64.sqrt()) - 1.0).abs() < 1e-9);
        let law = Law::Beverloo { power: 1.5, grain: None, density: None, gravity: 9.81 };
        let fitted = law.fit(&[(1.0, 0.1), (2.0, 1.2), (3.0, 2.7), (4.0, 5.4)]).unwrap();
        let [low, high] = fitted.band(3.0).unwrap();
        assert!(low < fitted.at(3.0).unwrap() && fitted.at(3.0).unwrap() < high);
    }

    #[test]
    fn the_best_line_recovers_an_exponent() {
        let points: Vec<_> = (1..20).map(|n| (f64::from(n), 3.0 - 0.5 * f64::from(n).powf(1.5))).collect();
        let best = best_line(&points, (50..300).map(|n| 0.01 * f64::from(n)), f64::powf).unwrap();
        assert!((best.candidate - 1.5).abs() < 1e-9 && (best.fitted.value("slope").unwrap() + 0.5).abs() < 1e-9);
    }
}
