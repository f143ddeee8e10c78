//! The laws of the discharge rate, fitted to the rates of all runs, and their panels.

use super::bed::Silo;
use siloflow_figures::diagram::{Axis, Curve, Panel, colour};
use siloflow_figures::statistics::least_squares::{Fit, fit};

/// Fits to rates in units of the bed.
pub(super) struct Laws {
    power: f64,
    /// Width in diameters, rate.
    points: Vec<(f64, f64)>,
    /// ln C and k.
    pub(super) beverloo: Fit<2>,
    /// ln C and the exponent at [`OFFSET`].
    pub(super) exponent: Fit<2>,
    /// ln C, k and the exponent.
    pub(super) free: Fit<3>,
    /// ln C' and b. With b at zero or below the data do not show the correction.
    pub(super) mankoc: Option<Fit<2>>,
}

/// k of the fit of the exponent alone, as in DIRT.
pub(super) const OFFSET: f64 = 1.4;

/// Logarithm of Beverloo's law.
fn beverloo(width: f64, [log, offset, power]: [f64; 3]) -> f64 {
    log + power * (width - offset).ln()
}

/// Logarithm of Mankoc's form.
fn mankoc(width: f64, [log, b]: [f64; 2], power: f64) -> f64 {
    log + (1.0 - 0.5 * (-b * (width - 1.0)).exp()).ln() + power * (width - 1.0).ln()
}

impl Laws {
    /// Fits the laws to widths and rates. `None` if they do not determine the laws.
    pub(super) fn fit(power: f64, points: Vec<(f64, f64)>) -> Option<Self> {
        let logs: Vec<_> = points.iter().filter(|(_, rate)| *rate > 0.0).map(|(x, rate)| (*x, rate.ln())).collect();
        let fixed = fit(&|x, p: &[f64; 2]| beverloo(x, [p[0], p[1], power]), &logs, [0.0, 1.0])?;
        let [log, offset] = fixed.values;
        let exponent = fit(&|x, p: &[f64; 2]| beverloo(x, [p[0], OFFSET, p[1]]), &logs, [log, power])?;
        let free = fit(&|x, p: &[f64; 3]| beverloo(x, *p), &logs, [log, offset, power])?;
        let mankoc = fit(&|x, p: &[f64; 2]| mankoc(x, *p, power), &logs, [log, 0.1]);
        Some(Self { power, points, beverloo: fixed, exponent, free, mankoc })
    }

    /// Returns the panels of a silo: rates, and deviations from both laws.
    pub(super) fn panels(&self, silo: Silo) -> [Panel; 2] {
        let straight = |rate: f64| rate.powf(1.0 / self.power);
        let law = |x: f64| beverloo(x, [self.beverloo.values[0], self.beverloo.values[1], self.power]).exp();
        let form = |x: f64| self.mankoc.map_or(f64::NAN, |it| mankoc(x, it.values, self.power).exp());
        let widest = self.points.iter().map(|point| point.0).fold(0.0, f64::max);
        let sampled = |from: f64, of: &dyn Fn(f64) -> f64| {
            let places = (0..=100).map(|n| from + (widest + 0.5 - from) * f64::from(n) / 100.0);
            places.map(|x| (x, straight(of(x)))).collect::<Vec<_>>()
        };
        let x = || Axis::linear("width of the orifice, d", 0.0, widest + 1.0);
        let dots = |name: &str, number: usize, points: Vec<(f64, f64)>| Curve {
            name: name.to_owned(),
            colour: colour(number),
            points,
            has_dots: true,
            ..Curve::default()
        };
        let curves = vec![
            dots("siloflow", 1, self.points.iter().map(|(x, rate)| (*x, straight(*rate))).collect()),
            Curve {
                name: "Beverloo".to_owned(),
                colour: colour(0),
                points: sampled(self.beverloo.values[1].max(0.0), &law),
                has_line: true,
                ..Curve::default()
            },
            Curve {
                name: "Mankoc".to_owned(),
                colour: colour(2),
                points: sampled(1.01, &form),
                has_line: true,
                is_dashed: true,
                ..Curve::default()
            },
        ];
        let label = if silo == Silo::Slot { "W^(2/3)" } else { "W^(2/5)" };
        let top = curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.1));
        let y = Axis::around(label, top.chain([0.0]));
        let rates = Panel { curves, ..Panel::new(format!("Rate of the {}", silo.name()), x(), y) };
        let off = |of: &dyn Fn(f64) -> f64| {
            self.points.iter().map(|(x, rate)| (*x, 100.0 * (rate / of(*x) - 1.0))).collect::<Vec<_>>()
        };
        let curves = vec![dots("from Beverloo", 0, off(&law)), dots("from Mankoc", 2, off(&form))];
        let all = curves.iter().flat_map(|curve| curve.points.iter().map(|point| point.1));
        let y = Axis::around("deviation of the rate, %", all.chain([-5.0, 5.0]));
        [rates, Panel { curves, ..Panel::new(format!("Deviations, {}", silo.name()), x(), y) }]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rates of a law with errors of half a percent, at five widths of three runs.
    fn points(law: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let noise = [
            -0.004, 0.006, 0.001, 0.003, -0.007, 0.002, 0.005, -0.001, -0.004, 0.0, 0.004, -0.005, 0.006, -0.003,
            -0.002,
        ];
        let widths = (0..).map(|n| 4.0 + f64::from(n / 3));
        widths.zip(noise).map(|(x, noise)| (x, law(x) * (1.0 + noise))).collect()
    }

    #[test]
    fn the_exponent_of_a_law_is_found_within_its_error_and_another_one_is_not() {
        for power in [1.5, 2.5] {
            let laws = Laws::fit(power, points(|x| 0.58 * (x - 1.4).powf(power))).unwrap();
            let exponent = laws.free.values[2];
            let error = laws.free.errors[2];
            assert!((exponent - power).abs() < 3.0 * error && error < 0.25, "{exponent} {error}");
            assert!((laws.beverloo.values[1] - 1.4).abs() < 3.0 * laws.beverloo.errors[1]);
            assert!((laws.exponent.values[1] - power).abs() < 3.0 * laws.exponent.errors[1]);
            // A rate that grows with another power is beyond the bound of the case.
            let other = Laws::fit(power, points(|x| 0.58 * (x - 1.4).powf(power + 0.6))).unwrap();
            assert!((other.exponent.values[1] - power).abs() > super::super::BOUND, "{:?}", other.exponent);
        }
    }

    #[test]
    fn the_numbers_of_mankocs_form_are_found() {
        let laws = Laws::fit(2.5, points(|x| mankoc(x, [0.7, 0.1], 2.5).exp())).unwrap();
        let mankoc = laws.mankoc.unwrap();
        assert!((mankoc.values[1] - 0.1).abs() < 3.0 * mankoc.errors[1], "{mankoc:?}");
    }
}
