//! Orientations of rigid bodies, and the free rotation of a body.
//!
//! A [`Rotor`] turns vectors of the body into vectors of space. In the plane it is the unit vector (cos a, sin a) of the angle a, in solid
//! space a unit quaternion. The principal axes of the body are the axes of the body's vectors. The moments of inertia about them are a number
//! in the plane and three numbers in solid space ([`Space::Principal`]); all functions take their inverses, 1/(kg m^2).
//!
//! The angular momentum of a free body stays constant in space. [`plane`] and [`quaternion`] have the two kinds of orientation.
//!
//! The tangent of half an angle x is a series with a relative error below x^14/1e7 for x < 1. The series calls no function of the system's library, so that all
//! machines get the same bits. Another function of the angle turns the body at a slightly different rate, and keeps the symplectic form.

use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Debug;

use crate::space::{Solid, Space};

pub use self::quaternion::Quaternion;

mod plane;
mod quaternion;

/// An orientation: turns vectors of a body into vectors of space.
pub trait Rotor<V: Space>: Copy + Debug + PartialEq + Send + Sync + Serialize + DeserializeOwned + 'static {
    /// No rotation.
    const IDENTITY: Self;
    /// Number of numbers.
    const NUMBERS: usize;

    /// Returns the numbers, and zeros after them.
    #[must_use]
    fn numbers(self) -> [f64; 4];

    /// Returns the rotor of these numbers, which may be followed by others.
    #[must_use]
    fn of_numbers(numbers: [f64; 4]) -> Self;

    /// Returns a vector of the body as a vector of space.
    #[must_use]
    fn turn(self, vector: V) -> V;

    /// Returns a vector of space as a vector of the body.
    #[must_use]
    fn turn_back(self, vector: V) -> V;

    /// Returns the orientation after a rotation by `rotation` (axis times angle, rad) in space.
    #[must_use]
    fn rotated(self, rotation: V::Spin) -> Self;

    /// Returns the angular velocity (rad/s) of a body with the angular momentum `momentum`, kg m^2/s.
    #[must_use]
    fn spin(self, momentum: V::Spin, inverse_inertia: V::Principal) -> V::Spin;

    /// Returns the angular momentum (kg m^2/s) of a body with the angular velocity `spin`, rad/s.
    #[must_use]
    fn momentum(self, spin: V::Spin, inverse_inertia: V::Principal) -> V::Spin;

    /// Returns a body with this orientation, and with the angular momentum `own` (kg m^2/s) in its principal axes, after a free rotation for
    /// `dt`, s.
    #[must_use]
    fn freely_turned(self, own: V::Spin, inverse_inertia: V::Principal, dt: f64) -> Turned<V, Self>;

    /// Returns a spin or an angular momentum in space as one in the principal axes.
    #[must_use]
    fn own(self, in_space: V::Spin) -> V::Spin;

    /// Returns the angular velocity (rad/s) of a body with the angular momentum `own`, kg m^2/s, in its principal axes.
    #[must_use]
    fn spin_of_own(self, own: V::Spin, inverse_inertia: V::Principal) -> V::Spin;

    /// Returns the rotation as a quaternion; in the plane it is about z.
    #[must_use]
    fn to_quaternion(self) -> Quaternion;

    /// Returns the rotor of a quaternion; in the plane its part about z.
    #[must_use]
    fn of_quaternion(rotation: Quaternion) -> Self;

    /// Returns the rotor without rounding errors of its length; `None` if it has no direction.
    #[must_use]
    fn normalised(self) -> Option<Self>;

    /// Returns the rotor that turns the axes x, y and z into these three, a right-handed frame of unit vectors. In the plane no axis turns.
    #[must_use]
    fn from_axes(axes: [Solid; 3]) -> Self;

    /// Returns the rotor of three numbers between 0 and 1. All orientations are equally likely if the numbers are.
    #[must_use]
    fn from_uniform(numbers: [f64; 3]) -> Self;
}

/// A body after a free rotation.
#[derive(Clone, Copy, Debug)]
pub struct Turned<V: Space, R: Rotor<V>> {
    /// The orientation.
    pub rotor: R,
    /// The angular momentum in the principal axes, kg m^2/s.
    pub own: V::Spin,
}

/// The square of an angle below which three terms of its tangent are exact to rounding.
const SMALL: f64 = 1e-4;

/// Returns tan(x/2)/x for the angle x whose square is given.
#[inline(always)]
fn half_tangent(squared: f64) -> f64 {
    let y = 0.25 * squared;
    let rest = if squared < SMALL {
        2.0 / 15.0
    } else {
        2.0 / 15.0 + y * (17.0 / 315.0 + y * (62.0 / 2835.0 + y * (1382.0 / 155_925.0 + y * (21844.0 / 6_081_075.0))))
    };
    0.5 + 0.5 * y * (1.0 / 3.0 + y * rest)
}
