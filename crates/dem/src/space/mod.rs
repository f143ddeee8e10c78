//! The space of a scene, plane or solid, as a type parameter.
//!
//! A space *is* the type of its vectors. [`Plane`] is a vector of two components, x to the right and y up. [`Solid`] is
//! a vector of three, x to the right, y into the depth and z up. All moving things are generic over [`Space`] and
//! compiled once for each, so that a planar scene stores and computes no z. Generic types default to the plane:
//! `Position` means `Position<Plane>`, and systems of a planar behaviour need no generics.
//!
//! A spin (angular velocity, torque) has one component in the plane, positive counter-clockwise, and three in solid
//! space. Units are SI. Numbers are in double precision, because the overlaps that carry a bed are 1e-4 of its size.

mod plane;
mod rotor;
mod solid;

use std::fmt::Debug;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, IndexMut, Mul, Neg, Sub, SubAssign};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

pub use self::rotor::{Quaternion, Rotor, Turned};

/// The plane: (x, y), y is up.
pub type Plane = glam::DVec2;

/// Solid space: (x, y, z), z is up.
pub type Solid = glam::DVec3;

/// A vector of the plane, in SI units: the name for planar behaviours.
pub type Vector = Plane;

/// The squared distance, m^2, below which two points count as coincident: far below any length, far above the smallest
/// double.
pub(crate) const COINCIDENT: f64 = 1e-200;

/// The assumed distance of two coincident points, m: too small to change an overlap.
pub(crate) const PARTED: f64 = 1e-90;

/// The scene's `space`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum Dimension {
    /// Vectors are (x, y), y is up, grains are discs.
    #[default]
    Plane,
    /// Vectors are (x, y, z), z is up, grains are spheres.
    Solid,
}

impl Dimension {
    /// Number of components of a vector.
    #[must_use]
    pub fn count(self) -> usize {
        match self {
            Self::Plane => Plane::COMPONENTS,
            Self::Solid => Solid::COMPONENTS,
        }
    }
}

/// Operations that vectors and spins have in common: sums, multiples, a scalar product.
pub trait Linear:
    Copy
    + Debug
    + Default
    + PartialEq
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + Mul<f64, Output = Self>
    + Sum
    + Serialize
    + DeserializeOwned
{
    /// Zero.
    const ZERO: Self;
    /// Number of components.
    const COUNT: usize;

    /// Returns one component.
    #[must_use]
    fn component(self, axis: usize) -> f64;

    /// Builds a value from its components.
    #[must_use]
    fn from_components(component: impl FnMut(usize) -> f64) -> Self;

    /// The scalar product.
    #[must_use]
    fn dot(self, other: Self) -> f64;

    /// The component-wise product; the sum of its components is the scalar product. Summing many of these products is
    /// faster than summing scalar products.
    #[inline]
    #[must_use]
    fn times(self, other: Self) -> Self {
        Self::from_components(|axis| self.component(axis) * other.component(axis))
    }

    /// The sum of the components.
    #[inline]
    #[must_use]
    fn sum_of_components(self) -> f64 {
        (0..Self::COUNT).map(|axis| self.component(axis)).sum()
    }

    /// Returns the components padded with zeros to three. A planar spin is along z.
    #[must_use]
    fn spread(self) -> Solid;

    /// Whether all components are finite.
    #[must_use]
    fn is_finite(self) -> bool;

    /// The square of the length.
    #[inline]
    #[must_use]
    fn length_squared(self) -> f64 {
        self.dot(self)
    }

    /// The length.
    #[inline]
    #[must_use]
    fn length(self) -> f64 {
        self.length_squared().sqrt()
    }
}

/// The plane or solid space, as the type of its vectors.
pub trait Space: Linear + Div<f64, Output = Self> + IndexMut<usize, Output = f64> {
    /// Number of components.
    const COMPONENTS: usize;
    /// The dimension.
    const DIMENSION: Dimension;
    /// The type of angular velocities and torques.
    type Spin: Linear;
    /// The type of orientations.
    type Rotor: Rotor<Self>;
    /// Principal moments of inertia, or their inverses.
    type Principal: Linear;
    /// A row of grid cells along x: the cell numbers along the other axes.
    type Row: Copy + Debug + PartialEq + Send + Sync + 'static;

    /// The part of the velocity in the middle of a step that a body stores: in the plane the vector, which fills up a cache line.
    type MiddleInBody: Copy + Default + Debug + Send + Sync + 'static;
    /// The part of the velocity in the middle of a step that is stored in an array beside the bodies: in solid space the vector, because a
    /// body fills a cache line without it.
    type MiddleBesideBody: Copy + Default + Debug + Send + Sync + 'static;

    /// Returns the velocity in the middle of a step.
    fn middle(in_body: &Self::MiddleInBody, beside: &Self::MiddleBesideBody) -> Self;

    /// Stores the velocity in the middle of a step.
    fn set_middle(velocity: Self, in_body: &mut Self::MiddleInBody, beside: &mut Self::MiddleBesideBody);

    /// Returns the first components of a padded vector.
    #[must_use]
    fn narrow(padded: Solid) -> Self;

    /// Returns the spin of a padded vector: in the plane, its z component.
    #[must_use]
    fn narrow_spin(padded: Solid) -> Self::Spin;

    /// Returns one component: 0 is x.
    #[inline]
    #[must_use]
    fn axis(self, axis: usize) -> f64 {
        self[axis]
    }

    /// Returns the vector with one component replaced.
    #[inline]
    #[must_use]
    fn with_axis(mut self, axis: usize, value: f64) -> Self {
        self[axis] = value;
        self
    }

    /// The component that points up: y in the plane, z in solid space.
    #[inline]
    #[must_use]
    fn height(self) -> f64 {
        self.axis(Self::COMPONENTS - 1)
    }

    /// The position in a drawing: in the plane, the vector itself; in solid space x and z, seen along y.
    #[must_use]
    fn on_paper(self) -> Plane;

    /// The distance behind the drawing plane.
    #[must_use]
    fn depth(self) -> f64;

    /// Returns self x other: a torque from an arm and a force.
    #[must_use]
    fn cross(self, other: Self) -> Self::Spin;

    /// Returns spin x self: the velocity of a point at self.
    #[must_use]
    fn turned_by(self, spin: Self::Spin) -> Self;

    /// Returns a unit vector that depends on `number` only.
    #[must_use]
    fn direction(number: u32) -> Self;

    /// Returns a unit vector perpendicular to this one, which is not zero.
    #[must_use]
    fn any_perpendicular(self) -> Self;

    /// The rows with entries from `-reach` to `reach`, around the zero row, in a fixed order.
    fn rows(reach: i32) -> impl Iterator<Item = Self::Row>;

    /// Maps a row entry by entry. `entry` receives the axis (1 for y) and the entry of `from`.
    #[must_use]
    fn row(from: Self::Row, entry: impl FnMut(usize, i32) -> i32) -> Self::Row;

    /// The row of zeros.
    #[must_use]
    fn origin_row() -> Self::Row;

    /// Hashes a row for a hash table.
    #[must_use]
    fn scatter(row: Self::Row) -> u64;

    /// The distance to another point.
    #[inline]
    #[must_use]
    fn distance(self, other: Self) -> f64 {
        (self - other).length()
    }

    /// The squared distance to another point.
    #[inline]
    #[must_use]
    fn distance_squared(self, other: Self) -> f64 {
        (self - other).length_squared()
    }

    /// The sum of the absolute components: an upper bound of the length, without a square root.
    #[inline]
    #[must_use]
    fn extent(self) -> f64 {
        (0..Self::COMPONENTS).map(|axis| self.axis(axis).abs()).sum()
    }

    /// The components as a list.
    #[must_use]
    fn components(self) -> Vec<f64> {
        (0..Self::COMPONENTS).map(|axis| self.axis(axis)).collect()
    }

    /// The unit vector in this direction; zero for the zero vector.
    #[must_use]
    fn unit_or_zero(self) -> Self {
        let length = self.length();
        if length > 0.0 { self / length } else { Self::ZERO }
    }
}

impl Linear for f64 {
    const ZERO: Self = 0.0;
    const COUNT: usize = 1;

    #[inline]
    fn component(self, _: usize) -> f64 {
        self
    }

    #[inline]
    fn from_components(mut component: impl FnMut(usize) -> f64) -> Self {
        component(0)
    }

    #[inline]
    fn dot(self, other: Self) -> f64 {
        self * other
    }

    fn spread(self) -> Solid {
        Solid::new(0.0, 0.0, self)
    }

    #[inline]
    fn is_finite(self) -> bool {
        f64::is_finite(self)
    }
}

/// Spreads the number of a row over the bits of a hash.
fn mix(line: i32) -> u64 {
    u64::from(line.cast_unsigned()).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32
}

/// Builds an array of four numbers from their indices, so that vector instructions may evaluate all four at once.
#[inline(always)]
pub(crate) fn quad(mut number: impl FnMut(usize) -> f64) -> [f64; 4] {
    [number(0), number(1), number(2), number(3)]
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact values")]
mod tests {
    use super::*;

    #[test]
    fn the_plane_is_a_slice_of_solid_space() {
        let a = Plane::new(0.3, -1.7);
        let b = Plane::new(2.1, 0.4);
        let spin = 0.9;
        assert_eq!(a.cross(b).spread(), Space::cross(a.spread(), b.spread()));
        assert_eq!(a.turned_by(spin).spread(), a.spread().turned_by(spin.spread()));
        assert_eq!(Linear::dot(a, b), Linear::dot(a.spread(), b.spread()));
    }

    #[test]
    fn directions_are_unit_vectors() {
        for number in [0, 1, 0xFFFF, 0x8000_1234, u32::MAX] {
            assert!((Plane::direction(number).length() - 1.0).abs() < 1e-15);
            assert!((Solid::direction(number).length() - 1.0).abs() < 1e-15);
            let v = Solid::direction(number);
            assert!(Linear::dot(v, v.any_perpendicular()).abs() < 1e-15);
            assert!((Linear::length(v.any_perpendicular()) - 1.0).abs() < 1e-15);
        }
    }
}
