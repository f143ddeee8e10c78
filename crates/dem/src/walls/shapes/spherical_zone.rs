//! Spherical zone: the part of a thin sphere between two heights along an axis, such as a hemispherical bottom with an orifice, a
//! dome, or a whole hollow sphere.
//!
//! The nearest point of the sphere to x lies on the line from the centre through x. If its height is not between the two
//! heights, the nearest point of the zone is on the edge at the nearer height. Both principal curvatures of a sphere of radius
//! R are 1/R.
//!
//! Limit: a grain that blocks the sphere or an orifice touches it all round. Here it has one contact, at one point.

use std::f64::consts::{PI, TAU};

use crate::math;
use crate::space::{Plane, Space};
use crate::walls::area::strips_area;
use crate::walls::drawing::{Detail, Drawing};
use crate::walls::pose::Pose;
use crate::walls::shapes::revolution::Axis;
use crate::walls::shapes::{Nearest, Shape, parted, path_shares};

/// Number of pieces from pole to pole of a sphere whose area is measured.
const PIECES: u32 = 180;

/// A thin spherical zone in solid space.
#[derive(Clone, Copy, Debug)]
pub struct SphericalZone<V: Space = Plane> {
    /// Centre of the sphere, m.
    pub centre: V,
    /// Unit vector of the axis.
    pub axis: V,
    /// Radius of the sphere, m.
    pub radius: f64,
    /// The heights of the edges along the axis from the centre, m, ascending; infinite where the zone has no edge.
    pub heights: [f64; 2],
}

impl<V: Space> SphericalZone<V> {
    /// Returns the zone between two heights along the axis from the centre (m, ascending). The zone has no edge at a height of a radius or
    /// more.
    #[must_use]
    pub fn new(centre: V, axis: V, radius: f64, [low, high]: [f64; 2]) -> Self {
        let heights =
            [if low <= -radius { f64::NEG_INFINITY } else { low }, if high >= radius { f64::INFINITY } else { high }];
        Self { centre, axis: axis.unit_or_zero(), radius, heights }
    }

    /// Returns the heights of the ends of the zone, m.
    fn ends(&self) -> [f64; 2] {
        self.heights.map(|height| height.clamp(-self.radius, self.radius))
    }

    /// Returns the radius of the circle at a height, m.
    fn circle(&self, height: f64) -> f64 {
        ((self.radius - height) * (self.radius + height)).max(0.0).sqrt()
    }

    /// Returns points (r, z) of the section on one side of the axis, from the low end to the high one: `lines` pieces for a whole sphere.
    fn profile(&self, lines: u32) -> Vec<[f64; 2]> {
        let [low, high] = self.ends().map(|height| math::atan2(height, self.circle(height)));
        let share = (high - low) / PI;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 1 and the number of lines"
        )]
        let count = (f64::from(lines) * share).ceil().max(1.0) as u32;
        let point = |n: u32| {
            let (sine, cosine) = math::sincos(low + (high - low) * f64::from(n) / f64::from(count));
            [self.radius * cosine.max(0.0), self.radius * sine]
        };
        let mut points: Vec<_> = (0..=count).map(point).collect();
        // Without rounding, so that a pole is on the axis.
        let [first, last] = self.ends().map(|height| [self.circle(height), height]);
        (points[0], points[count as usize]) = (first, last);
        points
    }

    fn has_height(&self, height: f64) -> bool {
        (self.heights[0]..=self.heights[1]).contains(&height)
    }
}

impl<V: Space> Shape<V> for SphericalZone<V> {
    #[inline]
    fn nearest(&self, x: V) -> Nearest<V> {
        let from_centre = x - self.centre;
        let z = from_centre.dot(self.axis);
        let distance = from_centre.length();
        let outwards = if distance > 0.0 { from_centre / distance } else { self.axis.any_perpendicular() };
        let foot = if distance > 0.0 { z * (self.radius / distance) } else { 0.0 };
        if self.has_height(foot) {
            let beyond = distance - self.radius;
            let away = parted(outwards * beyond, || outwards);
            return Nearest::Point { away, curvature: (1.0 / self.radius).copysign(beyond), at_edge: false };
        }
        let edge = foot.clamp(self.heights[0], self.heights[1]);
        let radial = from_centre - self.axis * z;
        let r = radial.length();
        let aside = if r > 0.0 { radial / r } else { self.axis.any_perpendicular() };
        let away = aside * (r - self.circle(edge)) + self.axis * (z - edge);
        Nearest::Point { away: parted(away, || outwards), curvature: 0.0, at_edge: true }
    }

    fn bounds(&self) -> Option<[V; 2]> {
        let [low, high] = self.ends();
        // The point of the sphere that is farthest along a direction, or the farthest of both edges.
        let reach = |along: f64| {
            if self.has_height(self.radius * along) {
                return self.radius;
            }
            let aside = (1.0 - along * along).max(0.0).sqrt();
            [low, high].map(|height| height * along + self.circle(height) * aside).into_iter().fold(f64::MIN, f64::max)
        };
        let bound =
            |sign: f64| V::from_components(|axis| self.centre.axis(axis) + sign * reach(sign * self.axis.axis(axis)));
        Some([bound(-1.0), bound(1.0)])
    }

    fn placed(&self, pose: &Pose<V>) -> Self {
        Self { centre: pose.point(self.centre), axis: pose.direction(self.axis), ..*self }
    }

    fn crossing(&self, from: V, to: V) -> Option<f64> {
        let start = from - self.centre;
        let way = to - from;
        // |start + t way|^2 = R^2
        let c = start.length_squared() - self.radius * self.radius;
        let shares = path_shares(way.length_squared(), start.dot(way), c);
        shares.into_iter().find(|share| self.has_height((start + way * *share).dot(self.axis)))
    }

    fn reference(&self) -> V {
        self.centre
    }

    fn area_between(&self, low: f64, high: f64) -> Option<f64> {
        let upwards = self.axis.height();
        if (upwards.abs() - 1.0).abs() < 1e-12 {
            let [from, to] = self.ends().map(|height| self.centre.height() + upwards * height);
            let within = from.max(to).min(high) - from.min(to).max(low);
            return Some(TAU * self.radius * within.max(0.0));
        }
        let axis = Axis { base: self.centre, direction: self.axis };
        Some(strips_area(&axis, &self.profile(PIECES), low, high))
    }

    fn drawing(&self, &Detail { sectors, .. }: &Detail) -> Drawing {
        Drawing::revolved(self.centre.spread(), self.axis.spread(), &self.profile(sectors / 2), sectors)
    }

    fn axis(&self) -> Option<V> {
        Some(self.axis)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use proptest::prelude::*;

    use super::*;
    use crate::space::Solid;

    /// A zone from a few numbers, and the points of a fine grid on it.
    fn zone(radius: f64, heights: [f64; 2], axis: (f64, f64, f64)) -> (SphericalZone<Solid>, Vec<Solid>) {
        let axis = Solid::new(axis.0, axis.1, axis.2).normalize();
        let zone = SphericalZone::new(Solid::new(0.3, -0.2, 0.1), axis, radius, heights.map(|height| height * radius));
        let first = axis.any_orthonormal_vector();
        let second = axis.cross(axis.any_orthonormal_vector());
        let [low, high] = heights.map(f64::asin);
        let mut points = Vec::new();
        for step in 0..=200 {
            let (sine, cosine) = (low + (high - low) * f64::from(step) / 200.0).sin_cos();
            for turn in 0..200 {
                let angle = TAU * f64::from(turn) / 200.0;
                points
                    .push(zone.centre + radius * (axis * sine + cosine * (first * angle.cos() + second * angle.sin())));
            }
        }
        (zone, points)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// The grid points lie at most half a cell from any point of the zone.
        #[test]
        fn the_nearest_point_is_nearest_and_on_the_zone(
            radius in 0.1..1.0, heights in (-1.0..0.9, 0.05..2.0),
            axis in (-1.0..1.0, -1.0..1.0, 0.1..1.0), x in (-2.0..2.0, -2.0..2.0, -2.0..2.0),
        ) {
            let (radius, heights): (f64, (f64, f64)) = (radius, heights);
            let (zone, points) = zone(radius, [heights.0, (heights.0 + heights.1).min(1.0)], axis);
            let x = Solid::new(x.0, x.1, x.2);
            let nearest = zone.nearest(x);
            let by_points = points.iter().map(|point| point.distance(x)).fold(f64::INFINITY, f64::min);
            let cell = radius * TAU / 200.0;
            prop_assert!(nearest.distance() <= by_points + 1e-12 && by_points <= nearest.distance() + cell);
            let Nearest::Point { away, .. } = nearest else { panic!("a thin surface") };
            prop_assert!(zone.nearest(x - away).distance() < 1e-12);
        }

        /// A path from inside the sphere to its outside crosses the sphere once, and its zone if the point is at its heights.
        #[test]
        fn a_path_crosses_where_it_meets_the_zone(
            from in (-0.5..0.5, -0.5..0.5, -0.5..0.5), to in (-2.0..2.0, -2.0..2.0, 1.1..2.0), low in -0.9..0.8,
        ) {
            let whole = SphericalZone::new(Solid::ZERO, Solid::Z, 1.0, [-1.0, 1.0]);
            let zone = SphericalZone::new(Solid::ZERO, Solid::Z, 1.0, [low, low + 0.1]);
            let from = Solid::new(from.0, from.1, from.2);
            let to = Solid::new(to.0, to.1, to.2);
            let share = whole.crossing(from, to).unwrap();
            let point = from + (to - from) * share;
            prop_assert!((point.length() - 1.0).abs() < 1e-12);
            prop_assert_eq!(zone.crossing(from, to), (low..=low + 0.1).contains(&point.z).then_some(share));
            prop_assert_eq!(whole.crossing(to, to * 1.1), None);
        }
    }

    #[test]
    fn curvature_is_one_over_the_radius_and_zero_at_an_edge() {
        let bowl = SphericalZone::new(Solid::ZERO, Solid::Z, 0.5, [-0.4, 0.0]);
        let at = |x, z| match bowl.nearest(Solid::new(x, 0.0, z)) {
            Nearest::Point { curvature, at_edge, .. } => (curvature, at_edge),
            Nearest::OfSolid { .. } => panic!("a thin surface"),
        };
        assert_eq!(at(0.3, -0.3), (-2.0, false));
        assert_eq!(at(0.4, -0.4), (2.0, false));
        // Above the rim, and over the orifice of radius 0.3.
        assert_eq!((at(0.5, 0.1), at(0.1, -0.4)), ((0.0, true), (0.0, true)));
        let over_the_orifice = bowl.nearest(Solid::new(0.0, 0.0, -0.4));
        assert!((over_the_orifice.distance() - 0.3).abs() < 1e-15);
    }

    #[test]
    fn the_centre_and_the_poles_of_a_whole_sphere_have_a_nearest_point_off_any_edge() {
        let sphere = SphericalZone::new(Solid::ZERO, Solid::new(0.1, 0.7, 0.3), 0.1, [-0.1, 0.1]);
        for x in [Solid::ZERO, sphere.axis * 0.1, sphere.axis * -0.1, sphere.axis * 0.099] {
            let Nearest::Point { away, at_edge, .. } = sphere.nearest(x) else { panic!("a thin surface") };
            assert!(!at_edge && ((x - away).length() - 0.1).abs() < 1e-15);
        }
    }

    #[test]
    fn bounds_hold_all_points_and_touch_some() {
        for heights in [[-1.0, 1.0], [-0.9, 0.0], [0.2, 0.6]] {
            let (zone, points) = zone(0.7, heights, (0.3, -0.5, 0.8));
            let [low, high] = zone.bounds().unwrap();
            let [least, most] = [Solid::min, Solid::max].map(|join| points.iter().copied().reduce(join).unwrap());
            assert!((low - least).abs().max_element() < 1e-3 && (high - most).abs().max_element() < 1e-3);
            assert!((least - low).min_element() > -1e-12 && (high - most).min_element() > -1e-12);
        }
    }
}
