//! The list of the shapes that a wall surface may have.

use crate::space::{Plane, Space};
use crate::walls::pose::Pose;
use crate::walls::shapes::ball::Ball;
use crate::walls::shapes::half_plane::HalfPlane;
use crate::walls::shapes::panel::Panel;
use crate::walls::shapes::revolved::Revolved;
use crate::walls::shapes::segment::Segment;
use crate::walls::shapes::spherical_zone::SphericalZone;
use crate::walls::shapes::triangle::Triangle;
use crate::walls::shapes::trimmed::Trimmed;
use crate::walls::shapes::{Nearest, Shape};

/// The shape of a wall.
#[derive(Clone, Debug)]
pub enum Surface<V: Space = Plane> {
    /// Solid behind the surface.
    HalfPlane(HalfPlane<V>),
    /// Thin line between two points.
    Segment(Segment<V>),
    /// A thin rectangle of solid space.
    Panel(Panel<V>),
    /// A thin triangle of solid space.
    Triangle(Triangle<V>),
    /// A thin cylinder, cone, frustum or ring of solid space.
    Revolved(Revolved<V>),
    /// A thin part of a sphere, in solid space.
    SphericalZone(SphericalZone<V>),
    /// A disc of the plane or a sphere of solid space, solid inside.
    Ball(Ball<V>),
    /// A panel, cylinder, cone or ring with a hole, or the part of it that fills a hole. Boxed, because it is twice as large as the others.
    Trimmed(Box<Trimmed<V>>),
}

impl<V: Space> Surface<V> {
    /// Returns the shape.
    #[must_use]
    pub fn shape(&self) -> &dyn Shape<V> {
        match self {
            Self::HalfPlane(shape) => shape,
            Self::Segment(shape) => shape,
            Self::Panel(shape) => shape,
            Self::Triangle(shape) => shape,
            Self::Revolved(shape) => shape,
            Self::SphericalZone(shape) => shape,
            Self::Ball(shape) => shape,
            Self::Trimmed(shape) => &**shape,
        }
    }

    /// Returns the surface in a pose.
    #[must_use]
    pub fn placed(&self, pose: &Pose<V>) -> Self {
        match self {
            Self::HalfPlane(shape) => Self::HalfPlane(shape.placed(pose)),
            Self::Segment(shape) => Self::Segment(shape.placed(pose)),
            Self::Panel(shape) => Self::Panel(shape.placed(pose)),
            Self::Triangle(shape) => Self::Triangle(shape.placed(pose)),
            Self::Revolved(shape) => Self::Revolved(shape.placed(pose)),
            Self::SphericalZone(shape) => Self::SphericalZone(shape.placed(pose)),
            Self::Ball(shape) => Self::Ball(shape.placed(pose)),
            Self::Trimmed(shape) => Self::Trimmed(Box::new(shape.placed(pose))),
        }
    }

    /// Returns the position of the surface relative to `x` (m).
    #[inline(always)]
    #[must_use]
    pub fn nearest(&self, x: V) -> Nearest<V> {
        match self {
            Self::HalfPlane(shape) => shape.nearest(x),
            Self::Segment(shape) => shape.nearest(x),
            Self::Panel(shape) => shape.nearest(x),
            Self::Triangle(shape) => shape.nearest(x),
            // Inlined, the rarer shapes would make loops over the others longer and slower.
            _ => self.shape().nearest(x),
        }
    }

    /// Returns the distance of a point from the surface, m; negative inside a solid.
    #[inline]
    #[must_use]
    pub fn distance(&self, x: V) -> f64 {
        self.nearest(x).distance()
    }

    /// Returns the point of the surface that is nearest to `x`, m.
    #[must_use]
    pub fn nearest_point(&self, x: V) -> V {
        x - self.nearest(x).away()
    }

    /// Returns the lowest and the highest coordinates of the surface, m; `None` if it has no ends.
    #[must_use]
    pub fn bounds(&self) -> Option<[V; 2]> {
        self.shape().bounds()
    }

    /// Returns where the straight path passes through the surface, as a share of the path (0 to 1); `None` if it does not,
    /// or if the surface has no area.
    #[inline]
    #[must_use]
    pub fn crossing(&self, from: V, to: V) -> Option<f64> {
        match self {
            Self::HalfPlane(shape) => shape.crossing(from, to),
            _ => self.shape().crossing(from, to),
        }
    }
}
