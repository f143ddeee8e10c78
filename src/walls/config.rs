//! The scene's `walls`.

use serde::{Deserialize, Serialize};

use crate::particle::Species;
use crate::space::Space;
use crate::values::{FiniteVector, Positive};
use crate::walls::surfaces::{FlatWall, Surface, WallLoad};

/// One of the scene's `walls`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub enum Wall {
    /// Everything behind a line, in solid space behind a plane, is solid.
    #[serde(alias = "HalfSpace")]
    HalfPlane {
        /// A point of the surface, m.
        point: FiniteVector,
        /// The direction from the solid into the free half, of any length but zero.
        normal: FiniteVector,
        /// Its velocity along itself, m/s: a belt. Default at rest.
        #[serde(default)]
        velocity: Option<FiniteVector>,
        /// Its material. Default 0.
        #[serde(default)]
        species: u8,
    },
    /// A thin wall between two points; in solid space, a thin rod.
    Segment {
        /// One end, m.
        from: FiniteVector,
        /// The other end, m.
        to: FiniteVector,
        /// Its material. Default 0.
        #[serde(default)]
        species: u8,
    },
    /// A thin rectangle of solid space.
    Panel {
        /// One corner, m.
        corner: FiniteVector,
        /// From there along one edge, m.
        along: FiniteVector,
        /// From there along the other edge, m, at right angles to the first.
        across: FiniteVector,
        /// Its material. Default 0.
        #[serde(default)]
        species: u8,
        /// Whether it is the door: gone when the door opens, and grains that pass where it was are out.
        #[serde(default)]
        door: bool,
    },
    /// A fixed disc or sphere: a wall grain like those of a silo file.
    #[serde(alias = "Sphere")]
    Disc {
        /// Centre, m.
        centre: FiniteVector,
        /// Radius, m.
        radius: Positive,
        /// Its material. Default 0.
        #[serde(default)]
        species: u8,
    },
}

impl Wall {
    /// The flat wall, unless it is a disc.
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
