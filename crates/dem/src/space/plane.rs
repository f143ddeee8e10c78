//! The plane: vectors of two components, spins of one component.

use crate::math;
use crate::space::{Dimension, Linear, Plane, Solid, Space, mix};

impl Linear for Plane {
    const ZERO: Self = Self::ZERO;
    const COUNT: usize = 2;

    #[inline]
    fn component(self, axis: usize) -> f64 {
        self[axis]
    }

    #[inline]
    fn from_components(mut component: impl FnMut(usize) -> f64) -> Self {
        Self::new(component(0), component(1))
    }

    #[inline]
    fn dot(self, other: Self) -> f64 {
        Self::dot(self, other)
    }

    fn spread(self) -> Solid {
        self.extend(0.0)
    }

    #[inline]
    fn is_finite(self) -> bool {
        Self::is_finite(self)
    }
}

impl Space for Plane {
    const COMPONENTS: usize = 2;
    const DIMENSION: Dimension = Dimension::Plane;
    type MiddleInBody = Self;
    type MiddleBesideBody = ();

    #[inline(always)]
    fn middle(inside: &Self, (): &()) -> Self {
        *inside
    }

    #[inline(always)]
    fn set_middle(velocity: Self, inside: &mut Self, (): &mut ()) {
        *inside = velocity;
    }

    type Spin = f64;
    type Rotor = Self;
    type Principal = f64;
    type Row = [i32; 1];

    fn narrow(padded: Solid) -> Self {
        padded.truncate()
    }

    fn narrow_spin(padded: Solid) -> f64 {
        padded.z
    }

    fn on_paper(self) -> Plane {
        self
    }

    fn depth(self) -> f64 {
        0.0
    }

    #[inline]
    fn cross(self, other: Self) -> f64 {
        self.x * other.y - self.y * other.x
    }

    #[inline]
    fn turned_by(self, spin: f64) -> Self {
        Self::new(-(spin * self.y), spin * self.x)
    }

    fn direction(number: u32) -> Self {
        math::direction(f64::from(number))
    }

    fn any_perpendicular(self) -> Self {
        self.perp().normalize()
    }

    fn rows(reach: i32) -> impl Iterator<Item = [i32; 1]> {
        (-reach..=reach).map(|y| [y])
    }

    #[inline]
    fn row(from: [i32; 1], mut entry: impl FnMut(usize, i32) -> i32) -> [i32; 1] {
        [entry(1, from[0])]
    }

    fn origin_row() -> [i32; 1] {
        [0]
    }

    #[inline]
    fn scatter(row: [i32; 1]) -> u64 {
        mix(row[0])
    }
}
