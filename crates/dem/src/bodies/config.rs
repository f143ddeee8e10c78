//! The scene key `shapes`: shapes of grains by name.

use serde::{Deserialize, Serialize};

use crate::bodies::makers::{Deviation, Link, Profile};
use crate::space::{Dimension, Solid};
use crate::values::{FiniteVector, Positive};

/// A sphere (disc) of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SphereConfig {
    /// Centre, m, from any point of the shape.
    pub at: FiniteVector,
    /// Radius, m.
    pub radius: Positive,
}

/// An entry of the scene key `shapes`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum ShapeConfig {
    /// Spheres in solid space.
    Spheres(Vec<SphereConfig>),
    /// Discs in the plane.
    Discs(Vec<SphereConfig>),
    /// An ellipsoid whose two shorter axes are equal, along x, in solid space.
    Ellipsoid {
        /// Full lengths of the axes, m.
        axes: (Positive, Positive, Positive),
        /// Number of spheres.
        spheres: u16,
    },
    /// An ellipse along x, in the plane.
    Ellipse {
        /// Full lengths of the axes, m.
        axes: (Positive, Positive),
        /// Number of discs.
        discs: u16,
    },
    /// A cylinder with round ends, along x; in the plane a strip with round ends.
    Capsule {
        /// The whole length, m.
        length: Positive,
        /// Diameter, m.
        diameter: Positive,
        /// Number of spheres (discs).
        #[serde(alias = "discs")]
        spheres: u16,
    },
}

/// The spheres of an entry, and how far they are from the surface asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct MadeShape {
    /// Centres and radii, m; in the plane z is 0.
    pub spheres: Vec<(Solid, f64)>,
    /// The distance to the surface asked for; `None` if the entry lists its spheres.
    pub deviation: Option<Deviation>,
}

impl ShapeConfig {
    /// Returns the space that the shape needs; `None` if it serves both.
    #[must_use]
    pub fn space(&self) -> Option<Dimension> {
        match self {
            Self::Spheres(_) | Self::Ellipsoid { .. } => Some(Dimension::Solid),
            Self::Discs(_) | Self::Ellipse { .. } => Some(Dimension::Plane),
            Self::Capsule { .. } => None,
        }
    }

    /// Returns the vectors of the entry with their keys.
    #[must_use]
    pub fn vectors(&self) -> Vec<(String, FiniteVector)> {
        match self {
            Self::Spheres(spheres) | Self::Discs(spheres) => {
                spheres.iter().enumerate().map(|(number, sphere)| (format!("[{number}].at"), sphere.at)).collect()
            }
            _ => Vec::new(),
        }
    }

    /// Makes the spheres.
    ///
    /// # Errors
    /// If the entry describes no shape, with the reason.
    pub fn make(&self) -> Result<MadeShape, String> {
        let (profile, count) = match *self {
            Self::Spheres(ref spheres) | Self::Discs(ref spheres) => {
                let spheres = spheres.iter().map(|sphere| (sphere.at.padded(), sphere.radius.get())).collect();
                return Ok(MadeShape { spheres, deviation: None });
            }
            Self::Ellipsoid { axes: (x, y, z), .. } if y != z || x < y => {
                return Err("an ellipsoid has its long axis first, and two equal shorter ones: x >= y = z".to_owned());
            }
            Self::Ellipse { axes: (x, y), .. } if x < y => {
                return Err("the first axis of an ellipse is the longer one".to_owned());
            }
            Self::Capsule { length, diameter, .. } if length < diameter => {
                return Err("a capsule is at least as long as it is wide".to_owned());
            }
            Self::Ellipsoid { axes: (x, y, _), spheres } => (ellipse(x, y), spheres),
            Self::Ellipse { axes: (x, y), discs } => (ellipse(x, y), discs),
            Self::Capsule { length, diameter, spheres } => {
                let profile = Profile::Capsule { half_length: 0.5 * length.get(), radius: 0.5 * diameter.get() };
                (profile, spheres)
            }
        };
        let links = profile.chain(usize::from(count)).ok_or_else(|| {
            format!("{count} spheres in a row do not reach from end to end: neighbours would not overlap; give more")
        })?;
        let deviation = Some(profile.deviation(&links));
        let spheres = links.iter().map(|&Link { x, radius }| (Solid::new(x, 0.0, 0.0), radius)).collect();
        Ok(MadeShape { spheres, deviation })
    }
}

fn ellipse(length: Positive, width: Positive) -> Profile {
    Profile::Ellipse { a: 0.5 * length.get(), b: 0.5 * width.get() }
}
