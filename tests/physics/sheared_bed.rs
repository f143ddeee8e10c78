//! A bed sheared by two walls, and the geometry of its neighbours.

use glam::DVec3;

use crate::{Motion, simulation, sphere};
use siloflow::grains::file::GrainRow;
use siloflow::prelude::*;
use siloflow::random::Stream;

pub const K: f64 = 1.0e5;
pub const E: f64 = 0.7;
pub const K_T: f64 = 2.9e4;
pub const K_R: f64 = 2.0e4;
pub const MU: f64 = 0.5;
pub const MU_R: f64 = 0.1;
/// Speed of each wall, m/s. One moves to the left, one to the right.
const SPEED: f64 = 1.0;
pub const DT: f64 = 5.0e-5;
/// Initial distance of neighbouring grains, m. Their radii alternate between 0.044 and 0.036 m.
const APART: f64 = 0.0802;

/// A bed between two walls, periodic along the walls.
pub struct Bed {
    solid: bool,
    /// gamma of the tangential and rolling dashpots, 1/s.
    pub gamma: f64,
    height: f64,
    width: f64,
    grains: Vec<GrainRow>,
    pub simulation: Simulation,
}

impl Bed {
    pub fn new(solid: bool, gamma: f64) -> Self {
        let (side, rows) = if solid { (4, 4) } else { (10, 6) };
        let height = APART * f64::from(rows - 1) + 0.0882;
        let width = APART * f64::from(side);
        let random = Stream::new(1, "shear");
        let grain = |i: u32| {
            let x = i % side;
            let up = i / side % rows;
            let z = i / side / rows;
            let radius = if (x + up + z).is_multiple_of(2) { 0.044 } else { 0.036 };
            let flat = if solid { DVec3::ONE } else { DVec3::new(1.0, 1.0, 0.0) };
            let velocity = 0.2 * flat * DVec3::from(random.uniform(u64::from(i)).map(|u: f64| 2.0 * u - 1.0));
            let lifted = APART * f64::from(up) + 0.0441;
            let [x, z] = [x, z].map(|n| APART * (f64::from(n) + 0.5));
            let place = if solid { DVec3::new(x, z, lifted) } else { DVec3::new(x, lifted, 0.0) };
            sphere(i + 1, place, velocity, radius, 100.0 * radius * radius)
        };
        let grains: Vec<_> = (0..if solid { 64 } else { 60 }).map(grain).collect();
        let simulation = simulation(&Self::keys(solid, gamma, height, width), grains.clone());
        Self { solid, gamma, height, width, grains, simulation }
    }

    fn keys(solid: bool, gamma: f64, height: f64, width: f64) -> String {
        // Formats the vector (x, up).
        let vector = |x: f64, up: f64| if solid { format!("({x:?}, 0.0, {up:?})") } else { format!("({x:?}, {up:?})") };
        let wall = |at: f64, normal: f64, speed: f64| {
            let point = vector(0.0, at);
            let normal = vector(0.0, normal);
            let velocity = vector(speed, 0.0);
            format!("HalfPlane(point: {point}, normal: {normal}, velocity: {velocity})")
        };
        let along = if solid { format!(", y: (0.0, {width:?})") } else { String::new() };
        format!(
            "space: {}, gravity: {}, periodic: (x: (0.0, {width:?}){along}), walls: [{}, {}], \
             contact: Linear(k: {K:?}, damping: Restitution({E:?}), \
             tangential: Spring(k: {K_T:?}, damping: PerMass({gamma:?}), friction: {MU:?}), \
             rolling: (k: {K_R:?}, damping: PerMass({gamma:?}), friction: {MU_R:?})), step: Fixed({DT:?}), until: 1.0e3",
            if solid { "Solid" } else { "Plane" },
            vector(0.0, -3.0),
            wall(0.0, 1.0, -SPEED),
            wall(height, -1.0, SPEED),
        )
    }

    /// Calls `visit` with number and geometry of every pair that could touch, in a fixed order: pairs of grains, and
    /// grains with the two walls.
    pub fn each_pair(&self, state: &[Motion], mut visit: impl FnMut(usize, &Near)) {
        let up = if self.solid { DVec3::Z } else { DVec3::Y };
        let mut number = 0;
        for (i, (a, grain)) in state.iter().zip(&self.grains).enumerate() {
            for (b, other) in state.iter().zip(&self.grains).take(i) {
                let mut between = a.position - b.position;
                between.x -= self.width * (between.x / self.width).round();
                if self.solid {
                    between.y -= self.width * (between.y / self.width).round();
                }
                let sum = grain.radius + other.radius;
                let product = grain.radius * other.radius;
                visit(
                    number,
                    &Near {
                        gap: between.length() - sum,
                        normal: between,
                        velocity: a.velocity - b.velocity,
                        turning: grain.radius * a.spin + other.radius * b.spin,
                        rolling: product / sum * (a.spin - b.spin),
                        mass: grain.mass * other.mass / (grain.mass + other.mass),
                    },
                );
                number += 1;
            }
            for (at, side) in [(0.0, 1.0), (self.height, -1.0)] {
                let spin = grain.radius * a.spin;
                visit(
                    number,
                    &Near {
                        gap: side * (a.position.dot(up) - at) - grain.radius,
                        normal: side * up,
                        velocity: a.velocity + side * SPEED * DVec3::X,
                        turning: spin,
                        rolling: spin,
                        mass: grain.mass,
                    },
                );
                number += 1;
            }
        }
    }
}

/// Geometry of two neighbours, seen from the first one.
pub struct Near {
    /// Distance between the surfaces, m; negative in contact.
    pub gap: f64,
    /// Vector towards the first neighbour, of any length.
    pub normal: DVec3,
    /// Velocity of the first relative to the second, m/s.
    pub velocity: DVec3,
    /// R_i w_i + R_j w_j, m/s: the spin part of the velocity of the surfaces past each other.
    pub turning: DVec3,
    /// R_eff (w_i - w_j), m/s.
    pub rolling: DVec3,
    /// Reduced mass, kg.
    pub mass: f64,
}
