//! The scene key `walls`.

use serde::{Deserialize, Serialize};

use crate::particle::Species;
use crate::space::Space;
use crate::values::{FiniteVector, Positive};
use crate::walls::surfaces::{FlatWall, Surface, WallLoad};

/// One entry of the scene key `walls`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Wall {
    /// A solid half-plane behind a line; in solid space, a half-space behind a plane.
    #[serde(alias = "HalfSpace")]
    HalfPlane {
        /// A point of the surface, m.
        point: FiniteVector,
        /// Direction from the solid into the free half, of any non-zero length.
        normal: FiniteVector,
        /// Velocity of the wall along itself, m/s, for a belt. Default 0.
        #[serde(default)]
        velocity: Option<FiniteVector>,
        /// Material. Default 0.
        #[serde(default)]
        species: u8,
    },
    /// A thin wall between two points; in solid space, a thin rod.
    Segment {
        /// One end, m.
        from: FiniteVector,
        /// The other end, m.
        to: FiniteVector,
        /// Material. Default 0.
        #[serde(default)]
        species: u8,
    },
    /// A thin rectangle, in solid space.
    Panel {
        /// One corner, m.
        corner: FiniteVector,
        /// Edge vector from the corner, m.
        along: FiniteVector,
        /// Other edge vector from the corner, m, at right angles to `along`.
        across: FiniteVector,
        /// Material. Default 0.
        #[serde(default)]
        species: u8,
        /// Whether the panel is the door. It vanishes when the door opens, and grains that pass through its place are
        /// out.
        #[serde(default)]
        door: bool,
    },
    /// A fixed disc or sphere: a wall grain like a grain of a silo file.
    #[serde(alias = "Sphere")]
    Disc {
        /// Centre, m.
        centre: FiniteVector,
        /// Radius, m.
        radius: Positive,
        /// Material. Default 0.
        #[serde(default)]
        species: u8,
    },
}

impl Wall {
    /// Returns the flat wall, or `None` for a disc.
    #[must_use]
    pub fn flat<V: Space>(&self) -> Option<FlatWall<V>> {
        let (surface, species) = match *self {
            Self::HalfPlane { point, normal, species, .. } => {
                (Surface::HalfPlane { point: point.get(), normal: normal.get::<V>().unit_or_zero() }, species)
            }
            Self::Segment { from, to, species } => (Surface::Segment { from: from.get(), to: to.get() }, species),
            Self::Panel { corner, along, across, species, .. } => {
                (Surface::Panel { corner: corner.get(), along: along.get(), across: across.get() }, species)
            }
            Self::Disc { .. } => return None,
        };
        let velocity = match self {
            Self::HalfPlane { velocity: Some(velocity), .. } => velocity.get(),
            _ => V::ZERO,
        };
        let is_door = matches!(self, Self::Panel { door: true, .. });
        let load = WallLoad::default();
        Some(FlatWall { surface, velocity, species: Species(species), is_door, is_present: true, load })
    }
}
