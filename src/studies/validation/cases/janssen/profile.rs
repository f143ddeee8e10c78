//! Stresses against the depth in a silo, and the laws of Janssen.
//!
//! The vertical stress follows from the balance of slices: the weight above, less the friction that the wall bears above (`wall_bands.csv`), over the section.
//! Depth is the weight above over density and gravity, with the mean density of the lower half.
//!
//! | law | vertical stress at a depth z |
//! |---|---|
//! | Janssen 1895 | rho g lambda (1 - exp(-z/lambda)) |
//! | Vanel and Clement, Eur. Phys. J. B 11, 525 (1999) | rho g z down to a depth a, from there rho g (a + lambda (1 - exp(-(z - a)/lambda))) |
//!
//! Where the wall bears all further weight, the stress is rho g R/(2 mu K) with the wall's friction mu and the ratio K of the pressure on the wall over
//! the vertical stress: R/(2 mu K) = a + lambda.

use std::f64::consts::PI;

use super::loads::GRAVITY;
use crate::studies::validation::runs::FinishedRun;
use siloflow_figures::statistics::least_squares::{Fit, fit};
use siloflow_text::fault::Fault;

/// A slice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Slice {
    /// Depth of its middle, m.
    pub depth: f64,
    /// Vertical stress from the balance, and the one of the coarse-grained contacts, Pa.
    pub vertical: f64,
    pub coarse: f64,
    /// Pressure on the wall, and its downward friction, Pa.
    pub pressure: f64,
    pub friction: f64,
}

/// The slices of a silo in a time, from the floor upwards.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Profile {
    pub slices: Vec<Slice>,
    /// rho g, N/m^3.
    pub unit_weight: f64,
    /// R, m.
    pub radius: f64,
}

/// Depth below which slices count for means and fits, diameters of a grain (m): slices at the top are partly empty.
const TOP: f64 = 3.0 * 0.004;

impl Profile {
    /// Reads the profile of the averages that begin at `from`, s. `None` if there is none.
    pub(super) fn of(run: &FinishedRun, from: f64) -> Result<Option<Self>, Fault> {
        let bands = run.table("wall_bands.csv")?;
        let fields = run.table("fields.csv")?;
        // The tables begin with the first sample at or after `from`, at most an interval of sampling later.
        let is_now = |times: Vec<f64>| {
            let of_window: Vec<_> = times.iter().map(|time| *time > from - 1e-6 && *time < from + 0.015).collect();
            of_window
        };
        let of_bands = is_now(bands.needed("from_s")?);
        let of_fields = is_now(fields.needed("from_s")?);
        let chosen = |numbers: Vec<f64>, chosen: &[bool]| {
            let kept = numbers.into_iter().zip(chosen).filter(|(_, is_chosen)| **is_chosen);
            kept.map(|(number, _)| if number.is_finite() { number } else { 0.0 }).collect::<Vec<_>>()
        };
        let band = |name: &str| chosen(bands.numbers(name).unwrap_or_default(), &of_bands);
        let field = |name: &str| chosen(fields.numbers(name).unwrap_or_default(), &of_fields);
        let low = band("low_m");
        let high = band("high_m");
        let area = band("area_m2");
        let (Some((low, high)), Some(area)) = (low.first().zip(high.first()), area.first()) else { return Ok(None) };
        let height = high - low;
        let radius = area / (2.0 * PI * height);
        let density = field("density");
        let coarse = field("contact_33");
        let pressure = band("pressure_pa");
        let friction = band("downward_traction_pa");
        Ok(Some(Self::from_slices(&density, &coarse, &pressure, &friction, height, radius)))
    }

    /// Computes the vertical stress of slices of one height, from the floor upwards.
    fn from_slices(
        density: &[f64],
        coarse: &[f64],
        pressure: &[f64],
        friction: &[f64],
        height: f64,
        radius: f64,
    ) -> Self {
        let count = density.len();
        let lower = &density[..count / 3];
        #[expect(clippy::cast_precision_loss, reason = "a number of slices")]
        let unit_weight = GRAVITY * lower.iter().sum::<f64>() / lower.len() as f64;
        let mut above = 0.0;
        let mut borne = 0.0;
        let mut slices = Vec::with_capacity(count);
        for i in (0..count).rev() {
            // Stresses: weight and wall friction of the slice over the section.
            let weight = GRAVITY * density[i] * height;
            let rubbed = 2.0 * friction[i] * height / radius;
            let depth = (above + 0.5 * weight) / unit_weight;
            let vertical = above + 0.5 * weight - borne - 0.5 * rubbed;
            slices.push(Slice { depth, vertical, coarse: coarse[i], pressure: pressure[i], friction: friction[i] });
            above += weight;
            borne += rubbed;
        }
        slices.reverse();
        Self { slices, unit_weight, radius }
    }

    /// Slices below the top.
    fn counted(&self) -> impl Iterator<Item = &Slice> {
        self.slices.iter().filter(|slice| slice.depth > TOP && slice.vertical > 0.0)
    }

    /// Returns the mean of a ratio over the slices below the top.
    fn mean(&self, ratio: impl Fn(&Slice) -> f64) -> f64 {
        let all: Vec<_> = self.counted().map(ratio).collect();
        #[expect(clippy::cast_precision_loss, reason = "a number of slices")]
        let count = all.len() as f64;
        all.iter().sum::<f64>() / count
    }

    /// Returns K: pressure on the wall over vertical stress.
    pub(super) fn pressure_ratio(&self) -> f64 {
        self.mean(|slice| slice.pressure / slice.vertical)
    }

    /// Returns mu: the friction that the wall bears over the pressure on it.
    pub(super) fn mobilised(&self) -> f64 {
        let sum = |of: fn(&Slice) -> f64| self.counted().map(of).sum::<f64>();
        sum(|slice| slice.friction) / sum(|slice| slice.pressure)
    }

    /// Returns the vertical stress of the balance over the coarse-grained one.
    pub(super) fn agreement(&self) -> f64 {
        self.mean(|slice| slice.vertical / slice.coarse)
    }

    /// Fits the law of Vanel and Clement: a and lambda, m.
    pub(super) fn two_parameters(&self) -> Option<Fit<2>> {
        let points: Vec<_> = self.counted().map(|slice| (slice.depth, slice.vertical / self.unit_weight)).collect();
        fit_vanel_clement(&points)
    }

    /// Fits Janssen's law: lambda, m.
    pub(super) fn one_parameter(&self) -> Option<Fit<1>> {
        let points: Vec<_> = self.counted().map(|slice| (slice.depth, slice.vertical / self.unit_weight)).collect();
        fit(&|z, [lambda]: &[f64; 1]| vanel_clement(z, 0.0, *lambda), &points, [0.5 * self.deepest()])
    }

    /// Returns the depth of the lowest slice, m.
    pub(super) fn deepest(&self) -> f64 {
        self.slices.first().map_or(f64::NAN, |slice| slice.depth)
    }
}

/// Vertical stress over rho g, m, at the depth z. A law with a negative a is below the hydrostatic one from the top on.
pub(super) fn vanel_clement(z: f64, a: f64, lambda: f64) -> f64 {
    if z < a { z } else { a + lambda * (1.0 - (-(z - a) / lambda).exp()) }
}

/// Fits a and lambda of the law of Vanel and Clement to points, beginning at several places: the kink at a makes minima that are not the least one.
pub(super) fn fit_vanel_clement(points: &[(f64, f64)]) -> Option<Fit<2>> {
    let deepest = points.iter().map(|point| point.0).fold(0.0, f64::max);
    let law = |z: f64, [a, lambda]: &[f64; 2]| vanel_clement(z, *a, lambda.max(1e-3 * deepest));
    let starts = [0.01, 0.1, 0.2, 0.35, 0.5].map(|share| [share * deepest, 0.2 * deepest]);
    let all = starts.into_iter().filter_map(|start| fit(&law, points, start));
    all.min_by(|a, b| a.rms.total_cmp(&b.rms))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A silo whose stress is the law of Vanel and Clement with a = 2 cm, and whose pressure is K times it, by slices of 1 mm.
    fn silo(lambda: f64, k: f64) -> Profile {
        let radius = 0.025;
        let height = 1e-3;
        let density = 1500.0;
        let mut pressure = Vec::new();
        let mut friction = Vec::new();
        let mut coarse = Vec::new();
        for i in (0..200).rev() {
            let middle = height * (f64::from(i) + 0.5);
            let vertical = density * GRAVITY * vanel_clement(middle, 0.02, lambda);
            pressure.push(k * vertical);
            // The weight less the gain of the stress.
            let bearing = 0.5 * radius * density * GRAVITY * (1.0 - (-(middle - 0.02) / lambda).exp());
            friction.push(bearing.max(0.0));
            coarse.push(vertical);
        }
        Profile::from_slices(&[density; 200], &coarse, &pressure, &friction, height, radius)
    }

    #[test]
    fn the_balance_of_slices_is_the_law_that_made_them() {
        let found = silo(0.05, 0.8);
        let fit = found.two_parameters().unwrap();
        // Half a slice for a, and slices over lambda for lambda.
        assert!((fit.values[1] / 0.05 - 1.0).abs() < 0.02 && (fit.values[0] - 0.02).abs() < 5e-4, "{fit:?}");
        assert!((found.agreement() - 1.0).abs() < 2e-3 && (found.pressure_ratio() - 0.8).abs() < 2e-3);
        // At the floor the wall bears all weight but exp(-3.6): mu K (a + lambda) = R/2. Above it bears less.
        let saturated = 0.025 / (2.0 * 0.8 * 0.07);
        assert!(found.mobilised() < saturated && found.mobilised() > 0.7 * saturated, "{}", found.mobilised());
        // Janssen's law alone misses the hydrostatic part.
        assert!(found.one_parameter().unwrap().rms > 10.0 * fit.rms);
    }
}
