//! Shapes of wall surfaces, one file each.
//!
//! A shape knows its nearest point to a centre, its bounds, where a path passes through it, its area between two heights and its
//! drawing. Half-planes and balls are solid. All others are thin: they push grains away on both sides.

pub mod ball;
pub mod half_plane;
pub mod panel;
pub mod prism;
pub(crate) mod revolution;
pub mod revolved;
pub mod segment;
pub mod spherical_zone;
pub mod triangle;
pub mod trimmed;
pub mod whole;
mod zero;

use crate::space::{COINCIDENT, PARTED, Space};
use crate::walls::drawing::{Detail, Drawing};
use crate::walls::pose::Pose;

/// Position of a shape relative to a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Nearest<V> {
    /// The nearest point of a thin shape.
    Point {
        /// Vector from the nearest point to the centre, m. It is never zero: for a centre on the shape it is a very
        /// short vector to one side.
        away: V,
        /// Mean of the two principal curvatures at the nearest point, 1/m: positive if the shape bulges towards the
        /// centre, negative if it is hollow, 0 if it is flat or if the point is on an edge.
        curvature: f64,
        /// Whether the nearest point lies on an edge, where another shape may continue this one.
        at_edge: bool,
    },
    /// Normal and distance of a shape that is solid inside.
    OfSolid {
        /// Unit normal out of the solid.
        normal: V,
        /// Distance from the surface, m; negative inside.
        distance: f64,
        /// Mean curvature at the nearest point, 1/m, as above.
        curvature: f64,
    },
}

impl<V: Space> Nearest<V> {
    /// Returns the nearest point of a flat thin shape. `side` returns the unit vector along which the shape pushes a
    /// centre that lies exactly on it.
    #[inline(always)]
    fn flat(away: V, at_edge: bool, side: impl FnOnce() -> V) -> Self {
        Self::Point { away: parted(away, side), curvature: 0.0, at_edge }
    }

    /// Returns the distance, m; negative inside a solid.
    #[inline]
    #[must_use]
    pub fn distance(&self) -> f64 {
        match self {
            Self::Point { away, .. } => away.length(),
            Self::OfSolid { distance, .. } => *distance,
        }
    }

    /// Returns the vector from the nearest point to the centre, m.
    #[inline]
    #[must_use]
    pub fn away(&self) -> V {
        match *self {
            Self::Point { away, .. } => away,
            Self::OfSolid { normal, distance, .. } => normal * distance,
        }
    }
}

/// Returns `away`, or a very short vector to one side if `away` is zero.
#[inline(always)]
fn parted<V: Space>(away: V, side: impl FnOnce() -> V) -> V {
    if away.length_squared() < COINCIDENT { side() * PARTED } else { away }
}

/// A shape of a wall surface.
pub trait Shape<V: Space> {
    /// Returns the position of the shape relative to `x` (m).
    fn nearest(&self, x: V) -> Nearest<V>;

    /// Returns the lowest and the highest coordinates of the shape, m; `None` if it has no ends.
    fn bounds(&self) -> Option<[V; 2]>;

    /// Returns where the straight path first passes through the shape, as a share of the path (0 to 1); `None` if it does not,
    /// or if the shape has no area.
    fn crossing(&self, from: V, to: V) -> Option<f64>;

    /// Returns the shape in a pose.
    #[must_use]
    fn placed(&self, pose: &Pose<V>) -> Self
    where
        Self: Sized;

    /// Returns a point of the shape, or of its axis, m. It is the reference of torques on a wall of this shape.
    fn reference(&self) -> V;

    /// Returns the area between two heights, m^2, in the plane the length, m; `None` if the shape has no ends.
    fn area_between(&self, low: f64, high: f64) -> Option<f64>;

    /// Returns the drawing.
    fn drawing(&self, detail: &Detail) -> Drawing;

    /// Whether the shape is solid inside.
    fn is_solid(&self) -> bool {
        false
    }

    /// Returns the unit vector of the axis about which the shape may turn in its place.
    fn axis(&self) -> Option<V> {
        None
    }

    /// Whether the shape is a straight extension along an axis of coordinates.
    fn runs_along(&self, _axis: usize) -> bool {
        false
    }

    /// Returns the numbers of a shape that the plane has, too.
    fn planar(&self) -> Option<Planar<V>> {
        None
    }
}

/// A shape of those that the plane has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Planar<V> {
    /// Solid behind a line, or in solid space behind a plane.
    HalfPlane {
        /// A point of the surface, m.
        point: V,
        /// Unit normal into the free half.
        normal: V,
    },
    /// A thin line.
    Segment {
        /// One end, m.
        from: V,
        /// The other end, m.
        to: V,
    },
    /// A disc or sphere, solid inside.
    Ball {
        /// Centre, m.
        centre: V,
        /// Radius, m.
        radius: f64,
    },
}

/// Whether a vector is along an axis of coordinates, to rounding.
fn is_along<V: Space>(edge: V, axis: usize) -> bool {
    edge.axis(axis).abs() >= (1.0 - 1e-12) * edge.length()
}

/// Returns the box around points.
pub(crate) fn box_around<V: Space>(points: &[V]) -> Option<[V; 2]> {
    let join =
        |choose: fn(f64, f64) -> f64| move |a: V, b: V| V::from_components(|axis| choose(a.axis(axis), b.axis(axis)));
    let bound = |choose| points.iter().copied().reduce(join(choose));
    Some([bound(f64::min)?, bound(f64::max)?])
}

/// Returns the point of an edge nearest to a centre, as a share of the edge (0 to 1).
#[inline]
fn foot_share<V: Space>(from_corner: V, edge: V) -> f64 {
    (from_corner.dot(edge) / edge.length_squared()).clamp(0.0, 1.0)
}

/// Whether a share of an edge is one of its ends.
#[inline]
fn is_end(share: f64) -> bool {
    share <= 0.0 || share >= 1.0
}

/// Returns the roots of a t^2 + 2 half_b t + c, ascending. Without roots both are no numbers, and one of them is infinite or no
/// number if a is zero.
fn roots(a: f64, half_b: f64, c: f64) -> [f64; 2] {
    // The form that does not subtract nearly equal numbers.
    let q = -(half_b + (half_b * half_b - a * c).sqrt().copysign(half_b));
    let mut roots = [q / a, c / q];
    roots.sort_unstable_by(f64::total_cmp);
    roots
}

/// Returns the roots of a t^2 + 2 half_b t + c that are shares of a path (0 to 1), ascending.
fn path_shares(a: f64, half_b: f64, c: f64) -> Vec<f64> {
    roots(a, half_b, c).into_iter().filter(|share| (0.0..=1.0).contains(share)).collect()
}
