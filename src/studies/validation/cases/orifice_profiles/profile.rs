//! The profile of one run: covered share of time and velocity on the floor's line, and the fits of the laws.

use std::f64::consts::PI;

use crate::studies::validation::runs::FinishedRun;
use siloflow_figures::statistics::fit::Law;
use siloflow_text::fault::Fault;

/// Mean diameter of the grains, m.
pub(super) const DIAMETER: f64 = 1.0e-3;

/// Acceleration of gravity, m/s^2.
pub(super) const GRAVITY: f64 = 9.81;

/// Share of the half-width in which profiles are fitted.
const FITTED: f64 = 0.9;

/// A point of a profile: x (m), solid fraction, downward velocity (m/s).
pub(super) type Point = (f64, f64, f64);

/// The profiles of one run, and their fits.
pub(super) struct Profile {
    /// Half-width of the orifice, m.
    pub(super) half: f64,
    /// From one edge to the other.
    pub(super) points: Vec<Point>,
    pub(super) gamma: f64,
    pub(super) velocity_exponent: f64,
    /// phi_0.
    pub(super) middle: f64,
    /// 1/nu.
    pub(super) fraction_exponent: f64,
    /// Counted rate, grains/s.
    pub(super) rate: f64,
    /// Flux of the profiles over the counted rate.
    pub(super) flux: f64,
}

impl Profile {
    /// Returns the width of the orifice in diameters, for a name.
    pub(super) fn width(&self) -> String {
        format!("D = {} d", (200.0 * self.half / DIAMETER).round() / 100.0)
    }

    /// Reads and fits the profile of a run.
    pub(super) fn of(run: &FinishedRun) -> Result<Self, Fault> {
        let half = 0.5 * DIAMETER * run.value("parameters.width").unwrap_or(f64::NAN);
        let table = run.table("fields.csv")?;
        let column = |name: &str| table.numbers(name).unwrap_or_default();
        let x = column("x1_m");
        let y = column("x2_m");
        let fraction = column("solid_fraction");
        let velocity = column("v2");
        let cells: Vec<_> = (0..x.len()).map(|n| ([x[n], y[n]], fraction[n], velocity[n])).collect();
        let points = covered(&cells, half);
        let counted = run.number("discharge.rate_per_s").unwrap_or(f64::NAN);
        Ok(Self::fit(half, points, counted))
    }

    /// Fits the laws to a profile; `counted` is the discharge rate, grains/s.
    pub(super) fn fit(half: f64, points: Vec<Point>, counted: f64) -> Self {
        let inner = || {
            let shape = |x: f64| 1.0 - (x / half).powi(2);
            points.iter().filter(|(x, ..)| x.abs() < FITTED * half).map(move |(x, phi, v)| (shape(*x), *phi, *v))
        };
        let (above, below) = inner().fold((0.0, 0.0), |(a, b), (s, _, v)| (a + v * s.sqrt(), b + s));
        let power = |points: Vec<(f64, f64)>| {
            let fit = Law::Power.fit(&points)?;
            Some((fit.value("prefactor")?, fit.value("exponent")?))
        };
        let nothing = (f64::NAN, f64::NAN);
        let (_, velocity_exponent) = power(inner().map(|(s, _, v)| (s, v)).collect()).unwrap_or(nothing);
        let (middle, fraction_exponent) = power(inner().map(|(s, phi, _)| (s, phi)).collect()).unwrap_or(nothing);
        let spacing = points.get(1).zip(points.first()).map_or(f64::NAN, |(b, a)| b.0 - a.0);
        let flux = points.iter().map(|(_, phi, v)| phi * v).sum::<f64>() * spacing / (0.25 * PI * DIAMETER.powi(2));
        let gamma = (above / below).powi(2) / (2.0 * GRAVITY * half);
        Self { half, points, gamma, velocity_exponent, middle, fraction_exponent, rate: counted, flux: flux / counted }
    }
}

/// Returns the profile on the line y = 0 from cells (place, solid fraction of the grains with their centres there, upward velocity).
fn covered(cells: &[([f64; 2], f64, f64)], half: f64) -> Vec<Point> {
    let spacing = 0.1 * DIAMETER;
    // The mean over the disc of a density of centres, times the disc's area, over the area of a grain: the share of time that the point is covered.
    let disc = 0.25 * PI * DIAMETER.powi(2);
    let at = |x: f64| {
        let near = cells.iter().filter(|(place, ..)| (place[0] - x).hypot(place[1]) < 0.5 * DIAMETER);
        let filled = near.filter(|(_, fraction, velocity)| *fraction > 0.0 && velocity.is_finite());
        let (density, momentum) =
            filled.fold((0.0, 0.0), |(n, p), (_, fraction, velocity)| (n + fraction, p - fraction * velocity));
        (x, density * spacing * spacing / disc, momentum / density)
    };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small number of points")]
    let number = (2.0 * half / spacing).round() as u32;
    (0..number).map(|n| at(spacing * (f64::from(n) + 0.5) - half)).filter(|point| point.2.is_finite()).collect()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Returns the exact profile of the law, with the rate that it carries.
    pub(in super::super) fn exact(half: f64, gamma: f64, exponent: f64, middle: f64) -> Profile {
        let place = |n: u16| half * ((f64::from(n) + 0.5) / 500.0 - 1.0);
        let point = |x: f64| {
            let s = 1.0 - (x / half).powi(2);
            (x, middle * s.powf(exponent), (2.0 * gamma * GRAVITY * half * s).sqrt())
        };
        let points: Vec<_> = (0..1000).map(place).map(point).collect();
        let rate =
            points.iter().map(|(_, phi, v)| phi * v).sum::<f64>() * half / 500.0 / (0.25 * PI * DIAMETER.powi(2));
        Profile::fit(half, points, rate)
    }

    #[test]
    fn the_constants_of_exact_profiles_are_recovered() {
        let it = exact(0.006, 1.07, 0.22, 0.76);
        for (found, expected) in [
            (it.gamma, 1.07),
            (it.velocity_exponent, 0.5),
            (it.fraction_exponent, 0.22),
            (it.middle, 0.76),
            (it.flux, 1.0),
        ] {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }

    #[test]
    fn grains_of_one_density_cover_that_share_and_keep_their_velocity() {
        // Centres at the density of a solid fraction of 0.6 in all cells: each point is covered for 0.6 of the time.
        let place = |n: i32| 1e-4 * (f64::from(n) + 0.5);
        let cells: Vec<_> = (-100..100).flat_map(|i| (-6..6).map(move |j| ([place(i), place(j)], 0.6, -0.4))).collect();
        let points = covered(&cells, 0.005);
        assert_eq!(points.len(), 100);
        // 78.5 cells are in the disc; those at its edge count whole.
        assert!(points.iter().all(|(_, phi, v)| (phi / 0.6 - 1.0).abs() < 0.04 && (v - 0.4).abs() < 1e-12));
    }
}
