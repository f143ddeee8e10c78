//! The silos of the case: their widths, the rate and the density of a run.

use std::f64::consts::PI;

use crate::studies::validation::runs::FinishedRun;
use siloflow_text::fault::Fault;

/// Gravity, m/s^2, and mean diameter of the grains, m, in both scenes.
const GRAVITY: f64 = 9.81;
const DIAMETER: f64 = 0.004;

/// Time after the opening from which on the rate is taken, s: the rate is steady after about 0.05 s.
const FROM: f64 = 0.1;

/// Distance of the grains that count for the density from floor and walls, diameters.
const AWAY: f64 = 3.0;

/// A silo of the case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Silo {
    Slot,
    Circle,
}

impl Silo {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Slot => "slot",
            Self::Circle => "circle",
        }
    }

    /// Sweep files of the full and the short form.
    pub(super) fn sweeps(self) -> [&'static str; 2] {
        match self {
            Self::Slot => ["full-slot.ron", "short-slot.ron"],
            Self::Circle => ["full-circle.ron", "short-circle.ron"],
        }
    }

    /// Exponent of the law.
    pub(super) fn power(self) -> f64 {
        match self {
            Self::Slot => 1.5,
            Self::Circle => 2.5,
        }
    }

    /// C of Beverloo's law and b of Mankoc's form, as they are often quoted.
    pub(super) fn constants(self) -> (f64, f64) {
        match self {
            Self::Slot => (1.03, 0.23),
            Self::Circle => (0.58, 0.051),
        }
    }

    /// Width of the orifice of a run, diameters.
    pub(super) fn width(self, run: &FinishedRun) -> Option<f64> {
        run.number(match self {
            Self::Slot => "parameters.slot",
            Self::Circle => "parameters.orifice",
        })
    }

    /// Returns the unit of the rate, n sqrt(g) d^(5/2), grains/s, of a bed with `number` grains per volume (1/m^3); for the slot times its length in d.
    pub(super) fn unit(self, run: &FinishedRun, number: f64) -> Option<f64> {
        let length = match self {
            Self::Slot => run.number("parameters.deep")?,
            Self::Circle => 1.0,
        };
        Some(length * number * GRAVITY.sqrt() * DIAMETER.powf(2.5))
    }

    /// Returns whether a place (diameters) is far enough from the walls, and the area of such places (square diameters).
    fn core(self, run: &FinishedRun) -> Option<(impl Fn(f64, f64) -> bool, f64)> {
        let reach = 0.5 * run.number("parameters.wide")? - AWAY;
        let area = match self {
            Self::Slot => 2.0 * reach * run.number("parameters.deep")?,
            Self::Circle => PI * reach * reach,
        };
        Some((move |x: f64, y: f64| if self == Self::Slot { x.abs() < reach } else { x.hypot(y) < reach }, area))
    }
}

/// Returns the discharge rate of a run, grains/s; NaN if it is too short.
pub(super) fn rate(run: &FinishedRun) -> Result<f64, Fault> {
    run.rate(FROM, f64::INFINITY)
}

/// Returns the number of grains per volume at the end of a run, 1/m^3.
pub(super) fn density(silo: Silo, run: &FinishedRun) -> Result<f64, Fault> {
    let state = run.table("state.csv")?;
    let [x, y, z] = [state.needed("x")?, state.needed("y")?, state.needed("z")?];
    let Some(((is_far, area), layers)) = silo.core(run).zip(run.number("parameters.layers")) else {
        return Ok(f64::NAN);
    };
    let top = 0.5 * layers;
    let is_counted = |i: usize| {
        let [x, y, z] = [x[i], y[i], z[i]].map(|place| place / DIAMETER);
        (AWAY..top).contains(&z) && is_far(x, y)
    };
    let count = (0..x.len()).filter(|i| is_counted(*i)).count();
    let volume = area * (top - AWAY) * DIAMETER.powi(3);
    Ok(f64::from(u32::try_from(count).unwrap_or(u32::MAX)) / volume)
}
