//! The surfaces that a hole may have: a panel, or a surface of revolution.

use crate::space::{Plane, Space};
use crate::walls::pose::Pose;
use crate::walls::shapes::panel::Panel;
use crate::walls::shapes::revolved::{Exit, Revolved};
use crate::walls::shapes::{Nearest, Shape};

/// A surface that a prism may cut.
#[derive(Clone, Copy, Debug)]
pub enum Whole<V: Space = Plane> {
    /// A rectangle.
    Panel(Panel<V>),
    /// A cylinder, cone, frustum or ring.
    Revolved(Revolved<V>),
}

impl<V: Space> Whole<V> {
    /// Returns the shape.
    pub(super) fn shape(&self) -> &dyn Shape<V> {
        match self {
            Self::Panel(shape) => shape,
            Self::Revolved(shape) => shape,
        }
    }

    /// Returns the unit normal of the surface beside a point: away from the axis, or of a flat surface to one side. For a point on
    /// the axis it is the part along the axis.
    pub(in crate::walls) fn outwards(&self, x: V) -> V {
        match self {
            Self::Panel(panel) => panel.normal(),
            Self::Revolved(shape) => shape.outwards(x),
        }
    }

    /// Returns the point of the surface that is nearest to `x`, m, and whether it is on an edge.
    pub(super) fn foot(&self, x: V) -> (V, bool) {
        match self.shape().nearest(x) {
            Nearest::Point { away, at_edge, .. } => (x - away, at_edge),
            Nearest::OfSolid { normal, distance, .. } => (x - normal * distance, false),
        }
    }

    /// Returns where a line through `x` along a vector leaves the surface.
    pub(super) fn exit(&self, x: V, along: V) -> Option<Exit<V>> {
        match self {
            Self::Panel(panel) => {
                let normal = panel.normal();
                let way = (panel.corner - x).dot(normal) / along.dot(normal);
                way.is_finite().then(|| Exit { point: x + along * way, normal })
            }
            Self::Revolved(shape) => shape.exit(x, along),
        }
    }

    /// Returns the largest distance from an axis, m; 0 of a panel.
    pub(super) fn largest_radius(&self) -> f64 {
        match self {
            Self::Panel(_) => 0.0,
            Self::Revolved(shape) => shape.from[0].max(shape.to[0]),
        }
    }

    /// Returns flat pieces of the surface, with `around` of them about an axis.
    pub(super) fn facets(&self, around: u32) -> Vec<[V; 4]> {
        match self {
            Self::Panel(panel) => vec![panel.corners()],
            Self::Revolved(shape) => (0..around).map(|n| shape.facet(n, around)).collect(),
        }
    }

    /// Returns the surface in a pose.
    pub(super) fn placed(&self, pose: &Pose<V>) -> Self {
        match self {
            Self::Panel(shape) => Self::Panel(shape.placed(pose)),
            Self::Revolved(shape) => Self::Revolved(shape.placed(pose)),
        }
    }
}
