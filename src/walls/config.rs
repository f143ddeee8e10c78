//! The scene key `walls`.

use serde::{Deserialize, Serialize};

use crate::particle::Species;
use crate::space::{Linear, Solid, Space};
use crate::values::{Finite, FiniteVector, NonNegative, Positive};
use crate::walls::shapes::Shape as _;
use crate::walls::shapes::half_plane::HalfPlane;
use crate::walls::shapes::panel::Panel;
use crate::walls::shapes::revolved::Revolved;
use crate::walls::shapes::segment::Segment;
use crate::walls::surfaces::{Surface, SurfaceWall};

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
    /// A thin cylinder, open at both ends, in solid space.
    Cylinder {
        /// One end of the axis, m.
        from: FiniteVector,
        /// The other end of the axis, m.
        to: FiniteVector,
        /// Radius, m.
        radius: Positive,
        /// Angular velocity about the axis, rad/s, positive by the right-hand rule from `from` to `to`. Default 0.
        #[serde(default)]
        spin: Option<Finite>,
        /// Material. Default 0.
        #[serde(default)]
        species: u8,
        /// Whether the wall is the door, as for a panel.
        #[serde(default)]
        door: bool,
    },
    /// A thin cone or frustum, open at both ends, in solid space.
    Cone {
        /// One end of the axis, m.
        from: FiniteVector,
        /// The other end of the axis, m.
        to: FiniteVector,
        /// Radius at `from` and at `to`, m.
        radii: (NonNegative, NonNegative),
        /// Angular velocity about the axis, rad/s, as for a cylinder. Default 0.
        #[serde(default)]
        spin: Option<Finite>,
        /// Material. Default 0.
        #[serde(default)]
        species: u8,
        /// Whether the wall is the door, as for a panel.
        #[serde(default)]
        door: bool,
    },
    /// A thin flat ring in solid space, or a circular plate.
    Annulus {
        /// Centre, m.
        centre: FiniteVector,
        /// Direction of the axis, of any non-zero length.
        normal: FiniteVector,
        /// Radius of the hole, m. Default 0: a plate without a hole.
        #[serde(default)]
        inner: Option<NonNegative>,
        /// Radius of the ring, m.
        outer: Positive,
        /// Angular velocity about the axis, rad/s, positive by the right-hand rule along `normal`. Default 0.
        #[serde(default)]
        spin: Option<Finite>,
        /// Material. Default 0.
        #[serde(default)]
        species: u8,
        /// Whether the wall is the door, as for a panel.
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
    /// Returns the shape, or `None` for a disc, which is a wall grain. `vector` converts the vectors of the scene.
    fn shape<V: Space>(&self, vector: impl Fn(FiniteVector) -> V) -> Option<Surface<V>> {
        let radius = |radius: NonNegative| radius.get();
        Some(match *self {
            Self::HalfPlane { point, normal, .. } => {
                Surface::HalfPlane(HalfPlane { point: vector(point), normal: vector(normal).unit_or_zero() })
            }
            Self::Segment { from, to, .. } => Surface::Segment(Segment { from: vector(from), to: vector(to) }),
            Self::Panel { corner, along, across, .. } => {
                Surface::Panel(Panel { corner: vector(corner), along: vector(along), across: vector(across) })
            }
            Self::Cylinder { from, to, radius, .. } => {
                Surface::Revolved(Revolved::between(vector(from), vector(to), [radius.get(); 2]))
            }
            Self::Cone { from, to, radii, .. } => {
                Surface::Revolved(Revolved::between(vector(from), vector(to), <[_; 2]>::from(radii).map(radius)))
            }
            Self::Annulus { centre, normal, inner, outer, .. } => {
                let radii = [inner.map_or(0.0, radius), outer.get()];
                Surface::Revolved(Revolved::ring(vector(centre), vector(normal), radii))
            }
            Self::Disc { .. } => return None,
        })
    }

    /// Returns the wall surface, or `None` for a disc.
    #[must_use]
    pub fn surface<V: Space>(&self) -> Option<SurfaceWall<V>> {
        let surface = self.shape(FiniteVector::get::<V>)?;
        let velocity = match self {
            Self::HalfPlane { velocity: Some(velocity), .. } => velocity.get(),
            _ => V::ZERO,
        };
        let spin = match (&surface, self) {
            (
                Surface::Revolved(shape),
                Self::Cylinder { spin: Some(spin), .. }
                | Self::Cone { spin: Some(spin), .. }
                | Self::Annulus { spin: Some(spin), .. },
            ) => V::narrow_spin(shape.axis.spread() * spin.get()),
            _ => V::Spin::ZERO,
        };
        let still = SurfaceWall::still(surface, Species(self.species()));
        Some(SurfaceWall { velocity, spin, is_door: self.is_door(), ..still })
    }

    /// Returns the lowest and the highest coordinates of a surface with ends, m; z is 0 in the plane.
    #[must_use]
    pub fn bounds(&self) -> Option<[Solid; 2]> {
        self.shape::<Solid>(FiniteVector::padded)?.bounds()
    }

    /// Returns the material.
    #[must_use]
    pub fn species(&self) -> u8 {
        match *self {
            Self::HalfPlane { species, .. }
            | Self::Segment { species, .. }
            | Self::Panel { species, .. }
            | Self::Cylinder { species, .. }
            | Self::Cone { species, .. }
            | Self::Annulus { species, .. }
            | Self::Disc { species, .. } => species,
        }
    }

    /// Whether the wall is the door.
    #[must_use]
    pub fn is_door(&self) -> bool {
        match *self {
            Self::Panel { door, .. }
            | Self::Cylinder { door, .. }
            | Self::Cone { door, .. }
            | Self::Annulus { door, .. } => door,
            Self::HalfPlane { .. } | Self::Segment { .. } | Self::Disc { .. } => false,
        }
    }

    /// Whether the wall exists in solid space only.
    #[must_use]
    pub fn is_solid(&self) -> bool {
        matches!(self, Self::Panel { .. } | Self::Cylinder { .. } | Self::Cone { .. } | Self::Annulus { .. })
    }

    /// Returns the vectors of the wall with their keys.
    #[must_use]
    pub fn vectors(&self) -> Vec<(&'static str, FiniteVector)> {
        match *self {
            Self::HalfPlane { point, normal, velocity, .. } => {
                [("point", point), ("normal", normal)].into_iter().chain(velocity.map(|v| ("velocity", v))).collect()
            }
            Self::Segment { from, to, .. } | Self::Cylinder { from, to, .. } | Self::Cone { from, to, .. } => {
                vec![("from", from), ("to", to)]
            }
            Self::Panel { corner, along, across, .. } => {
                vec![("corner", corner), ("along", along), ("across", across)]
            }
            Self::Annulus { centre, normal, .. } => vec![("centre", centre), ("normal", normal)],
            Self::Disc { centre, .. } => vec![("centre", centre)],
        }
    }
}
