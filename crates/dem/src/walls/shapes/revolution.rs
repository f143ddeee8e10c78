//! Points of surfaces of revolution.

use std::f64::consts::PI;

use crate::math;
use crate::space::Space;

/// An axis of revolution.
#[derive(Clone, Copy)]
pub(crate) struct Axis<V> {
    /// The point of the axis at z = 0, m.
    pub base: V,
    /// Unit vector.
    pub direction: V,
}

impl<V: Space> Axis<V> {
    /// Returns the points of a profile (r, z), m, turned by `part` of `parts` equal parts of a turn.
    pub(crate) fn turned<const N: usize>(&self, profile: [[f64; 2]; N], part: u32, parts: u32) -> [V; N] {
        let across = self.direction.any_perpendicular();
        let other = V::narrow(self.direction.spread().cross(across.spread()));
        let (sine, cosine) = math::sincos(2.0 * PI * f64::from(part) / f64::from(parts));
        profile.map(|[r, z]| self.base + self.direction * z + (across * cosine + other * sine) * r)
    }
}
