//! Half-plane; in solid space a half-space. It is solid behind its surface, at any depth.

use crate::space::{Dimension, Plane, Solid, Space};
use crate::walls::drawing::{Detail, Drawing};
use crate::walls::pose::Pose;
use crate::walls::shapes::{Nearest, Planar, Shape};

/// Solid behind a line, or in solid space behind a plane.
#[derive(Clone, Copy, Debug)]
pub struct HalfPlane<V: Space = Plane> {
    /// A point of the surface, m.
    pub point: V,
    /// Unit normal into the free half.
    pub normal: V,
}

impl<V: Space> Shape<V> for HalfPlane<V> {
    #[inline(always)]
    fn nearest(&self, x: V) -> Nearest<V> {
        Nearest::OfSolid { normal: self.normal, distance: (x - self.point).dot(self.normal), curvature: 0.0 }
    }

    fn bounds(&self) -> Option<[V; 2]> {
        None
    }

    /// A path crosses the surface if it leads from the free half into the solid one.
    #[inline]
    fn crossing(&self, from: V, to: V) -> Option<f64> {
        let [before, after] = [from, to].map(|x| (x - self.point).dot(self.normal));
        (before >= 0.0 && after < 0.0).then(|| before / (before - after))
    }

    fn placed(&self, pose: &Pose<V>) -> Self {
        Self { point: pose.point(self.point), normal: pose.direction(self.normal) }
    }

    fn reference(&self) -> V {
        self.point
    }

    fn area_between(&self, _: f64, _: f64) -> Option<f64> {
        None
    }

    fn drawing(&self, &Detail { domain, .. }: &Detail) -> Drawing {
        let point = self.point.spread();
        let normal = self.normal.spread();
        let middle = 0.5 * (domain[0] + domain[1]);
        let foot = middle - (middle - point).dot(normal) * normal;
        let reach = (0.5 * (domain[1] - domain[0]).length()).max(f64::MIN_POSITIVE);
        match V::DIMENSION {
            Dimension::Plane => {
                let along = reach * Solid::new(-normal.y, normal.x, 0.0);
                Drawing::line([foot - along, foot + along])
            }
            Dimension::Solid => {
                let along = reach * normal.any_orthonormal_vector();
                let across = normal.cross(along);
                let corners = [-along - across, along - across, along + across, across - along];
                Drawing::quadrangle(corners.map(|corner| foot + corner))
            }
        }
    }

    fn is_solid(&self) -> bool {
        true
    }

    fn planar(&self) -> Option<Planar<V>> {
        Some(Planar::HalfPlane { point: self.point, normal: self.normal })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Vector;

    #[test]
    fn a_half_plane_measures_depth() {
        let wall = HalfPlane { point: Vector::new(0.0, 1.0), normal: Vector::Y };
        let nearest = Nearest::OfSolid { normal: Vector::Y, distance: -0.75, curvature: 0.0 };
        assert_eq!(wall.nearest(Vector::new(7.0, 0.25)), nearest);
        assert_eq!(wall.crossing(Vector::new(0.0, 2.0), Vector::new(3.0, 0.0)), Some(0.5));
        assert_eq!(wall.crossing(Vector::new(0.0, 0.0), Vector::new(0.0, 2.0)), None);
    }
}
