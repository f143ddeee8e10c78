//! One grain on a frictional plane, for the tests of friction and of rolling resistance.
//!
//! The grain starts at its static overlap m g cos(a)/k, so its normal force is m g cos(a) throughout.

use glam::DVec3;

use crate::{motion, simulation, sphere};
use siloflow::dem::spin::Inertia;
use siloflow::prelude::*;

pub const R: f64 = 0.04;
pub const M: f64 = 0.16;
pub const K: f64 = 1.0e5;
pub const MU: f64 = 0.3;
pub const G: f64 = 9.81;

/// A sphere in solid space or a disc in the plane, on an incline of which the slope has the tangent `slope`.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    pub solid: bool,
    pub slope: f64,
}

impl Case {
    pub fn both(slope: f64) -> [Self; 2] {
        [true, false].map(|solid| Self { solid, slope })
    }

    pub fn q(self) -> f64 {
        if self.solid { 0.4 } else { 0.5 }
    }

    pub fn cos(self) -> f64 {
        self.slope.atan().cos()
    }

    /// Returns g sin of the slope angle, m/s^2.
    pub fn drive(self) -> f64 {
        G * self.slope.atan().sin()
    }

    /// Returns the normal force over the mass, m/s^2.
    pub fn press(self) -> f64 {
        G * self.cos()
    }

    /// Returns the horizontal direction that points downhill, and up. In solid space it is along no axis.
    fn axes(self) -> (DVec3, DVec3) {
        if self.solid { (DVec3::new(0.6, 0.8, 0.0), DVec3::Z) } else { (DVec3::X, DVec3::Y) }
    }

    fn downhill(self) -> DVec3 {
        let (along, up) = self.axes();
        self.cos() * (along - self.slope * up)
    }

    fn normal(self) -> DVec3 {
        let (along, up) = self.axes();
        self.cos() * (up + self.slope * along)
    }

    /// Starts the grain at its static overlap, with speed `u` downhill and the spin of rolling at speed `roll`.
    pub fn start(self, tangential: &str, dt: f64, u: f64, roll: f64) -> Ride {
        let numbers = |v: DVec3| {
            if self.solid { format!("({:?}, {:?}, {:?})", v.x, v.y, v.z) } else { format!("({:?}, {:?})", v.x, v.y) }
        };
        let keys = format!(
            "space: {}, gravity: {}, contact: Linear(k: {K:?}, damping: Restitution(0.5), attraction: Allowed, \
             {tangential}), walls: [HalfPlane(point: {}, normal: {})], step: Fixed({dt:?}), until: 1.0e3",
            if self.solid { "Solid" } else { "Plane" },
            numbers(-G * self.axes().1),
            numbers(DVec3::ZERO),
            numbers(self.normal()),
        );
        let place = (R - M * self.press() / K) * self.normal();
        let mut grain = sphere(1, place, u * self.downhill(), R, M);
        grain.spin = roll / R * self.normal().cross(self.downhill());
        Ride { case: self, simulation: simulation(&keys, vec![grain]), steps: 0, dt, place }
    }
}

pub struct Ride {
    case: Case,
    simulation: Simulation,
    steps: u64,
    dt: f64,
    place: DVec3,
}

/// Distance from the start, speed of the centre, and rolling speed that corresponds to the spin; all downhill.
pub struct Now {
    pub way: f64,
    pub u: f64,
    pub roll: f64,
}

impl Ride {
    pub fn after(&mut self, steps: u64) -> Now {
        self.steps = steps;
        self.simulation.run_steps(steps);
        let now = motion(&mut self.simulation)[0];
        let downhill = self.case.downhill();
        let roll = R * now.spin.cross(self.case.normal());
        Now { way: (now.position - self.place).dot(downhill), u: now.velocity.dot(downhill), roll: roll.dot(downhill) }
    }

    /// Returns the time of the last state, s.
    pub fn time(&self) -> f64 {
        self.steps as f64 * self.dt
    }

    pub fn never_turning(mut self) -> Self {
        let world = self.simulation.world_mut();
        let grains: Vec<Entity> = world.query_filtered::<Entity, With<Grain>>().iter(world).collect();
        for grain in grains {
            world.entity_mut(grain).insert(Inertia(1e300));
        }
        self
    }
}

/// Returns the round-off of a position near the start after `steps` sums, each rounded by half an ulp.
pub fn way_round_off(steps: u64) -> f64 {
    steps as f64 * 0.5 * f64::EPSILON * R
}

/// Returns the round-off of the normal force over the mass after a distance, m/s^2. The overlap is a difference of
/// positions, accurate to two ulp.
pub fn press_round_off(way: f64) -> f64 {
    2.0 * f64::EPSILON * (R + way) * K / M
}
