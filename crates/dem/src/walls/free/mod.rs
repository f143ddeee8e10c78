//! The scene key `free_walls`: walls that forces move along a line or about an axis, such as pistons, lids, flaps and paddles.
//!
//! One coordinate q (a shift in m, or an angle in rad) with the inertia M (mass, or moment of inertia about the axis) obeys
//!
//! M q'' = F_grains + load + weight - k (q - rest) - c q' + motor,
//!
//! where the motor is g (speed - q') as far as its limit allows. For a hinge all forces are torques, and the weight is that of the mass at the centre of mass.
//! Velocity Verlet integrates it, of second order:
//!
//! q'(t + dt/2) = q'(t) + a(t) dt/2, q(t + dt) = q(t) + q'(t + dt/2) dt, q'(t + dt) = q'(t + dt/2) + a(t + dt) dt/2,
//!
//! where the last equation, in which a depends on q'(t + dt) by dashpot and motor, is solved exactly. Grains meet the wall with its velocity in the middle of
//! the step, as each other, and with the `Centred` scheme with the one predicted for the end, q'(t + dt/2) + a(t) dt/2.
//!
//! A *servo* has a gain G in place of an inertia: q' = G (F_grains + load + weight - k (q - rest)), of first order in dt. It presses with a set load
//! without swinging, and must satisfy G K dt < 2 for the stiffness K of the contacts with it.
//!
//! The coordinate stays between its `stops`. A wall that meets one loses its velocity there.
//!
//! Limit: dt < 2 sqrt(M/K) for the sum K of the stiffnesses of its contacts.

mod load;
pub mod plugin;
mod state;

use serde::{Deserialize, Serialize};

pub use self::load::Load;
pub use self::state::FreeState;
use crate::space::{Linear, Solid, Space};
use crate::values::{Finite, FiniteVector, NonNegative, Positive};
use crate::walls::motion::PoseInTime;
use crate::walls::pose::Pose;

/// One entry of the scene key `free_walls`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct FreeWall {
    /// The `name` of the walls, which move together.
    pub walls: String,
    /// The way that they can go.
    pub moves: Freedom,
    /// Mass, kg: the inertia of walls that shift, and what gravity pulls.
    pub mass: Option<Positive>,
    /// Moment of inertia about the axis of a hinge, kg m^2.
    pub inertia: Option<Positive>,
    /// Centre of mass in the scene, m, for gravity on a hinge. Default: on the axis.
    pub centre: Option<FiniteVector>,
    /// Rate per force of a servo, m/(N s) or rad/(N m s), in place of an inertia: it presses with a set load without swinging.
    pub gain: Option<Positive>,
    /// Whether gravity pulls the mass. Default `true`.
    #[serde(default = "yes")]
    pub gravity: bool,
    /// Force along the direction, or torque about the axis, N or N m: constant, or straight lines between times. Default 0.
    pub load: Option<Load>,
    /// A spring.
    pub spring: Option<WallSpring>,
    /// Coefficient of a dashpot, N s/m or N m s. Default 0.
    pub damping: Option<NonNegative>,
    /// A motor with a limited force.
    pub motor: Option<Motor>,
    /// Lowest and highest shift or angle, m or rad, around 0, the place in the scene. A wall that meets a stop loses its velocity.
    pub stops: (Finite, Finite),
    /// Rate at the start, m/s or rad/s. Default 0.
    pub rate: Option<Finite>,
    /// Time until which the walls are held, s. Default 0.
    pub from: Option<NonNegative>,
}

fn yes() -> bool {
    true
}

/// The way that walls can go.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub enum Freedom {
    /// Along a direction, a vector of any length.
    Along(FiniteVector),
    /// About an axis; in the plane it points to the reader.
    About {
        /// A point of the axis, m.
        point: FiniteVector,
        /// Direction of the axis, of any non-zero length, in solid space.
        #[serde(default)]
        axis: Option<FiniteVector>,
    },
}

impl Freedom {
    /// The unit vector of the direction or of the axis.
    #[must_use]
    pub fn unit(&self) -> Solid {
        match self {
            Self::Along(direction) => direction.padded(),
            Self::About { axis, .. } => axis.map_or(Solid::Z, FiniteVector::padded),
        }
        .unit_or_zero()
    }
}

/// A spring on a free wall.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct WallSpring {
    /// Stiffness, N/m or N m/rad.
    pub stiffness: Positive,
    /// The coordinate at which it is relaxed, m or rad. Default 0.
    pub rest: Option<Finite>,
}

/// A motor on a free wall: it pulls the rate towards `speed` with a force of at most `limit`.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Motor {
    /// Rate towards which the motor pulls, m/s or rad/s.
    pub speed: Finite,
    /// Largest force or torque, N or N m.
    pub limit: Positive,
    /// Force per difference of rates, N s/m or N m s.
    pub gain: Positive,
}

impl FreeWall {
    /// The pose at a coordinate and a rate.
    pub(super) fn pose<V: Space>(&self, coordinate: f64, rate: f64) -> PoseInTime<V> {
        let unit = self.moves.unit();
        match &self.moves {
            Freedom::Along(_) => {
                let direction = V::narrow(unit);
                PoseInTime {
                    pose: Pose::shifted(direction * coordinate),
                    velocity: direction * rate,
                    spin: V::Spin::ZERO,
                }
            }
            Freedom::About { point, .. } => {
                let pose = Pose {
                    about: V::narrow(point.padded()),
                    axis: V::narrow_spin(unit),
                    angle: coordinate,
                    shift: V::ZERO,
                };
                PoseInTime { pose, velocity: V::ZERO, spin: V::narrow_spin(unit * rate) }
            }
        }
    }

    /// The force (N) on walls along the direction, or the torque (N m) about the axis, of a force and a torque about `reference`, m.
    pub(super) fn along<V: Space>(&self, force: V, torque: V::Spin, reference: V) -> f64 {
        match &self.moves {
            Freedom::Along(_) => force.dot(V::narrow(self.moves.unit())),
            Freedom::About { point, .. } => {
                let axis = V::narrow_spin(self.moves.unit());
                let arm = reference - V::narrow(point.padded());
                (torque + arm.cross(force)).dot(axis)
            }
        }
    }

    /// The weight along the direction, N, or its torque about the axis, N m, at a coordinate.
    pub(super) fn weight<V: Space>(&self, coordinate: f64, gravity: V) -> f64 {
        let Some(mass) = self.mass.filter(|_| self.gravity) else { return 0.0 };
        let centre = match (&self.moves, self.centre) {
            (Freedom::About { .. }, Some(centre)) => centre.padded(),
            (Freedom::About { point, .. }, None) => point.padded(),
            (Freedom::Along(_), _) => Solid::ZERO,
        };
        let centre = self.pose::<V>(coordinate, 0.0).pose.point(V::narrow(centre));
        self.along(gravity * mass.get(), V::Spin::ZERO, centre)
    }

    /// The inertia: the mass of a shift, kg, the moment of inertia of a hinge, kg m^2; `None` for a servo.
    #[must_use]
    pub fn moved_inertia(&self) -> Option<f64> {
        match self.moves {
            Freedom::Along(_) => self.mass,
            Freedom::About { .. } => self.inertia,
        }
        .filter(|_| self.gain.is_none())
        .map(Positive::get)
    }

    /// Lowest and highest coordinate, m or rad.
    #[must_use]
    pub fn range(&self) -> [f64; 2] {
        [self.stops.0.get(), self.stops.1.get()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Plane;

    #[test]
    fn forces_become_torques_about_the_axis() {
        let point = FiniteVector::from(Plane::new(1.0, 0.0));
        let text = "(walls: \"flap\", moves: About(point: (1.0, 0.0)), inertia: 1.0, mass: 2.0, centre: (2.0, 0.0), stops: (-2.0, 2.0))";
        let options = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
        let flap: FreeWall = options.from_str(text).unwrap();
        assert_eq!(flap.moves, Freedom::About { point, axis: None });
        // A force of 3 N upwards at an arm of 2 m, and a torque of its own.
        let torque = flap.along(Plane::new(0.0, 3.0), 0.5, Plane::new(3.0, 0.0));
        assert!((torque - 6.5).abs() < 1e-15);
        // The weight of 2 kg at 1 m, level and turned down by 60 degrees.
        let gravity = Plane::new(0.0, -10.0);
        assert!((flap.weight(0.0, gravity) + 20.0).abs() < 1e-14);
        assert!((flap.weight(-std::f64::consts::FRAC_PI_3, gravity) + 10.0).abs() < 1e-14);
        let pose = flap.pose::<Plane>(std::f64::consts::FRAC_PI_2, 2.0);
        assert!((pose.pose.point(Plane::new(2.0, 0.0)) - Plane::new(1.0, 1.0)).length() < 1e-15);
        assert!((pose.spin - 2.0).abs() < 1e-15);
    }
}
