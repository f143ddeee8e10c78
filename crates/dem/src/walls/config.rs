//! The scene key `walls`.

use std::path::PathBuf;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::particle::Species;
use crate::space::{Linear, Solid, Space};
use crate::values::{Finite, FiniteVector, NonNegative, Positive};
use crate::walls::figure::Figure;
use crate::walls::shapes::ball::Ball;
use crate::walls::shapes::half_plane::HalfPlane;
use crate::walls::shapes::panel::Panel;
use crate::walls::shapes::revolved::Revolved;
use crate::walls::shapes::segment::Segment;
use crate::walls::shapes::spherical_zone::SphericalZone;
use crate::walls::shapes::triangle::Triangle;
use crate::walls::shapes::trimmed::{Trimmed, Whole};
use crate::walls::shapes::{Shape as _, box_around};
use crate::walls::silo_file::LengthUnit;
use crate::walls::surfaces::{Surface, SurfaceWall};
use crate::walls::triangulation;

/// One entry of the scene key `walls`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
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
        /// Name, for `motions` and `doors`; several walls may share one. Default: none.
        #[serde(default)]
        name: Option<String>,
        /// Whether the wall is the door, as for a panel.
        #[serde(default)]
        door: bool,
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
        /// Name, for `motions` and `doors`; several walls may share one. Default: none.
        #[serde(default)]
        name: Option<String>,
        /// Whether the wall is the door, as for a panel.
        #[serde(default)]
        door: bool,
    },
    /// A thin rectangle, in solid space.
    Panel {
        /// One corner, m.
        corner: FiniteVector,
        /// Edge vector from the corner, m.
        along: FiniteVector,
        /// Other edge vector from the corner, m, at right angles to `along`.
        across: FiniteVector,
        /// Outline of a hole. Default: no hole.
        #[serde(default)]
        hole: Option<Figure>,
        /// Outline of the part of the wall that is left, such as the lid of a hole. Default: the whole wall.
        #[serde(default)]
        patch: Option<Figure>,
        /// Material. Default 0.
        #[serde(default)]
        species: u8,
        /// Name, for `motions` and `doors`; several walls may share one. Default: none.
        #[serde(default)]
        name: Option<String>,
        /// Whether the panel is the door. It vanishes when the door opens, and grains that pass through its place are
        /// out.
        #[serde(default)]
        door: bool,
    },
    /// A thin flat polygon in solid space, with or without a hole.
    Polygon {
        /// Corners in one plane, in order round the polygon, m.
        points: Vec<FiniteVector>,
        /// Corners of the hole, in order round it, m. Default: no hole.
        #[serde(default)]
        hole: Vec<FiniteVector>,
        /// Material. Default 0.
        #[serde(default)]
        species: u8,
        /// Name, for `motions` and `doors`; several walls may share one. Default: none.
        #[serde(default)]
        name: Option<String>,
        /// Whether the wall is the door, as for a panel.
        #[serde(default)]
        door: bool,
    },
    /// Triangles of a file, thin, in solid space.
    Mesh {
        /// Path of the STL or OBJ file, relative to the scene file.
        file: PathBuf,
        /// Unit of the numbers in the file.
        unit: LengthUnit,
        /// Material. Default 0.
        #[serde(default)]
        species: u8,
        /// Name, for `motions` and `doors`; several walls may share one. Default: none.
        #[serde(default)]
        name: Option<String>,
        /// Whether the wall is the door, as for a panel.
        #[serde(default)]
        door: bool,
        /// The triangles, m; read from the file after the scene.
        #[serde(skip)]
        triangles: Arc<[[Solid; 3]]>,
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
        /// Outline of a hole. Default: no hole.
        #[serde(default)]
        hole: Option<Figure>,
        /// Outline of the part of the wall that is left, such as the lid of a hole. Default: the whole wall.
        #[serde(default)]
        patch: Option<Figure>,
        /// Material. Default 0.
        #[serde(default)]
        species: u8,
        /// Name, for `motions` and `doors`; several walls may share one. Default: none.
        #[serde(default)]
        name: Option<String>,
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
        /// Outline of a hole. Default: no hole.
        #[serde(default)]
        hole: Option<Figure>,
        /// Outline of the part of the wall that is left, such as the lid of a hole. Default: the whole wall.
        #[serde(default)]
        patch: Option<Figure>,
        /// Material. Default 0.
        #[serde(default)]
        species: u8,
        /// Name, for `motions` and `doors`; several walls may share one. Default: none.
        #[serde(default)]
        name: Option<String>,
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
        /// Outline of a hole. Default: no hole.
        #[serde(default)]
        hole: Option<Figure>,
        /// Outline of the part of the wall that is left, such as the lid of a hole. Default: the whole wall.
        #[serde(default)]
        patch: Option<Figure>,
        /// Material. Default 0.
        #[serde(default)]
        species: u8,
        /// Name, for `motions` and `doors`; several walls may share one. Default: none.
        #[serde(default)]
        name: Option<String>,
        /// Whether the wall is the door, as for a panel.
        #[serde(default)]
        door: bool,
    },
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
        /// Material. Default 0.
        #[serde(default)]
        species: u8,
        /// Name, for `motions` and `doors`; several walls may share one. Default: none.
        #[serde(default)]
        name: Option<String>,
        /// Whether the wall is the door, as for a panel.
        #[serde(default)]
        door: bool,
    },
    /// A disc or sphere. With a name, or as a door, it is a wall surface, solid inside; otherwise a fixed grain, like a grain of a silo file.
    #[serde(alias = "Sphere")]
    Disc {
        /// Centre, m.
        centre: FiniteVector,
        /// Radius, m.
        radius: Positive,
        /// Material. Default 0.
        #[serde(default)]
        species: u8,
        /// Name, for `motions` and `doors`; several walls may share one. Default: none.
        #[serde(default)]
        name: Option<String>,
        /// Whether the wall is the door, as for a panel.
        #[serde(default)]
        door: bool,
    },
}

impl Wall {
    /// Returns the shapes: several for a polygon or a mesh, none for a wall grain. `vector` converts the vectors of
    /// the scene.
    fn shapes<V: Space>(&self, vector: impl Fn(FiniteVector) -> V) -> Vec<Surface<V>> {
        let radius = |radius: NonNegative| radius.get();
        let shape = match *self {
            Self::HalfPlane { point, normal, .. } => {
                Surface::HalfPlane(HalfPlane { point: vector(point), normal: vector(normal).unit_or_zero() })
            }
            Self::Segment { from, to, .. } => Surface::Segment(Segment { from: vector(from), to: vector(to) }),
            Self::Panel { corner, along, across, .. } => {
                let panel = Panel { corner: vector(corner), along: vector(along), across: vector(across) };
                self.trimmed(Whole::Panel(panel), &vector)
            }
            Self::Cylinder { from, to, radius, .. } => {
                let cylinder = Revolved::between(vector(from), vector(to), [radius.get(); 2]);
                self.trimmed(Whole::Revolved(cylinder), &vector)
            }
            Self::Cone { from, to, radii, .. } => {
                let cone = Revolved::between(vector(from), vector(to), <[_; 2]>::from(radii).map(radius));
                self.trimmed(Whole::Revolved(cone), &vector)
            }
            Self::Annulus { centre, normal, inner, outer, .. } => {
                let radii = [inner.map_or(0.0, radius), outer.get()];
                self.trimmed(Whole::Revolved(Revolved::ring(vector(centre), vector(normal), radii)), &vector)
            }
            Self::SphericalZone { centre, radius, axis, heights, .. } => {
                let axis = axis.map_or_else(|| V::narrow(Solid::Z), &vector);
                let radius = radius.get();
                let heights = heights.map_or([-radius, radius], |(low, high)| [low.get(), high.get()]);
                Surface::SphericalZone(SphericalZone::new(vector(centre), axis, radius, heights))
            }
            Self::Polygon { .. } | Self::Mesh { .. } => {
                // The rules have refused polygons without triangles.
                let triangles = self.triangles().unwrap_or_default();
                return triangles.iter().map(|t| Surface::Triangle(Triangle(t.map(V::narrow)))).collect();
            }
            Self::Disc { .. } if self.wall_grain().is_some() => return Vec::new(),
            Self::Disc { centre, radius, .. } => Surface::Ball(Ball { centre: vector(centre), radius: radius.get() }),
        };
        vec![shape]
    }

    /// Returns the surface with the hole of the wall, or its part inside the patch.
    fn trimmed<V: Space>(&self, whole: Whole<V>, vector: impl Fn(FiniteVector) -> V) -> Surface<V> {
        let (hole, patch) = self.cuts();
        if let Some(hole) = hole {
            return Surface::Trimmed(Box::new(Trimmed::with_hole(whole, hole.prism(&whole, vector))));
        }
        if let Some(patch) = patch {
            return Surface::Trimmed(Box::new(Trimmed::patch(whole, patch.prism(&whole, vector))));
        }
        match whole {
            Whole::Panel(panel) => Surface::Panel(panel),
            Whole::Revolved(shape) => Surface::Revolved(shape),
        }
    }

    /// Returns the outlines of the hole and of the patch.
    #[must_use]
    pub fn cuts(&self) -> (Option<&Figure>, Option<&Figure>) {
        match self {
            Self::Panel { hole, patch, .. }
            | Self::Cylinder { hole, patch, .. }
            | Self::Cone { hole, patch, .. }
            | Self::Annulus { hole, patch, .. } => (hole.as_ref(), patch.as_ref()),
            _ => (None, None),
        }
    }

    /// Returns the triangles of a polygon or a mesh, m; none for another wall.
    ///
    /// # Errors
    /// In words, if the corners are not those of a flat polygon.
    pub fn triangles(&self) -> Result<Arc<[[Solid; 3]]>, String> {
        if let Self::Mesh { triangles, .. } = self {
            return Ok(triangles.clone());
        }
        let Self::Polygon { points, hole, .. } = self else { return Ok(Arc::default()) };
        let padded = |points: &[FiniteVector]| points.iter().map(|point| point.padded()).collect::<Vec<_>>();
        triangulation::triangles(&padded(points), &padded(hole)).map(Arc::from)
    }

    /// Returns the surfaces of the wall, which has this number among the walls of the scene, from 0 and without wall grains: several
    /// for a polygon or a mesh, none for a wall grain.
    #[must_use]
    pub fn surfaces<V: Space>(&self, number: usize) -> Vec<SurfaceWall<V>> {
        let shapes = self.shapes(FiniteVector::get::<V>);
        let reference = shapes.first().map_or(V::ZERO, Surface::reference);
        let velocity = match self {
            Self::HalfPlane { velocity: Some(velocity), .. } => velocity.get(),
            _ => V::ZERO,
        };
        let spin_of = |shape: &Surface<V>| match (shape, self.spin()) {
            (
                Surface::Revolved(Revolved { axis, .. }) | Surface::SphericalZone(SphericalZone { axis, .. }),
                Some(spin),
            ) => V::narrow_spin(axis.spread() * spin.get()),
            _ => V::Spin::ZERO,
        };
        let surface = |(piece, shape): (u32, Surface<V>)| {
            let spin = spin_of(&shape);
            let still = SurfaceWall::still(shape, Species(self.species()));
            SurfaceWall { number, piece, reference, velocity, spin, ..still }
        };
        (0..).zip(shapes).map(surface).collect()
    }

    /// Returns the lowest and the highest coordinates of a wall with ends, m; z is 0 in the plane.
    #[must_use]
    pub fn bounds(&self) -> Option<[Solid; 2]> {
        let corners = |shape: Surface<Solid>| shape.bounds().into_iter().flatten();
        let corners: Vec<_> = self.shapes(FiniteVector::padded).into_iter().flat_map(corners).collect();
        box_around(&corners)
    }

    /// Returns the material.
    #[must_use]
    pub fn species(&self) -> u8 {
        match *self {
            Self::HalfPlane { species, .. }
            | Self::Segment { species, .. }
            | Self::Panel { species, .. }
            | Self::Polygon { species, .. }
            | Self::Mesh { species, .. }
            | Self::Cylinder { species, .. }
            | Self::Cone { species, .. }
            | Self::Annulus { species, .. }
            | Self::SphericalZone { species, .. }
            | Self::Disc { species, .. } => species,
        }
    }

    /// Whether the wall is part of the door of the key `door`.
    #[must_use]
    pub fn is_door(&self) -> bool {
        match *self {
            Self::HalfPlane { door, .. }
            | Self::Segment { door, .. }
            | Self::Panel { door, .. }
            | Self::Polygon { door, .. }
            | Self::Mesh { door, .. }
            | Self::Cylinder { door, .. }
            | Self::Cone { door, .. }
            | Self::Annulus { door, .. }
            | Self::SphericalZone { door, .. }
            | Self::Disc { door, .. } => door,
        }
    }

    /// Returns the name.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::HalfPlane { name, .. }
            | Self::Segment { name, .. }
            | Self::Panel { name, .. }
            | Self::Polygon { name, .. }
            | Self::Mesh { name, .. }
            | Self::Cylinder { name, .. }
            | Self::Cone { name, .. }
            | Self::Annulus { name, .. }
            | Self::SphericalZone { name, .. }
            | Self::Disc { name, .. } => name.as_deref(),
        }
    }

    /// Returns the angular velocity about the axis, rad/s.
    fn spin(&self) -> Option<Finite> {
        match *self {
            Self::Cylinder { spin, .. }
            | Self::Cone { spin, .. }
            | Self::Annulus { spin, .. }
            | Self::SphericalZone { spin, .. } => spin,
            _ => None,
        }
    }

    /// Whether the wall moves along itself or about its axis, and keeps its place.
    #[must_use]
    pub fn moves_in_place(&self) -> bool {
        match self {
            Self::HalfPlane { velocity, .. } => velocity.is_some(),
            _ => self.spin().is_some(),
        }
    }

    /// Whether the wall is a surface, not a wall grain.
    #[must_use]
    pub fn is_surface(&self) -> bool {
        self.wall_grain().is_none()
    }

    /// Returns centre, radius (m) and material of a wall grain: a disc or sphere without a name that is no door.
    #[must_use]
    pub fn wall_grain(&self) -> Option<(FiniteVector, f64, Species)> {
        match *self {
            Self::Disc { centre, radius, species, name: None, door: false } => {
                Some((centre, radius.get(), Species(species)))
            }
            _ => None,
        }
    }

    /// Whether the wall exists in solid space only.
    #[must_use]
    pub fn is_solid(&self) -> bool {
        !matches!(self, Self::HalfPlane { .. } | Self::Segment { .. } | Self::Disc { .. })
    }

    /// Returns the vectors of the wall with their keys.
    #[must_use]
    pub fn vectors(&self) -> Vec<(String, FiniteVector)> {
        let (hole, patch) = self.cuts();
        let of_cut = |key: &'static str, figure: Option<&Figure>| {
            let vectors = figure.map(Figure::vectors).unwrap_or_default();
            vectors.into_iter().map(move |(name, vector)| (format!("{key}.{name}"), vector))
        };
        self.own_vectors().into_iter().chain(of_cut("hole", hole)).chain(of_cut("patch", patch)).collect()
    }

    /// Returns the vectors of the wall without its hole, with their keys.
    fn own_vectors(&self) -> Vec<(String, FiniteVector)> {
        let named = |names: &[&str], vectors: &[FiniteVector]| {
            names.iter().map(|name| (*name).to_owned()).zip(vectors.iter().copied()).collect()
        };
        match self {
            Self::HalfPlane { point, normal, velocity: Some(velocity), .. } => {
                named(&["point", "normal", "velocity"], &[*point, *normal, *velocity])
            }
            Self::HalfPlane { point, normal, .. } => named(&["point", "normal"], &[*point, *normal]),
            Self::Segment { from, to, .. } | Self::Cylinder { from, to, .. } | Self::Cone { from, to, .. } => {
                named(&["from", "to"], &[*from, *to])
            }
            Self::Panel { corner, along, across, .. } => {
                named(&["corner", "along", "across"], &[*corner, *along, *across])
            }
            Self::Polygon { points, hole, .. } => {
                let listed = |key: &'static str, points: &[FiniteVector]| {
                    let points = points.to_vec();
                    points.into_iter().enumerate().map(move |(place, point)| (format!("{key}[{place}]"), point))
                };
                listed("points", points).chain(listed("hole", hole)).collect()
            }
            Self::Annulus { centre, normal, .. } => named(&["centre", "normal"], &[*centre, *normal]),
            Self::SphericalZone { centre, axis: Some(axis), .. } => named(&["centre", "axis"], &[*centre, *axis]),
            Self::Mesh { .. } => Vec::new(),
            Self::SphericalZone { centre, .. } | Self::Disc { centre, .. } => named(&["centre"], &[*centre]),
        }
    }
}
