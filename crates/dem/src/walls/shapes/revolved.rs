//! Surface of revolution of a straight line: cylinder, cone, frustum, annulus and circular plate.
//!
//! A point has the coordinates (r, z): its distance from the axis, and its height along it. The surface has the line
//! from (r_0, z_0) to (r_1, z_1) in every half-plane that the axis bounds. The nearest point lies in the half-plane of
//! the centre, so it follows from the nearest point of a segment in the plane (r, z).
//!
//! Curvature: along the line it is 0, around the axis it is n_r/r, with n_r the radial component of the normal. [`Nearest`]
//! has the mean of both, as LAMMPS has it for its cylinder (a wall radius of 2 R).
//!
//! Limit: a grain wider than the tube that it blocks touches it all round. Here it has one contact, at one point.

use std::f64::consts::PI;

use crate::math;
use crate::space::{Plane, Space};
use crate::walls::area::strips_area;
use crate::walls::drawing::{Detail, Drawing};
use crate::walls::pose::Pose;
use crate::walls::shapes::revolution::Axis;
use crate::walls::shapes::{Nearest, Shape, is_along, is_end, parted, path_shares, roots};

/// A thin surface of revolution in solid space.
#[derive(Clone, Copy, Debug)]
pub struct Revolved<V: Space = Plane> {
    /// A point of the axis, at z = 0, m.
    pub base: V,
    /// Unit vector of the axis.
    pub axis: V,
    /// One end of the line, (r_0, z_0), m.
    pub from: [f64; 2],
    /// The other end, (r_1, z_1), m.
    pub to: [f64; 2],
}

/// A place where a line leaves a surface.
pub(super) struct Exit<V> {
    /// The place, m.
    pub point: V,
    /// An outward normal there, of any length.
    pub normal: V,
}

impl<V: Space> Revolved<V> {
    /// Returns the frustum between two points of its axis, with a radius at each (m): a cylinder if they are equal.
    #[must_use]
    pub fn between(from: V, to: V, radii: [f64; 2]) -> Self {
        let length = (to - from).length();
        Self { base: from, axis: (to - from) / length, from: [radii[0], 0.0], to: [radii[1], length] }
    }

    /// Returns the flat ring between two radii (m); a circular plate if the inner one is zero.
    #[must_use]
    pub fn ring(centre: V, normal: V, radii: [f64; 2]) -> Self {
        Self { base: centre, axis: normal.unit_or_zero(), from: [radii[0], 0.0], to: [radii[1], 0.0] }
    }

    /// Returns height and radial vector of a point.
    #[inline]
    fn coordinates(&self, x: V) -> (f64, V) {
        let from_base = x - self.base;
        let z = from_base.dot(self.axis);
        (z, from_base - self.axis * z)
    }

    /// Returns the unit vector in the half-plane of the line, at right angles to it, as (r, z).
    fn line_normal(&self) -> [f64; 2] {
        let [dr, dz] = [self.to[0] - self.from[0], self.to[1] - self.from[1]];
        let length = math::hypot(dr, dz);
        [dz / length, -dr / length]
    }

    /// Returns one of `around` flat pieces about the axis, by its number.
    pub(super) fn facet(&self, number: u32, around: u32) -> [V; 4] {
        let ends = |number| self.line_axis().turned([self.from, self.to], number, around);
        let [a, d] = ends(number);
        let [b, c] = ends(number + 1);
        [a, b, c, d]
    }

    fn line_axis(&self) -> Axis<V> {
        Axis { base: self.base, direction: self.axis }
    }

    /// Whether the surface is a flat ring. For a line as flat as this, the slope of a cone would be lost in rounding.
    fn is_flat(&self) -> bool {
        (self.to[1] - self.from[1]).abs() <= 1e-12 * (self.to[0] - self.from[0]).abs()
    }

    /// Returns the unit normal of the surface in the half-plane of a point, away from the axis; of a flat ring, to one side. For a
    /// point on the axis, which is in no half-plane, it is the part along the axis.
    pub(super) fn outwards(&self, x: V) -> V {
        let [normal_r, normal_z] = self.line_normal();
        let (_, radial) = self.coordinates(x);
        let is_on_the_axis = radial.length() <= 1e-9 * self.from[0].max(self.to[0]);
        let aside = if is_on_the_axis { V::ZERO } else { radial.unit_or_zero() };
        (aside * normal_r + self.axis * normal_z) * 1f64.copysign(normal_r)
    }

    /// Returns where a line through `x` along a vector leaves the surface without its ends.
    pub(super) fn exit(&self, x: V, along: V) -> Option<Exit<V>> {
        let (z, _) = self.coordinates(x);
        if self.is_flat() {
            let way = (self.from[1] - z) / along.dot(self.axis);
            return way.is_finite().then(|| Exit { point: x + along * way, normal: self.axis * along.dot(self.axis) });
        }
        let [a, half_b, c] = self.cone_terms(x, along);
        let slope = self.slope();
        roots(a, half_b, c).into_iter().find_map(|way| {
            let point = x + along * way;
            let (z, radial) = self.coordinates(point);
            let width = self.from[0] + slope * (z - self.from[1]);
            // The quadratic form is negative inside the cone and its mirror image, where the width is negative.
            let leads_out = way.is_finite() && a * way + half_b > 0.0 && width >= 0.0;
            leads_out.then(|| Exit { point, normal: radial - self.axis * (slope * width) })
        })
    }

    /// Returns dr/dz of the line.
    fn slope(&self) -> f64 {
        (self.to[0] - self.from[0]) / (self.to[1] - self.from[1])
    }

    /// Returns a, b/2 and c of a t^2 + b t + c, which is zero where the line `x` + t `along` meets the cone of the surface.
    fn cone_terms(&self, x: V, along: V) -> [f64; 3] {
        let slope = self.slope();
        let (height, radial) = self.coordinates(x);
        let climb = along.dot(self.axis);
        let way = along - self.axis * climb;
        // |radial + t way|^2 = (width + t growth)^2
        let width = self.from[0] + slope * (height - self.from[1]);
        let growth = slope * climb;
        let a = way.length_squared() - growth * growth;
        let half_b = radial.dot(way) - width * growth;
        let c = radial.length_squared() - width * width;
        [a, half_b, c]
    }
}

impl<V: Space> Shape<V> for Revolved<V> {
    #[inline]
    fn nearest(&self, x: V) -> Nearest<V> {
        let (z, radial) = self.coordinates(x);
        let r = radial.length();
        let [dr, dz] = [self.to[0] - self.from[0], self.to[1] - self.from[1]];
        let share = ((r - self.from[0]) * dr + (z - self.from[1]) * dz) / (dr * dr + dz * dz);
        let share = share.clamp(0.0, 1.0);
        let [foot_r, foot_z] = [self.from[0] + share * dr, self.from[1] + share * dz];
        let outwards = if r > 0.0 { radial / r } else { self.axis.any_perpendicular() };
        let away = outwards * (r - foot_r) + self.axis * (z - foot_z);
        let at_edge = is_end(share);
        let curvature =
            if at_edge || dz == 0.0 { 0.0 } else { (0.5 * self.line_normal()[0].abs() / foot_r).copysign(r - foot_r) };
        let side = || {
            let [normal_r, normal_z] = self.line_normal();
            outwards * normal_r + self.axis * normal_z
        };
        Nearest::Point { away: parted(away, side), curvature, at_edge }
    }

    fn bounds(&self) -> Option<[V; 2]> {
        let ends = [self.from, self.to].map(|[r, z]| (self.base + self.axis * z, r));
        let bound = |sign: f64, choose: fn(f64, f64) -> f64| {
            V::from_components(|axis| {
                let reach = (1.0 - self.axis.axis(axis).powi(2)).max(0.0).sqrt();
                let [a, b] = ends.map(|(centre, r)| centre.axis(axis) + sign * r * reach);
                choose(a, b)
            })
        };
        Some([bound(-1.0, f64::min), bound(1.0, f64::max)])
    }

    fn placed(&self, pose: &Pose<V>) -> Self {
        Self { base: pose.point(self.base), axis: pose.direction(self.axis), ..*self }
    }

    fn crossing(&self, from: V, to: V) -> Option<f64> {
        let [(r_0, z_0), (r_1, z_1)] = [self.from, self.to].map(|[r, z]| (r, z));
        if self.is_flat() {
            let (z, radial) = self.coordinates(from);
            let (z_end, radial_end) = self.coordinates(to);
            let before = z - z_0;
            let after = z_end - z_0;
            if (before < 0.0) == (after < 0.0) {
                return None;
            }
            let share = before / (before - after);
            let r = (radial + (radial_end - radial) * share).length();
            return (r_0.min(r_1)..=r_0.max(r_1)).contains(&r).then_some(share);
        }
        let is_within = |share: &f64| {
            let (z, _) = self.coordinates(from + (to - from) * *share);
            (z_0.min(z_1)..=z_0.max(z_1)).contains(&z)
        };
        let [a, half_b, c] = self.cone_terms(from, to - from);
        path_shares(a, half_b, c).into_iter().find(is_within)
    }

    fn reference(&self) -> V {
        self.base
    }

    fn area_between(&self, low: f64, high: f64) -> Option<f64> {
        let [[r_0, z_0], [r_1, z_1]] = [self.from, self.to];
        let upwards = self.axis.height();
        if (upwards.abs() - 1.0).abs() >= 1e-12 {
            return Some(strips_area(&self.line_axis(), &[self.from, self.to], low, high));
        }
        let length = math::hypot(r_1 - r_0, z_1 - z_0);
        let height = |z: f64| self.base.height() + upwards * z;
        let from = height(z_0);
        let to = height(z_1);
        if from.min(to) >= from.max(to) {
            let is_inside = (low..high).contains(&from);
            return Some(if is_inside { PI * (r_0 + r_1) * length } else { 0.0 });
        }
        let share_at = |height: f64| ((height - from) / (to - from)).clamp(0.0, 1.0);
        let a = share_at(low);
        let b = share_at(high);
        let radius = |share: f64| r_0 + share * (r_1 - r_0);
        Some(PI * (radius(a) + radius(b)) * length * (b - a).abs())
    }

    fn drawing(&self, &Detail { sectors, .. }: &Detail) -> Drawing {
        Drawing::revolved(self.base.spread(), self.axis.spread(), &[self.from, self.to], sectors)
    }

    fn axis(&self) -> Option<V> {
        Some(self.axis)
    }

    /// A cone differs from place to place along its axis.
    fn runs_along(&self, axis: usize) -> bool {
        (self.from[0] - self.to[0]).abs() <= 0.0 && is_along(self.axis, axis)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use proptest::prelude::*;

    use super::*;
    use crate::space::Solid;

    /// A surface from a few numbers, and the points of a fine grid on it.
    fn surface(ends: [f64; 4], axis: (f64, f64, f64)) -> (Revolved<Solid>, Vec<Solid>) {
        let axis = Solid::new(axis.0, axis.1, axis.2).normalize();
        let [r_0, z_0, r_1, z_1] = ends;
        let surface = Revolved { base: Solid::new(0.3, -0.2, 0.1), axis, from: [r_0, z_0], to: [r_1, z_1] };
        let first = axis.any_orthonormal_vector();
        let second = axis.cross(axis.any_orthonormal_vector());
        let mut points = Vec::new();
        for step in 0..=200 {
            let share = f64::from(step) / 200.0;
            let r = r_0 + share * (r_1 - r_0);
            let z = z_0 + share * (z_1 - z_0);
            for turn in 0..200 {
                let angle = 2.0 * PI * f64::from(turn) / 200.0;
                points.push(surface.base + axis * z + r * (first * angle.cos() + second * angle.sin()));
            }
        }
        (surface, points)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// The grid points lie at most half a cell from any point of the surface.
        #[test]
        fn the_nearest_point_is_nearest_and_on_the_surface(
            ends in (0.0..1.0, -0.5..0.5, 0.05..1.0, -0.5..0.5),
            axis in (-1.0..1.0, -1.0..1.0, 0.1..1.0),
            x in (-2.0..2.0, -2.0..2.0, -2.0..2.0),
        ) {
            let (r_0, z_0, r_1, z_1): (f64, f64, f64, f64) = ends;
            prop_assume!((r_1 - r_0).hypot(z_1 - z_0) > 0.05);
            let (surface, points) = surface([r_0, z_0, r_1, z_1], axis);
            let x = Solid::new(x.0, x.1, x.2);
            let nearest = surface.nearest(x);
            let by_points = points.iter().map(|point| point.distance(x)).fold(f64::INFINITY, f64::min);
            let cell = 0.5 * (r_1 - r_0).hypot(z_1 - z_0) / 200.0 + PI * r_0.max(r_1) / 200.0;
            prop_assert!(nearest.distance() <= by_points + 1e-12 && by_points <= nearest.distance() + cell);
            let Nearest::Point { away, .. } = nearest else { panic!("a thin surface") };
            prop_assert!(surface.nearest(x - away).distance() < 1e-12);
        }

        /// The signed distance from the surface changes its sign where the path crosses, and nowhere else.
        #[test]
        fn a_path_crosses_where_it_meets_the_surface(
            radii in (0.1..1.0, 0.1..1.0), length in 0.2..1.0,
            from in (-1.0..1.0, -1.0..1.0, -1.0..1.0), way in (-0.2..0.2, -0.2..0.2, -0.2..0.2),
        ) {
            let surface = Revolved::between(Solid::ZERO, Solid::new(0.0, 0.0, length), [radii.0, radii.1]);
            let from = Solid::new(from.0, from.1, from.2);
            let to = from + Solid::new(way.0, way.1, way.2);
            let outside = |x: Solid| x.truncate().length() - (radii.0 + (radii.1 - radii.0) * x.z / length);
            match surface.crossing(from, to) {
                Some(share) => prop_assert!(surface.nearest(from + (to - from) * share).distance() < 1e-9),
                None if (0.0..length).contains(&from.z) && (0.0..length).contains(&to.z) => {
                    prop_assert!(outside(from) * outside(to) > -1e-12);
                }
                None => {}
            }
        }
    }

    #[test]
    fn curvature_has_the_sign_and_size_of_the_textbook() {
        let curvature = |surface: &Revolved<Solid>, x: Solid| match surface.nearest(x) {
            Nearest::Point { curvature, .. } => curvature,
            Nearest::OfSolid { .. } => panic!("a thin surface"),
        };
        let cylinder = Revolved::between(Solid::ZERO, Solid::Z, [0.5, 0.5]);
        assert!((curvature(&cylinder, Solid::new(0.4, 0.0, 0.5)) + 1.0).abs() < 1e-12);
        assert!((curvature(&cylinder, Solid::new(0.0, 0.6, 0.5)) - 1.0).abs() < 1e-12);
        // At a slope of 45 degrees: n_r/r = 1/sqrt(2)/0.5.
        let cone = Revolved::between(Solid::ZERO, Solid::Z, [0.0, 1.0]);
        let inside = Solid::new(0.5, 0.0, 0.5) + 0.1 * Solid::new(-1.0, 0.0, 1.0);
        assert!((curvature(&cone, inside) + 0.5f64.sqrt()).abs() < 1e-12);
        let ring = Revolved::ring(Solid::ZERO, Solid::Z, [0.2, 1.0]);
        assert!(curvature(&ring, Solid::new(0.5, 0.1, 0.3)).abs() < 1e-12);
    }

    #[test]
    fn points_of_a_slanted_axis_are_a_radius_away() {
        for axis in [Solid::Z, Solid::new(0.6, 0.0, 0.8), Solid::new(0.48, 0.6, 0.64)] {
            let cylinder = Revolved::between(Solid::ZERO, axis, [0.5, 0.5]);
            assert!((cylinder.nearest(axis * 0.5).distance() - 0.5).abs() < 1e-15);
        }
    }

    #[test]
    fn a_ring_lets_paths_through_its_hole() {
        let ring = Revolved::ring(Solid::ZERO, Solid::Z, [0.2, 1.0]);
        let down = |x: f64| ring.crossing(Solid::new(x, 0.0, 0.1), Solid::new(x, 0.0, -0.1));
        assert_eq!((down(0.1), down(0.5), down(1.5)), (None, Some(0.5), None));
    }

    #[test]
    fn bounds_hold_all_points_and_touch_some() {
        let (surface, points) = surface([0.3, -0.4, 0.8, 0.2], (0.3, -0.5, 0.8));
        let [low, high] = surface.bounds().unwrap();
        let [least, most] = [Solid::min, Solid::max].map(|join| points.iter().copied().reduce(join).unwrap());
        assert!((low - least).abs().max_element() < 1e-3 && (high - most).abs().max_element() < 1e-3);
    }
}
