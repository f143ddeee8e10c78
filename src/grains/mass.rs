//! Mass of a grain as a function of its radius.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use siloflow_dem::values::Positive;

/// The scene key `mass`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum MassLaw {
    /// m = rho R^2 for this rho, kg/m^2: the law of the assignment.
    ArealSquare(Positive),
    /// m = rho pi R^2 for this rho, kg/m^2: a disc.
    Disc(Positive),
    /// m = rho 4/3 pi R^3 for this rho, kg/m^3: a sphere.
    Sphere(Positive),
}

impl MassLaw {
    /// Returns the mass (kg) of a grain of radius `radius` (m).
    #[must_use]
    pub fn of(self, radius: f64) -> f64 {
        match self {
            Self::ArealSquare(rho) => rho.get() * radius * radius,
            Self::Disc(rho) => rho.get() * PI * radius * radius,
            Self::Sphere(rho) => rho.get() * 4.0 / 3.0 * PI * radius.powi(3),
        }
    }

    /// Returns the law that gives grains with `factor` times the radius the same mass.
    #[must_use]
    pub fn at_radii_times(self, factor: f64) -> Self {
        // A density too small for a number stays, and the rules on masses refuse it.
        let over = |rho: Positive, power: i32| Positive::try_from(rho.get() / factor.powi(power)).unwrap_or(rho);
        match self {
            Self::ArealSquare(rho) => Self::ArealSquare(over(rho, 2)),
            Self::Disc(rho) => Self::Disc(over(rho, 2)),
            Self::Sphere(rho) => Self::Sphere(over(rho, 3)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masses_of_a_grain_of_4_cm() {
        let rho = Positive::try_from(100.0).unwrap();
        for (law, mass) in [
            (MassLaw::ArealSquare(rho), 0.16),
            (MassLaw::Disc(rho), 0.502_654_824_574_366_9),
            (MassLaw::Sphere(rho), 0.026_808_257_310_632_903),
        ] {
            // The mass is a product of up to five rounded numbers.
            assert!((law.of(0.04) / mass - 1.0).abs() < 5.0 * f64::EPSILON);
        }
    }
}
