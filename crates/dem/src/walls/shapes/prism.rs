//! Prism: a circle or a rectangle, extruded without end along its normal. It bounds a hole in a wall, or a part of a wall.

use std::f64::consts::TAU;

use crate::math;
use crate::space::{Plane, Space};
use crate::walls::pose::Pose;

/// A circular or rectangular prism of solid space.
#[derive(Clone, Copy, Debug)]
pub struct Prism<V: Space = Plane> {
    is_round: bool,
    /// Centre of the circle or rectangle, m.
    pub centre: V,
    /// Vector from the centre to the middle of a side; of a circle, a radius, m.
    along: V,
    /// The other such vector, at right angles, m.
    across: V,
    /// Unit vector along which the circle or rectangle is extruded.
    pub direction: V,
}

/// A point of a curve.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurvePoint<V: Space> {
    /// The point, m.
    pub point: V,
    /// Its derivative with respect to the share of the side that lies before it, m.
    pub slope: V,
}

/// A flat side of a prism.
pub(super) struct FlatSide<V> {
    /// The corner from which the side starts, m.
    pub corner: V,
    /// Vector to the outside, of any length.
    pub outwards: V,
}

impl<V: Space> Prism<V> {
    /// Returns the prism of a circle.
    #[must_use]
    pub fn circle(centre: V, normal: V, radius: f64) -> Self {
        let direction = normal.unit_or_zero();
        let along = direction.any_perpendicular();
        let across = V::narrow(direction.spread().cross(along.spread()));
        Self { is_round: true, centre, along: along * radius, across: across * radius, direction }
    }

    /// Returns the prism of a rectangle with these edge vectors, which are at right angles, m.
    #[must_use]
    pub fn rectangle(centre: V, along: V, across: V) -> Self {
        let direction = V::narrow(along.spread().cross(across.spread())).unit_or_zero();
        Self { is_round: false, centre, along: along * 0.5, across: across * 0.5, direction }
    }

    /// Returns the same prism with the opposite direction.
    pub(super) fn reversed(self) -> Self {
        Self { direction: -self.direction, ..self }
    }

    /// Returns the prism in a pose.
    pub(super) fn placed(&self, pose: &Pose<V>) -> Self {
        Self {
            centre: pose.point(self.centre),
            along: pose.direction(self.along),
            across: pose.direction(self.across),
            direction: pose.direction(self.direction),
            ..*self
        }
    }

    /// Returns a vector in units of `along` and `across`.
    fn in_units(&self, v: V) -> [f64; 2] {
        [self.along, self.across].map(|unit| v.dot(unit) / unit.length_squared())
    }

    /// Returns the longer one of the vectors from the centre to the middle of a side, as a length, m.
    pub(super) fn reach(&self) -> f64 {
        self.along.length().max(self.across.length())
    }

    /// Whether a point is inside the prism.
    pub(super) fn contains(&self, x: V) -> bool {
        let [a, b] = self.in_units(x - self.centre);
        if self.is_round { a * a + b * b < 1.0 } else { a.abs() < 1.0 && b.abs() < 1.0 }
    }

    /// Number of smooth lines that bound the circle or rectangle.
    pub(super) fn sides(&self) -> u32 {
        if self.is_round { 1 } else { 4 }
    }

    /// Returns the point at this share (0 to 1) of a side.
    pub(super) fn on_side(&self, side: u32, share: f64) -> CurvePoint<V> {
        let Self { centre, along, across, .. } = *self;
        if self.is_round {
            let (y, x) = math::sincos(TAU * share);
            return CurvePoint { point: centre + along * x + across * y, slope: (across * x - along * y) * TAU };
        }
        let (out, on) = match side {
            0 => (along, across),
            1 => (across, -along),
            2 => (-along, -across),
            _ => (-across, along),
        };
        CurvePoint { point: centre + out + on * (2.0 * share - 1.0), slope: on * 2.0 }
    }

    /// Returns the sides of the rectangle, or of a polygon with `round` corners on the circle.
    pub(super) fn flat_sides(&self, round: u32) -> Vec<FlatSide<V>> {
        let places = if self.is_round { round } else { 4 };
        let point = |n: u32| {
            let n = n % places;
            if self.is_round {
                self.on_side(0, f64::from(n) / f64::from(round)).point
            } else {
                self.on_side(n, 0.0).point
            }
        };
        let outwards = |from: V, to: V| V::narrow((to - from).spread().cross(self.turning_axis().spread()));
        (0..places).map(|n| FlatSide { corner: point(n), outwards: outwards(point(n), point(n + 1)) }).collect()
    }

    /// Returns the axis about which the sides follow each other by the right-hand rule: `direction`, or its opposite.
    fn turning_axis(&self) -> V {
        V::narrow(self.along.spread().cross(self.across.spread()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Solid;

    fn prisms() -> [Prism<Solid>; 2] {
        let along = Solid::new(0.3, 0.0, 0.4);
        let across = Solid::new(0.0, 0.8, 0.0);
        let centre = Solid::new(0.1, 0.2, -0.1);
        [Prism::circle(centre, Solid::new(0.2, -0.5, 0.3), 0.4), Prism::rectangle(centre, along, across)]
    }

    #[test]
    fn a_point_inside_a_prism_is_inside_of_all_sides() {
        for prism in prisms() {
            for side in 0..prism.sides() {
                for n in 0..40 {
                    let share = f64::from(n) / 40.0;
                    let CurvePoint { point, slope } = prism.on_side(side, share);
                    let next = prism.on_side(side, share + 1e-6).point;
                    assert!(((next - point) / 1e-6 - slope).length() < 1e-4 * slope.length());
                    let out = point - prism.centre;
                    let on_axis = prism.direction * 7.0;
                    assert!(prism.contains(prism.centre + out * 0.999 + on_axis));
                    assert!(!prism.contains(prism.centre + out * 1.001 + on_axis));
                    // A polygon of many corners is the circle but for 1 - cos(pi/360) = 4e-5.
                    let outside =
                        |x: Solid| prism.flat_sides(360).iter().any(|side| (x - side.corner).dot(side.outwards) > 0.0);
                    assert!(!outside(prism.centre + out * 0.999) && outside(prism.centre + out * 1.001));
                }
            }
        }
    }
}
