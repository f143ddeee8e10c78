//! Pose: where a moving wall is, as a rotation about a point and a shift of the wall of the scene.
//!
//! x -> a + Q (x - a) + s, with Q the rotation by an angle phi about the unit vector n (Rodrigues):
//! Q v = v + sin(phi) n x v + (1 - cos(phi)) n x (n x v).

use crate::math;
use crate::space::{Linear, Space};

/// A rotation about a point, and a shift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose<V: Space> {
    /// Point about which the wall turns, before the shift, m.
    pub about: V,
    /// Unit vector of the axis.
    pub axis: V::Spin,
    /// Angle by which the wall has turned, rad.
    pub angle: f64,
    /// Shift, m.
    pub shift: V,
}

impl<V: Space> Pose<V> {
    /// Returns the pose of a wall that is shifted and not turned.
    #[must_use]
    pub fn shifted(shift: V) -> Self {
        Self { about: V::ZERO, axis: V::Spin::ZERO, angle: 0.0, shift }
    }

    /// Turns a vector that belongs to the wall.
    #[must_use]
    pub fn direction(&self, v: V) -> V {
        turned(v, self.axis, self.angle)
    }

    /// Moves a point of the wall, m.
    #[must_use]
    pub fn point(&self, x: V) -> V {
        if self.angle == 0.0 { x + self.shift } else { self.about + self.direction(x - self.about) + self.shift }
    }

    /// Returns the point that [`Self::point`] moves to `x`, m.
    #[must_use]
    pub fn origin_of(&self, x: V) -> V {
        let unshifted = x - self.shift;
        if self.angle == 0.0 { unshifted } else { self.about + turned(unshifted - self.about, self.axis, -self.angle) }
    }
}

/// Returns `v` turned by an angle (rad) about a unit vector.
fn turned<V: Space>(v: V, axis: V::Spin, angle: f64) -> V {
    let (sine, cosine) = math::sincos(angle);
    let across = v.turned_by(axis);
    v + across * sine + across.turned_by(axis) * (1.0 - cosine)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;
    use crate::space::{Plane, Solid};

    #[test]
    fn quarter_turns_permute_the_axes() {
        let pose = Pose { about: Solid::X, axis: Solid::Z, angle: FRAC_PI_2, shift: Solid::new(0.0, 0.0, 3.0) };
        // (2, 0, 0) is one unit from the axis through (1, 0, 0).
        assert!((pose.point(Solid::new(2.0, 0.0, 0.0)) - Solid::new(1.0, 1.0, 3.0)).length() < 1e-15);
        assert!((pose.direction(Solid::new(0.0, 1.0, 7.0)) - Solid::new(-1.0, 0.0, 7.0)).length() < 1e-15);
        let plane = Pose { about: Plane::ZERO, axis: 1.0, angle: PI, shift: Plane::X };
        assert!((plane.point(Plane::new(1.0, 2.0)) - Plane::new(0.0, -2.0)).length() < 1e-15);
    }

    #[test]
    fn the_origin_of_a_moved_point_is_the_point() {
        let axis = Solid::new(1.0, -2.0, 0.5).normalize();
        let pose = Pose { about: Solid::new(0.3, 0.1, -2.0), axis, angle: 1.234, shift: Solid::new(-1.0, 0.2, 0.7) };
        let x = Solid::new(0.4, 5.0, -0.6);
        assert!((pose.origin_of(pose.point(x)) - x).length() < 1e-14);
        assert!((pose.point(x).distance(pose.point(Solid::ZERO)) - x.length()).abs() < 1e-14, "lengths are kept");
    }
}
