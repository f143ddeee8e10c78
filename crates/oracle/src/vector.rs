//! Vectors with three components, used only by the oracle. In the plane z is 0 and spins are along z.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// A vector, SI.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct V(pub [f64; 3]);

impl V {
    pub fn dot(self, other: Self) -> f64 {
        self.0[0] * other.0[0] + self.0[1] * other.0[1] + self.0[2] * other.0[2]
    }

    pub fn cross(self, other: Self) -> Self {
        let component = |axis: usize| {
            let next = (axis + 1) % 3;
            let last = (axis + 2) % 3;
            self.0[next] * other.0[last] - self.0[last] * other.0[next]
        };
        Self([component(0), component(1), component(2)])
    }

    pub fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    pub fn unit(self) -> Self {
        self * (1.0 / self.length())
    }

    /// Returns the component perpendicular to the unit vector `normal`.
    pub fn across(self, normal: Self) -> Self {
        self - normal * self.dot(normal)
    }

    /// Returns the vector, shortened to length `cap` if it is longer, and whether it was longer.
    pub fn cut(self, cap: f64) -> (Self, bool) {
        let length = self.length();
        if length > cap { (self * (cap / length), true) } else { (self, false) }
    }

    /// Returns the text of a scene: two components in the plane, three in solid space.
    pub fn ron(self, solid: bool) -> String {
        let [x, y, z] = self.0;
        if solid { format!("({x:?}, {y:?}, {z:?})") } else { format!("({x:?}, {y:?})") }
    }
}

impl Add for V {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self([self.0[0] + other.0[0], self.0[1] + other.0[1], self.0[2] + other.0[2]])
    }
}

impl AddAssign for V {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Neg for V {
    type Output = Self;

    fn neg(self) -> Self {
        self * -1.0
    }
}

impl Sub for V {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul<f64> for V {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self(self.0.map(|component| component * factor))
    }
}
