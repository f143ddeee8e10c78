//! Solid space: vectors and spins of three components.

use crate::math;
use crate::space::{Dimension, Linear, Plane, Quaternion, Solid, Space, mix};

impl Linear for Solid {
    const ZERO: Self = Self::ZERO;
    const COUNT: usize = 3;

    #[inline]
    fn component(self, axis: usize) -> f64 {
        self[axis]
    }

    #[inline]
    fn from_components(mut component: impl FnMut(usize) -> f64) -> Self {
        Self::new(component(0), component(1), component(2))
    }

    #[inline]
    fn dot(self, other: Self) -> f64 {
        Self::dot(self, other)
    }

    fn spread(self) -> Solid {
        self
    }

    #[inline]
    fn is_finite(self) -> bool {
        Self::is_finite(self)
    }
}

impl Space for Solid {
    const COMPONENTS: usize = 3;
    const DIMENSION: Dimension = Dimension::Solid;
    type MiddleInBody = ();
    type MiddleBesideBody = Self;

    #[inline(always)]
    fn middle((): &(), apart: &Self) -> Self {
        *apart
    }

    #[inline(always)]
    fn set_middle(velocity: Self, (): &mut (), apart: &mut Self) {
        *apart = velocity;
    }

    type Spin = Self;
    type Rotor = Quaternion;
    type Principal = Self;
    type Row = [i32; 2];

    fn narrow(padded: Solid) -> Self {
        padded
    }

    fn narrow_spin(padded: Solid) -> Self {
        padded
    }

    fn on_paper(self) -> Plane {
        Plane::new(self.x, self.z)
    }

    fn depth(self) -> f64 {
        self.y
    }

    #[inline]
    fn cross(self, other: Self) -> Self {
        Self::cross(self, other)
    }

    #[inline]
    fn turned_by(self, spin: Self) -> Self {
        Self::cross(spin, self)
    }

    fn direction(number: u32) -> Self {
        // Polar angle and height of a point on the unit sphere, from the two halves of the number.
        let height = 2.0 * f64::from(number >> 16) / 65_535.0 - 1.0;
        let around = math::direction(f64::from(number & 0xFFFF)) * (1.0 - height * height).max(0.0).sqrt();
        around.extend(height)
    }

    fn any_perpendicular(self) -> Self {
        self.any_orthogonal_vector().normalize()
    }

    fn rows(reach: i32) -> impl Iterator<Item = [i32; 2]> {
        (-reach..=reach).flat_map(move |z| (-reach..=reach).map(move |y| [y, z]))
    }

    #[inline]
    fn row(from: [i32; 2], mut entry: impl FnMut(usize, i32) -> i32) -> [i32; 2] {
        [entry(1, from[0]), entry(2, from[1])]
    }

    fn origin_row() -> [i32; 2] {
        [0, 0]
    }

    #[inline]
    fn scatter(row: [i32; 2]) -> u64 {
        mix(row[0]).wrapping_add(mix(row[1].wrapping_mul(0x5851_F42D)))
    }
}
