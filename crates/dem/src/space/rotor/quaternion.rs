//! Orientations in solid space: unit quaternions.
//!
//! **Free rotation.** The angular momentum L stays constant in space. In solid space the orientation follows from a symplectic splitting
//! (Dullweber, Leimkuhler and McLachlan, J. Chem. Phys. 107, 5840, 1997). With M = R^T L, the energy sum a_i M_i^2/2 of the inverse moments
//! a_i is
//!
//! a_k |L|^2/2 + (a_p - a_k) M_p^2/2 + (a_q - a_k) M_q^2/2.
//!
//! The first term turns the body about L by the angle a_k |L| dt and commutes with the others. Each of the others turns it about one of its own
//! axes, by (a_p - a_k) M_p dt. The step takes half of the second, all of the third, and the other half of the second. k and p are the axes with
//! the most similar moments, so the error is proportional to their difference: the step is exact for bodies of revolution. The order is 2,
//! |L| is kept because L is not touched, and the error of the energy does not grow.
//!
//! The steps follow M and the orientation alike: a rotation about L leaves M as it is, and one about an own axis turns M about that axis.
//!

use super::{Rotor, Turned, half_tangent};
use crate::math;
use crate::space::{Linear, Solid};

/// A unit quaternion.
pub type Quaternion = glam::DQuat;

/// Returns the quaternion of a rotation vector (axis times angle).
#[inline(always)]
fn quaternion(rotation: Solid) -> Quaternion {
    let squared = Linear::length_squared(rotation);
    let tangents = rotation * half_tangent(squared);
    let scale = 1.0 / (1.0 + Linear::length_squared(tangents)).sqrt();
    Quaternion::from_xyzw(tangents.x * scale, tangents.y * scale, tangents.z * scale, scale)
}

/// The principal axes in the order of their roles in the splitting: the axis whose moment all share, the one with the most similar moment, the third.
/// They are x, y and z moved round, so that quaternions keep their products. Two flags select each number, because the compiler makes vector
/// instructions of selections, and not of indices or of an enum.
#[derive(Clone, Copy)]
struct Roles {
    /// The order is y, z, x.
    from_y: bool,
    /// The order is z, x, y.
    from_z: bool,
}

impl Roles {
    #[inline(always)]
    fn of(a: Solid) -> Self {
        let xy = (a.x - a.y).abs();
        let yz = (a.y - a.z).abs();
        let zx = (a.z - a.x).abs();
        let from_x = xy <= yz && xy <= zx;
        Self { from_y: !from_x && yz <= zx, from_z: !from_x && yz > zx }
    }

    /// Returns the number of the present order.
    #[inline(always)]
    fn choose(self, [from_x, from_y, from_z]: [f64; 3]) -> f64 {
        let number = if self.from_y { from_y } else { from_x };
        if self.from_z { from_z } else { number }
    }

    /// Returns the components in the order of the roles.
    #[inline(always)]
    fn sorted(self, Solid { x, y, z }: Solid) -> Solid {
        Solid::new(self.choose([x, y, z]), self.choose([y, z, x]), self.choose([z, x, y]))
    }

    /// Returns the components in the order x, y, z.
    #[inline(always)]
    fn unsorted(self, Solid { x, y, z }: Solid) -> Solid {
        Solid::new(self.choose([x, z, y]), self.choose([y, x, z]), self.choose([z, y, x]))
    }
}

/// The tangent of half an angle, and the sine and cosine of the angle.
struct HalfAngle {
    tangent: f64,
    sine: f64,
    cosine: f64,
}

impl HalfAngle {
    #[inline(always)]
    fn of(angle: f64) -> Self {
        let tangent = angle * half_tangent(angle * angle);
        let per_length = 1.0 / (1.0 + tangent * tangent);
        Self { tangent, sine: 2.0 * tangent * per_length, cosine: (1.0 - tangent * tangent) * per_length }
    }
}

/// A body in free rotation, with vectors in the order of [`Roles`].
struct Turning {
    /// The vector and the number of the quaternion, with a length that the caller restores.
    axis: Solid,
    number: f64,
    own: Solid,
}

impl Turning {
    /// Turns the body about its second axis by `angle`, rad. The axes turn one way, so that a vector of space turns the other way among them.
    #[inline(always)]
    fn about_second(&mut self, angle: f64) {
        let HalfAngle { tangent: t, sine, cosine } = HalfAngle::of(angle);
        let Solid { x, y, z } = self.axis;
        self.axis = Solid::new(x - t * z, y + t * self.number, z + t * x);
        self.number -= t * y;
        let own = self.own;
        self.own = Solid::new(cosine * own.x - sine * own.z, own.y, cosine * own.z + sine * own.x);
    }

    /// Turns the body about its third axis by `angle`, rad.
    #[inline(always)]
    fn about_third(&mut self, angle: f64) {
        let HalfAngle { tangent: t, sine, cosine } = HalfAngle::of(angle);
        let Solid { x, y, z } = self.axis;
        self.axis = Solid::new(x + t * y, y - t * x, z + t * self.number);
        self.number -= t * z;
        let own = self.own;
        self.own = Solid::new(cosine * own.x + sine * own.y, cosine * own.y - sine * own.x, own.z);
    }

    /// Turns the body by the rotation vector `rotation` in its own axes, rad.
    #[inline(always)]
    fn about(&mut self, rotation: Solid) {
        let turn = rotation * half_tangent(Linear::length_squared(rotation));
        let Self { axis, number, .. } = *self;
        self.axis = axis + turn * number + axis.cross(turn);
        self.number = number - Linear::dot(axis, turn);
    }
}

impl Rotor<Solid> for Quaternion {
    const IDENTITY: Self = Self::IDENTITY;
    const NUMBERS: usize = 4;

    #[inline(always)]
    fn numbers(self) -> [f64; 4] {
        self.to_array()
    }

    #[inline(always)]
    fn of_numbers(numbers: [f64; 4]) -> Self {
        Self::from_array(numbers)
    }

    #[inline(always)]
    fn turn(self, vector: Solid) -> Solid {
        let axis = Solid::new(self.x, self.y, self.z);
        let twice = axis.cross(vector) * 2.0;
        vector + twice * self.w + axis.cross(twice)
    }

    #[inline(always)]
    fn turn_back(self, vector: Solid) -> Solid {
        self.conjugate().turn(vector)
    }

    #[inline(always)]
    fn rotated(self, rotation: Solid) -> Self {
        let turned = quaternion(rotation) * self;
        turned * (1.5 - 0.5 * turned.length_squared())
    }

    #[inline(always)]
    fn spin(self, momentum: Solid, inverse_inertia: Solid) -> Solid {
        self.turn(self.turn_back(momentum) * inverse_inertia)
    }

    #[inline(always)]
    fn momentum(self, spin: Solid, inverse_inertia: Solid) -> Solid {
        self.turn(self.turn_back(spin) / inverse_inertia)
    }

    #[inline(always)]
    fn freely_turned(self, own: Solid, a: Solid, dt: f64) -> Turned<Solid, Self> {
        let roles = Roles::of(a);
        let a = roles.sorted(a);
        let axis = roles.sorted(Solid::new(self.x, self.y, self.z));
        let mut turning = Turning { axis, number: self.w, own: roles.sorted(own) };
        let half = 0.5 * dt * (a.y - a.x);
        turning.about_second(half * turning.own.y);
        turning.about_third(dt * (a.z - a.x) * turning.own.z);
        turning.about_second(half * turning.own.y);
        // About L, which has the same components before and after.
        turning.about(turning.own * (a.x * dt));
        let Turning { axis, number, own } = turning;
        let per_length = 1.0 / (Linear::length_squared(axis) + number * number).sqrt();
        let axis = roles.unsorted(axis * per_length);
        Turned { rotor: Self::from_xyzw(axis.x, axis.y, axis.z, number * per_length), own: roles.unsorted(own) }
    }

    #[inline(always)]
    fn own(self, in_space: Solid) -> Solid {
        self.turn_back(in_space)
    }

    #[inline(always)]
    fn spin_of_own(self, own: Solid, a: Solid) -> Solid {
        self.turn(own * a)
    }

    fn to_quaternion(self) -> Quaternion {
        self
    }

    fn of_quaternion(rotation: Quaternion) -> Self {
        rotation
    }

    fn normalised(self) -> Option<Self> {
        let length = self.length();
        (length.is_finite() && length > 0.0).then(|| self * (1.0 / length))
    }

    fn from_axes([x, y, z]: [Solid; 3]) -> Self {
        Self::from_mat3(&glam::DMat3::from_cols(x, y, z))
    }

    fn from_uniform([first, second, third]: [f64; 3]) -> Self {
        // Shoemake, Graphics Gems III, 1992.
        let [low, high] = [(1.0 - first).sqrt(), first.sqrt()];
        let [one, two] = [second, third].map(|turn| math::direction(turn * std::f64::consts::TAU));
        Self::from_xyzw(low * one.y, low * one.x, high * two.y, high * two.x)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::space::Plane;

    fn solid() -> impl Strategy<Value = Solid> {
        (-1.0..1.0, -1.0..1.0, -1.0..1.0).prop_map(|(x, y, z)| Solid::new(x, y, z))
    }

    fn energy(rotor: Quaternion, momentum: Solid, a: Solid) -> f64 {
        0.5 * Linear::dot(momentum, Rotor::<Solid>::spin(rotor, momentum, a))
    }

    /// The orientation after a free rotation with the angular momentum `momentum` in space.
    fn after(rotor: Quaternion, momentum: Solid, a: Solid, dt: f64) -> Quaternion {
        rotor.freely_turned(Rotor::<Solid>::own(rotor, momentum), a, dt).rotor
    }

    /// The largest error of the energy of a top, over its energy, in a time of 200 with steps of `dt`.
    fn energy_error(dt: f64) -> f64 {
        let (momentum, a) = (Solid::new(0.3, 0.5, 0.8), Solid::new(1.0, 0.7, 0.4));
        let mut rotor = Quaternion::IDENTITY;
        let start = energy(rotor, momentum, a);
        let mut time = 0.0;
        let mut largest = 0.0_f64;
        while time < 200.0 {
            rotor = after(rotor, momentum, a, dt);
            time += dt;
            largest = largest.max((energy(rotor, momentum, a) / start - 1.0).abs());
        }
        largest
    }

    #[test]
    fn the_energy_of_a_free_top_has_an_error_of_second_order() {
        let [coarse, fine] = [energy_error(0.1), energy_error(0.05)];
        assert!((coarse / fine - 4.0).abs() < 0.1, "{coarse} {fine}");
        assert!(coarse < 2e-4, "{coarse}");
    }

    #[test]
    fn a_body_of_revolution_precesses_exactly_at_any_step() {
        // L along z; the axis of the body precesses about it at a_k |L| and the body turns about its axis at (a_q - a_k) M_q.
        let (momentum, a) = (Solid::new(0.0, 0.0, 2.0), Solid::new(0.6, 0.6, 0.25));
        let start = Rotor::<Solid>::rotated(Quaternion::IDENTITY, Solid::new(0.7, 0.0, 0.0));
        let axis = start.turn(Solid::Z);
        let step = 0.05;
        let mut rotor = start;
        for number in 1..=1000 {
            rotor = after(rotor, momentum, a, step);
            let angle = 0.6 * 2.0 * step * f64::from(number);
            let expected = Quaternion::from_rotation_z(angle) * axis;
            assert!(Linear::length(rotor.turn(Solid::Z) - expected) < 1e-12);
        }
        let about_axis = (0.25 - 0.6) * 2.0 * axis.z * step * 1000.0;
        let expected =
            Quaternion::from_rotation_z(0.6 * 2.0 * step * 1000.0) * start * Quaternion::from_rotation_z(about_axis);
        assert!((rotor.dot(expected).abs() - 1.0).abs() < 1e-11);
    }

    proptest! {
        #[test]
        fn rotors_turn_as_the_rotation_vector_says(rotation in solid(), vector in solid()) {
            let angle = Linear::length(rotation);
            prop_assume!(angle > 1e-3);
            let turned = Rotor::<Solid>::rotated(Quaternion::IDENTITY, rotation).turn(vector);
            let expected = Quaternion::from_axis_angle(rotation / angle, angle) * vector;
            // The next term of the series is 8.9e-8 x^14 of the first. Up to x = 1.74 the terms after it add two fifths.
            prop_assert!(Linear::length(turned - expected) < 3e-7 * angle.powi(14) + 1e-13);
            let spread = Rotor::<Plane>::to_quaternion(Plane::from_angle(9.0 * rotation.x));
            prop_assert!(Linear::length(<Plane as Rotor<Plane>>::of_quaternion(spread) - Plane::from_angle(9.0 * rotation.x)) < 1e-14);
            prop_assert!(Linear::length(spread * Solid::X - Plane::from_angle(9.0 * rotation.x).extend(0.0)) < 1e-14);
            let planar = Rotor::<Plane>::rotated(Plane::X, 0.3 * rotation.x).turn(vector.truncate());
            let expected = Plane::from_angle(0.3 * rotation.x).rotate(vector.truncate());
            prop_assert!(Linear::length(planar - expected) < 1e-13);
        }

        #[test]
        fn spin_and_momentum_are_inverse_and_turning_back_undoes_turning(
            vector in solid(), rotation in solid(), a in (0.1..2.0, 0.1..2.0, 0.1..2.0),
        ) {
            let a = Solid::new(a.0, a.1, a.2);
            let rotor = Rotor::<Solid>::rotated(Quaternion::IDENTITY, rotation);
            let spin = Rotor::<Solid>::spin(rotor, rotor.momentum(vector, a), a);
            prop_assert!(Linear::length(spin - vector) < 1e-14);
            prop_assert!(Linear::length(rotor.turn_back(rotor.turn(vector)) - vector) < 1e-14);
            prop_assert!((rotor.length() - 1.0).abs() < 1e-15);
        }

        #[test]
        fn the_angular_momentum_is_followed_into_the_axes_of_the_turned_body(
            vector in solid(), rotation in solid(), a in (0.1..2.0, 0.1..2.0, 0.1..2.0),
        ) {
            let a = Solid::new(a.0, a.1, a.2);
            let rotor = Rotor::<Solid>::rotated(Quaternion::IDENTITY, rotation);
            let Turned { rotor: turned, own } = rotor.freely_turned(Rotor::<Solid>::own(rotor, vector), a, 0.4);
            prop_assert!(Linear::length(turned.turn(own) - vector) < 1e-14);
            let spin = Rotor::<Solid>::spin(turned, vector, a);
            prop_assert!(Linear::length(Rotor::<Solid>::spin_of_own(turned, own, a) - spin) < 1e-14);
        }

        #[test]
        fn the_length_of_a_rotor_stays_one(rotation in solid(), numbers in (0.0..1.0, 0.0..1.0, 0.0..1.0)) {
            let mut rotor: Quaternion = Rotor::<Solid>::from_uniform([numbers.0, numbers.1, numbers.2]);
            prop_assert!((rotor.length() - 1.0).abs() < 1e-14);
            let mut planar = <Plane as Rotor<Plane>>::from_uniform([numbers.0, 0.0, 0.0]);
            for _ in 0..1000 {
                rotor = after(rotor, rotation, Solid::new(1.0, 0.5, 0.2), 0.3);
                planar = Rotor::<Plane>::rotated(planar, rotation.x);
            }
            prop_assert!((rotor.length() - 1.0).abs() < 1e-15 && (Linear::length(planar) - 1.0).abs() < 1e-15);
        }
    }
}
