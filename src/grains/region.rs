//! Regions of space in which random grains are placed: their bounds, and points that are uniform in them.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use siloflow_dem::math;
use siloflow_dem::space::Solid;
use siloflow_dem::values::{FiniteVector, NonNegative, Positive};

/// The key `region` of a feed.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub enum Region {
    /// A box with sides along the axes. It may be flat: equal coordinates make a line, or a face.
    Box {
        /// Lower corner, m.
        low: FiniteVector,
        /// Upper corner, m.
        high: FiniteVector,
    },
    /// A horizontal disc of solid space, or with a height an upright cylinder above it.
    Disc {
        /// Centre of the disc, m.
        centre: FiniteVector,
        /// Radius of the disc, m.
        radius: Positive,
        /// Height of the cylinder, m. Default 0.
        #[serde(default)]
        height: Option<NonNegative>,
    },
}

impl Region {
    /// Returns the lower and the upper corner of the box around the region, m.
    #[must_use]
    pub fn bounds(&self) -> (Solid, Solid) {
        match *self {
            Self::Box { low, high } => (low.padded(), high.padded()),
            Self::Disc { centre, radius, height } => {
                let centre = centre.padded();
                let radius = radius.get();
                let side = Solid::new(radius, radius, 0.0);
                (centre - side, centre + side + Solid::Z * height.map_or(0.0, NonNegative::get))
            }
        }
    }

    /// Returns the point of the region for three numbers, each uniform in 0 <= u < 1. Points are uniform in the region.
    #[must_use]
    pub fn point(&self, u: [f64; 3]) -> Solid {
        match *self {
            Self::Box { low, high } => low.padded() + (high.padded() - low.padded()) * Solid::from(u),
            Self::Disc { centre, radius, height } => {
                let (sin, cos) = math::sincos(TAU * u[1]);
                let r = radius.get() * u[0].sqrt();
                centre.padded() + Solid::new(r * cos, r * sin, u[2] * height.map_or(0.0, NonNegative::get))
            }
        }
    }
}
