//! A half-space that forces move along a line.
//!
//! With the coordinate s along the unit vector u, the force F of the grains along u, and A = load + M g.u - k s - c v: v += h (F + A)/M, s += dt v, then F
//! and A at the end, and v += h (F + A)/M, which is solved for v in its own dashpot. Grains meet the wall with the velocity in the middle of
//! the step, with the centred scheme with v + h (F + A)/M of the step before.

use crate::vector::V;

/// Numbers and state of a free wall.
#[derive(Clone, Copy, Debug)]
pub struct FreeWall {
    /// Unit vector.
    pub along: V,
    /// Point of the surface at s = 0, m.
    pub home: V,
    /// M, kg.
    pub mass: f64,
    /// N.
    pub load: f64,
    /// k, N/m.
    pub stiffness: f64,
    /// c, N s/m.
    pub damping: f64,
    /// s, m.
    pub place: f64,
    /// v, m/s.
    pub rate: f64,
    /// (F + A)/M at the end of the step, m/s^2.
    pub acceleration: f64,
}

impl FreeWall {
    /// Moves the wall by a step. Returns its point (m) and the velocity (m/s) with which grains meet it.
    pub fn drift(&mut self, dt: f64, is_centred: bool) -> [V; 2] {
        let gain = 0.5 * dt * self.acceleration;
        self.rate += gain;
        self.place += dt * self.rate;
        let met = self.rate + if is_centred { gain } else { 0.0 };
        [self.home + self.along * self.place, self.along * met]
    }

    /// Takes the force of the grains at the end of a step, or at the start, where `dt` is 0.
    pub fn kick(&mut self, force: V, gravity: V, dt: f64) {
        let constant =
            force.dot(self.along) + self.load + self.mass * gravity.dot(self.along) - self.stiffness * self.place;
        let share = 0.5 * dt / self.mass;
        self.rate = (self.rate + share * constant) / (1.0 + share * self.damping);
        self.acceleration = (constant - self.damping * self.rate) / self.mass;
    }
}
