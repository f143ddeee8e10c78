//! The shapes of walls and their keys.

use std::path::PathBuf;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::cut::Cut;
use super::keys::{CommonKeys, wall_shapes};
use crate::space::Solid;
use crate::values::{Finite, FiniteVector, LengthUnit, NonNegative, Positive};

wall_shapes! {
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
    }
    /// A thin wall between two points; in solid space, a thin rod.
    Segment {
        /// One end, m.
        from: FiniteVector,
        /// The other end, m.
        to: FiniteVector,
    }
    /// A thin rectangle, in solid space.
    Panel {
        /// One corner, m.
        corner: FiniteVector,
        /// Edge vector from the corner, m.
        along: FiniteVector,
        /// Other edge vector from the corner, m, at right angles to `along`.
        across: FiniteVector,
        /// A hole. Default: no hole.
        #[serde(default)]
        hole: Option<Cut>,
        /// The part of the wall that is left, such as the lid of a hole. Default: the whole wall.
        #[serde(default)]
        patch: Option<Cut>,
    }
    /// A thin flat polygon in solid space, with or without a hole.
    Polygon {
        /// Corners in one plane, in order round the polygon, m.
        points: Vec<FiniteVector>,
        /// Corners of the hole, in order round it, m. Default: no hole.
        #[serde(default)]
        hole: Vec<FiniteVector>,
    }
    /// Triangles of a file, thin, in solid space.
    Mesh {
        /// Path of the STL or OBJ file, relative to the scene file.
        file: PathBuf,
        /// Unit of the numbers in the file.
        unit: LengthUnit,
        /// The triangles, m; read from the file after the scene.
        #[serde(skip)]
        triangles: Arc<[[Solid; 3]]>,
    }
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
        /// A hole. Default: no hole.
        #[serde(default)]
        hole: Option<Cut>,
        /// The part of the wall that is left, such as the lid of a hole. Default: the whole wall.
        #[serde(default)]
        patch: Option<Cut>,
    }
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
        /// A hole. Default: no hole.
        #[serde(default)]
        hole: Option<Cut>,
        /// The part of the wall that is left, such as the lid of a hole. Default: the whole wall.
        #[serde(default)]
        patch: Option<Cut>,
    }
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
        /// A hole. Default: no hole.
        #[serde(default)]
        hole: Option<Cut>,
        /// The part of the wall that is left, such as the lid of a hole. Default: the whole wall.
        #[serde(default)]
        patch: Option<Cut>,
    }
    /// A thin part of a sphere between two heights along its axis, in solid space: a hemispherical bottom, a dome, or a hollow
    /// sphere.
    SphericalZone {
        /// Centre of the sphere, m.
        centre: FiniteVector,
        /// Radius of the sphere, m.
        radius: Positive,
        /// Direction of the axis, of any non-zero length. Default: upwards, along z.
        #[serde(default)]
        axis: Option<FiniteVector>,
        /// The two heights along the axis from the centre, m, the lower one first. Default: the whole sphere.
        #[serde(default)]
        heights: Option<(Finite, Finite)>,
        /// Angular velocity about the axis, rad/s, positive by the right-hand rule along `axis`. Default 0.
        #[serde(default)]
        spin: Option<Finite>,
    }
    /// A disc or sphere. With a name, or as a door, it is a wall surface, solid inside; otherwise a fixed grain, like a grain of a silo file.
    #[serde(alias = "Sphere")]
    Disc {
        /// Centre, m.
        centre: FiniteVector,
        /// Radius, m.
        radius: Positive,
    }
}
