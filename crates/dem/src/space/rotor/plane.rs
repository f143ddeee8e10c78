//! Orientations in the plane: the unit vector (cos a, sin a) of the angle a.

use super::{Quaternion, Rotor, Turned, half_tangent};
use crate::math;
use crate::space::{Linear, Plane, Solid};

impl Rotor<Plane> for Plane {
    const IDENTITY: Self = Self::X;
    const NUMBERS: usize = 2;

    #[inline(always)]
    fn numbers(self) -> [f64; 4] {
        [self.x, self.y, 0.0, 0.0]
    }

    #[inline(always)]
    fn of_numbers([x, y, ..]: [f64; 4]) -> Self {
        Self::new(x, y)
    }

    #[inline(always)]
    fn turn(self, vector: Plane) -> Plane {
        self.rotate(vector)
    }

    #[inline(always)]
    fn turn_back(self, vector: Plane) -> Plane {
        Self::new(self.x, -self.y).rotate(vector)
    }

    #[inline(always)]
    fn rotated(self, angle: f64) -> Self {
        let tangent = angle * half_tangent(angle * angle);
        let squared = tangent * tangent;
        let turned = self.rotate(Self::new(1.0 - squared, 2.0 * tangent) / (1.0 + squared));
        // One step of Newton's method keeps the length.
        turned * (1.5 - 0.5 * Linear::length_squared(turned))
    }

    #[inline(always)]
    fn spin(self, momentum: f64, inverse_inertia: f64) -> f64 {
        momentum * inverse_inertia
    }

    #[inline(always)]
    fn momentum(self, spin: f64, inverse_inertia: f64) -> f64 {
        spin / inverse_inertia
    }

    #[inline(always)]
    fn freely_turned(self, own: f64, inverse_inertia: f64, dt: f64) -> Turned<Plane, Self> {
        Turned { rotor: self.rotated(own * inverse_inertia * dt), own }
    }

    #[inline(always)]
    fn own(self, in_space: f64) -> f64 {
        in_space
    }

    #[inline(always)]
    fn spin_of_own(self, own: f64, inverse_inertia: f64) -> f64 {
        own * inverse_inertia
    }

    fn to_quaternion(self) -> Quaternion {
        // Half of the angle, from the better conditioned of two formulas.
        let half = if self.x > 0.0 {
            Self::new(1.0 + self.x, self.y)
        } else {
            Self::new(self.y.abs(), (1.0 - self.x).copysign(self.y))
        };
        let half = half / Linear::length(half);
        Quaternion::from_xyzw(0.0, 0.0, half.y, half.x)
    }

    fn of_quaternion(rotation: Quaternion) -> Self {
        let half = Self::new(rotation.w, rotation.z).try_normalize().unwrap_or(Self::X);
        half.rotate(half)
    }

    fn normalised(self) -> Option<Self> {
        self.try_normalize()
    }

    fn from_axes(_: [Solid; 3]) -> Self {
        Self::IDENTITY
    }

    fn from_uniform([turn, ..]: [f64; 3]) -> Self {
        math::direction(turn * std::f64::consts::TAU)
    }
}
