//! A wall that forces move along a line or about an axis.
//!
//! With the coordinate s (m, or rad) along or about the unit vector u, the force or torque F of the grains, that of all else A = load + weight - k s - c v, and the
//! mass or moment of inertia M: v += h (F + A)/M, s += dt v, then F and A at the end, and v += h (F + A)/M, which is solved for v in its own
//! dashpot. Grains meet the wall with the velocity in the middle of the step, and the centred scheme predicts v + h (F + A)/M of the step before for the end.
//!
//! The weight is m g . u, or of a hinge u . ((C - P) x m g), with the centre of mass C and the point P of the axis.

use crate::vector::V;
use crate::wall::Shape;

/// The way of a free wall.
#[derive(Clone, Copy, Debug)]
pub enum Way {
    /// Along this unit vector.
    Along(V),
    /// About an axis with this unit vector.
    About { point: V, axis: V },
}

/// Numbers and state of a free wall.
#[derive(Clone, Copy, Debug)]
pub struct FreeWall {
    pub way: Way,
    /// The wall at s = 0.
    pub home: Shape,
    /// M, kg or kg m^2.
    pub inertia: f64,
    /// m, kg.
    pub mass: f64,
    /// C at s = 0, m, of a hinge.
    pub centre: V,
    /// N or N m.
    pub load: f64,
    /// k, N/m or N m/rad.
    pub stiffness: f64,
    /// c, N s/m or N m s.
    pub damping: f64,
    /// s, m or rad.
    pub place: f64,
    /// v, m/s or rad/s.
    pub rate: f64,
    /// Gain of the rate from the middle of the step to its end, as far as the scheme predicts it.
    pub gained: f64,
    /// (F + A)/M at the end of the step.
    pub acceleration: f64,
}

impl FreeWall {
    /// Moves the wall by a step. Returns its surface.
    pub fn drift(&mut self, dt: f64, is_centred: bool) -> Shape {
        let gain = 0.5 * dt * self.acceleration;
        self.rate += gain;
        self.place += dt * self.rate;
        self.gained = if is_centred { gain } else { 0.0 };
        self.home.moved(|x| self.moved(x), |direction| self.turned(direction))
    }

    /// Returns the present place of a point of the wall.
    fn moved(&self, home: V) -> V {
        match self.way {
            Way::Along(along) => home + along * self.place,
            Way::About { point, .. } => point + self.turned(home - point),
        }
    }

    /// Returns the present direction of a vector of the wall: Rodrigues' rotation.
    fn turned(&self, home: V) -> V {
        let Way::About { axis, .. } = self.way else { return home };
        let [cosine, sine] = [self.place.cos(), self.place.sin()];
        home * cosine + axis.cross(home) * sine + axis * (axis.dot(home) * (1.0 - cosine))
    }

    /// Returns the velocity of the wall at a place, for a rate.
    pub fn velocity(&self, place: V, rate: f64) -> V {
        match self.way {
            Way::Along(along) => along * rate,
            Way::About { point, axis } => axis.cross(place - point) * rate,
        }
    }

    /// Takes the force of the grains and its torque about the origin, at the end of a step, or at the start, where `dt` is 0.
    pub fn kick(&mut self, [force, moment]: [V; 2], gravity: V, dt: f64) {
        let weight = gravity * self.mass;
        let driving = match self.way {
            Way::Along(along) => (force + weight).dot(along),
            Way::About { point, axis } => {
                (moment - point.cross(force) + (self.moved(self.centre) - point).cross(weight)).dot(axis)
            }
        };
        let constant = driving + self.load - self.stiffness * self.place;
        let share = 0.5 * dt / self.inertia;
        self.rate = (self.rate + share * constant) / (1.0 + share * self.damping);
        self.acceleration = (constant - self.damping * self.rate) / self.inertia;
    }
}
