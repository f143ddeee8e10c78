//! Ball: a disc of the plane, or a sphere of solid space, solid inside.
//!
//! The mean curvature of a sphere of radius R is 1/R. The curve round a disc has the curvature 1/R.

use std::f64::consts::TAU;

use crate::math;
use crate::space::{Dimension, Linear, Plane, Solid, Space};
use crate::walls::drawing::{Detail, Drawing};
use crate::walls::pose::Pose;
use crate::walls::shapes::spherical_zone::SphericalZone;
use crate::walls::shapes::{Nearest, Planar, Shape, roots};

/// A disc or sphere as a wall.
#[derive(Clone, Copy, Debug)]
pub struct Ball<V: Space = Plane> {
    /// Centre, m.
    pub centre: V,
    /// Radius, m.
    pub radius: f64,
}

impl<V: Space> Ball<V> {
    /// Returns `count` points of the circle about the centre in the plane of x and y, m.
    fn circle(&self, count: u32) -> Vec<V> {
        let point = |n: u32| {
            let (sine, cosine) = math::sincos(TAU * f64::from(n) / f64::from(count));
            self.centre + V::narrow(Solid::new(cosine, sine, 0.0)) * self.radius
        };
        (0..count).map(point).collect()
    }
}

impl<V: Space> Shape<V> for Ball<V> {
    #[inline]
    fn nearest(&self, x: V) -> Nearest<V> {
        let from_centre = x - self.centre;
        let distance = from_centre.length();
        let normal = if distance > 0.0 { from_centre / distance } else { V::direction(0) };
        Nearest::OfSolid { normal, distance: distance - self.radius, curvature: 1.0 / self.radius }
    }

    fn bounds(&self) -> Option<[V; 2]> {
        let reach = V::from_components(|_| self.radius);
        Some([self.centre - reach, self.centre + reach])
    }

    /// A path crosses the surface where it leads from outside to inside.
    fn crossing(&self, from: V, to: V) -> Option<f64> {
        let start = from - self.centre;
        let way = to - from;
        let c = start.length_squared() - self.radius * self.radius;
        let half_b = start.dot(way);
        // |start + t way|^2 = R^2, at the smaller root, if the path starts outside and approaches.
        let share = roots(way.length_squared(), half_b, c)[0];
        (c >= 0.0 && half_b < 0.0 && (0.0..=1.0).contains(&share)).then_some(share)
    }

    fn placed(&self, pose: &Pose<V>) -> Self {
        Self { centre: pose.point(self.centre), ..*self }
    }

    fn reference(&self) -> V {
        self.centre
    }

    /// In the plane it is the length of both arcs.
    fn area_between(&self, low: f64, high: f64) -> Option<f64> {
        let [low, high] = [low, high].map(|height| ((height - self.centre.height()) / self.radius).clamp(-1.0, 1.0));
        Some(match V::DIMENSION {
            Dimension::Plane => 2.0 * self.radius * (math::asin(high) - math::asin(low)),
            Dimension::Solid => TAU * self.radius * self.radius * (high - low),
        })
    }

    fn drawing(&self, detail: &Detail) -> Drawing {
        match V::DIMENSION {
            Dimension::Plane => {
                Drawing::closed_line(self.circle(detail.sectors).into_iter().map(Linear::spread).collect())
            }
            Dimension::Solid => {
                let heights = [-self.radius, self.radius];
                SphericalZone::new(self.centre.spread(), Solid::Z, self.radius, heights).drawing(detail)
            }
        }
    }

    fn is_solid(&self) -> bool {
        true
    }

    fn planar(&self) -> Option<Planar<V>> {
        Some(Planar::Ball { centre: self.centre, radius: self.radius })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Vector;

    #[test]
    fn a_ball_is_solid() {
        let ball = Ball { centre: Vector::new(1.0, 2.0), radius: 0.5 };
        let above = Nearest::OfSolid { normal: Vector::Y, distance: 0.25, curvature: 2.0 };
        assert_eq!(ball.nearest(Vector::new(1.0, 2.75)), above);
        let inside = Nearest::OfSolid { normal: -Vector::X, distance: -0.25, curvature: 2.0 };
        assert_eq!(ball.nearest(Vector::new(0.75, 2.0)), inside);
        assert!((ball.nearest(ball.centre).distance() + 0.5).abs() < f64::EPSILON);
        assert_eq!(ball.bounds(), Some([Vector::new(0.5, 1.5), Vector::new(1.5, 2.5)]));
    }

    #[test]
    fn a_path_crosses_a_ball_where_it_enters() {
        let ball = Ball { centre: Solid::new(0.0, 0.0, 1.0), radius: 0.5 };
        let down = |x: f64, from: f64, to: f64| ball.crossing(Solid::new(x, 0.0, from), Solid::new(x, 0.0, to));
        assert_eq!(down(0.0, 2.0, 1.0), Some(0.5));
        assert_eq!(down(0.0, 2.0, 0.0), Some(0.25), "a path through the whole ball");
        assert_eq!(down(0.0, 1.0, 3.0), None, "a path out of the ball");
        assert_eq!(down(0.0, 1.5, 3.0), None, "a path from the surface outwards");
        assert_eq!(down(0.6, 2.0, 0.0), None, "a path beside the ball");
        assert_eq!(down(0.0, 2.0, 1.6), None, "a path that ends before the ball");
    }
}
