//! The geometry of the shapes of walls: their surfaces, cuts, motions in place and vectors.

use std::sync::Arc;

use super::cut::Cut;
use super::shape::WallShape;
use crate::space::{Solid, Space};
use crate::values::{Finite, FiniteVector, NonNegative};
use crate::walls::shapes::ball::Ball;
use crate::walls::shapes::box_around;
use crate::walls::shapes::half_plane::HalfPlane;
use crate::walls::shapes::panel::Panel;
use crate::walls::shapes::revolved::Revolved;
use crate::walls::shapes::segment::Segment;
use crate::walls::shapes::spherical_zone::SphericalZone;
use crate::walls::shapes::triangle::Triangle;
use crate::walls::shapes::trimmed::{RimFault, Trimmed};
use crate::walls::shapes::whole::Whole;
use crate::walls::surface::Surface;
use crate::walls::triangulation;

/// The keys `hole` and `patch` of a wall.
#[derive(Clone, Copy, Debug)]
pub struct Cuts<'a> {
    /// The hole.
    pub hole: Option<&'a Cut>,
    /// The part of the wall that is left.
    pub patch: Option<&'a Cut>,
}

/// The rotation of a wall about its own axis, in which it keeps its place.
#[derive(Clone, Copy, Debug)]
pub struct OwnSpin {
    /// Angular velocity, rad/s, positive by the right-hand rule along the axis.
    pub rate: f64,
    /// A point of the axis, m.
    pub about: Solid,
    /// Direction of the axis, of any non-zero length.
    pub axis: Solid,
}

impl WallShape {
    /// Returns the surfaces: several for a polygon or a mesh. `vector` converts the vectors of the scene.
    pub(super) fn surfaces<V: Space>(&self, vector: impl Fn(FiniteVector) -> V) -> Vec<Surface<V>> {
        let surface = match *self {
            Self::HalfPlane { point, normal, .. } => {
                Surface::HalfPlane(HalfPlane { point: vector(point), normal: vector(normal).unit_or_zero() })
            }
            Self::Segment { from, to } => Surface::Segment(Segment { from: vector(from), to: vector(to) }),
            Self::Panel { corner, along, across, .. } => {
                let panel = Panel { corner: vector(corner), along: vector(along), across: vector(across) };
                self.cut(Whole::Panel(panel), &vector)
            }
            Self::Cylinder { from, to, radius, .. } => {
                let cylinder = Revolved::between(vector(from), vector(to), [radius.get(); 2]);
                self.cut(Whole::Revolved(cylinder), &vector)
            }
            Self::Cone { from, to, radii, .. } => {
                let radii = <[NonNegative; 2]>::from(radii).map(NonNegative::get);
                self.cut(Whole::Revolved(Revolved::between(vector(from), vector(to), radii)), &vector)
            }
            Self::Annulus { centre, normal, inner, outer, .. } => {
                let radii = [inner.map_or(0.0, NonNegative::get), outer.get()];
                self.cut(Whole::Revolved(Revolved::ring(vector(centre), vector(normal), radii)), &vector)
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
            Self::Disc { centre, radius } => Surface::Ball(Ball { centre: vector(centre), radius: radius.get() }),
        };
        vec![surface]
    }

    /// Returns the surface with the hole of the wall, or its part inside the patch.
    fn cut<V: Space>(&self, whole: Whole<V>, vector: impl Fn(FiniteVector) -> V) -> Surface<V> {
        let Cuts { hole, patch } = self.cuts();
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
    pub fn cuts(&self) -> Cuts<'_> {
        match self {
            Self::Panel { hole, patch, .. }
            | Self::Cylinder { hole, patch, .. }
            | Self::Cone { hole, patch, .. }
            | Self::Annulus { hole, patch, .. } => Cuts { hole: hole.as_ref(), patch: patch.as_ref() },
            _ => Cuts { hole: None, patch: None },
        }
    }

    /// Returns the fault of the rim of a hole or patch, if it has one.
    #[must_use]
    pub fn rim_fault(&self) -> Option<RimFault<Solid>> {
        match self.surfaces(FiniteVector::get::<Solid>).pop()? {
            Surface::Trimmed(surface) => surface.rim_fault(),
            _ => None,
        }
    }

    /// Returns the triangles of a polygon or a mesh, m; none for another shape.
    ///
    /// # Errors
    /// In words, if the corners are not those of a flat polygon.
    pub fn triangles(&self) -> Result<Arc<[[Solid; 3]]>, String> {
        if let Self::Mesh { triangles, .. } = self {
            return Ok(triangles.clone());
        }
        let Self::Polygon { points, hole } = self else { return Ok(Arc::default()) };
        let padded = |points: &[FiniteVector]| points.iter().map(|point| point.padded()).collect::<Vec<_>>();
        triangulation::triangles(&padded(points), &padded(hole)).map(Arc::from)
    }

    /// Returns the lowest and the highest coordinates of a shape with ends, m; z is 0 in the plane.
    pub(super) fn bounds(&self) -> Option<[Solid; 2]> {
        let surfaces = self.surfaces(FiniteVector::padded);
        let corners: Vec<_> = surfaces.iter().filter_map(Surface::bounds).flatten().collect();
        box_around(&corners)
    }

    /// Returns the width of the opening that the wall leaves where it is a door and vanishes, m; `None` for a shape without ends.
    #[must_use]
    pub fn width(&self) -> Option<f64> {
        let length = |from: FiniteVector, to: FiniteVector| to.padded().distance(from.padded());
        if let Some(patch) = self.cuts().patch {
            return Some(patch.width());
        }
        match *self {
            Self::Panel { along, across, .. } => Some(along.padded().length().min(across.padded().length())),
            Self::Annulus { outer, .. } => Some(2.0 * outer.get()),
            Self::Disc { radius, .. } => Some(2.0 * radius.get()),
            Self::Segment { from, to } => Some(length(from, to)),
            Self::Cylinder { from, to, radius, .. } => Some((2.0 * radius.get()).min(length(from, to))),
            Self::Cone { from, to, radii, .. } => Some((2.0 * radii.0.get().max(radii.1.get())).min(length(from, to))),
            // The smallest extent is the thickness: about zero, or the height of a cap.
            _ => self.bounds().map(|[low, high]| {
                let mut extents = (high - low).to_array();
                extents.sort_unstable_by(f64::total_cmp);
                extents[1]
            }),
        }
    }

    /// Returns the velocity of a wall that moves along itself, m/s.
    #[must_use]
    pub fn own_velocity(&self) -> Option<FiniteVector> {
        match *self {
            Self::HalfPlane { velocity, .. } => velocity,
            _ => None,
        }
    }

    /// Returns the rotation of a wall that turns about its own axis.
    #[must_use]
    pub fn own_spin(&self) -> Option<OwnSpin> {
        let (spin, about, axis) = match *self {
            Self::Cylinder { spin, from, to, .. } | Self::Cone { spin, from, to, .. } => {
                (spin, from, to.padded() - from.padded())
            }
            Self::Annulus { spin, centre, normal, .. } => (spin, centre, normal.padded()),
            Self::SphericalZone { spin, centre, axis, .. } => {
                (spin, centre, axis.map_or(Solid::Z, FiniteVector::padded))
            }
            _ => return None,
        };
        spin.map(|spin: Finite| OwnSpin { rate: spin.get(), about: about.padded(), axis })
    }

    /// Whether the wall moves along itself or about its axis, and keeps its place.
    #[must_use]
    pub fn moves_in_place(&self) -> bool {
        self.own_velocity().is_some() || self.own_spin().is_some()
    }

    /// Whether the shape exists in solid space only.
    #[must_use]
    pub fn needs_solid_space(&self) -> bool {
        !matches!(self, Self::HalfPlane { .. } | Self::Segment { .. } | Self::Disc { .. })
    }

    /// Returns the vectors of the shape with their keys.
    #[must_use]
    pub fn vectors(&self) -> Vec<(String, FiniteVector)> {
        let Cuts { hole, patch } = self.cuts();
        let of_cut = |key: &'static str, cut: Option<&Cut>| {
            let vectors = cut.map(Cut::vectors).unwrap_or_default();
            vectors.into_iter().map(move |(name, vector)| (format!("{key}.{name}"), vector))
        };
        self.own_vectors().into_iter().chain(of_cut("hole", hole)).chain(of_cut("patch", patch)).collect()
    }

    /// Returns the vectors of the shape without its cuts, with their keys.
    fn own_vectors(&self) -> Vec<(String, FiniteVector)> {
        let named = |names: &[&str], vectors: &[FiniteVector]| {
            names.iter().map(|name| (*name).to_owned()).zip(vectors.iter().copied()).collect()
        };
        match self {
            Self::HalfPlane { point, normal, velocity: Some(velocity) } => {
                named(&["point", "normal", "velocity"], &[*point, *normal, *velocity])
            }
            Self::HalfPlane { point, normal, velocity: None } => named(&["point", "normal"], &[*point, *normal]),
            Self::Segment { from, to } | Self::Cylinder { from, to, .. } | Self::Cone { from, to, .. } => {
                named(&["from", "to"], &[*from, *to])
            }
            Self::Panel { corner, along, across, .. } => {
                named(&["corner", "along", "across"], &[*corner, *along, *across])
            }
            Self::Polygon { points, hole } => {
                let listed = |key: &'static str, points: &[FiniteVector]| {
                    let points = points.to_vec();
                    points.into_iter().enumerate().map(move |(place, point)| (format!("{key}[{place}]"), point))
                };
                listed("points", points).chain(listed("hole", hole)).collect()
            }
            Self::Annulus { centre, normal, .. } => named(&["centre", "normal"], &[*centre, *normal]),
            Self::SphericalZone { centre, axis: Some(axis), .. } => named(&["centre", "axis"], &[*centre, *axis]),
            Self::Mesh { .. } => Vec::new(),
            Self::SphericalZone { centre, axis: None, .. } | Self::Disc { centre, .. } => {
                named(&["centre"], &[*centre])
            }
        }
    }
}
